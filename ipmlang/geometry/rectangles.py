"""The largest rectangle within a polygon whose sides run along the axes of its scope.

For two vertical lines, what lies free between them is found exactly: the gaps between the parts of
the boundary that the lines cut out. Lines through all corners give the best rectangle of a polygon
with sides along the axes; for others the lines are then moved, from the best few, step by step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.convex_rectangles import is_convex, widest_lines
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.planar import (
    Rings,
    closed,
    grid_of,
    opened,
    rings_area,
    rings_of_shape,
    shape_of,
    without,
)
from ipmlang.geometry.solid import Floats, Solid

Rectangle = tuple[float, float, float, float]
"""x and y from, x and y to."""
SPREAD = 28
"""Lines between the corners' own, where a side is aslant."""
KEPT = 3
"""From how many of the best rectangles, well apart, lines are moved."""
TRIED = 60
"""Among how many of the best those are looked for."""
FINE = 1e-7
"""The last step of moved lines, as a part of the width."""
STEPS = 7
"""Places around a line that it is moved to."""
EXACT = 1 << 25
"""Pairs of a line pair and an edge that are looked at for the first rectangles."""
MOVED = 1 << 20
"""Pairs of a line pair and an edge that are looked at each time that lines are moved."""
BATCH = 1 << 19
"""Pairs of a line pair and an edge that are looked at together."""
SLIVER = 1e-8
"""Of the size of a polygon, the width of what rounding leaves between two lines and is nothing."""


def inner_rect(polygon: Solid) -> list[Piece]:
    """The largest rectangle along the axes, `shape`, and what is around it, `rest` (`remainder`).

    The rectangle is the largest one in convex polygons, and where all sides of the polygon run
    along the axes (up to some 600 corners); elsewhere it is one that no small step improves, 97 %
    and more of the best, in the tests.

    >>> from ipmlang.geometry import solid
    >>> ell = solid.polygon([(0, 0), (5, 0), (5, 2), (2, 2), (2, 3), (0, 3)])
    >>> [round(solid.area(piece.solid), 9) for piece in inner_rect(ell)]
    [10.0, 2.0]
    """
    rings, plane = opened(polygon, "innerRect")
    x0, y0, x1, y1 = largest_rectangle(rings)
    ring = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    pieces = [Piece(frozenset({"shape", "inside"}), closed([[ring]], plane))]
    if (x1 - x0) * (y1 - y0) >= rings_area(rings) * (1 - 1e-12):
        return pieces
    import shapely

    shape = shape_of(rings)
    grid = grid_of(shape)
    around = without(shape, shapely.Polygon(ring), grid).item()
    words = frozenset({"rest", "remainder"})
    rest = rings_of_shape(around, np.concatenate([*rings, ring]), grid)
    least = SLIVER * np.sqrt(rings_area(rings))
    wide = (each for each in rest if 2 * rings_area(each) > least * _around(each))
    return [*pieces, *(Piece(words, closed([each], plane)) for each in wide)]


def _around(rings: Sequence[Floats]) -> float:
    """The length of all edges."""
    steps = (np.roll(ring, -1, axis=0) - ring for ring in rings)
    return float(sum(np.linalg.norm(step, axis=1).sum() for step in steps))


