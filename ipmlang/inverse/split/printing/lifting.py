"""Counts that a person would set: floors and bays as attributes, sizes of scopes that follow them.

In go schemes, out come for scopes that stand freely the axes along which cells or rows repeat, and
attributes with the sizes that they make. A scope is as long as its rest and so many periods, so
that an engine which derives it finds the count of its cells again; rows are told theirs. No scheme
is changed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.growing import follows
from ipmlang.inverse.split.measuring import extents
from ipmlang.inverse.split.printing.items import Wording
from ipmlang.inverse.split.rows import FEWEST, Row, rows
from ipmlang.inverse.split.scheme import Array, Cell, Octant, Place, Ring, Rule, Scheme, Split
from ipmlang.inverse.split.wording import Vector, plus, times

MOST = 4  # attributes of one file
TOKENS = 50  # of a grammar for each attribute behind the first
WORDS = ("bays", "rows", "floors")
TREADS = "treads"  # of a stair that winds
AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Counted:
    """The scope of rule `root` is `rest + count * period` long along `axis`, where the symbol
    `cell` repeats `count` times in it, or in a cell of it that is as long; drawn: how many of them
    there are; row: the rule, item and direction of a row, None for cells, whose count their scope
    tells; alone: whether nothing follows the scope there, so that the count says all.
    """

    root: int
    axis: int
    cell: int
    count: int
    period: float
    rest: float
    drawn: int
    row: tuple[int, int, int] | None = None
    alone: bool = False


def counted(found: Iterable[Counted]) -> list[Counted]:
    """Of all that repeats the counts that the sizes of free scopes say, one an axis: floors first,
    then those of most cells.
    """
    best: dict[tuple[int, int], Counted] = {}
    for each in found:
        if not each.alone:
            known = best.get((each.root, each.axis))
            if known is None or _weight(each) > _weight(known):
                best[each.root, each.axis] = each
    return sorted(best.values(), key=lambda each: (each.axis < 2, -each.drawn, each.root))


def _weight(each: Counted) -> tuple[bool, int]:
    return each.row is None, each.drawn


def repeated(scheme: Scheme) -> list[Counted]:
    """All that repeats in scopes that stand freely."""
    boxes = extents(scheme)
    every = [tuple(rows(symbol, boxes)) for symbol in scheme.symbols]
    return [each for root in sorted(_free(scheme)) for each in _within(scheme, root, every)]


def _free(scheme: Scheme) -> set[int]:
    """Rules that do not stand in cells alone."""
    free = {scheme.axiom}
    for symbol in scheme.symbols:
        for item in symbol.items if isinstance(symbol, Rule) else ():
            if isinstance(item, Place | Array | Ring | Octant):
                free.add(item.symbol)
    return {number for number in free if isinstance(scheme.symbols[number], Rule)}


def _within(scheme: Scheme, root: int, every: list[tuple[Row, ...]]) -> Iterator[Counted]:
    """What repeats in a scope, or in cells that are as long as it along an axis."""
    size = scheme.symbols[root].size
    waiting = [(root, (True, True, True), 1)]
    while waiting:
        number, whole, times_there = waiting.pop()
        symbol = scheme.symbols[number]
        if not isinstance(symbol, Rule):
            continue
        for row in every[number]:
            if whole[row.axis]:
                yield _row(symbol, number, row, root, float(size[row.axis]), times_there)
        for item in symbol.items:
            if not isinstance(item, Split):
                continue
            if whole[item.axis]:
                yield from _repeated(item, root, float(size[item.axis]), times_there)
            across = tuple(own and axis != item.axis for axis, own in enumerate(whole))
            for cell in item.cells:
                if cell.symbol is not None:
                    x, y, z = across
                    waiting.append((cell.symbol, (x, y, z), times_there * cell.count))


def _row(rule: Rule, number: int, row: Row, root: int, length: float, times_there: int) -> Counted:
    item = rule.items[row.item]
    assert isinstance(item, Array | Ring)
    rest = length - row.count * row.period
    alone = not any(follows(other, row.axis) for other in rule.items)
    where = (number, row.item, row.direction)
    drawn = times_there * row.count
    return Counted(root, row.axis, item.symbol, row.count, row.period, rest, drawn, where, alone)


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
    found = repeated(wording.scheme)
    for each in counted(found):
        name = next((name for other, name in named if _one(each, other, wording)), None)
        if name is None:
            if len(attributes) >= max(most, 1):
                continue
            name = wording.given.give(_word(wording.scheme, each))
            attributes.append(_attribute(wording, each, name))
            named.append((each, name))
        own = sizes.get(each.root) or _size(wording, each.root)
        sizes[each.root] = _with(own, each.axis, _length(wording, each, name))
        wording.counts |= _tied(found, each, name, wording)
    return Lifted(tuple(attributes), sizes)


def _one(a: Counted, b: Counted, wording: Wording) -> bool:
    """Whether two counts are one: as many of one length, along one axis, in two scopes."""
    near = abs(a.period - b.period) <= 2 * wording.precision.length
    return a.root != b.root and a.axis == b.axis and a.count == b.count and near


def _word(scheme: Scheme, each: Counted) -> str:
    """What a person would call so many of something."""
    rule = scheme.symbols[each.row[0]] if each.row else None
    winds = each.row and isinstance(rule, Rule) and isinstance(rule.items[each.row[1]], Ring)
    return TREADS if winds else WORDS[each.axis]


def _tied(
    found: Sequence[Counted], named: Counted, name: str, wording: Wording
) -> dict[tuple[int, int, int], ast.Expr]:
    """The counts of rows that go with a count: of the row that it is, and of those in its scope
    that keep step with it, one or more to a period.
    """
    often = Counter(each.row for each in found)
    tied: dict[tuple[int, int, int], ast.Expr] = {}
    for each in found:
        if (each.root, each.axis) != (named.root, named.axis) or each.row is None:
            continue
        ratio = each.count // named.count
        in_step = abs(named.period - ratio * each.period) <= 2 * wording.precision.length
        if in_step and often[each.row] == 1 and each.count == ratio * named.count:
            tied[each.row] = times(ast.Number(float(ratio)), ast.Name(name))
    return tied


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
    grows = times(period, ast.Name(name))
    return plus(grows, rest) if each.rest < 0 else plus(rest, grows)


def _with(size: Vector, axis: int, length: ast.Expr) -> Vector:
    x, y, z = (length if axis == place else each for place, each in enumerate(size))
    return (x, y, z)
