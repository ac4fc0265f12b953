"""Strips along the edges of a polygon, mitred where they meet, and what they leave of it.

Rings and a width per edge come in; the strip of each edge and the polygons left over come out.
Together they are the whole, without overlap. Where no strip ends before its full width, strips are
quadrilaterals and the rest is a ring moved inward: that is computed directly. Else it is cut out
of the polygon, by what each edge claims.
"""

from __future__ import annotations

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
    signed_area,
    together,
    without,
)
from ipmlang.geometry.solid import Floats


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
    ends = ((corners.before[edges.after] - corners.own) * edges.along).sum(axis=1)
    plain = not corners.juts.any() or bool((widths == widths[0]).all())
    if (ends <= 0).any() or not (plain or held(edges, widths, corners).all()):
        return None
    rings: Rings = []
    begin = 0
    for count in edges.counts:
        here = slice(begin, begin + count)
        rings.append(_doubled(corners, here))
        begin += count
    way = -1 if outward else 1
    areas = [way * signed_area(ring) for ring in rings]
    if areas[0] <= 0 or max(areas[1:], default=-1.0) >= 0:
        return None
    import shapely

    return rings if shapely.Polygon(rings[0], rings[1:]).is_valid else None


def _doubled(corners: Corners, here: slice) -> Floats:
    """A ring with both points of the corners that are cut."""
    cut = (corners.apart | corners.long)[here]
    if not cut.any():
        return corners.own[here]
    both = np.stack([corners.before[here], corners.own[here]], axis=1).reshape(-1, 2)
    keep = np.stack([cut, np.ones(len(cut), np.bool_)], axis=1)
    return both[keep.reshape(-1)]


def _plain(edges: Edges, widths: Floats, corners: Corners) -> list[list[Rings]]:
    """Each strip a quadrilateral, with one point more where a mitre is cut off."""
    points = np.stack([
        edges.start, edges.end,
        corners.middle[edges.after], corners.before[edges.after], corners.own, corners.middle,
    ], axis=1)  # fmt: skip
    keep = np.ones((len(points), 6), np.bool_)
    keep[:, 2] = keep[:, 5] = False
    keep[:, 5] |= corners.long
    keep[:, 2] |= corners.long[edges.after]
    return [
        [[quad[chosen]]] if width > 0 else []
        for quad, chosen, width in zip(points, keep, widths, strict=True)
    ]


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
