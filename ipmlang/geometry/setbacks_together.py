"""Strips cut off many polygons at once: what `setback` gives of each, in a few passes over all.

In go level polygons without holes and a row of distances for each; out come their pieces. The lines
are those that `setbacks` and `strips` draw, over all edges together, so that the pieces are the
same to the last bit whatever the others are. What takes more care is left out, for `setback`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.geometry.corners import THIN, Edges, Marks, corners_of, edges_of, length_of
from ipmlang.geometry.pieces import Piece, numbered_rings
from ipmlang.geometry.setbacks import BORDER, SHAPE, SIDES, axes_of, sides_of
from ipmlang.geometry.solid import Floats, Indices, Solid
from ipmlang.geometry.strips import all_moved_in, plain_strips

LEVEL = 1e-6  # of a polygon's size: how far from its plane a corner may be


def setbacks(polygons: Sequence[Solid], widths: Floats) -> list[list[Piece] | None]:
    """What `setback` gives of each polygon; widths (n, 4): the distance, and those at the front, at
    the sides and at the back, NaN where not given. None where strips end early, for polygons with
    holes or texture coordinates, and for whatever `setback` refuses.

    >>> from ipmlang.geometry.solid import area, unit_square
    >>> (pieces,) = setbacks([unit_square()], np.array([(0.0, 0.25, np.nan, np.nan)]))
    >>> [round(area(piece.solid), 2) for piece in pieces]
    [0.75, 0.25]
    """
    found: list[list[Piece] | None] = [None] * len(polygons)
    given = np.where(np.isnan(widths), widths[:, :1], widths)
    fit = np.flatnonzero((np.isfinite(given) & (given >= 0)).all(axis=1))
    some = [k for k in fit.tolist() if _has_one_ring(polygons[k])]
    if not some:
        return found
    points = [polygons[k].vertices[polygons[k].corners] for k in some]
    counts = np.array([len(each) for each in points])
    flat = np.concatenate(points)
    level = _are_level(flat, counts)
    if not level.all():
        fitting = [k for k, good in zip(some, level.tolist(), strict=True) if good]
        for k, own in zip(
            fitting, setbacks([polygons[k] for k in fitting], widths[fitting]), strict=True
        ):
            found[k] = own
        return found
    rings = np.split(np.ascontiguousarray(flat[:, :2]), np.cumsum(counts)[:-1])
    edges = edges_of(rings)
    sides = sides_of(edges)
    per_side = given[some][:, [1, 2, 3, 2]]
    own_widths = per_side[np.repeat(np.arange(len(some)), counts), sides]
    size = np.repeat(_extents(flat, counts), counts)
    own_widths = np.where(own_widths > THIN * size, own_widths, 0.0)
    for k, own in zip(
        some, _pieces(edges, own_widths, sides, [polygons[k] for k in some]), strict=True
    ):
        found[k] = own
    return found


def _has_one_ring(polygon: Solid) -> bool:
    return len(polygon) == 1 and len(polygon.rings) == 2 and polygon.uv is None


def _are_level(points: Floats, counts: Indices) -> Marks:
    """Which rings (n, 3), of so many points each, lie level and run counter-clockwise, along edges
    that have a length.
    """
    starts = np.cumsum(counts) - counts
    high, low = (each.reduceat(points, starts) for each in (np.maximum, np.minimum))
    rise = high - low
    near = points[:, :2] - np.repeat(points[starts, :2], counts, axis=0)
    after = np.arange(1, len(points) + 1)
    after[starts + counts - 1] = starts
    x, y = near.T
    area = np.add.reduceat(x * y[after] - x[after] * y, starts)
    long = np.logical_and.reduceat((near != near[after]).any(axis=1), starts)
    found: Marks = (rise[:, 2] <= LEVEL * rise[:, :2].max(axis=1)) & (area > 0) & long
    return found


def _extents(points: Floats, counts: Indices) -> Floats:
    """The diagonals of the boxes around rings."""
    starts = np.cumsum(counts) - counts
    size = np.maximum.reduceat(points, starts) - np.minimum.reduceat(points, starts)
    return length_of(size[:, :2])


def _pieces(
    edges: Edges, widths: Floats, sides: Indices, polygons: Sequence[Solid]
) -> list[list[Piece] | None]:
    """The pieces of polygons that have these edges, one polygon after the other."""
    corners = corners_of(edges, widths)
    moved = all_moved_in(edges, widths, corners, [1] * len(polygons))
    points, counts = plain_strips(edges, corners)
    heights = [float(each.vertices[each.corners[0], 2]) for each in polygons]
    spatial = np.empty((len(points), 3))
    spatial[:, :2] = points
    spatial[:, 2] = np.repeat(np.repeat(heights, edges.counts), counts)
    ends = np.cumsum(counts).tolist()
    wide, side, axes = (widths > 0).tolist(), sides.tolist(), axes_of(edges)
    found: list[list[Piece] | None] = []
    edge = 0
    for polygon, ring, height, count in zip(polygons, moved, heights, edges.counts, strict=True):
        if ring is None:
            found.append(None)
            edge += count
            continue
        own = [Piece(SHAPE, _within(polygon, _raised(ring[0], height)))]
        for k in range(edge, edge + count):
            if wide[k]:
                strip = spatial[ends[k] - counts[k] : ends[k]]
                own.append(Piece(_BORDERS[side[k]], _within(polygon, strip), axes[k]))
        found.append(own)
        edge += count
    return found


_BORDERS = [BORDER | words for words, _ in SIDES]


def _raised(ring: Floats, height: float) -> Floats:
    return np.column_stack([ring, np.full(len(ring), height)])


def _within(polygon: Solid, points: Floats) -> Solid:
    """A part of a polygon, which keeps its tags."""
    return Solid(points, *numbered_rings((len(points),)), polygon.tags)
