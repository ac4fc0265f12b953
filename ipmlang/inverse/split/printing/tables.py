"""Copies without a rule: written out one by one, or as rows of a table, whichever is shorter.

Takes spots and what stands at each; gives elements and the tables they read. Which spots share a
table, and what of them is said once for all, is counted in tokens, as everything that competes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import Integers
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.placing import Spot, placed, steps_to
from ipmlang.inverse.split.printing.counting import (
    TURNS,
    Ledger,
    columns,
    ledger,
    pays,
    tokens_of,
)
from ipmlang.inverse.split.wording import NOTHING, Vector
from ipmlang.inverse.wording import several, stem

AXES = (0, 1, 2)
NAMES = ("x", "y", "z", "rx", "ry", "rz")  # of columns, by axis of the place and of the turn
SCALE = "scale"
APART = 4  # turns that may have a table each while the rest share one


@dataclass(frozen=True, slots=True)
class Layout:
    """How spots become rows. columns: by axis, what each row says of its place and of its turn;
    scaled: whether rows say a scale; common: what all have besides, behind the row's place.
    """

    shifts: tuple[int, ...]
    turns: tuple[int, ...]
    scaled: bool
    common: Spot

    def cells(self, spot: Spot) -> tuple[ast.Expr, ...]:
        """A row."""
        own = [spot.place[axis] for axis in self.shifts] + [spot.turn[axis] for axis in self.turns]
        return (*own, _scale(spot)) if self.scaled else tuple(own)

    @property
    def columns(self) -> tuple[str, ...]:
        """Their names."""
        names = [NAMES[axis] for axis in self.shifts] + [NAMES[axis + 3] for axis in self.turns]
        return (*names, SCALE) if self.scaled else tuple(names)


def cheapest(
    found: Sequence[Spot], inner: Sequence[ast.Element], name: str, names: Names
) -> tuple[list[ast.Element], list[ast.Table]]:
    """The elements for copies at these spots: those that a table says shorter in repeats over it,
    the others one by one.
    """
    elements: list[ast.Element] = []
    tables: list[ast.Table] = []
    own = ledger(found)
    for rows in grouped(own, np.arange(len(found))):
        if pays(own, rows):
            element, table = tabled(found, own, rows, inner, name, names)
            tables.append(table)
            elements.append(element)
        else:
            elements += [placed(found[row], inner) for row in rows.tolist()]
    return elements, tables


def tabled(
    found: Sequence[Spot],
    own: Ledger,
    rows: Integers,
    inner: Sequence[ast.Element],
    name: str,
    names: Names,
) -> tuple[ast.Element, ast.Table]:
    """A repeat over the table of some of the spots, and the table."""
    layout = layout_of(found, own, rows)
    cells = tuple(layout.cells(found[row]) for row in rows.tolist())
    table = ast.Table(names.give(_title(name)), columns=layout.columns, rows=cells)
    head = ast.Rows("at", table.name, places=True)
    return ast.Repeat(head, behind(layout.common, inner)), table


def behind(common: Spot, inner: Sequence[ast.Element]) -> tuple[ast.Element, ...]:
    """What stands at a row's place; a factor is the turtle's, and has a bracket of its own."""
    return (placed(common, inner),) if common.scale is not None else (*steps_to(common), *inner)


def _title(name: str) -> str:
    """`windows` for `window`."""
    things = several(name).replace(" ", "_")
    plain = name.replace("_", "").isalpha() and things.isidentifier() and things != name
    return things if plain else f"{stem(name)}_places"


def grouped(own: Ledger, rows: Integers) -> list[Integers]:
    """Spots that one table could hold, those of each hand in the shortest of some ways."""
    groups: list[Integers] = []
    for mirrored in (False, True):
        some = rows[own.mirrored[rows] == mirrored]
        if len(some):
            groups += _shortest(own, some)
    return groups


def _shortest(own: Ledger, rows: Integers) -> list[Integers]:
    """The way to tell spots apart that takes fewest tokens, of equally short ones the first."""
    known: dict[bytes, int] = {}

    def tokens(way: list[Integers]) -> int:
        for group in way:
            if group.tobytes() not in known:
                known[group.tobytes()] = tokens_of(own, group)
        return sum(known[group.tobytes()] for group in way)

    return min(_ways(own, rows), key=tokens)


def _ways(own: Ledger, rows: Integers) -> Iterator[list[Integers]]:
    """Ways to tell spots apart: the most frequent turns each alone, the rest together, or those
    about each axis together.
    """
    turned = _by_row(rows, own.values[rows, TURNS.start :])
    ranked = sorted(turned, key=len, reverse=True)
    for count in [*range(min(APART, len(ranked))), len(ranked)]:
        rest = np.concatenate([rows[:0], *ranked[count:]])
        yield [*ranked[:count], *([rest] if len(rest) else [])]
        yield [*ranked[:count], *_by_row(rest, own.said[rest, TURNS])]


def _by_row(rows: Integers, table: np.ndarray) -> list[Integers]:
    """Rows for which a table (n, c) says the same, together, by the first of each kind."""
    kinds: dict[bytes, list[int]] = {}
    for row, said in zip(rows.tolist(), np.ascontiguousarray(table), strict=True):
        kinds.setdefault(said.tobytes(), []).append(row)
    return [np.array(each, np.int64) for each in kinds.values()]


def layout_of(found: Sequence[Spot], own: Ledger, rows: Integers) -> Layout:
    """How some of the spots become rows of the shortest table."""
    best = columns(own, rows)
    first = found[int(rows[0])]
    x, y, z = (NOTHING if axis in best.shifts else first.place[axis] for axis in AXES)
    turn: Vector = (NOTHING, NOTHING, NOTHING) if best.turns else first.turn
    common = Spot((x, y, z), turn, first.mirrored, None if best.scaled else first.scale)
    return Layout(best.shifts, best.turns, best.scaled, common)


def _scale(spot: Spot) -> ast.Expr:
    return ast.Number(1.0) if spot.scale is None else spot.scale
