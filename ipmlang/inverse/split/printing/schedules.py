"""Schedules: one table that says of many symbols where their copies stand.

Takes the copies of all symbols in a body; gives elements for each, and the tables that they read. A
copy is written out, a row of its symbol's own table, or a row of a schedule, whose first column is
the symbol: whatever takes the fewest tokens together. Nothing here knows schemes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.inverse.naming import Names
from ipmlang.inverse.split.placing import Spot, placed
from ipmlang.inverse.split.printing.tables import (
    Layout,
    behind,
    grouped,
    layout_of,
    pays,
    row_tokens,
    spot_tokens,
    tabled,
    tokens_of,
)
from ipmlang.inverse.split.wording import is_nothing

SHAPE = "shape"
FEWEST = 3  # rows that are worth a schedule


@dataclass(frozen=True, slots=True)
class Copies:
    """A symbol's name, what draws it, and where it stands."""

    name: str
    inner: tuple[ast.Element, ...]
    spots: tuple[Spot, ...]


@dataclass(frozen=True, slots=True)
class _Unit:
    """Spots of one symbol that stay together; alone: tokens that they take by themselves."""

    owner: int
    spots: tuple[Spot, ...]
    alone: int


@dataclass(frozen=True, slots=True)
class _Schedule:
    """Units that share a table, and how their spots become its rows."""

    units: tuple[_Unit, ...]
    layout: Layout
    tokens: int

    @property
    def gain(self) -> int:
        """Tokens that it saves."""
        return sum(unit.alone for unit in self.units) - self.tokens


@dataclass(frozen=True, slots=True)
class Arrangement:
    """first: elements of the schedules; own: of the copies of each symbol that are in none."""

    first: tuple[ast.Element, ...]
    own: tuple[tuple[ast.Element, ...], ...]
    tables: tuple[ast.Table, ...]


def arrangement(copies: Sequence[Copies], title: str, names: Names) -> Arrangement:
    """The shortest way to place all copies; title: what a schedule is called, as a wish."""
    units = [unit for owner, each in enumerate(copies) for unit in _units(owner, each)]
    schedules = _schedules([unit for unit in units if _may_share(copies, unit)])
    shared = {id(unit) for schedule in schedules for unit in schedule.units}
    first: list[ast.Element] = []
    tables: list[ast.Table] = []
    for schedule in schedules:
        table = _table(copies, schedule, names.give(title))
        body = behind(schedule.layout.common, (ast.Module(f"at.{SHAPE}"),))
        tables.append(table)
        first.append(ast.Repeat(ast.Rows("at", table.name, places=True), body))
    own: list[tuple[ast.Element, ...]] = []
    for owner, each in enumerate(copies):
        elements: list[ast.Element] = []
        for unit in units:
            if unit.owner != owner or id(unit) in shared:
                continue
            if pays(unit.spots):
                element, table = tabled(unit.spots, each.inner, each.name, names)
                elements.append(element)
                tables.append(table)
            else:
                elements += [placed(spot, each.inner) for spot in unit.spots]
        own.append(tuple(elements))
    return Arrangement(tuple(first), tuple(own), tuple(tables))


def _units(owner: int, copies: Copies) -> Iterator[_Unit]:
    """The tables that a symbol would have by itself, and its copies that would be in none."""
    for group in grouped(copies.spots):
        if pays(group):
            yield _Unit(owner, tuple(group), tokens_of(group))
        else:
            yield from (_Unit(owner, (spot,), spot_tokens(spot)) for spot in group)


def _may_share(copies: Sequence[Copies], unit: _Unit) -> bool:
    """Whether a schedule may hold a unit: a plain symbol, that stands elsewhere than at home."""
    return len(copies[unit.owner].inner) == 1 and unit.alone > len(unit.spots)


def _schedules(units: Sequence[_Unit]) -> list[_Schedule]:
    """The schedules that save most: of each hand one, or one for each way to be turned; what is
    scaled is apart.
    """
    found: list[_Schedule] = []
    for mirrored, scaled in ((False, False), (True, False), (False, True), (True, True)):
        own = [
            unit
            for unit in units
            if unit.spots[0].mirrored == mirrored and _is_scaled(unit) == scaled
        ]
        ways = [_best(way) for way in _ways(own)]
        found += max(ways, key=lambda way: sum(each.gain for each in way), default=[])
    return found


def _is_scaled(unit: _Unit) -> bool:
    return any(spot.scale is not None for spot in unit.spots)


def _ways(units: Sequence[_Unit]) -> Iterator[list[list[_Unit]]]:
    """All together; those about no axis or z, and the rest; those about no axis apart from them."""
    upright = [unit for unit in units if _about(unit) <= {2}]
    rest = [unit for unit in units if not _about(unit) <= {2}]
    plain = [unit for unit in upright if not _about(unit)]
    turned = [unit for unit in upright if _about(unit)]
    yield [list(units)]
    yield [upright, rest]
    yield [plain, turned, rest]
    yield [plain, [*turned, *rest]]


def _about(unit: _Unit) -> set[int]:
    """The axes that its copies are turned about."""
    return {axis for spot in unit.spots for axis in range(3) if not is_nothing(spot.turn[axis])}


def _best(way: Sequence[Sequence[_Unit]]) -> list[_Schedule]:
    """Of each group the schedule that saves most, where one saves anything."""
    found = (_grown(group) for group in way if group)
    return [each for each in found if each is not None and each.gain > 0]


def _grown(units: Sequence[_Unit]) -> _Schedule | None:
    """A schedule of what is written out otherwise, and of the tables that are shorter in it."""
    chosen = [unit for unit in units if len(unit.spots) == 1]
    if not chosen:
        return None
    best = _schedule(chosen)
    for unit in sorted(units, key=lambda each: len(each.spots)):
        if len(unit.spots) > 1:
            more = _schedule([*best.units, unit])
            best = more if more.gain > best.gain else best
    for unit in list(best.units):
        fewer = [each for each in best.units if each is not unit]
        if len(fewer) >= FEWEST:
            less = _schedule(fewer)
            best = less if less.gain >= best.gain else best
    return best if sum(len(unit.spots) for unit in best.units) >= FEWEST else None


def _schedule(units: Sequence[_Unit]) -> _Schedule:
    spots = [spot for unit in units for spot in unit.spots]
    layout = layout_of(spots)
    return _Schedule(tuple(units), layout, row_tokens(spots, layout) + 1 + len(spots))


def _table(copies: Sequence[Copies], schedule: _Schedule, name: str) -> ast.Table:
    rows = [
        (ast.Name(copies[unit.owner].name), *schedule.layout.cells(spot))
        for unit in sorted(schedule.units, key=lambda each: each.owner)
        for spot in unit.spots
    ]
    return ast.Table(name, columns=(SHAPE, *schedule.layout.columns), rows=tuple(rows))
