"""Copies of many things that no rule explains, as rows of a table whose `r.shape` stands in each.

Takes the bodies of rules as they are printed; where many placements follow each other, each of
another symbol, another turn or another size, gives a table with a row for each and the loop that
reads it, wherever that is shorter than the placements or a walk along them. What is drawn, and in
which order, stays the same. Copies of one thing have their tables from `build`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.places import SHAPE
from ipmlang.inverse.gridded_tables import Grid, grid_of, gridded_loop
from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import Names

ROW = "r"
LABELS = ("x", "y", "angle", "scale")
REST = (0.0, 0.0, 0.0, 1.0)
HEAD = 18  # tokens of `table T(shape, x, y) =` and of `repeat(r in T) { [at(r.x, r.y) r.shape] }`
LEAST_EVEN = 8  # unlike things in even steps that are worth a loop
LEAST = 20  # tokens that a table saves
MOST = 2 / 3  # of the tokens that the placements take: one reads a walk sooner than a table
ALONE = 4  # tokens that a placement takes with a table before and behind, for it breaks them

Extra: TypeAlias = "tuple[bool, bool, bool]"  # mirrored; whether rows say an angle, and a scale


@dataclass(frozen=True, slots=True)
class _Copy:
    """`[at(x, y, angle, scale) mirror A]`."""

    at: tuple[float, float, float, float]
    mirrored: bool
    thing: ast.Module

    @property
    def tokens(self) -> int:
        """What it takes where it stands alone."""
        moved = self.at[0] or self.at[1]
        last = 4 if self.at[3] != 1 else 3 if self.at[2] else 2
        said = 3 + last + _signs(self.at[:last]) if moved else 4 * (last - 2)
        inside = said + self.mirrored
        return 1 + (2 + inside if inside else 0)

    def fits(self, extra: Extra) -> bool:
        """Whether a table can have it as a row."""
        mirrored, turned, scaled = extra
        return (
            self.mirrored == mirrored
            and (turned or self.at[2] == 0)
            and (scaled or self.at[3] == 1)
        )

    def row_tokens(self, extra: Extra) -> int:
        """What it takes as a row."""
        last = 2 + extra[1] + extra[2]
        return 1 + last + _signs(self.at)


TABLES: tuple[Extra, ...] = tuple(
    (mirrored, turned, scaled)
    for mirrored in (False, True)
    for turned in (False, True)
    for scaled in (False, True)
)


def _signs(values: Sequence[float]) -> int:
    return sum(value < 0 for value in values)


@dataclass(frozen=True, slots=True, eq=False)
class Schedules:
    """Rules and the tables that stand in them: about how many tokens each spares, and how many rows
    those have that stand on grids.
    """

    rules: list[ast.Rule]
    tables: list[ast.Table]
    spared: dict[str, float]
    even: dict[str, int]


@dataclass(slots=True, eq=False)
class _Listing:
    """The tables that were made, and about how many tokens they spare; even: how many rows those
    have that stand on grids; error: units, what a place on one may be off.
    """

    names: Names
    error: float
    tables: list[ast.Table] = field(default_factory=list)
    spared: dict[str, float] = field(default_factory=dict)
    even: dict[str, int] = field(default_factory=dict)


def with_schedules(
    rules: Sequence[ast.Rule], things: Set[str], names: Names, error: float
) -> Schedules:
    """The rules, with tables of what stands in them; things: names of symbols, and no others;
    error: units, what a place on a grid may be off.
    """
    listing = _Listing(names, error)
    made = [replace(rule, body=tuple(_scheduled(rule.body, things, listing))) for rule in rules]
    return Schedules(made, listing.tables, listing.spared, listing.even)


def _scheduled(
    body: tuple[ast.Element, ...], things: Set[str], listing: _Listing
) -> Iterator[ast.Element]:
    run: list[tuple[_Copy, ast.Element]] = []
    for element in body:
        copy = _copy(element, things)
        if copy is not None:
            run.append((copy, element))
            continue
        yield from _written(run, listing)
        run = []
        if isinstance(element, ast.Bracket):
            yield replace(element, body=tuple(_scheduled(element.body, things, listing)))
        else:
            yield element
    yield from _written(run, listing)


def _copy(element: ast.Element, things: Set[str]) -> _Copy | None:
    """What a table can have as a row."""
    match element:
        case ast.Module(name, ()) if name in things:
            return _Copy(REST, False, element)
        case ast.Bracket((*moves, ast.Module(name, ()) as thing)) if name in things:
            mirrored = bool(moves) and moves[-1] == ast.Module("mirror")
            at = _place(moves[:-1] if mirrored else moves)
            return None if at is None else _Copy(at, mirrored, thing)
    return None


def _place(moves: Sequence[ast.Element]) -> tuple[float, float, float, float] | None:
    """Where moves lead that are `at(…)`, or turns and a factor."""
    at = list(REST)
    for number, move in enumerate(moves):
        if not isinstance(move, ast.Module):
            return None
        values = [_number(each.value) for each in move.args]
        known = [value for value in values if value is not None]
        if len(known) < len(values):
            return None
        match move.name, known:
            case "at", [x, y, *more] if number == 0:
                at = [x, y, *more, *REST[2 + len(more) :]]
            case "+" | "-" as sign, [angle] if number == 0:
                at[2] = angle if sign == "+" else -angle
            case "*", [factor] if number == len(moves) - 1:
                at[3] *= factor
            case _:
                return None
    x, y, angle, scale = at
    return x, y, angle, scale


def _number(value: ast.Expr) -> float | None:
    match value:
        case ast.Number(number):
            return number
        case ast.Unary("-", ast.Number(number)):
            return -number
    return None


# ------------------------------------------------------------------------- which rows


def _written(run: Sequence[tuple[_Copy, ast.Element]], listing: _Listing) -> Iterator[ast.Element]:
    """The run, its tables in place of what they hold."""
    begin = 0
    for start, stop, grid in _even([copy for copy, _ in run], listing.error):
        yield from _listed(run[begin:start], listing)
        yield _on_grid([copy for copy, _ in run[start:stop]], grid, listing)
        begin = stop
    yield from _listed(run[begin:], listing)


def _even(copies: Sequence[_Copy], error: float) -> Iterator[tuple[int, int, Grid]]:
    """The stretches of unlike things in even steps, and from line to line in even steps."""
    places = np.array([complex(*copy.at[:2]) for copy in copies])
    steps, room = np.diff(places), 4 * error
    begin = 0
    while begin + LEAST_EVEN <= len(copies):
        on = np.abs(steps[begin:] - steps[begin]) <= room
        count = len(on) + 1 if on.all() else int(np.argmin(on)) + 1
        stop = begin + count
        while count > 2 and on[stop - begin : stop - begin + count - 1].sum() == count - 1:
            stop += count
        grid = _grid(copies[begin:stop], places[begin:stop], error)
        if grid is not None:
            yield begin, stop, grid
        begin = stop if grid is not None else begin + max(1, count - 1)


def _grid(copies: Sequence[_Copy], places: Complexes, error: float) -> Grid | None:
    """The grid of upright things that differ, if it is one."""
    plain = all(copy.at[2:] == REST[2:] and not copy.mirrored for copy in copies)
    unlike = len({copy.thing.name for copy in copies}) > 1
    return grid_of(places, error) if plain and unlike and len(copies) >= LEAST_EVEN else None


def _on_grid(copies: Sequence[_Copy], grid: Grid, listing: _Listing) -> ast.Element:
    """The loop over the nodes of a grid, and the table of what stands on each."""
    cells = tuple((ast.Name(copy.thing.name),) for copy in copies)
    table = ast.Table(listing.names.give("Places"), None, (SHAPE,), cells)
    listing.tables.append(table)
    listing.even[table.name] = len(copies)
    return gridded_loop(grid, table, ROW, (), (ast.Module(f"{ROW}.{SHAPE}"),))


def _listed(run: Sequence[tuple[_Copy, ast.Element]], listing: _Listing) -> Iterator[ast.Element]:
    """The run, tables of places in place of what they hold."""
    copies = [copy for copy, _ in run]
    for start, end, extra in _parts(copies):
        before = [None, *copies][start:end]
        alone = sum(map(_cost, copies[start:end], before, [None] * (end - start)))
        rows = 0 if extra is None else sum(copy.row_tokens(extra) for copy in copies[start:end])
        if extra is None or rows + HEAD > MOST * alone:
            yield from (element for _, element in run[start:end])
            continue
        table, loop = _table(copies[start:end], extra[0], listing.names)
        listing.tables.append(table)
        listing.spared[table.name] = alone - rows - HEAD
        yield loop


def _parts(copies: Sequence[_Copy]) -> list[tuple[int, int, Extra | None]]:
    """Stretches of a run, each with its kind of table, None for placements as they are: the
    shortest way to say all, step by step.
    """
    if not copies:
        return []
    ways: tuple[Extra | None, ...] = (None, *TABLES)
    costs = _costs(copies)
    opened = HEAD + LEAST  # tokens of a table's beginning
    best = [cost + opened * (way is not None) for way, cost in zip(ways, next(costs), strict=True)]
    came: list[list[int]] = []
    for own in costs:
        lowest = min(best)
        least, fresh = best.index(lowest), lowest + opened
        came.append([way if cost <= fresh else least for way, cost in enumerate(best)])
        came[-1][0] = least if best[0] > lowest else 0
        onward = [lowest, *(min(cost, fresh) for cost in best[1:])]
        best = [cost + more for cost, more in zip(onward, own, strict=True)]
    return _stretches(best, came, ways)


def _costs(copies: Sequence[_Copy]) -> Iterator[list[float]]:
    """What each copy takes by itself, and as a row of each kind of table."""
    known: dict[tuple[bool, bool, bool], list[float]] = {}
    before: _Copy | None = None
    for copy in copies:
        key, signs = (copy.mirrored, copy.at[2] == 0, copy.at[3] == 1), _signs(copy.at)
        if key not in known:
            known[key] = [_cost(copy, None, way) - signs for way in TABLES]
        yield [_cost(copy, before, None), *(cost + signs for cost in known[key])]
        before = copy


def _cost(copy: _Copy, before: _Copy | None, way: Extra | None) -> float:
    if way is not None:
        return float(copy.row_tokens(way)) if copy.fits(way) else float("inf")
    if before is not None and _steps(before, copy):
        return 1.0 + ALONE * (copy.at[0] != before.at[0])
    return float(copy.tokens)


def _steps(here: _Copy, there: _Copy) -> bool:
    """Whether a walk leads from one to the next."""
    plain = here.at[2:] == there.at[2:] == REST[2:] and not (here.mirrored or there.mirrored)
    return plain and here.at[1] == there.at[1] and here.at[0] <= there.at[0]


def _stretches(
    best: Sequence[float], came: Sequence[Sequence[int]], ways: Sequence[Extra | None]
) -> list[tuple[int, int, Extra | None]]:
    way = min(range(len(ways)), key=lambda each: best[each])
    made: list[tuple[int, int, Extra | None]] = []
    end = len(came) + 1
    for number in range(len(came), 0, -1):
        earlier = came[number - 1][way]
        if earlier != way:
            made.append((number, end, ways[way]))
            way, end = earlier, number
    made.append((0, end, ways[way]))
    return made[::-1]


# -------------------------------------------------------------------------- one table


def _table(copies: Sequence[_Copy], mirrored: bool, names: Names) -> tuple[ast.Table, ast.Element]:
    """A table of copies, and the loop that draws them."""
    columns = list(zip(*(copy.at for copy in copies), strict=True))
    varying = [len(set(column)) > 1 for column in columns]
    last = max((k + 1 for k in range(4) if varying[k] or columns[k][0] != REST[k]), default=0)
    things = [copy.thing for copy in copies]
    many = len({thing.name for thing in things}) > 1
    name = names.give("Places")
    labels = [SHAPE] * many + [label for label, own in zip(LABELS, varying, strict=True) if own]
    cells = [[ast.Name(thing.name) for thing in things]] if many else []
    rows = _rows(cells, [column for column, own in zip(columns, varying, strict=True) if own])
    moves = [
        ast.Name(f"{ROW}.{label}") if own else ast.Number(column[0])
        for label, own, column in zip(LABELS, varying, columns, strict=True)
    ]
    body: list[ast.Element] = [call("at", *moves[: max(2, last)])] if last else []
    body += [ast.Module("mirror")] * mirrored
    body.append(ast.Module(f"{ROW}.{SHAPE}") if many else things[0])
    table = ast.Table(name, None, tuple(labels), rows)
    return table, ast.Repeat(ast.Rows(ROW, name), (ast.Bracket(tuple(body)),))


def _rows(
    names: Sequence[Sequence[ast.Expr]], columns: Sequence[Sequence[float]]
) -> tuple[tuple[ast.Expr, ...], ...]:
    numbers = [[ast.Number(value) for value in column] for column in columns]
    return tuple(zip(*names, *numbers, strict=True))
