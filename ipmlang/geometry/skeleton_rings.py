"""The rings of a polygon made fit for a skeleton: turned the right way, without what has no length.

In go rings of points as they come; out come rings of corners that know which edge they came from,
outlines counter-clockwise and holes clockwise. What no repair can read, such as a polygon that
crosses itself, raises GeometryError.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats, GeometryError, Indices

Marks = NDArray[np.bool_]
FEW = 64  # edges of which all pairs are looked at
AT_ONCE = 1 << 20  # pairs of a point and an edge that are looked at together
SAME = 1e-9  # points nearer than this part of the polygon's size are one
NO_AREA = ("the polygon has no area", "it needs three corners that are not in one line")


@dataclass(frozen=True, slots=True)
class Ring:
    """points (n, 2), and for each the number of the input's edge that begins there."""

    points: Floats
    edges: list[int]


def fit_rings(rings: Sequence[Floats | Sequence[Sequence[float]]]) -> list[Ring]:
    """The rings, cleaned; the first is the outline. Edges are numbered through all rings.

    Raises GeometryError for a polygon without area, that crosses itself, or whose holes lie
    outside it.
    """
    arrays = [np.asarray(ring, np.float64) for ring in rings]
    if not arrays or any(each.ndim != 2 or each.shape[1] != 2 for each in arrays):
        raise GeometryError("a polygon needs rings of points in the plane")
    everything = np.concatenate(arrays)
    if not np.isfinite(everything).all():
        raise GeometryError("a polygon's points must be numbers")
    size = float(np.ptp(everything, axis=0).max()) if len(everything) else 0.0
    found: list[Ring] = []
    first = 0
    for number, points in enumerate(arrays):
        ring = _cleaned(points, first, SAME * size)
        first += len(points)
        if number == 0 and ring is None:
            raise GeometryError(*NO_AREA)
        if ring is not None and (number == 0 or abs(signed_area(ring.points)) > SAME * size**2):
            found.append(_turned(ring, number == 0))
    _check_crossings(found, SAME * size)
    if signed_area(found[0].points) <= SAME * size**2:
        raise GeometryError(*NO_AREA)
    return found


def _cleaned(points: Floats, first: int, same: float) -> Ring | None:
    """A ring without points that repeat and without spikes, or None where nothing is left."""
    corners = [(float(x), float(y), first + k) for k, (x, y) in enumerate(points)]
    at = 0
    while len(corners) >= 3 and at < len(corners):
        (ax, ay, one), (bx, by, two) = corners[at - 1], corners[at]
        cx, cy, _ = corners[(at + 1) % len(corners)]
        px, py, qx, qy = bx - ax, by - ay, cx - bx, cy - by
        p, q = (px * px + py * py) ** 0.5, (qx * qx + qy * qy) ** 0.5
        if q <= same:
            del corners[(at + 1) % len(corners)]
            corners[at - (at == len(corners))] = (bx, by, _)
        elif p > same and px * qx + py * qy < 0 and abs(px * qy - py * qx) <= same * max(p, q):
            corners[at - 1] = (ax, ay, one if p > q else two)
            del corners[at]
        else:
            at += 1
            continue
        at = max(at - 2, 0)
    if len(corners) < 3:
        return None
    return Ring(np.array([corner[:2] for corner in corners]), [corner[2] for corner in corners])


def following(points: Floats) -> Floats:
    """The point after each of a ring (n, 2)."""
    return np.concatenate([points[1:], points[:1]])


def directions(points: Floats) -> Floats:
    """Of each edge of a ring (n, 2), the unit vector along it."""
    onward = following(points) - points
    return np.asarray(onward / np.hypot(onward[:, 0], onward[:, 1])[:, None])


def signed_area(points: Floats) -> float:
    """The area within a ring (n, 2), negative where it runs clockwise."""
    own = points - points[0]
    x, y = following(own).T
    return float(own[:, 0] @ y - own[:, 1] @ x) / 2


def _turned(ring: Ring, left: bool) -> Ring:
    """The ring, counter-clockwise or clockwise."""
    return ring if (signed_area(ring.points) > 0) == left else reversed_ring(ring)


def reversed_ring(ring: Ring) -> Ring:
    """The ring the other way round, its edges still the input's."""
    edges = ring.edges[-2::-1] + ring.edges[-1:]
    return Ring(ring.points[::-1], edges)


def _check_crossings(rings: list[Ring], slack: float) -> None:
    a = np.concatenate([ring.points for ring in rings])
    b = np.concatenate([following(ring.points) for ring in rings])
    d = np.concatenate([directions(ring.points) for ring in rings])
    one, other = _pairs(a, b)
    parts = _on_both_sides(a, b, d, one, other, slack) & _on_both_sides(a, b, d, other, one, slack)
    if parts.any():
        raise GeometryError(
            "the polygon crosses itself", "its outline and its holes must not cross"
        )
    if len(rings) == 1:
        return
    for hole in rings[1:]:
        if not mostly_inside(hole.points, rings[0].points):
            raise GeometryError("a hole lies outside the polygon's outline")
    low = np.array([ring.points.min(axis=0) for ring in rings])
    high = np.array([ring.points.max(axis=0) for ring in rings])
    around = (low[:, None] <= low).all(axis=2) & (high[:, None] >= high).all(axis=2)
    for outer, inner in np.argwhere(around).tolist():
        if outer > 0 and outer != inner and mostly_inside(rings[inner].points, rings[outer].points):
            raise GeometryError("a hole of the polygon lies within another")


def _pairs(start: Floats, end: Floats) -> tuple[Indices, Indices]:
    """Pairs of edges (p,), (p,) that may cross: all of few, of many those whose boxes meet."""
    if len(start) <= FEW:
        return _all_pairs(len(start))
    import shapely

    boxes = shapely.box(*np.minimum(start, end).T, *np.maximum(start, end).T)
    one, other = shapely.STRtree(boxes).query(boxes)
    first = one < other
    return one[first], other[first]


@lru_cache(maxsize=FEW)
def _all_pairs(count: int) -> tuple[Indices, Indices]:
    return np.triu_indices(count, 1)


def _on_both_sides(
    start: Floats, end: Floats, along: Floats, one: Indices, other: Indices, slack: float
) -> Marks:
    """Whether the ends of other edges lie on both sides of the lines of some, pair by pair."""
    (x, y), (u, v) = along[one].T, start[one].T
    height = [x * (each[other, 1] - v) - y * (each[other, 0] - u) for each in (start, end)]
    found: Marks = (np.minimum(*height) < -slack) & (np.maximum(*height) > slack)
    return found


def mostly_inside(ring: Floats, outline: Floats) -> bool:
    """Whether half of a ring (n, 2) or more lies within another, by its corners and midpoints."""
    tested = np.concatenate([ring, (ring + following(ring)) / 2])
    step = max(1, AT_ONCE // len(outline))
    parts = [tested[at : at + step] for at in range(0, len(tested), step)]
    return 2 * sum(_count_inside(each, outline) for each in parts) >= len(tested)


def _count_inside(points: Floats, outline: Floats) -> int:
    """How many points (n, 2) lie within an outline."""
    a, b = outline, following(outline)
    x, y = points[:, 0, None], points[:, 1, None]
    rise = b[:, 1] - a[:, 1]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    at = a[:, 0] + (y - a[:, 1]) / np.where(rise == 0, 1.0, rise) * (b[:, 0] - a[:, 0])
    return int(((spans & (x < at)).sum(axis=1) % 2).sum())
