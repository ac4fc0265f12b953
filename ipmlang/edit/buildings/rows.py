"""Parts in frames as the elements of a body: rows as repeats, all others one by one.

In go frames with what stands in each, out come elements as inference prints them. Nothing is
derived here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.symbols import Elements
from ipmlang.inverse.frames import Floats, Frames
from ipmlang.inverse.split.placing import Precision, Spot, placed, spots
from ipmlang.inverse.split.wording import Vector, plus, times

FEWEST = 3  # members of a row
PRECISION = Precision(1e-9)
Part = tuple[Frames, Elements]


def laid_out(parts: Sequence[Part]) -> Elements:
    """The elements that draw parts at frames of one row each."""
    body: list[ast.Element] = []
    begin = 0
    while begin < len(parts):
        end = _row_end(parts, begin)
        if end - begin >= FEWEST:
            body.append(_row(parts[begin:end]))
        else:
            end = begin + 1
            body.append(placed(_spot(parts[begin][0]), parts[begin][1]))
        begin = end
    return tuple(body)


def _spot(frame: Frames) -> Spot:
    spot = spots(frame, PRECISION, 1.0)[0]
    x, y, z = (literal(float(each)) for each in np.round(frame.position[0], 10))
    return spot.at((x, y, z))


def _row_end(parts: Sequence[Part], begin: int) -> int:
    """Behind the last of equal parts that follow each other in equal steps."""
    first, elements = parts[begin]
    end, step = begin + 1, np.zeros(3)
    while end < len(parts) and parts[end][1] == elements and _turned_alike(parts[end][0], first):
        own = parts[end][0].position[0] - parts[end - 1][0].position[0]
        if end == begin + 1:
            step = own
        elif not np.allclose(own, step, atol=1e-9):
            break
        end += 1
    return end


def _turned_alike(one: Frames, other: Frames) -> bool:
    return bool(
        np.allclose(one.rotation, other.rotation, atol=1e-9)
        and one.hand[0] == other.hand[0]
        and abs(one.scale[0] - other.scale[0]) < 1e-9
    )


def _row(parts: Sequence[Part]) -> ast.Element:
    first, elements = parts[0]
    last = parts[-1][0]
    step: Floats = (last.position[0] - first.position[0]) / (len(parts) - 1)
    spot = _spot(first)
    x, y, z = (
        plus(at, times(literal(float(by)), ast.Name("i")))
        for at, by in zip(spot.place, np.round(step, 10), strict=True)
    )
    place: Vector = (x, y, z)
    head = ast.Count("i", ast.Number(float(len(parts))))
    return ast.Repeat(head, (placed(spot.at(place), elements),))
