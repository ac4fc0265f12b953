"""Strips along the edges of a polygon, mitred where they meet, and what they leave of it.

Rings and a width per edge come in; the strip of each edge and the polygons left over come out.
Together they are the whole, without overlap. Where no strip ends before its full width, strips are
quadrilaterals and the rest is a ring moved inward: that is computed directly. Else the region that
each edge claims is cut out of the polygon, and what two edges claim goes to the one that a front,
moving from all edges at once, would reach it from first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.planar import (
    Rings,
    Shapes,
    common,
    exact_rings,
    grid_of,
    known_points,
    rings_area,
    shape_of,
    signed_area,
    together,
    without,
)
from ipmlang.geometry.solid import Floats, Indices

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry as Shape

Marks = NDArray[np.bool_]

MITRE = 5.0
"""A mitre around a corner that juts in reaches this many widths; what is longer is cut off."""

TIE = 1e-9
"""Fronts that differ by less than this part of their way arrive together."""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """The edges of all rings: start and end (n, 2), unit direction, unit inward normal, length,
    and the numbers of the edges before and after each on its ring.
    """

    start: Floats
    end: Floats
    along: Floats
    inward: Floats
    length: Floats
    before: Indices
    after: Indices
    counts: list[int]


def edges_of(rings: Rings) -> Edges:
    """The edges, ring by ring; each begins at the point of its number."""
    counts = [len(ring) for ring in rings]
    before, after, offset = [], [], 0
    for count in counts:
        number = np.arange(offset, offset + count)
        before.append(np.roll(number, 1))
        after.append(np.roll(number, -1))
        offset += count
    start = np.concatenate(rings)
    follows = np.concatenate(after)
    step = start[follows] - start
    length = np.hypot(step[:, 0], step[:, 1])
    along = step / length[:, None]
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return Edges(
        start, start[follows], along, inward, length, np.concatenate(before), follows, counts
    )


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """Where strips meet at the start of each edge.

    Inner corner of the strip before it and of its own (n, 2); between them, where a long mitre is
    cut off, the middle of the cut. apart: the strips end at different widths on the line that
    halves the angle, for their inner lines meet nowhere near; long: the mitre is cut off; juts:
    the polygon juts in here. Elsewhere all three points are one.
    """

    before: Floats
    middle: Floats
    own: Floats
    apart: Marks
    long: Marks
    juts: Marks


def corners_of(edges: Edges, widths: Floats, mitre: float = MITRE) -> Corners:
    """The corners of strips of these widths (n,), one per edge, all at least 0."""
    here, other = edges.inward, edges.inward[edges.before]
    wide, wide_before = widths, widths[edges.before]
    turn = (other * edges.along).sum(axis=1)  # the sine: above 0 where it turns left
    dot = (here * other).sum(axis=1)
    # the point on both inner lines, as mean width and difference: stable on straight edges
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = ((wide + wide_before) / 2 / (1 + dot))[:, None] * (here + other)
        skew = ((wide_before - wide) / 2 / (1 - dot))[:, None] * (other - here)
    skew = np.where((wide == wide_before)[:, None], 0.0, skew)
    reach = mean + skew
    single = edges.start + reach
    most = mitre * np.maximum(wide, wide_before)
    leans = ((reach * edges.along).sum(axis=1) > 0) | (
        (reach * edges.along[edges.before]).sum(axis=1) < 0
    )
    juts = turn < 0
    apart = (_length(skew) > most) | (juts & leans & (wide != wide_before))
    long = juts & (_length(reach) > most) & ~apart
    before, middle, own = single.copy(), single.copy(), single.copy()
    if apart.any():
        line = (here + other)[apart] / _length((here + other)[apart])[:, None]
        share = (line * here[apart]).sum(axis=1)[:, None]
        own[apart] = edges.start[apart] + line * wide[apart, None] / share
        before[apart] = edges.start[apart] + line * wide_before[apart, None] / share
        middle[apart] = own[apart]
    if long.any():
        _cut_off(edges, widths, reach[long], long, mitre, (before, middle, own))
    return Corners(before, middle, own, apart, long, juts)


def _cut_off(
    edges: Edges, widths: Floats, reach: Floats, long: Marks, mitre: float,
    ends: tuple[Floats, Floats, Floats],
) -> None:  # fmt: skip
    """Cut a mitre square off at its limit."""
    before, middle, own = ends
    last = edges.before[long]
    away = reach / _length(reach)[:, None]
    start = edges.start[long]
    limit = mitre * np.maximum(widths[long], widths[last])
    for found, which, way in ((before, last, 1.0), (own, np.flatnonzero(long), -1.0)):
        line = start + edges.inward[which] * widths[which, None]
        along = edges.along[which] * way
        short = limit - ((line - start) * away).sum(axis=1)
        found[long] = line + along * (short / (along * away).sum(axis=1))[:, None]
    middle[long] = start + away * limit[:, None]


def _length(vectors: Floats) -> Floats:
    return np.hypot(vectors[:, 0], vectors[:, 1])


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """The polygons left over, and those of each edge's strip (none where its width is 0)."""

    rest: list[Rings]
    strips: list[list[Rings]]


