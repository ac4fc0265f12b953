"""A polygon cut into pieces of given areas by lines across x or y.

How much area lies before a line is a quadratic of the line's place between two corners, so the
lines are found by solving it, not by searching.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.planar import (
    Rings,
    closed,
    common,
    grid_of,
    opened,
    rings_of_shape,
    shape_of,
)
from ipmlang.geometry.solid import Floats, GeometryError, Solid

AXES = {"x": 0, "y": 1}
CUT = frozenset({"area"})


def area_split(polygon: Solid, axis: str, areas: Sequence[float]) -> list[Piece]:
    """Pieces of these areas, one after the other along x or y.

    A piece has several faces where its strip of the polygon falls apart. What is left beyond the
    last area makes no piece; a last area that is not all there makes a smaller piece, later ones
    and areas of 0 or less make none. Raises `GeometryError` for an unknown axis.

    >>> from ipmlang.geometry import solid
    >>> pieces = area_split(solid.unit_square(), "x", [0.25, 1])
    >>> [float(solid.bounds(piece.solid)[1][0]) for piece in pieces]
    [0.25, 1.0]
    """
    import shapely

    rings, plane = opened(polygon, "split")
    if axis not in AXES:
        raise GeometryError(f"an area is split along x or y, not along {axis}")
    along = AXES[axis]
    cuts = cuts_of(rings, along, areas)
    whole = shape_of(rings)
    grid = grid_of(whole)
    known = np.concatenate(rings)
    low, high = rings[0].min(axis=0) - 1, rings[0].max(axis=0) + 1
    found: list[Piece] = []
    for start, end in pairwise(cuts.tolist()):
        if end <= start:
            continue
        corner, opposite = low.copy(), high.copy()
        corner[along], opposite[along] = start, end
        part = common(whole, shapely.box(*corner, *opposite), grid).item()
        parts = [_on_lines(each, along, (start, end), 4 * grid)
                 for each in rings_of_shape(part, known, grid)]  # fmt: skip
        if parts:
            found.append(Piece(CUT, closed(parts, plane)))
    return found


def _on_lines(rings: Rings, along: int, lines: tuple[float, float], near: float) -> Rings:
    """The rings with points on the cutting lines, to the last bit, where they were rounded."""
    for ring in rings:
        for line in lines:
            ring[np.abs(ring[:, along] - line) <= near, along] = line
    return rings


def area_cuts(polygon: Solid, axis: str, areas: Sequence[float]) -> Floats:
    """Where along x or y pieces of these areas begin and end (n + 1,)."""
    rings, _ = opened(polygon, "split")
    return cuts_of(rings, AXES[axis], areas)


def cuts_of(rings: Rings, along: int, areas: Sequence[float]) -> Floats:
    """As `area_cuts`, of rings, along the axis of this number."""
    upto = np.cumsum([0.0, *(max(0.0, each) for each in areas)])
    turned = rings if along == 0 else [ring[:, ::-1] for ring in rings]
    sign = 1.0 if along == 0 else -1.0
    start = np.concatenate(turned)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in turned])
    stops = np.unique(start[:, 0])
    before = sign * _before(start, end, stops)
    whole = before[-1]
    upto = np.where(upto >= whole * (1 - 1e-14), whole, upto)
    return np.array([_place(start, end, sign, stops, before, float(area)) for area in upto])


def _before(start: Floats, end: Floats, lines: Floats) -> Floats:
    """The area to the left of lines x = … (m,): the sum over edges of min(x, line) dy.

    (Green's theorem, for the field that is min(x, line) along x.)
    """
    origin = start[:, 0].min()
    x0, x1 = start[:, 0] - origin, end[:, 0] - origin
    height = end[:, 1] - start[:, 1]
    line = (lines - origin)[:, None]
    low, high = np.minimum(x0, x1), np.maximum(x0, x1)
    span = np.where(high > low, high - low, 1.0)
    share = np.clip((line - low) / span, 0.0, 1.0)  # of the edge, to the left of the line
    mean = share * (low + (np.clip(line, low, high) - low) / 2) + (1 - share) * line
    mean = np.where(line >= high, (low + high) / 2, np.where(line <= low, line, mean))
    found: Floats = (mean * height).sum(axis=1)
    return found


def _place(
    start: Floats, end: Floats, sign: float, stops: Floats, before: Floats, area: float
) -> float:
    """Where so much area lies before the line."""
    if area <= 0.0:
        return float(stops[0])
    after = min(int(np.searchsorted(before, area)), len(stops) - 1)
    if before[after] <= area:
        return float(stops[after])
    low, high = float(stops[after - 1]), float(stops[after])
    middle = sign * float(_before(start, end, np.array([(low + high) / 2]))[0])
    first, last, want = before[after - 1], before[after], area - before[after - 1]
    # first + b t + c t², with t from 0 to 1 between the stops
    c = 2 * (last - 2 * middle + first)
    b = last - first - c
    root = np.sqrt(max(b * b + 4 * c * want, 0.0))
    share = 2 * want / (b + root) if b + root > 0 else 1.0
    return low + (high - low) * min(max(share, 0.0), 1.0)
