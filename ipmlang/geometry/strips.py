"""Strips along the edges of a polygon, mitred where they meet, and what they leave of it.

Rings and a width per edge come in; the strip of each edge and the polygons left over come out.
Together they are the whole, without overlap. Where no strip ends before its full width, strips are
quadrilaterals and the rest is a ring moved inward: that is computed directly. Else it is cut out
of the polygon, by what each edge claims.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.geometry.claims import claims, claims_of, shared_out
from ipmlang.geometry.corners import MITRE, THIN, Corners, Edges, corners_of, edges_of, held
from ipmlang.geometry.planar import (
    Rings,
    exact_rings,
    extent,
    grid_of,
    known_points,
    rings_area,
    shape_of,
    together,
    without,
)
from ipmlang.geometry.solid import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """The polygons left over, and those of each edge's strip (none where its width is 0)."""

    rest: list[Rings]
    strips: list[list[Rings]]


def strips_of(rings: Rings, widths: Floats, mitre: float = MITRE) -> Strips:
    """Strips of these widths (n,) cut off a polygon along its edges."""
    widths = np.where(widths > THIN * extent(rings), widths, 0.0)
    edges = edges_of(rings)
    corners = corners_of(edges, widths, mitre)
    moved = moved_in(edges, widths, corners)
    if moved is not None:
        return Strips([moved], _plain(edges, widths, corners))
    return _claimed(rings, edges, widths, corners)


def rest_area(rings: Rings, widths: Floats, mitre: float = MITRE) -> float:
    """The area that strips of these widths (n,) leave."""
    edges = edges_of(rings)
    corners = corners_of(edges, widths, mitre)
    moved = moved_in(edges, widths, corners)
    if moved is not None:
        return rings_area(moved)

    shape = shape_of(rings)
    grid = grid_of(shape)
    return float(without(shape, claims_of(shape, edges, widths, corners), grid).item().area)


# --- no strip ends early --------------------------------------------------------------------------


def moved_in(
    edges: Edges, widths: Floats, corners: Corners, *, outward: bool = False
) -> Rings | None:
    """The rings moved in by the widths; None where a strip ends early or rings would meet.

    outward: the rings run the other way round, and move away from the polygon. Why it is enough
    to look at each strip by itself: claims (see `claims`) end where the strips do, for equal
    widths, where nothing juts in, and where neighbours are long enough. If then each strip and
    the polygon within have simple rings, they turn once around each of their points; their sum
    turns as often as the outer rings do, so they overlap nowhere and leave no gap.
    """
    whole = [len(edges.counts)]
    return all_moved_in(edges, widths, corners, whole, outward=outward)[0]


def all_moved_in(
    edges: Edges,
    widths: Floats,
    corners: Corners,
    polygons: Sequence[int],
    *,
    outward: bool = False,
) -> list[Rings | None]:
    """As `moved_in`, for many polygons at once, which have so many rings each."""
    import shapely

    counts = np.array(edges.counts)
    per_polygon = np.array(polygons)
    rings = np.cumsum(per_polygon) - per_polygon
    firsts = (np.cumsum(counts) - counts)[rings]
    with np.errstate(invalid="ignore"):  # corners of strips that end early may lie nowhere
        ends = ((corners.before[edges.after] - corners.own) * edges.along).sum(axis=1)
    sound = np.logical_and.reduceat(ends > 0, firsts)
    plain = ~np.logical_or.reduceat(corners.juts, firsts)
    plain |= np.maximum.reduceat(widths, firsts) == np.minimum.reduceat(widths, firsts)
    if not plain.all():
        plain |= np.logical_and.reduceat(held(edges, widths, corners), firsts)
    points, counts = _doubled(corners, counts)
    stops = np.cumsum(counts)
    with np.errstate(invalid="ignore"):
        areas = _areas(points, stops - counts, counts) * (-1 if outward else 1)
    right = areas < 0
    right[rings] = areas[rings] > 0
    sound &= plain & np.logical_and.reduceat(right, rings)
    chosen = np.flatnonzero(sound)
    if not len(chosen):
        return [None] * len(polygons)
    ring_of = np.repeat(np.arange(len(counts)), counts)
    used = np.repeat(sound, per_polygon)
    loops = shapely.linearrings(points[used[ring_of]], indices=_numbered(counts[used]))
    shapes = shapely.polygons(loops, indices=_numbered(per_polygon[chosen]))
    sound[chosen] = shapely.is_valid(shapes)
    starts = (stops - counts).tolist()
    return [
        [points[starts[ring] : stops[ring]] for ring in range(first, first + many)]
        if good
        else None
        for first, many, good in zip(
            rings.tolist(), per_polygon.tolist(), sound.tolist(), strict=True
        )
    ]


def _numbered(counts: Indices) -> Indices:
    """The number of the group of each of so many members."""
    return np.repeat(np.arange(len(counts)), counts)


def _areas(points: Floats, starts: Indices, counts: Indices) -> Floats:
    """The signed areas of rings, twice."""
    near = points - np.repeat(points[starts], counts, axis=0)
    after = np.arange(1, len(points) + 1)
    after[starts + counts - 1] = starts
    x, y = near.T
    found: Floats = np.add.reduceat(x * y[after] - x[after] * y, starts)
    return found


def _doubled(corners: Corners, counts: Indices) -> tuple[Floats, Indices]:
    """The rings' points with both points of the corners that are cut, and how many each has."""
    cut = corners.apart | corners.long
    if not cut.any():
        return corners.own, counts
    both = np.stack([corners.before, corners.own], axis=1).reshape(-1, 2)
    keep = np.stack([cut, np.ones(len(cut), np.bool_)], axis=1)
    more = np.add.reduceat(cut.astype(np.int64), np.cumsum(counts) - counts)
    return both[keep.reshape(-1)], counts + more


def plain_strips(edges: Edges, corners: Corners) -> tuple[Floats, Indices]:
    """The outline of each edge's strip, one after the other, and how many points each has: a
    quadrilateral, with one point more where a mitre is cut off.
    """
    points = np.stack([
        edges.start, edges.end,
        corners.middle[edges.after], corners.before[edges.after], corners.own, corners.middle,
    ], axis=1)  # fmt: skip
    keep = np.ones((len(points), 6), np.bool_)
    keep[:, 2] = corners.long[edges.after]
    keep[:, 5] = corners.long
    return points[keep], keep.sum(axis=1)


def _plain(edges: Edges, widths: Floats, corners: Corners) -> list[list[Rings]]:
    """The strips that are as wide as they should be all along."""
    points, counts = plain_strips(edges, corners)
    rings = np.split(points, np.cumsum(counts)[:-1])
    return [[[ring]] if width > 0 else [] for ring, width in zip(rings, widths, strict=True)]


# --- strips that end early ------------------------------------------------------------------------


def _claimed(rings: Rings, edges: Edges, widths: Floats, corners: Corners) -> Strips:
    """Strips where some end early."""
    shape = shape_of(rings)
    claimed, numbers = claims(shape, edges, widths, corners)
    grid = grid_of(shape)
    rest = without(shape, together(claimed, grid), grid).item()
    points = np.concatenate([edges.start, corners.before, corners.middle, corners.own])
    known = known_points(points, grid)
    strips: list[list[Rings]] = [[] for _ in widths]
    for number, cell in zip(
        numbers, shared_out(claimed, numbers, edges, widths, grid), strict=True
    ):
        strips[int(number)] = exact_rings(cell, known, grid)
    return Strips(exact_rings(rest, known, grid), strips)
