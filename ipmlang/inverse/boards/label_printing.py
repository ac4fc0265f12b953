"""Labelled things as syntax: the loop over their copies and the table of their labels.

Takes labelled things and the names of their symbols. Nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.places import SHAPE
from ipmlang.inverse.boards.board_printing import ROW, Printed, formula, on_lines
from ipmlang.inverse.boards.labelled import Labelled
from ipmlang.inverse.lsystem.frames import Row
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.moves import call, placing
from ipmlang.inverse.naming import Names
from ipmlang.inverse.numbers import number

TURN = 1e-9  # degrees, and share of a size, that a symbol inside may be off


def printed_labels(
    labelled: Labelled, names: Mapping[int, str], given: Names, error: float
) -> Printed:
    """The loop and its table; names: of the symbols; given: names that are taken; error: units,
    what a point may be off.
    """
    cells = _cells(labelled, names, error)
    rows = tuple(zip(*cells.values(), strict=True))
    table = ast.Table(given.give("Labels"), None, tuple(cells), rows)
    things = [
        _thing(
            f"{ROW}.{SHAPE}" if k == labelled.label else names[part],
            labelled.frames.rows()[k],
            error,
        )
        for k, part in enumerate(labelled.inside)
    ]
    if labelled.listed:
        at = call("at", ast.Name(f"{ROW}.x"), ast.Name(f"{ROW}.y"))
        body = ast.Bracket((at, *things))
        return Printed(labelled.start, ast.Repeat(ast.Rows(ROW, table.name), (body,)), table, ())
    index = _index(labelled)
    place = [
        formula(each, label, (*index, ast.Number(0.0)))
        for each, label in ((labelled.x, "x"), (labelled.y, "y"))
    ]
    nodes, count = _nodes(labelled)
    loop = ast.Repeat(
        ast.Count("k" if _in_lines(labelled) else "i", ast.Number(float(count))),
        (ast.Bracket((call("at", *place), *things)),),
        holes=tuple(ast.Number(float(k)) for k in np.setdiff1d(np.arange(count), nodes)),
        rows=ast.Rows(ROW, table.name),
    )
    return Printed(labelled.start, loop, table, ())


def _nodes(labelled: Labelled) -> tuple[Integers, int]:
    """The node of each copy, from 0, and how many nodes there are."""
    nodes = labelled.raster.node - labelled.raster.node[0]
    return nodes, int(nodes[-1]) + 1


def _cells(labelled: Labelled, names: Mapping[int, str], error: float) -> dict[str, list[ast.Expr]]:
    """The cells of each column, a row for every node: one without a copy has any label."""
    nodes, count = _nodes(labelled)
    shown = np.full(count, labelled.labels[0])
    shown[nodes] = labelled.labels
    cells: dict[str, list[ast.Expr]] = {SHAPE: [ast.Name(names[part]) for part in shown.tolist()]}
    for label, each in (("x", labelled.x), ("y", labelled.y)):
        if each.rest is not None:
            values = np.zeros(count)
            values[nodes] = each.at(labelled.raster) if labelled.listed else each.rest
            cells[label] = [number(value, error / 4) for value in values.tolist()]
    return cells


def _in_lines(labelled: Labelled) -> bool:
    raster = labelled.raster
    return bool(raster.node[-1] >= raster.across)


def _index(labelled: Labelled) -> tuple[ast.Expr, ast.Expr]:
    """Which step along a line, and which line."""
    if not _in_lines(labelled):
        return ast.Name("i"), ast.Number(0.0)
    return on_lines(labelled.raster)


def _thing(name: str, place: Row, error: float) -> ast.Element:
    """`[at(x, y, angle, scale) mirror A]`, what is nothing left out."""
    moves = placing(place, (error / 4, TURN, TURN))
    return ast.Bracket((*moves, ast.Module(name))) if moves else ast.Module(name)