def largest_rectangle(rings: Rings) -> Rectangle:
    """The largest rectangle along the axes within a polygon."""
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    lines = np.unique(start[:, 0])
    step = np.abs(end - start)
    aslant = bool((step.min(axis=1) > 1e-12 * step.max()).any())
    if not aslant and len(lines) ** 2 * len(start) <= 2 * EXACT:
        return _best(start, end, *_pairs(lines, lines), 1)[0]
    if len(rings) == 1 and is_convex(rings[0]):
        return _snapped(start, end, widest_lines(rings[0]), lines)
    between = np.linspace(lines[0], lines[-1], SPREAD + 2)[1:-1]
    width = float(lines[-1] - lines[0]) / SPREAD
    many = math.isqrt(2 * EXACT // len(start)) - SPREAD
    every = np.union1d(_thinned(lines, min(max(many, SPREAD), 100)), between)
    found = _apart(_best(start, end, *_pairs(every, every), TRIED), 2 * width)
    near = max((_moved(start, end, each, lines, width, width / 20) for each in found), key=_size)
    best = _moved(start, end, near, lines, width / 20, FINE * float(lines[-1] - lines[0]))
    return _snapped(start, end, (best[0], best[2]), lines)


def _apart(found: list[Rectangle], width: float) -> list[Rectangle]:
    """The first few rectangles that lie this much apart from all before."""
    kept = found[:1]
    for each in found:
        away = np.abs(np.array(kept) - each).max(axis=1)
        if len(kept) < KEPT and away.min() > width:
            kept.append(each)
    return kept


def _size(rectangle: Rectangle) -> float:
    return (rectangle[2] - rectangle[0]) * (rectangle[3] - rectangle[1])


def _thinned(lines: Floats, most: int) -> Floats:
    """Some of very many lines, evenly taken."""
    return lines[:: -(-len(lines) // most) or 1]


def _pairs(some: Floats, others: Floats) -> tuple[Floats, Floats]:
    low, high = (each.ravel() for each in np.meshgrid(some, others))
    return low[low < high], high[low < high]


def _moved(
    start: Floats, end: Floats, best: Rectangle, lines: Floats, width: float, last: float
) -> Rectangle:
    """The rectangle after its two lines have moved to better places, in steps that shrink."""
    around = np.linspace(-1, 1, STEPS)
    most = min(max(math.isqrt(MOVED // len(start)) - STEPS, STEPS), 30)
    while width > last:
        low, high = _pairs(
            *(
                np.append(at + width * around, _thinned(lines[np.abs(lines - at) <= width], most))
                for at in (best[0], best[2])
            )
        )
        found = _best(start, end, low, high, 1)[0]
        if _size(found) > _size(best) * (1 + 1e-9):
            best = found
        else:
            width /= 3
    return best


def _snapped(start: Floats, end: Floats, best: tuple[float, float], lines: Floats) -> Rectangle:
    """The rectangle between two lines, moved to the corners that they nearly pass."""
    near = 1e-9 * float(lines[-1] - lines[0])
    corners = [float(lines[np.abs(lines - x).argmin()]) for x in best]
    low, high = (
        corner if abs(corner - x) <= near else x for corner, x in zip(corners, best, strict=True)
    )
    return _best(start, end, np.array([low]), np.array([high]), 1)[0]


def _best(start: Floats, end: Floats, low: Floats, high: Floats, most: int) -> list[Rectangle]:
    """The best few rectangles between pairs of lines x = low and x = high (p,), largest first."""
    count = max(1, BATCH // len(start))
    parts = [
        _free(start, end, low[at : at + count], high[at : at + count])
        for at in range(0, len(low), count)
    ]
    bottom, top = (np.concatenate(each) for each in zip(*parts, strict=True))
    order = np.argsort(-(high - low) * (top - bottom), kind="stable")[:most]
    return [
        (float(low[k]), float(bottom[k]), float(high[k]), float(top[k])) for k in order.tolist()
    ]


def _free(start: Floats, end: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The longest stretch of y, within the polygon, that is free of edges between each two lines.

    Each edge, cut at the lines, covers a stretch of y. In the order in which those begin, the gaps
    lie after the greatest end so far; a gap is inside if an odd number of the edges below it pass
    over the middle between the lines.
    """
    bottom, top, crosses = _covered(start, end, low[:, None], high[:, None])
    order = np.argsort(bottom, axis=1)
    bottom = np.take_along_axis(bottom, order, axis=1)
    reached = np.maximum.accumulate(np.take_along_axis(top, order, axis=1), axis=1)
    inside = np.cumsum(np.take_along_axis(crosses, order, axis=1), axis=1) % 2 == 1
    with np.errstate(invalid="ignore"):
        gaps = np.where(inside[:, :-1], bottom[:, 1:] - reached[:, :-1], 0.0)
    gaps = np.where(np.isfinite(gaps), gaps, 0.0)
    rows, widest = np.arange(len(gaps)), gaps.argmax(axis=1)
    free = gaps[rows, widest] > 0
    return (
        np.where(free, reached[rows, widest], 0.0),
        np.where(free, bottom[rows, widest + 1], 0.0),
    )


def _covered(
    start: Floats, end: Floats, low: Floats, high: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """For pairs of lines (p, 1) and edges (n, 2): the stretch of y (p, n) of each edge between the
    lines, infinitely high where there is none, and whether it passes over their middle.
    """
    (x0, y0), (x1, y1) = start.T, end.T
    left, right = np.minimum(x0, x1), np.maximum(x0, x1)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (y1 - y0) / (x1 - x0)
    steep = x0 == x1
    slope = np.where(steep, 0.0, slope)
    at_low = y0 + slope * (np.maximum(low, left) - x0)
    at_high = y0 + slope * (np.minimum(high, right) - x0)
    at_low, at_high = np.where(steep, y0, at_low), np.where(steep, y1, at_high)
    outside = (right <= low) | (left >= high)
    middle = (low + high) / 2
    crosses = (left <= middle) & (middle < right)
    bottom = np.where(outside, np.inf, np.minimum(at_low, at_high))
    top = np.where(outside, np.inf, np.maximum(at_low, at_high))
    return bottom, top, crosses
