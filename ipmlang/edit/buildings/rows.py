"""Parts in frames as the elements of a body: rows as repeats, copies as tables, others one by one.

In go frames with what stands in each, out come elements as inference prints them, and the tables
that they read. Numbers are as short as what touches allows. Nothing is derived here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.symbols import Elements
from ipmlang.inverse.frames import Floats, Frames
from ipmlang.inverse.split.placing import Precision, Spot, placed, spots
from ipmlang.inverse.split.wording import Vector, is_nothing, plus, times

FEWEST, MANY = 3, 4  # members of a row, rows of a table
COLUMNS = ("x", "y", "z", "rx", "ry", "rz")
Part = tuple[Frames, Elements]


@dataclass(frozen=True, slots=True)
class Room:
    """How exactly parts are written. near: units within which things touch."""

    near: float

    @property
    def precision(self) -> Precision:
        """Places and sizes, some of them multiplied, are off by far less than what touches."""
        return Precision(self.near / 80)

    def spot(self, frame: Frames) -> Spot:
        """A frame of one row; what stands there reaches no further than a building does."""
        return spots(frame, self.precision, 1e6 * self.near)[0]


def laid_out(
    parts: Sequence[Part], room: Room, title: Callable[[str], str]
) -> tuple[Elements, list[ast.Table]]:
    """The elements that draw parts at frames of one row each, and their tables; title: gives a free
    name like a wish.
    """
    body: list[ast.Element] = []
    tables: list[ast.Table] = []
    begin = 0
    while begin < len(parts):
        end = _row_end(parts, begin, room.near)
        alike = _alike_end(parts, begin)
        if end - begin >= FEWEST:
            body.append(_row(parts[begin:end], room))
        elif alike - begin >= MANY and (table := _table(parts[begin:alike], room, title)):
            end = alike
            tables.append(table)
            body.append(ast.Repeat(ast.Rows("at", table.name, places=True), parts[begin][1]))
        else:
            end = begin + 1
            body.append(placed(room.spot(parts[begin][0]), parts[begin][1]))
        begin = end
    return tuple(body), tables


def _alike_end(parts: Sequence[Part], begin: int) -> int:
    """Behind the last of equal parts that follow each other."""
    end = begin + 1
    while end < len(parts) and parts[end][1] == parts[begin][1]:
        end += 1
    return end


def _table(parts: Sequence[Part], room: Room, title: Callable[[str], str]) -> ast.Table | None:
    """The places of equal parts; None where they are more than moved and turned."""
    found = [room.spot(frame) for frame, _ in parts]
    if any(spot.mirrored or spot.scale is not None for spot in found):
        return None
    cells = [(*spot.place, *spot.turn) for spot in found]
    said = [k for k in range(len(COLUMNS)) if not all(is_nothing(row[k]) for row in cells)]
    if not said:
        return None
    last = parts[0][1][-1]
    name = last.name if isinstance(last, ast.Module) else "part"
    rows = tuple(tuple(row[k] for k in said) for row in cells)
    columns = tuple(COLUMNS[k] for k in said)
    return ast.Table(title(f"{name.lower()}_places"), columns=columns, rows=rows)


def _row_end(parts: Sequence[Part], begin: int, near: float) -> int:
    """Behind the last of equal parts that follow each other in equal steps."""
    first, elements = parts[begin]
    end, step = begin + 1, np.zeros(3)
    while end < len(parts) and parts[end][1] == elements and _turned_alike(parts[end][0], first):
        own = parts[end][0].position[0] - parts[end - 1][0].position[0]
        if end == begin + 1:
            step = own
        expected = first.position[0] + (end - begin) * step
        if np.abs(parts[end][0].position[0] - expected).max() > near / 8:
            break
        end += 1
    return end


def _turned_alike(one: Frames, other: Frames) -> bool:
    return bool(
        np.allclose(one.rotation, other.rotation, atol=1e-9)
        and one.hand[0] == other.hand[0]
        and abs(one.scale[0] - other.scale[0]) < 1e-9
    )


def _row(parts: Sequence[Part], room: Room) -> ast.Element:
    first, elements = parts[0]
    last = parts[-1][0]
    share = 1 / (len(parts) - 1)
    step: Floats = (last.position[0] - first.position[0]) * share
    spot = room.spot(first)
    x, y, z = (
        plus(at, times(by, ast.Name("i")))
        for at, by in zip(spot.place, room.precision.vector(step, share), strict=True)
    )
    place: Vector = (x, y, z)
    head = ast.Count("i", ast.Number(float(len(parts))))
    return ast.Repeat(head, (placed(spot.at(place), elements),))
