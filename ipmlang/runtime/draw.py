"""What a turtle draws on its way: segments, terminals and outlines as rows in the string's order.

In go a stream and its turtle, out come rows for a scene and the corners of its outlines. Inside a
polygon or a path `F` and `f` make corners and draw nothing else; what drew is asked for its pen
once. Nothing here moves the turtle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime.ancestry import ModuleError
from ipmlang.runtime.choose import told
from ipmlang.runtime.grouping import FIELD, Grouping
from ipmlang.runtime.interpret import Act, Stream, chosen
from ipmlang.runtime.keys import packed
from ipmlang.runtime.outlines import Polygons, outlines_of
from ipmlang.runtime.rows import TEXT_FIELDS, Rows
from ipmlang.runtime.scan import Frames, Real, Whole
from ipmlang.runtime.scene import OUTLINES, SCOPE, SEGMENT, Groups
from ipmlang.runtime.turtle import Turtle
from ipmlang.runtime.values import Value


@dataclass(slots=True, eq=False)
class _Drawn:
    """An act that draws, the number of what it draws, its sizes and, for outlines, their shapes."""

    act: Act
    asset: int
    size: tuple[Value, Value, Value]
    shape: NDArray[np.int32] | int = -1


def drawn(program: ir.Program, stream: Stream, turtle: Turtle) -> tuple[Rows, Polygons]:
    """All that a stream draws, in its order."""
    rows, polygons, _ = drawn_along(program, stream, turtle)
    return rows, polygons


def drawn_along(
    program: ir.Program, stream: Stream, turtle: Turtle
) -> tuple[Rows, Polygons, Whole]:
    """The same, and at which place of the stream each row is drawn (n,)."""
    polygons: Polygons = ()
    acts: list[_Drawn] = []
    outlines = outlines_of(stream, turtle)
    nest = None if outlines is None else outlines.nest
    for act in stream.visible("segment"):
        free = act if nest is None else chosen(act, np.flatnonzero(nest[act.at] == 0))
        acts.append(_Drawn(free, SEGMENT, (free.args[0], 0.0, 0.0)))
    for act in stream.visible("emit"):
        sizes = act.args if len(act.args) == 3 else (0.0, 0.0, 0.0)
        assert isinstance(act.const, int)
        acts.append(_Drawn(act, act.const if act.const >= 0 else SCOPE, sizes))
    if outlines is not None:
        acts += [_Drawn(*each) for each in outlines.closing]
        polygons = outlines.corners
    acts = [each for each in acts if len(each.act.at)]
    order = _order(stream.length, [each.act.at for each in acts])
    at = np.empty(sum(map(len, order)), np.int64)
    for each, rows in zip(acts, order, strict=True):
        at[rows] = each.act.at
    return _rows(program, stream, turtle, acts, order, at), polygons, at


def _rows(
    program: ir.Program,
    stream: Stream,
    turtle: Turtle,
    acts: list[_Drawn],
    order: list[Whole],
    at: Whole,
) -> Rows:
    count = len(at)
    size = np.zeros((count, 3))
    asset, shape, symbol, rule = (np.full(count, -1, np.int32) for _ in range(4))
    key = np.zeros(count, np.uint64)
    for each, rows in zip(acts, order, strict=True):
        asset[rows], shape[rows], symbol[rows] = each.asset, each.shape, each.act.modules.symbol
        rule[rows] = _of(each.act, each.act.modules.rule)
        key[rows] = _of(each.act, packed(each.act.modules.k0, each.act.modules.k1))
        for axis, value in enumerate(each.size):
            if isinstance(value, np.ndarray) or value:
                size[rows, axis] = value
    frames = turtle.frames(at)
    _check_finite(program, frames, rule, [each.act for each in acts], order)
    outline = np.isin(asset, OUTLINES)
    if outline.any():  # corners are in world coordinates
        frames.position[outline], frames.scale[outline] = 0, 1
        frames.rotation[outline] = (1, 0, 0, 0)
    pen = _Pen(program, stream, turtle, at)
    return Rows(
        frames.position,
        frames.rotation,
        frames.scale,
        size,
        asset,
        shape,
        pen.width(),
        pen.text("color"),
        pen.texts(),
        turtle.layers(at),
        symbol,
        rule,
        key,
        pen.groups(),
    )


def _check_finite(
    program: ir.Program,
    frames: Frames,
    rule: NDArray[np.int32],
    acts: list[Act],
    order: list[Whole],
) -> None:
    """Refuse frames that grew out of the numbers, and name the first rule that draws there."""
    whole = np.column_stack((frames.position, frames.rotation, frames.scale))
    bad = np.flatnonzero(~np.isfinite(whole).all(axis=1))
    if not len(bad):
        return
    number = int(rule[bad[0]])
    production = program.axiom if number < 0 else program.productions[number]
    name = told(program, production)
    error = fail(
        "not-a-number", f"{name} draws where the turtle's place, turn or scale is not finite"
    )
    act, row = next(
        (act, int(np.argmax(rows == bad[0])))
        for act, rows in zip(acts, order, strict=True)
        if (rows == bad[0]).any()
    )
    raise ModuleError(error, act.modules.symbol, row if act.rows is None else int(act.rows[row]))


def _of(act: Act, column: object) -> NDArray[np.generic] | int:
    """A column of the act's modules, for the rows that act."""
    if not isinstance(column, np.ndarray):
        assert isinstance(column, int)
        return column
    return column if act.rows is None or not column.ndim else column[act.rows]


