"""Tables whose rows stand on a grid, line by line: the places become a formula, the rest stays.

Takes rules and tables as they are printed; where the rows that one loop places lie in even steps
along even lines (the cells of a heat map, a board, the days of a month), gives a loop that counts
and reads only what differs from cell to cell: `repeat(k < 84) with r in T { … r.shape }`. What is
drawn, and in which order, stays the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lattices.formula import Formula
from ipmlang.inverse.lattices.printing import indices, predicted
from ipmlang.inverse.lsystem.frames import Complexes, frames
from ipmlang.inverse.moves import call
from ipmlang.inverse.numbers import shortest

LEAST = 8  # rows that are worth a formula
SHORTEST = 3  # members of a line, if there are several
AXES = ("x", "y")


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Node k + skipped of a formula is where row k stands, about an origin."""

    formula: Formula
    origin: complex
    skipped: int


@dataclass(slots=True, eq=False)
class Gridded:
    """The rules and tables with grids; names: of the tables that have become one; cells: how many
    rows they have.
    """

    rules: list[ast.Rule]
    tables: list[ast.Table]
    names: set[str] = field(default_factory=set)
    cells: int = 0


NO_GRIDS = Gridded([], [])


def with_grids(rules: Sequence[ast.Rule], tables: Sequence[ast.Table], error: float) -> Gridded:
    """Rules and tables, those that grids say shorter as these. error: units, what a place may be
    off.
    """
    known = {table.name: table for table in tables}
    used = Counter(name for rule in rules for name in _read(rule.body))
    made = Gridded([], [])
    left = dict(known)
    for rule in rules:
        body = tuple(_element(each, left, used, error, made) for each in rule.body)
        made.rules.append(replace(rule, body=body))
    made.tables = [left[name] for name in known if left[name].columns]
    return made


def _read(body: tuple[ast.Element, ...]) -> Iterator[str]:
    """The tables that loops read."""
    for element in body:
        if isinstance(element, ast.Repeat):
            if isinstance(element.head, ast.Rows):
                yield element.head.table
            if element.rows is not None:
                yield element.rows.table
        if isinstance(element, ast.Repeat | ast.Bracket):
            yield from _read(element.body)


def _element(
    element: ast.Element,
    tables: dict[str, ast.Table],
    used: Counter[str],
    error: float,
    made: Gridded,
) -> ast.Element:
    if isinstance(element, ast.Bracket):
        inner = tuple(_element(each, tables, used, error, made) for each in element.body)
        return replace(element, body=inner)
    match element:
        case ast.Repeat(
            ast.Rows(row, name),
            (ast.Bracket((ast.Module("at", (x, y, *more)), *rest)),),
        ) if used[name] == 1 and name in tables:
            table = tables[name]
            places = _places(table, row, (x.value, y.value))
            grid = None if places is None else grid_of(places, error)
            if grid is None:
                return element
            tables[name] = _without_places(table)
            made.names.add(name)
            made.cells += len(table.rows)
            return gridded_loop(grid, tables[name], row, tuple(more), tuple(rest))
    return element


def _places(table: ast.Table, row: str, said: tuple[ast.Expr, ast.Expr]) -> Complexes | None:
    """Where the rows stand; None where something else is said of it than columns and numbers."""
    values = []
    for each, axis in zip(said, AXES, strict=True):
        match each:
            case ast.Number(value):
                values.append(np.full(len(table.rows), value))
            case ast.Name(name) if name == f"{row}.{axis}" and axis in table.columns:
                column = table.columns.index(axis)
                cells = [cells[column] for cells in table.rows]
                numbers = [cell.value for cell in cells if isinstance(cell, ast.Number)]
                if len(numbers) < len(cells):
                    return None
                values.append(np.array(numbers))
            case _:
                return None
    return np.asarray(values[0] + 1j * values[1], np.complex128)


def _without_places(table: ast.Table) -> ast.Table:
    keep = [k for k, name in enumerate(table.columns) if name not in AXES]
    rows = tuple(tuple(cells[k] for k in keep) for cells in table.rows)
    return replace(table, columns=tuple(table.columns[k] for k in keep), rows=rows)


