"""Rings as maps, drawings and files have them, made into sound polygons, and a note of each mend.

What says the same thing twice is left out, rings that touch are taken apart at the touch; no point
is ever moved. What has no single reading (a ring that crosses itself, a face that is not flat) is
refused, with the place. Knows no file format and no scope.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.geometry.rings import (
    Marks,
    Ring,
    bends,
    loops_of,
    nest,
    repeated,
    simple_loops,
    spikes,
    straight,
)
from ipmlang.geometry.solid import Floats, GeometryError, Indices, Solid, polygon

SAME = 1e-9
"""Points nearer than this part of the whole's size are one point; a line this straight is one."""
FLAT = 1e-6
"""How far off its plane a point may lie, as a part of the whole's size."""

Points = Floats | Sequence[Sequence[float]]


def footprint(rings: Sequence[Points]) -> tuple[list[Solid], list[str]]:
    """The polygons that rings of points (n, 2) or (n, 3) bound, and notes of what was mended.

    The first ring is the outline, the others are holes, each in either direction, with or without
    a closing point. Polygons keep the points' coordinates (z = 0 where there is none); an outline
    faces up, a vertical one keeps its direction. There are several polygons where a ring touches
    itself so that its inside falls apart. Raises `GeometryError` for crossing rings (with the
    crossing), points off the plane (with the distance), numbers that are not finite and no area.

    >>> footprint([[(0, 0), (0, 2), (3, 2), (3, 1), (3, 0), (0, 0)]])[1]
    ['1 point in the middle of a straight edge left out', 'the outline ran clockwise: turned round']
    """
    spatial = [_points(ring, name) for ring, name in zip(rings, _names(len(rings)), strict=True)]
    if not spatial:
        raise GeometryError("a polygon needs a ring of points, and there is none")
    points = np.concatenate(spatial)
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    if size == 0.0:
        raise GeometryError("all points of the polygon are the same")
    flat = _flat(points, spatial[0], size)
    notes: list[str] = []
    found = _numbered(spatial)
    outline, *holes = [
        ring
        for ring in (
            _tidy(flat, ring, size * SAME, name, notes)
            for ring, name in zip(found, _names(len(found)), strict=True)
        )
        if len(ring)
    ] or [np.zeros(0, np.int64)]
    outline = _turned(flat, outline, notes)
    faces = _faces(flat, [outline, *holes], size * SAME, notes)
    return [_solid(points, face) for face in faces], notes


def sound(rings: Sequence[Floats]) -> Marks:
    """Which outlines without holes, points (n, 2) or (n, 3) each, are polygons as they stand: they
    lie level, run counter-clockwise, and `footprint` would mend nothing. Looked at all together.

    >>> sound([np.array([(0, 0), (2, 0), (0, 1)]), np.array([(0, 0), (1, 0), (2, 0), (0, 1)])])
    array([ True, False])
    """
    import shapely

    counts = np.array([len(ring) for ring in rings], np.int64)
    found: Marks = counts >= 3
    flat = [k for k in np.flatnonzero(found).tolist() if np.isfinite(rings[k]).all()]
    found[:] = False
    if not flat:
        return found
    counts = counts[flat]
    points = np.concatenate([_in_space(rings[k]) for k in flat])
    starts = np.cumsum(counts) - counts
    low, high = np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)
    near = (high - low).max(axis=1) * SAME
    xy = points[:, :2]
    after, before = np.arange(1, len(xy) + 1), np.arange(-1, len(xy) - 1)
    after[starts + counts - 1], before[starts] = starts, starts + counts - 1
    good = bends(xy, xy[before], xy[after], np.repeat(near, counts))
    ring_of = np.repeat(np.arange(len(counts)), counts)
    shapes = shapely.polygons(shapely.linearrings(xy, indices=ring_of))
    level = (high - low)[:, 2] <= near
    area = np.add.reduceat(_crossed(xy - xy[starts][ring_of], after), starts) / 2
    found[flat] = (
        np.logical_and.reduceat(good, starts)
        & level
        & (area > near * near)
        & shapely.is_valid(shapes)
    )
    return found


def _in_space(ring: Floats) -> Floats:
    return ring if ring.shape[1] == 3 else np.pad(ring, ((0, 0), (0, 1)))


def _crossed(points: Floats, after: Indices) -> Floats:
    """Twice the areas (n,) of triangles of the origin, a point and the one after it."""
    x, y = points.T
    found: Floats = x * y[after] - x[after] * y
    return found


def _names(count: int) -> list[str]:
    return ["the outline", *(f"hole {number}" for number in range(1, count))][:count]


def _points(ring: Points, name: str) -> Floats:
    points = np.asarray(ring, np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) < 3:
        raise GeometryError(f"{name} needs three points or more, and has {len(points)}")
    if not np.isfinite(points).all():
        where = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise GeometryError(f"point {where + 1} of {name} is not a number")
    return _in_space(points)


