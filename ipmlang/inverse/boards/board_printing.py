"""A board as syntax: the loop over its nodes, the table of sizes, the rule that reads a size.

Takes a board and the names of its symbols; gives a loop, a table where there is something to list,
and a rule where sizes stand for several shapes. Nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.places import SHAPE
from ipmlang.inverse.boards.board import Board
from ipmlang.inverse.boards.coordinates import Coordinate
from ipmlang.inverse.boards.raster import Raster
from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.moves import call
from ipmlang.inverse.naming import Names, capital
from ipmlang.inverse.numbers import number

ROW = "r"
SIZE = "size"


@dataclass(frozen=True, slots=True)
class Printed:
    """What stands in a grammar for rows of the axiom from `start` on."""

    start: int
    loop: ast.Repeat
    table: ast.Table | None
    rules: tuple[ast.Rule, ...]


def printed_board(board: Board, names: Mapping[int, str], given: Names) -> Printed:
    """The loop, its table and its rules; names: of the symbols; given: names that are taken."""
    columns = _columns(board, names)
    rules: tuple[ast.Rule, ...] = ()
    if board.sized is not None and board.codes:
        rules = _rules(board, names, given.give(capital(names[board.sized])))
    i, j = _indices(board, columns)
    size = _size(board)
    at = [formula(each, label, (i, j, size)) for each, label in ((board.x, "x"), (board.y, "y"))]
    body = _thing(board, columns, names, rules, at)
    table = None
    if columns:
        rows = tuple(zip(*columns.values(), strict=True))
        table = ast.Table(given.give("Board"), None, tuple(columns), rows)
    return Printed(board.start, _loop(board, body, table), table, rules)


def _loop(board: Board, body: tuple[ast.Element, ...], table: ast.Table | None) -> ast.Repeat:
    """The lines and the steps along each where all are alike, else all nodes in one."""
    if board.full and table is None:
        along = ast.Count("i", ast.Number(float(board.raster.across)))
        lines = ast.Count("j", ast.Number(float(board.count // board.raster.across)))
        return ast.Repeat(lines, (ast.Repeat(along, (ast.Bracket(body),)),))
    return ast.Repeat(
        ast.Count("k", ast.Number(float(board.count))),
        (ast.Bracket(body),),
        holes=_holes(board),
        rows=None if table is None else ast.Rows(ROW, table.name),
    )


def _thing(
    board: Board,
    columns: Mapping[str, object],
    names: Mapping[int, str],
    rules: tuple[ast.Rule, ...],
    at: list[ast.Expr],
) -> tuple[ast.Element, ...]:
    """`at(x, y) Dot(r.size)`, or with a size and a shape from the table."""
    size = ast.Name(f"{ROW}.{SIZE}")
    if rules:
        return call("at", *at), ast.Module(rules[0].head.name, (ast.Argument(size),))
    more: list[ast.Expr] = [ast.Number(0.0), size] if SIZE in columns else []
    only = names[int(board.part[0])]
    shape = f"{ROW}.{SHAPE}" if SHAPE in columns else only
    return call("at", *at, *more), ast.Module(shape)


def _holes(board: Board) -> tuple[ast.Expr, ...]:
    """Nodes on which nothing stands, where no size says so."""
    if None in board.codes:
        return ()
    empty = np.setdiff1d(np.arange(board.count), board.nodes)
    return tuple(ast.Number(float(each)) for each in empty)


# ------------------------------------------------------------------------ the table


def _columns(board: Board, names: Mapping[int, str]) -> dict[str, list[ast.Expr]]:
    """The cells of each column that says something, a row for every node."""
    made: dict[str, list[ast.Expr]] = {}
    kinds = np.unique(board.part)
    if board.sized is None and len(kinds) > 1:
        shown = np.full(board.count, int(board.part[0]), np.int64)
        shown[board.nodes] = board.part
        made[SHAPE] = [ast.Name(names[part]) for part in shown.tolist()]
    for label, each in (("x", board.x), ("y", board.y)):
        if each.rest is not None:
            made[label] = _cells(board, each.rest)
    if (board.size != 1).any() or None in board.codes:
        made[SIZE] = _cells(board, board.size, board.codes.get(None, 0.0))
    return made


def _cells(board: Board, values: Floats, empty: float = 0.0) -> list[ast.Expr]:
    full = np.full(board.count, empty)
    full[board.nodes] = values
    return [number(round(value, 12)) for value in full.tolist()]


# ------------------------------------------------------------------------ the rules


def _rules(board: Board, names: Mapping[int, str], name: str) -> tuple[ast.Rule, ...]:
    """`Dot(size) : size > 0 --> *(size) circle`, and what else a size can mean."""
    assert board.sized is not None
    head = ast.Head(name, (ast.Parameter(SIZE),))
    size, order = ast.Name(SIZE), sorted(board.codes.items(), key=lambda each: -each[1])
    large = ast.Bracket((call("*", size), ast.Module(names[board.sized])))
    made = [ast.Rule(head, (large,), ast.Binary(">", size, number(order[0][1])))]
    for part, code in order:
        body = ast.Module("nil" if part is None else names[part])
        equal = ast.Binary("==", size, number(code))
        made.append(ast.Rule(head, (body,), ast.Otherwise() if code == order[-1][1] else equal))
    return tuple(made)


# -------------------------------------------------------------------------- formulas


def _indices(board: Board, columns: Mapping[str, object]) -> tuple[ast.Expr, ast.Expr]:
    """Which step along the line, and which line node k is."""
    if board.full and not columns:
        return ast.Name("i"), ast.Name("j")
    return on_lines(board.raster)


def on_lines(raster: Raster) -> tuple[ast.Expr, ast.Expr]:
    """Which step along its line node k of a raster is, and on which line."""
    k: ast.Expr = ast.Name("k")
    across = ast.Number(float(raster.across))
    skipped = int(raster.node[0])
    if skipped:
        k = ast.Binary("+", k, ast.Number(float(skipped)))
    return _function("mod", k, across), _function("floor", ast.Binary("/", k, across))


def _function(name: str, *args: ast.Expr) -> ast.Call:
    return ast.Call(name, tuple(ast.Argument(each) for each in args))


def _size(board: Board) -> ast.Expr:
    """The size of what stands on a node, 0 of what has none."""
    size = ast.Name(f"{ROW}.{SIZE}")
    coded = any(code < 0 for part, code in board.codes.items() if part is not None)
    return _function("max", size, ast.Number(0.0)) if coded else size


def formula(
    coordinate: Coordinate, label: str, index: tuple[ast.Expr, ast.Expr, ast.Expr]
) -> ast.Expr:
    """`first + along * i + down * j`, and what else the coordinate says; index: i, j and size."""
    first, *slopes = coordinate.terms
    i, j, size = index
    odd = _function("mod", j, ast.Number(2.0))
    factors: list[ast.Expr] = [i, j, odd, size]
    made: ast.Expr | None = None if first == 0 else number(first)
    for slope, factor in zip((*slopes, coordinate.by), factors, strict=True):
        made = _plus(made, slope, factor)
    if coordinate.ladder is not None:
        made = _and(made, _steps(coordinate, i, j))
    made = ast.Number(0.0) if made is None else made
    if coordinate.decimals is not None:
        made = _rounded(made, 10.0**coordinate.decimals)
    return made if coordinate.rest is None else _and(made, ast.Name(f"{ROW}.{label}"))


def _plus(made: ast.Expr | None, slope: float, factor: ast.Expr) -> ast.Expr | None:
    if slope == 0:
        return made
    size = factor if abs(slope) == 1 else ast.Binary("*", ast.Number(abs(slope)), factor)
    if made is not None:
        return ast.Binary("+" if slope > 0 else "-", made, size)
    if slope > 0:
        return size
    return ast.Unary("-", factor) if slope == -1 else ast.Binary("*", number(slope), factor)


def _and(made: ast.Expr | None, more: ast.Expr) -> ast.Expr:
    return more if made is None else ast.Binary("+", made, more)


def _steps(coordinate: Coordinate, i: ast.Expr, j: ast.Expr) -> ast.Expr:
    """`if i < 3 then 0 else if i < 9 then 0.01 else 0`."""
    ladder = coordinate.ladder
    assert ladder is not None
    index = j if ladder.lines else i
    made = number(ladder.adds[-1])
    for until, add in reversed(list(zip(ladder.starts[1:], ladder.adds[:-1], strict=True))):
        made = ast.If(ast.Binary("<", index, ast.Number(float(until))), number(add), made)
    return made


def _rounded(value: ast.Expr, grain: float) -> ast.Expr:
    if grain == 1:
        return _function("round", value)
    whole = _function("round", ast.Binary("*", ast.Number(grain), value))
    return ast.Binary("/", whole, ast.Number(grain))