def gridded_loop(
    grid: Grid,
    table: ast.Table,
    row: str,
    more: tuple[ast.Argument, ...],
    rest: tuple[ast.Element, ...],
) -> ast.Element:
    """`[at(x, y) repeat(k < n) with r in T { [at(…) …] }]`, or lines of as many where the table has
    nothing to say; more: arguments of `at` beside x and y; rest: what stands there.
    """
    formula, several = grid.formula, bool(grid.formula.across)
    lines = several and not table.columns and not grid.skipped and not _repeats(rest)
    lines = lines and formula.count % formula.across == 0
    variable = "k" if several else "i"
    count: ast.Expr = ast.Name(variable)
    if grid.skipped:
        count = ast.Binary("+", count, ast.Number(float(grid.skipped)))
    (place,) = predicted(formula, *indices(formula, lines, count if several else None))
    assert isinstance(place, ast.Module)
    copy = ast.Bracket((replace(place, args=(*place.args, *more)), *rest))
    rows = ast.Rows(row, table.name) if table.columns else None
    if lines:
        loop = _counted("j", formula.count // formula.across, _counted("i", formula.across, copy))
    else:
        loop = replace(_counted(variable, formula.count - grid.skipped, copy), rows=rows)
    if not grid.origin:
        return loop
    at = call("at", ast.Number(grid.origin.real), ast.Number(grid.origin.imag))
    return ast.Bracket((at, loop))


def _counted(variable: str, count: int, copy: ast.Element) -> ast.Repeat:
    return ast.Repeat(ast.Count(variable, ast.Number(float(count))), (copy,))


def _repeats(body: Sequence[ast.Element]) -> bool:
    """Whether there are loops in it, which have names of their own."""
    inner = (each.body for each in body if isinstance(each, ast.Bracket))
    return any(isinstance(each, ast.Repeat) for each in body) or any(map(_repeats, inner))


# --------------------------------------------------------------------------- the grid


def grid_of(places: Complexes, error: float) -> Grid | None:
    """The grid whose nodes are these places (n,) one after the other, None if there is none."""
    if len(places) < LEAST:
        return None
    steps = np.diff(places)
    usual = np.median(steps.real) + 1j * np.median(steps.imag)
    if abs(usual) <= 4 * error:
        return None
    ends = np.flatnonzero(np.abs(steps - usual) > 4 * error) + 1
    lengths = np.diff(np.concatenate([[0], ends, [len(places)]]))
    across = int(lengths[1:-1].max(initial=lengths[0])) if len(ends) else len(places)
    whole = bool((lengths[1:-1] == across).all()) and int(lengths[-1]) <= across
    if not whole or int(lengths[0]) > across or (len(ends) and across < SHORTEST):
        return None
    skipped = across - int(lengths[0])
    return _fitted(places, across if len(ends) else 0, skipped if len(ends) else 0, error)


def _fitted(places: Complexes, across: int, skipped: int, error: float) -> Grid | None:
    """The grid with short numbers, None where a place is off."""
    node = np.arange(skipped, skipped + len(places), dtype=np.float64)
    i, j = (node % across, node // across) if across else (node, np.zeros(len(node)))
    lines = int(j.max()) + 1
    columns = [np.ones(len(node)), i]
    columns += [j] * (lines > 1) + [j % 2] * (lines > 2)
    solved = np.linalg.lstsq(np.stack(columns, axis=1), places, rcond=None)[0]
    origin, along, down, aside = (*solved.tolist(), 0.0, 0.0)[:4]
    if abs(aside) <= 4 * error:
        aside = 0.0
        solved = np.linalg.lstsq(np.stack(columns[:3], axis=1), places, rcond=None)[0]
        origin, along, down = (*solved.tolist(), 0.0)[:3]
    origin, along, down, aside = (
        complex(_short(each.real, each_error), _short(each.imag, each_error))
        for each, each_error in zip(
            map(complex, (origin, along, down, aside)),
            (error, error / len(places), error / lines, error),
            strict=True,
        )
    )
    stagger = aside / along
    if abs(stagger.imag) * abs(along) > error:
        return None
    moves = np.array([[along.real, down.real, 0.0], [along.imag, down.imag, 0.0]])
    share = shortest(stagger.real, error / abs(along))
    made = origin + along * (i + share * (j % 2)) + down * j
    if np.abs(made - places).max() > 2 * error:
        return None
    still = np.zeros(2)
    lead = frames(np.zeros(1, np.complex128))
    count = skipped + len(places)
    return Grid(
        Formula(count, across, lead, moves, None, still, still, stagger=share), origin, skipped
    )


def _short(value: float, error: float) -> float:
    return 0.0 if abs(value) <= error else shortest(value, error)
