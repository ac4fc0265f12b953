"""Schedules: one table that says of many symbols where their copies stand.

Takes the copies of all symbols in a body; gives elements for each, and the tables that they read. A
copy is written out, a row of its symbol's own table, or a row of a schedule, whose first column is
the symbol: whatever takes the fewest tokens together. Nothing here knows schemes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import Integers
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.placing import Spot, placed
from ipmlang.inverse.split.printing.counting import (
    SCALE,
    TURNS,
    Ledger,
    columns,
    ledger,
    pays,
    tokens_of,
)
from ipmlang.inverse.split.printing.tables import behind, grouped, layout_of, tabled

SHAPE = "shape"
AXES = np.array([1, 2, 4])  # bits of what is turned about x, y and z
UPRIGHT = 4
FEWEST = 3  # rows that are worth a schedule


@dataclass(frozen=True, slots=True)
class Copies:
    """A symbol's name, what draws it, and where it stands."""

    name: str
    inner: tuple[ast.Element, ...]
    spots: tuple[Spot, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Unit:
    """Spots of one symbol that stay together, by their rows; alone: tokens that they take by
    themselves; mirrored, scaled: whether they are; about: what any of them is turned about, a bit
    for each axis.
    """

    owner: int
    rows: Integers
    alone: int
    mirrored: bool
    scaled: bool
    about: int


@dataclass(frozen=True, slots=True, eq=False)
class _Schedule:
    """Units that share a table, and the tokens that it saves."""

    units: tuple[_Unit, ...]
    gain: int

    @property
    def rows(self) -> Integers:
        """The spots of all units."""
        return np.concatenate([unit.rows for unit in self.units])


@dataclass(frozen=True, slots=True)
class Arrangement:
    """first: elements of the schedules; own: of the copies of each symbol that are in none."""

    first: tuple[ast.Element, ...]
    own: tuple[tuple[ast.Element, ...], ...]
    tables: tuple[ast.Table, ...]


def arrangement(copies: Sequence[Copies], title: str, names: Names) -> Arrangement:
    """The shortest way to place all copies; title: what a schedule is called, as a wish."""
    spots = [spot for each in copies for spot in each.spots]
    own = ledger(spots)
    ends = np.cumsum([len(each.spots) for each in copies], dtype=np.int64)
    units = [
        list(_units(own, owner, np.arange(end - len(each.spots), end)))
        for owner, (each, end) in enumerate(zip(copies, ends.tolist(), strict=True))
    ]
    schedules = _schedules(
        own, [unit for each in units for unit in each if _may_share(copies, unit)]
    )
    shared = {id(unit) for schedule in schedules for unit in schedule.units}
    first: list[ast.Element] = []
    tables: list[ast.Table] = []
    for schedule in schedules:
        element, table = _scheduled(copies, spots, own, schedule, names.give(title))
        tables.append(table)
        first.append(element)
    singly: list[tuple[ast.Element, ...]] = []
    for each, parts in zip(copies, units, strict=True):
        elements: list[ast.Element] = []
        for unit in parts:
            if id(unit) in shared:
                continue
            if pays(own, unit.rows):
                element, table = tabled(spots, own, unit.rows, each.inner, each.name, names)
                elements.append(element)
                tables.append(table)
            else:
                elements += [placed(spots[row], each.inner) for row in unit.rows.tolist()]
        singly.append(tuple(elements))
    return Arrangement(tuple(first), tuple(singly), tuple(tables))


def _units(own: Ledger, owner: int, rows: Integers) -> Iterator[_Unit]:
    """The tables that a symbol would have by itself, and its copies that would be in none."""
    about = own.said[:, TURNS] @ AXES
    for group in grouped(own, rows):
        hand = bool(own.mirrored[group[0]])
        scaled = own.said[group, SCALE]
        if pays(own, group):
            every = int(np.bitwise_or.reduce(about[group]))
            yield _Unit(owner, group, tokens_of(own, group), hand, bool(scaled.any()), every)
            continue
        each = own.alone[group].tolist(), scaled.tolist(), about[group].tolist()
        for k, (tokens, grows, axes) in enumerate(zip(*each, strict=True)):
            yield _Unit(owner, group[k : k + 1], tokens, hand, grows, axes)


def _may_share(copies: Sequence[Copies], unit: _Unit) -> bool:
    """Whether a schedule may hold a unit: a plain symbol, that stands elsewhere than at home."""
    inner = copies[unit.owner].inner
    plain = len(inner) == 1 and isinstance(inner[0], ast.Module) and not inner[0].args
    return plain and unit.alone > len(unit.rows)


def _schedules(own: Ledger, units: Sequence[_Unit]) -> list[_Schedule]:
    """The schedules that save most: of each hand one, or one for each way to be turned; what is
    scaled is apart.
    """
    found: list[_Schedule] = []
    known: dict[tuple[int, ...], _Schedule | None] = {}

    def grown(group: Sequence[_Unit]) -> _Schedule | None:
        key = tuple(map(id, group))
        if key not in known:
            known[key] = _grown(own, group)
        return known[key]

    for mirrored, scaled in ((False, False), (True, False), (False, True), (True, True)):
        some = [unit for unit in units if (unit.mirrored, unit.scaled) == (mirrored, scaled)]
        ways = [
            [each for group in way if (each := grown(group)) is not None and each.gain > 0]
            for way in _ways(some)
        ]
        found += max(ways, key=lambda way: sum(each.gain for each in way), default=[])
    return found


def _ways(units: Sequence[_Unit]) -> Iterator[list[list[_Unit]]]:
    """All together; those about no axis or z, and the rest; those about no axis apart from them."""
    upright = [unit for unit in units if unit.about in (0, UPRIGHT)]
    rest = [unit for unit in units if unit.about not in (0, UPRIGHT)]
    plain = [unit for unit in upright if not unit.about]
    turned = [unit for unit in upright if unit.about]
    yield [list(units)]
    yield [upright, rest]
    yield [plain, turned, rest]
    yield [plain, [*turned, *rest]]


def _grown(own: Ledger, units: Sequence[_Unit]) -> _Schedule | None:
    """A schedule of what is written out otherwise, and of the tables that are shorter in it."""
    chosen = [unit for unit in units if len(unit.rows) == 1]
    if not chosen:
        return None
    best = _schedule(own, chosen)
    for unit in sorted(units, key=lambda each: len(each.rows)):
        if len(unit.rows) > 1:
            more = _schedule(own, [*best.units, unit])
            best = more if more.gain > best.gain else best
    for unit in list(best.units):
        fewer = [each for each in best.units if each is not unit]
        if len(fewer) >= FEWEST:
            less = _schedule(own, fewer)
            best = less if less.gain >= best.gain else best
    return best if len(best.rows) >= FEWEST else None


def _schedule(own: Ledger, units: Sequence[_Unit]) -> _Schedule:
    rows = np.concatenate([unit.rows for unit in units])
    tokens = columns(own, rows).tokens + 1 + len(rows)
    return _Schedule(tuple(units), sum(unit.alone for unit in units) - tokens)


def _scheduled(
    copies: Sequence[Copies],
    spots: Sequence[Spot],
    own: Ledger,
    schedule: _Schedule,
    name: str,
) -> tuple[ast.Element, ast.Table]:
    """A repeat over the table of a schedule, and the table."""
    layout = layout_of(spots, own, schedule.rows)
    rows = [
        (ast.Name(copies[unit.owner].name), *layout.cells(spots[row]))
        for unit in sorted(schedule.units, key=lambda each: each.owner)
        for row in unit.rows.tolist()
    ]
    body = behind(layout.common, (ast.Module(f"at.{SHAPE}"),))
    table = ast.Table(name, columns=(SHAPE, *layout.columns), rows=tuple(rows))
    return ast.Repeat(ast.Rows("at", name, places=True), body), table
