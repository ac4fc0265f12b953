"""The places that the rows of a table say, as operations that lead to them.

In go the columns of a table, out come elements that read a row: `translate`, `rotate`, a factor. A
column that is missing moves nothing. What the other columns mean is for those who read them.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast

AT = "at"  # what the row is called in the body
SHIFTS = ("x", "y", "z")
TURNS = ("rx", "ry", "rz")
SCALE = "scale"
COLUMNS = (*SHIFTS, *TURNS, SCALE)


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
