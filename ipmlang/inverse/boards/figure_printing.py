"""Figures of lines as syntax: a table of places and lengths, the loop over it, one rule.

Takes figures and the names of their symbols; gives the loop, `repeat(r in Figures) { [at(r.x, r.y)
Figure(r.a, r.b)] }`, and the rule that draws one. Nothing here decides anything.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.boards.board_printing import Printed
from ipmlang.inverse.boards.figures import Figures, Line
from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import number, settled, shortest

ROW = "r"
LABELS = ("a", "b", "c", "d")
SHARE = 0.25  # of what a point may be off that one number takes


def printed_figures(
    found: Figures, names: Mapping[int, str], given: Names, error: float, table: str | None
) -> Printed:
    """The loop, its table and its rule. names: of the symbols; given: names that are taken; error:
    units, what a point may be off; table: that of figures with the same places and lengths.
    """
    labels = LABELS[: found.lengths.shape[1]]
    head = ast.Head(given.give("Figure"), tuple(map(ast.Parameter, labels)))
    reach = np.abs(found.lengths).max(axis=0)
    body = tuple(
        ast.Bracket(tuple(_drawn(line, labels, names, reach, error))) for line in found.lines
    )
    rows = None
    if table is None:
        columns = [found.at.real, found.at.imag, *found.lengths.T]
        cells = [[number(each, SHARE * error) for each in column.tolist()] for column in columns]
        rows = ast.Table(
            given.give("Figures"), None, ("x", "y", *labels), tuple(zip(*cells, strict=True))
        )
        table = rows.name
    at = call("at", ast.Name(f"{ROW}.x"), ast.Name(f"{ROW}.y"))
    lengths = tuple(ast.Argument(ast.Name(f"{ROW}.{label}")) for label in labels)
    copy = ast.Bracket((at, ast.Module(head.name, lengths)))
    loop = ast.Repeat(ast.Rows(ROW, table), (copy,))
    return Printed(found.start, loop, rows, (ast.Rule(head, body),))


def _drawn(
    line: Line, labels: Sequence[str], names: Mapping[int, str], reach: Floats, error: float
) -> Iterator[ast.Element]:
    """`at(0, a, 90, b) line`"""
    small = SHARE * error
    room = small / np.concatenate([[1.0], reach])
    begins = [
        [settled(float(each), float(own)) for each, own in zip(values, room, strict=True)]
        for values in (line.begins.real, line.begins.imag)
    ]
    size = float(reach[line.length]) * line.factor if line.length >= 0 else line.factor
    angle = shortest(line.angle, math.degrees(small / size))
    length: ast.Expr = number(line.factor, small)
    if line.length >= 0:
        factor = settled(line.factor, small / float(reach[line.length]), 1.0)
        length = _times(factor, labels[line.length])
    if any(any(values) for values in begins):
        yield call("at", *(_sum(values, labels) for values in begins), number(angle), length)
    else:
        if angle:
            yield call("+" if angle > 0 else "-", number(abs(angle)))
        yield call("*", length)
    yield ast.Module(names[line.part])


def _sum(values: Sequence[float], labels: Sequence[str]) -> ast.Expr:
    """`1.5 - 0.8 * a + b`"""
    made: ast.Expr | None = None
    for label, value in zip(("", *labels), values, strict=True):
        if not value:
            continue
        if made is None:
            made = _times(value, label) if label else number(value)
            continue
        term = _times(abs(value), label)
        made = ast.Binary("+" if value > 0 else "-", made, term)
    return ast.Number(0.0) if made is None else made


def _times(value: float, label: str) -> ast.Expr:
    name = ast.Name(label)
    if value == 1:
        return name
    return ast.Unary("-", name) if value == -1 else ast.Binary("*", number(value), name)
