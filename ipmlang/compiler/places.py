"""The places that the rows of a table say, as operations that lead to them.

In go the columns of a table, out come elements that read a row: `translate`, `rotate`, a factor. A
column that is missing moves nothing; a column `shape` names the symbol that stands in each place.
What further columns mean is for those who read them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

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


def only(table: ast.Table, shape: str) -> ast.Table:
    """The rows of a table that place a symbol, without the column `shape`."""
    column = table.columns.index(SHAPE)
    rows = tuple(row for row in table.rows if row[column] == ast.Name(shape))
    return without_shapes(replace(table, rows=rows))


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