def _numbered(rings: Sequence[Floats]) -> list[Indices]:
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    return [np.arange(a, a + len(ring)) for a, ring in zip(starts, rings, strict=False)]


# --- the plane ------------------------------------------------------------------------------


def _flat(points: Floats, outline: Floats, size: float) -> Floats:
    """The points in their plane (n, 2): x and y themselves where it is level."""
    if float(np.ptp(points[:, 2])) <= size * SAME:
        return points[:, :2]
    middle = outline.mean(axis=0)
    around = outline - middle
    normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
    length = float(np.sqrt(normal @ normal))
    if length <= (size * SAME) ** 2:
        raise GeometryError("the polygon has no area: its points lie on a line")
    normal = normal / length
    off = np.abs((points - middle) @ normal)
    if float(off.max()) > size * FLAT:
        raise GeometryError(
            f"the face is not flat: point {int(off.argmax()) + 1} lies {off.max():.3g} off its"
            " plane",
            "cut it into triangles, or move the point into the plane",
        )
    along = np.cross(normal, _least(normal))
    x = along / np.sqrt(along @ along)
    y = np.cross(normal, x)
    if normal[2] < -SAME:  # seen from above, that what runs clockwise there is turned round
        y = -y
    flat: Floats = np.stack([(points - middle) @ x, (points - middle) @ y], axis=1)
    return flat


def _least(normal: Floats) -> Floats:
    axis = np.zeros(3)
    axis[int(np.argmin(np.abs(normal)))] = 1.0
    return axis


def _turned(flat: Floats, outline: Indices, notes: list[str]) -> Indices:
    if len(outline) and _twice_area(flat[outline]) < 0:
        notes.append("the outline ran clockwise: turned round")
        return outline[::-1]
    return outline


def _twice_area(ring: Floats) -> float:
    near = ring - ring[0]
    x, y = near.T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


# --- what says the same thing twice ------------------------------------------------------------


def _tidy(flat: Floats, ring: Indices, near: float, name: str, notes: list[str]) -> Indices:
    """The ring without repeated points, spikes and points on straight edges; [] if none is left."""
    closed = len(ring) > 1 and bool((flat[ring[0]] == flat[ring[-1]]).all())
    ring = ring[:-1] if closed else ring
    counts = dict.fromkeys(("repeated", "spikes", "straight"), 0)
    while True:
        before = len(ring)
        ring = _without(ring, repeated(flat[ring], near), counts, "repeated")
        ring = _without(ring, spikes(flat[ring], near), counts, "spikes")
        if len(ring) == before or len(ring) < 3:
            break
    if len(ring) >= 3:
        ring = _without(ring, straight(flat[ring], near), counts, "straight")
    if len(ring) < 3:
        if name == "the outline":
            raise GeometryError("the polygon has no area: its points lie on a line")
        notes.append(f"{name} has no area: left out")
        return ring[:0]
    notes.extend(_said(counts))
    return ring


def _said(counts: dict[str, int]) -> list[str]:
    one = {
        "repeated": ("1 repeated point left out", "{} repeated points left out"),
        "spikes": ("1 spike without width left out", "{} spikes without width left out"),
        "straight": (
            "1 point in the middle of a straight edge left out",
            "{} points in the middle of straight edges left out",
        ),
    }
    return [
        one[kind][0] if count == 1 else one[kind][1].format(count)
        for kind, count in counts.items()
        if count
    ]


def _without(ring: Indices, drop: Marks, counts: dict[str, int], kind: str) -> Indices:
    counts[kind] += int(drop.sum())
    return ring[~drop]


# --- rings that touch ---------------------------------------------------------------------------


def _faces(flat: Floats, rings: list[Indices], near: float, notes: list[str]) -> list[list[Ring]]:
    """The faces that the rings bound, each its outline and holes as numbers of points."""
    import shapely

    shape = shapely.Polygon(flat[rings[0]], [flat[hole] for hole in rings[1:]])
    if shape.is_valid:
        if shape.area <= near * near:
            raise GeometryError("the polygon has no area")
        turned = [h if _twice_area(flat[h]) < 0 else h[::-1] for h in rings[1:]]
        return [[list(map(int, ring)) for ring in (rings[0], *turned)]]
    directed = [ring if _right_way(flat, ring, k) else ring[::-1] for k, ring in enumerate(rings)]
    faces = nest(flat, simple_loops(flat, loops_of(flat, directed, near)))
    if not faces:
        raise GeometryError("the polygon has no area: its edges lie on each other")
    notes.append(
        "rings touch: taken apart at the touch"
        + (f", which gives {len(faces)} polygons" if len(faces) > 1 else "")
    )
    return faces


def _right_way(flat: Floats, ring: Indices, number: int) -> bool:
    return (_twice_area(flat[ring]) > 0) == (number == 0)


def _solid(points: Floats, face: list[Ring]) -> Solid:
    outline, *holes = (points[ring] for ring in face)
    return polygon(outline, holes)
