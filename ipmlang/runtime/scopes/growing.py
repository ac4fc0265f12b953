"""Turtles among scopes: shapes that are derived as strings of their own, many in one string.

In go shapes of one symbol, out come drawings of the frontier. Each shape is a branch of the string,
in which a module nobody wrote puts the turtle where the shape stands and gives it the shape's pen;
the shape itself follows it, under its own key. What is drawn has the other fields of its shape.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime.ancestry import ModuleError
from ipmlang.runtime.code import Column
from ipmlang.runtime.draw import drawn_along
from ipmlang.runtime.fields import first_rotation
from ipmlang.runtime.grow import grown_from, interpreted
from ipmlang.runtime.interpret import Stream, stream
from ipmlang.runtime.naming import OWN
from ipmlang.runtime.order import Copies as Drawings
from ipmlang.runtime.order import Drawn, Record
from ipmlang.runtime.outlines import Polygons
from ipmlang.runtime.pending import Shapes, taken
from ipmlang.runtime.rewrite import CLOSE, OPEN, Block, Budget, Copies, Modules, Rewriter
from ipmlang.runtime.rows import TEXT_FIELDS, Rows
from ipmlang.runtime.scene import OUTLINES, SCOPE
from ipmlang.runtime.scopes.boxes import SIZES, full
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.pool import NOTHING
from ipmlang.runtime.turtle import Turtle
from ipmlang.runtime.values import Bound

if TYPE_CHECKING:
    from ipmlang.runtime.frontier import Frontier

Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]
PLACE = ("x", "y", "z")
TURN = ("w", "i", "j", "k")
PENS = ("width", "color", *TEXT_FIELDS)  # a colour is for fill and stroke, which come after it


def grow(run: Frontier, symbol: int, generation: int, shapes: Shapes) -> None:
    """Derive shapes as strings, and draw them: mirrored turtles apart from the others."""
    scale = dict(zip(run.fields, shapes.state, strict=True)).get("scale", 1.0)
    mirrored = full(scale, shapes.count) < 0
    for hand in (False, True):
        rows = np.flatnonzero(mirrored == hand)
        if len(rows):
            _grow(run, symbol, generation, shapes.take(rows), hand)


def _grow(run: Frontier, symbol: int, generation: int, shapes: Shapes, mirrored: bool) -> None:
    state = dict(zip(run.fields, shapes.state, strict=True))
    program = _with_first(run.program, run.fields, mirrored)
    budget = Budget(run.counted.left(generation))
    bound = Bound(program, run.bound.attrs, FUNCTIONS, run.bound.data)
    rewriter = Rewriter(bound, budget, run.draws)
    start = Block(np.zeros(1, np.int64), [_branches(program, symbol, shapes, state)])
    steps = None if run.steps is None else max(run.steps - generation, 0)
    try:
        string = grown_from(rewriter, start, steps)
        final = interpreted(rewriter, string)
        budget.walk(final.length)
        acts = stream(rewriter.bound, final)
        turtle = Turtle(program, acts)
        rows, polygons, at = drawn_along(program, acts, turtle)
    except ModuleError as found:
        raise run.counted.traced(found.error, int(shapes.numbers[0])) from found
    except IpmError as found:
        raise _traced(run, shapes, found) from found
    run.generations = max(run.generations, generation + string.steps)
    run.counted.strung += budget.ruled - 1
    _drawn(run, shapes, state, rows, polygons, _owners(acts, at))


BRANCH = re.compile(r"start > \S+\[(\d+)\]")


def _traced(run: Frontier, shapes: Shapes, error: IpmError) -> IpmError:
    """An error within a string, whose way begins with a branch: that of a shape."""
    found = BRANCH.match(error.diagnostics[0].trail or "")
    if found is None or run.counted.trail is None:
        return error
    before = run.counted.trail.to(int(shapes.numbers[int(found[1])]))
    return IpmError(
        [
            replace(each, trail=before + (each.trail or "")[found.end() :])
            for each in error.diagnostics
        ]
    )


def _with_first(program: ir.Program, fields: Sequence[str], mirrored: bool) -> ir.Program:
    """The program with one more symbol, whose meaning is where a turtle starts and with what pen;
    its parameters are fields of a shape.
    """
    names = _told(fields)
    code = [ir.Instruction("param", number, const=number) for number in range(len(names))]
    register = {name: number for number, name in enumerate(names)}
    w, x, y, z = first_rotation(program)
    for value in (w, -x, -y, -z):  # what every turtle starts with is undone
        code.append(ir.Instruction("const", len(code), const=value))
    undone = tuple(range(len(names), len(names) + 4))
    code.append(ir.Instruction("orient", args=undone))
    code.append(ir.Instruction("move", args=tuple(register[name] for name in PLACE)))
    code.append(ir.Instruction("orient", args=tuple(register[name] for name in TURN)))
    if mirrored:
        code.append(ir.Instruction("mirror"))
    for name in names:
        args = (register[name],)
        if name in ("scale", "layer"):
            code.append(ir.Instruction("scale" if name == "scale" else "layer", args=args))
        elif name in PENS:
            code.append(ir.Instruction("pen", args=args, const=(name, None)))
    first = ir.Symbol("start", len(names), meaning=tuple(code), meaning_registers=len(names) + 4)
    return replace(program, symbols=(*program.symbols, first))


def _told(fields: Sequence[str]) -> list[str]:
    """The fields of a shape that a turtle is told."""
    return [name for name in (*PLACE, *TURN, "scale", "layer", *PENS) if name in fields]


def _branches(program: ir.Program, symbol: int, shapes: Shapes, state: dict[str, Column]) -> Copies:
    """A branch for each shape: the module that starts its turtle, and the shape's own."""
    count = shapes.count
    own = {**state, "scale": np.abs(state["scale"])} if "scale" in state else state
    told = tuple(own[name] for name in _told(tuple(state)))
    return Copies(
        np.zeros(count, np.int64),
        np.array([count]),
        [
            Modules(OPEN, count),
            Modules(len(program.symbols) - 1, count, told),
            Modules(symbol, count, shapes.params, shapes.k0, shapes.k1, shapes.rule),
            Modules(CLOSE, count),
        ],
    )