def strips_of(rings: Rings, widths: Floats, mitre: float = MITRE) -> Strips:
    """Strips of these widths (n,) cut off a polygon along its edges."""
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
    to look at each strip by itself: claims (see `_claims`) end where the strips do, for equal
    widths, where nothing juts in, and where neighbours are long enough. If then each strip and
    the polygon within have simple rings, they turn once around each of their points; their sum
    turns as often as the outer rings do, so they overlap nowhere and leave no gap.
    """
    ends = ((corners.before[edges.after] - corners.own) * edges.along).sum(axis=1)
    plain = not corners.juts.any() or bool((widths == widths[0]).all())
    if (ends <= 0).any() or not (plain or _held(edges, widths, corners).all()):
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


def _held(edges: Edges, widths: Floats, corners: Corners) -> Marks:
    """Of which edges (n,) the claims (see `_claims`) end, at both ends, where the strips do.

    They do where the strip has its full width, and nothing beyond the mitres of its ends lies
    out of the reach of its neighbours' strips.
    """
    last = edges.before
    dot = (edges.along * edges.along[last]).sum(axis=1)
    turn = (edges.inward[last] * edges.along).sum(axis=1)
    with np.errstate(divide="ignore"):
        share = np.where(dot >= 0, turn, 1 / turn)
    to_own = ((corners.own - edges.start) * edges.along).sum(axis=1)
    to_last = -((corners.before - edges.start) * edges.along[last]).sum(axis=1)
    shared = corners.juts | corners.apart  # claims end on one line
    at_start = np.where(shared, 0.0, np.maximum(to_own, widths[last] * share))
    at_end = np.where(shared, 0.0, np.maximum(to_last, widths * share))[edges.after]
    full = ((corners.before[edges.after] - corners.own) * edges.along).sum(axis=1) > 0
    found: Marks = full & (at_start + at_end <= edges.length)
    return found


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


# --- claims ---------------------------------------------------------------------------------------


def _claimed(rings: Rings, edges: Edges, widths: Floats, corners: Corners) -> Strips:
    """Strips where some end early."""
    shape = shape_of(rings)
    claims, numbers = _claims(shape, edges, widths, corners)
    grid = grid_of(shape)
    rest = without(shape, together(claims, grid), grid).item()
    points = np.concatenate([edges.start, corners.before, corners.middle, corners.own])
    known = known_points(points, grid)
    strips: list[list[Rings]] = [[] for _ in widths]
    for number, cell in zip(
        numbers, _shared_out(claims, numbers, edges, widths, grid), strict=True
    ):
        strips[int(number)] = exact_rings(cell, known, grid)
    return Strips(exact_rings(rest, known, grid), strips)


def claims_of(shape: Shape, edges: Edges, widths: Floats, corners: Corners) -> Shape:
    """All that strips of these widths take of a shape, which has these edges."""
    return together(_claims(shape, edges, widths, corners)[0], grid_of(shape))


def _claims(shape: Shape, edges: Edges, widths: Floats, corners: Corners) -> tuple[Shapes, Indices]:
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
    held = _held(edges, widths, corners)
    free = ~(corners.apart | (held & held[edges.before]))
    inside = ((first - edges.start) * edges.along).sum(axis=1) > 0
    first = np.where((inside & free)[:, None], edges.start + over, first)
    inside = ((final - edges.end) * edges.along).sum(axis=1) < 0
    final = np.where((inside & free[edges.after])[:, None], edges.end + over, final)
    long = corners.long[:, None]
    at_start = np.where(long, corners.middle, edges.start)
    at_end = np.where(long[edges.after], corners.middle[edges.after], edges.end)
    return np.stack([edges.start, edges.end, at_end, final, first, at_start], axis=1)


def _shared_out(
    claims: Shapes, numbers: Indices, edges: Edges, widths: Floats, grid: float
) -> Shapes:
    """The claims without what another edge's front reaches first."""
    import shapely

    one, other = shapely.STRtree(claims).query(claims, predicate="intersects")
    one, other = one[one < other], other[one < other]
    both = common(claims[one], claims[other], grid)
    solid = shapely.area(both) > 0
    one, other, both = one[solid], other[solid], both[solid]
    lost: list[list[Shape]] = [[] for _ in claims]
    nearer = _nearer(both, numbers[one], numbers[other], edges, widths)
    to_other, to_one = common(both, nearer, grid), without(both, nearer, grid)
    for a, b, to_b, to_a in zip(one, other, to_other, to_one, strict=True):
        lost[a].append(to_b)
        lost[b].append(to_a)
    gone = np.array([together(each, grid) for each in lost], np.object_)
    return without(claims, gone, grid)


def _nearer(both: Shapes, one: Indices, other: Indices, edges: Edges, widths: Floats) -> Shapes:
    """Where, around each shared region, the front of `other` comes before that of `one`."""
    import shapely

    slope = edges.inward[other] / widths[other, None] - edges.inward[one] / widths[one, None]
    level = (edges.inward[other] * edges.start[other]).sum(axis=1) / widths[other]
    level -= (edges.inward[one] * edges.start[one]).sum(axis=1) / widths[one]
    box = shapely.bounds(both)
    middle, size = (box[:, :2] + box[:, 2:]) / 2, _length(box[:, 2:] - box[:, :2])
    later = (slope * middle).sum(axis=1) - level  # by how much `other` is later, in the middle
    steep = _length(slope)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where((steep > 0)[:, None], slope / steep[:, None], [1.0, 0.0])
        back = np.clip(later / steep, -size, size)
    even = (steep * size < TIE) & (np.abs(later) < TIE)
    back = np.where(even, size, np.where(np.isnan(back), size, back))
    foot = middle - away * back[:, None]
    side, far = np.stack([-away[:, 1], away[:, 0]], axis=1), 3 * size[:, None]
    halves = [
        foot - side * far,
        foot + side * far,
        foot + (side - away) * far,
        foot - (side + away) * far,
    ]
    return np.asarray(shapely.polygons(np.stack(halves, axis=1)), np.object_)