def _order(length: int, places: list[Whole]) -> list[Whole]:
    """The row of each place when all are sorted; no place occurs twice."""
    there = np.zeros(length, np.int8)
    for each in places:
        there[each] = 1
    row = np.cumsum(there, dtype=np.int64) - 1
    return [row[each] for each in places]


class _Pen:
    """What the pen had set at the places that draw."""

    def __init__(self, program: ir.Program, stream: Stream, turtle: Turtle, at: Whole) -> None:
        self._program = program
        self._turtle = turtle
        self._at = at
        self._numbers = {text: number for number, text in enumerate(program.strings)}
        self._acts: dict[str, list[tuple[Act, Value]]] = {}
        for act in stream.of("pen"):
            field, value = self._setting(act)
            self._acts.setdefault(field, []).append((act, value))
        colored = [(act, -1.0) for act, _ in self._acts.get("color", [])]
        for field in {"fill", "stroke"} & self._acts.keys():  # a colour is for both
            self._acts[field] += colored

    def _setting(self, act: Act) -> tuple[str, Value]:
        assert isinstance(act.const, tuple)
        field, text = act.const
        if text is not None:
            return str(field), float(self._numbers[str(text)])
        return str(field), act.args[0]

    def width(self) -> NDArray[np.float32]:
        start = self._program.pen_width
        first = np.nan if start is None else start
        return self._turtle.last(self._acts.get("width", []), first, self._at).astype(np.float32)

    def text(self, field: str) -> NDArray[np.int32]:
        return self._turtle.last(self._acts.get(field, []), -1.0, self._at).astype(np.int32)

    def groups(self) -> Groups | None:
        """What `effect` wraps: one group for each time the turtle came by."""
        acts = self._acts.get(FIELD, [])
        if not acts:
            return None
        grouping, turtle = Grouping(), self._turtle
        ends = np.cumsum([len(act.at) for act, _ in acts]).tolist()
        begun: list[tuple[Act, Value]] = [
            (act, np.arange(end - len(act.at), end, dtype=np.float64))
            for (act, _), end in zip(acts, ends, strict=True)
        ]
        for act, text in acts:
            around = turtle.last(begun, -1.0, act.at, before=True)
            grouping.begin(len(act.at), text, around, _frame_columns(turtle, act.at))
        return grouping.groups(self._program, turtle.last(begun, -1.0, self._at).astype(np.int32))

    def texts(self) -> dict[str, NDArray[np.int32]]:
        return {field: self.text(field) for field in TEXT_FIELDS if field in self._acts}


def _frame_columns(turtle: Turtle, at: Whole) -> dict[str, Real]:
    """The state at some places, as an executor's columns."""
    found = turtle.frames(at)
    columns = dict(zip("xyz", found.position.T, strict=True))
    columns |= dict(zip("wijk", found.rotation.T, strict=True))
    return {**columns, "scale": found.scale, "layer": turtle.layers(at)}
