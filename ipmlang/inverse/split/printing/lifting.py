"""Counts that a person would set: floors and bays as attributes, sizes of scopes that follow them.

In go schemes with splits, out come for scopes that stand freely the axes along which cells repeat,
and attributes with the sizes that they make. A scope is as long as its rest and so many periods, so
that an engine which derives it finds the count again. No scheme is changed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.following import FEWEST
from ipmlang.inverse.split.printing.items import Wording
from ipmlang.inverse.split.scheme import Array, Cell, Octant, Place, Ring, Rule, Scheme, Split
from ipmlang.inverse.split.wording import Vector, plus, times

MOST = 4  # attributes of one file
TOKENS = 50  # of a grammar for each attribute behind the first
WORDS = ("bays", "rows", "floors")
AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Counted:
    """The scope of rule `root` is `rest + count * period` long along `axis`, where cells of the
    symbol `cell` repeat `count` times in it, or in a cell of it that is as long; drawn: how many of
    them there are.
    """

    root: int
    axis: int
    cell: int
    count: int
    period: float
    rest: float
    drawn: int


def counted(scheme: Scheme) -> list[Counted]:
    """The counts that the sizes of free scopes say, one an axis: floors first, then those of most
    cells.
    """
    found: dict[tuple[int, int], Counted] = {}
    for root in sorted(_free(scheme)):
        for each in _within(scheme, root):
            known = found.get((root, each.axis))
            if known is None or each.drawn > known.drawn:
                found[root, each.axis] = each
    return sorted(found.values(), key=lambda each: (each.axis < 2, -each.drawn, each.root))


def _free(scheme: Scheme) -> set[int]:
    """Rules that do not stand in cells alone."""
    free = {scheme.axiom}
    for symbol in scheme.symbols:
        for item in symbol.items if isinstance(symbol, Rule) else ():
            if isinstance(item, Place | Array | Ring | Octant):
                free.add(item.symbol)
    return {number for number in free if isinstance(scheme.symbols[number], Rule)}


def _within(scheme: Scheme, root: int) -> Iterator[Counted]:
    """What repeats in a scope, or in cells that are as long as it along an axis."""
    waiting = [(root, (True, True, True), 1)]
    while waiting:
        number, whole, times_there = waiting.pop()
        symbol = scheme.symbols[number]
        for item in symbol.items if isinstance(symbol, Rule) else ():
            if not isinstance(item, Split):
                continue
            if whole[item.axis]:
                length = float(scheme.symbols[root].size[item.axis])
                yield from _repeated(item, root, length, times_there)
            across = tuple(own and axis != item.axis for axis, own in enumerate(whole))
            for cell in item.cells:
                if cell.symbol is not None:
                    x, y, z = across
                    waiting.append((cell.symbol, (x, y, z), times_there * cell.count))


def _repeated(split: Split, root: int, length: float, times_there: int) -> Iterator[Counted]:
    repeats = [cell for cell in split.cells if cell.count > 1]
    if len(repeats) != 1 or repeats[0].count < FEWEST:
        return
    cell: Cell = repeats[0]
    assert cell.symbol is not None
    rest = max(length - cell.count * cell.length, 0.0)
    drawn = times_there * cell.count
    yield Counted(root, split.axis, cell.symbol, cell.count, cell.length, rest, drawn)


@dataclass(frozen=True, slots=True)
class Lifted:
    """attributes: of the grammar; sizes: of the scopes that follow them, by symbol."""

    attributes: tuple[ast.Attr, ...]
    sizes: dict[int, Vector]


def lifted(wording: Wording) -> Lifted:
    """The counts of a scheme as attributes. Floors of one height are one count in all scopes that
    have equally many.
    """
    attributes: list[ast.Attr] = []
    sizes: dict[int, Vector] = {}
    named: list[tuple[Counted, str]] = []
    most = min(scheme_tokens(wording.scheme, wording.precision.length) // TOKENS, MOST)
    for each in counted(wording.scheme):
        name = next((name for other, name in named if _one(each, other, wording)), None)
        if name is None:
            if len(attributes) >= max(most, 1):
                continue
            name = wording.given.give(WORDS[each.axis])
            attributes.append(_attribute(wording, each, name))
            named.append((each, name))
        own = sizes.get(each.root) or _size(wording, each.root)
        sizes[each.root] = _with(own, each.axis, _length(wording, each, name))
    return Lifted(tuple(attributes), sizes)


def _one(a: Counted, b: Counted, wording: Wording) -> bool:
    """Whether two counts are one: as many of one length, along one axis, in two scopes."""
    near = abs(a.period - b.period) <= 2 * wording.precision.length
    return a.root != b.root and a.axis == b.axis and a.count == b.count and near


def _attribute(wording: Wording, each: Counted, name: str) -> ast.Attr:
    said = f"times that {wording.names[each.cell]} repeats along {AXES[each.axis]}"
    value = ast.Number(float(each.count))
    return ast.Attr(name, "int", value, ast.Range(ast.Number(1.0), None), said)


def _size(wording: Wording, root: int) -> Vector:
    return wording.precision.vector(np.maximum(wording.scheme.symbols[root].size, 0.0))


def _length(wording: Wording, each: Counted, name: str) -> ast.Expr:
    """`1.4 + 2.8 * bays`."""
    share = 1.0 / (each.count + 1)
    period = wording.precision.number(each.period, share)
    rest = wording.precision.number(each.rest, share)
    return plus(rest, times(period, ast.Name(name)))


def _with(size: Vector, axis: int, length: ast.Expr) -> Vector:
    x, y, z = (length if axis == place else each for place, each in enumerate(size))
    return (x, y, z)
