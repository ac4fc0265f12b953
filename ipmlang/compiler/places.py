"""The places that the rows of a table say, as operations that lead to them.

In go the columns of a table, out come elements that read a row: `translate`, `rotate`, a factor. A
column that is missing moves nothing; a column `shape` names the symbol that stands in each row's
copy, whatever the row is called.
What further columns mean is for those who read them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from ipmlang.compiler import ast

AT = "at"  # what the row is called in the body
SHAPE = "shape"  # the column of symbols, which the body places as `at.shape`
PLACED = f"{AT}.{SHAPE}"
SHIFTS = ("x", "y", "z")
TURNS = ("rx", "ry", "rz")
SCALE = "scale"
COLUMNS = (*SHIFTS, *TURNS, SCALE)


def shapes_of(table: ast.Table) -> tuple[str, ...]:
    """The symbols in a table's column `shape`, each once, in order."""
    if SHAPE not in table.columns:
        return ()
    cells = (row[table.columns.index(SHAPE)] for row in table.rows)
    return tuple(dict.fromkeys(cell.id for cell in cells if isinstance(cell, ast.Name)))


def in_runs(table: ast.Table) -> bool:
    """Whether the rows of each symbol stand together, so that symbol by symbol is row by row."""
    column = table.columns.index(SHAPE)
    cells = [row[column] for row in table.rows]
    changes = sum(one != other for one, other in pairwise(cells))
    return changes < len(shapes_of(table))


def by_shape(table: ast.Table) -> dict[str, ast.Table]:
    """For each symbol that a table places its rows, without the column `shape`."""
    column = table.columns.index(SHAPE)
    found: dict[str, list[tuple[ast.Expr, ...]]] = {}
    for row in table.rows:
        cell = row[column]
        if isinstance(cell, ast.Name):
            found.setdefault(cell.id, []).append(row[:column] + row[column + 1 :])
    columns = table.columns[:column] + table.columns[column + 1 :]
    return {
        shape: replace(table, columns=columns, rows=tuple(rows)) for shape, rows in found.items()
    }


def choices(table: ast.Table) -> ast.Table:
    """The column `shape` alone, its symbols as numbers of `shapes_of`."""
    column, known = table.columns.index(SHAPE), shapes_of(table)
    number: dict[ast.Expr, ast.Expr] = {
        ast.Name(name): ast.Number(float(k)) for k, name in enumerate(known)
    }
    rows = tuple((number[row[column]],) for row in table.rows)
    return replace(table, columns=(SHAPE,), rows=rows)


def row_of(name: str) -> str:
    """The variable of the row whose symbol a module names: r of `r.shape`, else nothing."""
    row, _, column = name.rpartition(".")
    return row if column == SHAPE else ""


def without_shapes(table: ast.Table) -> ast.Table:
    """A table without its column `shape`."""
    column = table.columns.index(SHAPE)
    rows = tuple(row[:column] + row[column + 1 :] for row in table.rows)
    return replace(table, columns=table.columns[:column] + table.columns[column + 1 :], rows=rows)


def way_to_place(columns: Sequence[str], span: ast.Span) -> tuple[ast.Module, ...]:
    """The operations for a row of a table with these columns, none for what it has no column for.

    >>> [step.name for step in way_to_place(("x", "rz", "color"), ast.Span(0, 0))]
    ['translate', 'rotate']
    """
    steps = []
    for name, wanted in (("translate", SHIFTS), ("rotate", TURNS), ("*", (SCALE,))):
        if not set(wanted).isdisjoint(columns):
            args = tuple(ast.Argument(_cell(each, columns, span)) for each in wanted)
            steps.append(ast.Module(name, args, span))
    return tuple(steps)


def _cell(column: str, columns: Sequence[str], span: ast.Span) -> ast.Expr:
    return ast.Name(f"{AT}.{column}", span) if column in columns else ast.Number(0.0, "0", span)