def _owners(acts: Stream, at: Numbers) -> Numbers:
    """The branch in which each place of a stream stands."""
    step = np.zeros(acts.length + 1, np.int64)
    step[acts.opens] += 1
    step[acts.closes] -= 1
    opens = np.sort(acts.opens)
    outer = opens[np.cumsum(step)[opens] == 1]
    return np.searchsorted(outer, at, side="right") - 1


def _drawn(
    run: Frontier,
    shapes: Shapes,
    state: dict[str, Column],
    rows: Rows,
    polygons: Polygons,
    owner: Numbers,
) -> None:
    """Hand what the strings drew to the frontier, each where its shape stands in the order."""
    inherited = {name: full(each, shapes.count) for name, each in state.items()}
    columns = _columns(inherited, rows, owner)
    sizes = [np.where(rows.asset == SCOPE, columns[name], own)
             for name, own in zip(SIZES, rows.size.T, strict=True)]  # fmt: skip
    shown = np.flatnonzero((rows.asset != SCOPE) | (columns["geo"] != NOTHING))
    outline = np.isin(rows.asset, OUTLINES)
    columns["geo"] = np.where(outline, rows.shape + len(run.polygons), columns["geo"])
    if JOIN in columns:
        columns[JOIN] = np.where(outline, -1.0, columns[JOIN])
    run.polygons += polygons
    k0, k1 = ((rows.key >> shift & 0xFFFFFFFF).astype(np.uint32) for shift in (32, 0))
    slots = []
    place = np.cumsum(np.bincount(shown, minlength=len(owner))) - 1  # among those that are shown
    for kind, asset, own in _kinds(rows, shown):
        size = tuple(each[own] for each in sizes)
        fields = tuple(taken(columns[name], own) for name in run.fields)
        words = (k0[own], k1[own], OWN, ())
        made = run.draw(len(own), rows.rule[own], kind, asset, size, fields, *words, None)
        slots.append(Drawn(made.start, made.count, place[own]))
    counts = np.bincount(owner[shown], minlength=shapes.count)
    run.order.records.append(Record(shapes.numbers, (Drawings(counts, owner[shown], slots),)))


def _columns(state: dict[str, Floats], rows: Rows, owner: Numbers) -> dict[str, Column]:
    """The fields of what was drawn: those of the turtle, and all others as its shape has them."""
    found: dict[str, Column] = {name: each[owner] for name, each in state.items()}
    own = dict(zip((*PLACE, *TURN), (*rows.position.T, *rows.rotation.T), strict=True))
    own |= {"scale": rows.scale, "layer": rows.layer, "color": rows.color, "width": rows.width}
    own |= rows.texts
    return found | {name: each.astype(np.float64) for name, each in own.items() if name in found}


def _kinds(rows: Rows, shown: Numbers) -> Iterator[tuple[int, int, Numbers]]:
    """Of the rows that are shown those of each symbol and asset."""
    pairs = np.stack((rows.symbol, rows.asset), axis=1)[shown]
    distinct, kind = np.unique(pairs, axis=0, return_inverse=True)
    for number, (symbol, asset) in enumerate(distinct.tolist()):
        yield symbol, asset, shown[kind.reshape(-1) == number]
