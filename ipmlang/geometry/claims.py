"""What each edge of a polygon claims of it, where strips end before their full width.

Each claim is cut out of the polygon; what two edges claim goes to the one that a front, moving
from all edges at once, each as fast as its strip is wide, would reach it from first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ipmlang.geometry.corners import Corners, Edges, held, length_of
from ipmlang.geometry.planar import Shapes, common, grid_of, together, without
from ipmlang.geometry.solid import Floats, Indices

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry as Shape

TIE = 1e-9
"""Fronts that differ by less than this part of their way arrive together."""


def claims_of(shape: Shape, edges: Edges, widths: Floats, corners: Corners) -> Shape:
    """All that strips of these widths take of a shape, which has these edges."""
    return together(claims(shape, edges, widths, corners)[0], grid_of(shape))


def claims(shape: Shape, edges: Edges, widths: Floats, corners: Corners) -> tuple[Shapes, Indices]:
    """What lies before each edge, within its width, in the polygon; and the edges' numbers.

    A claim reaches to the mitre at either end, and at least over the whole edge: nothing within
    an edge's width is left over. What the edge does not see past another part of the outline is
    not claimed.
    """
    import shapely

    numbers = np.flatnonzero(widths > 0)
    boxes = shapely.polygons(_reach(edges, widths, corners)[numbers])
    claims = common(boxes, shape, grid_of(shape))
    middles = shapely.points((edges.start[numbers] + edges.end[numbers]) / 2)
    several = np.flatnonzero(shapely.get_num_geometries(claims) > 1)
    for place in several:
        parts = shapely.get_parts(claims[place])
        claims[place] = parts[int(np.argmin(shapely.distance(parts, middles[place])))]
    return claims, numbers


def _reach(edges: Edges, widths: Floats, corners: Corners) -> Floats:
    """The outlines (n, 6, 2) of what edges may claim; points stand twice where nothing is cut."""
    over = edges.inward * widths[:, None]
    first, final = corners.own, corners.before[edges.after]
    full = held(edges, widths, corners)
    free = ~(corners.apart | (full & full[edges.before]))
    inside = ((first - edges.start) * edges.along).sum(axis=1) > 0
    first = np.where((inside & free)[:, None], edges.start + over, first)
    inside = ((final - edges.end) * edges.along).sum(axis=1) < 0
    final = np.where((inside & free[edges.after])[:, None], edges.end + over, final)
    long = corners.long[:, None]
    at_start = np.where(long, corners.middle, edges.start)
    at_end = np.where(long[edges.after], corners.middle[edges.after], edges.end)
    return np.stack([edges.start, edges.end, at_end, final, first, at_start], axis=1)


def shared_out(
    claims: Shapes, numbers: Indices, edges: Edges, widths: Floats, grid: float
) -> Shapes:
    """The claims, of edges of these numbers, without what another's front reaches first."""
    import shapely

    one, other = shapely.STRtree(claims).query(claims, predicate="intersects")
    one, other = one[one < other], other[one < other]
    both = common(claims[one], claims[other], grid)
    solid = shapely.area(both) > 0
    one, other, both = one[solid], other[solid], both[solid]
    halves, later = _nearer(both, numbers[one], numbers[other], edges, widths)
    torn = later == 0
    lost: list[list[Shape]] = [[] for _ in claims]
    for losers, parts in (
        (one[later < 0], both[later < 0]),
        (other[later > 0], both[later > 0]),
        (one[torn], common(both[torn], halves[torn], grid)),
        (other[torn], without(both[torn], halves[torn], grid)),
    ):
        for loser, part in zip(losers, parts, strict=True):
            lost[loser].append(part)
    left = claims.copy()
    for number, parts in enumerate(lost):
        if parts:
            gone = together(parts, grid) if len(parts) > 1 else parts[0]
            left[number] = without(claims[number], gone, grid).item()
    return left


def _nearer(
    both: Shapes, one: Indices, other: Indices, edges: Edges, widths: Floats
) -> tuple[Shapes, Floats]:
    """For regions that two edges claim: where the front of `other` comes first, as a half plane
    around the region, and whether `other` comes earlier (-1) or later (1) all over it (else 0).
    """
    import shapely

    slope = edges.inward[other] / widths[other, None] - edges.inward[one] / widths[one, None]
    level = (edges.inward[other] * edges.start[other]).sum(axis=1) / widths[other]
    level -= (edges.inward[one] * edges.start[one]).sum(axis=1) / widths[one]
    box = shapely.bounds(both)
    middle, size = (box[:, :2] + box[:, 2:]) / 2, length_of(box[:, 2:] - box[:, :2])
    behind = (slope * middle).sum(axis=1) - level  # by how much `other` is later, in the middle
    steep = length_of(slope)
    change = steep * size
    later = np.where(np.abs(behind) < change, 0.0, np.sign(behind))
    later[(change < TIE) & (np.abs(behind) < TIE)] = 1.0  # together: it stays where it is
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where((later == 0)[:, None], slope / steep[:, None], 0.0)
        foot = middle - away * np.where(later == 0, behind / steep, 0.0)[:, None]
    side, far = np.stack([-away[:, 1], away[:, 0]], axis=1), 3 * size[:, None]
    halves = [
        foot - side * far,
        foot + side * far,
        foot + (side - away) * far,
        foot - (side + away) * far,
    ]
    return np.asarray(shapely.polygons(np.stack(halves, axis=1)), np.object_), later
