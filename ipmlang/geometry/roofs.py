"""Roofs over a polygon: hip, gable, shed, pyramid, mansard.

In goes one face in a level plane, facing up; out comes a closed solid that stands on that plane,
its vertices shared. Faces are tagged roof.slope, roof.gable, roof.side, roof.bottom and
roof.soffit, those of a mansard roof roof.lower and roof.upper as well. With an overhang the slopes
run on outwards and down past the footprint to level eaves; a flat soffit joins the eaves to the
footprint from below, so that the solid is closed and does not reach into what it stands on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, radians, tan

import numpy as np

from ipmlang.geometry.roof_base import (
    BOTTOM,
    Eaves,
    Faces,
    Footprint,
    add_underside,
    eaves,
    footprint,
)
from ipmlang.geometry.roof_ridges import direction, gable_edges
from ipmlang.geometry.skeleton import Skeleton, skeleton_of
from ipmlang.geometry.skeleton_rings import directions, following
from ipmlang.geometry.solid import Floats, GeometryError, Solid

SLOPE, GABLE, SIDE = ("roof.slope",), ("roof.gable",), ("roof.side",)
LOWER, UPPER = ("roof.slope", "roof.lower"), ("roof.slope", "roof.upper")
THIN = 1e-9  # heights below this part of a roof's size are none


def roof_hip(polygon: Solid, degrees: float | Sequence[float], overhang: float = 0.0) -> Solid:
    """A slope from each edge, at one angle or at one for each of the polygon's edges.

    Over a rectangle a x b (a >= b) the ridge is a - b long and b / 2 * tan(degrees) high. Eaves
    are level: with unequal angles the flattest slope hangs over by `overhang`, others by less.
    Raises GeometryError for angles not between 0 and 90, for what is no polygon, and for one of
    more corners than `skeleton.MOST`.

    >>> from ipmlang.geometry.solid import polygon, volume
    >>> roof = roof_hip(polygon([(0, 0), (4, 0), (4, 2), (0, 2)]), 45)
    >>> len(roof), round(volume(roof), 9)
    (5, 3.333333333)
    """
    base = footprint(polygon)
    slopes = [_slope(each) for each in _for_each_edge(degrees, base.edges)]
    return _planes(base, slopes, _checked(overhang))


def roof_gable(
    polygon: Solid, degrees: float, overhang: float = 0.0, ridge: float | None = None
) -> Solid:
    """Slopes at one angle between upright gables.

    Without `ridge` each wing of the polygon ends in a gable (a square's ridge runs along its first
    edge; a court without wings has none). `ridge` (degrees from x in the polygon's plane) puts
    gables on the sides between convex corners that run across it. An overhang moves gables
    outwards like the eaves. Raises GeometryError as `roof_hip` does.
    """
    base = footprint(polygon)
    slope = _slope(degrees)
    gables = gable_edges(base.rings, _angle(ridge))
    slopes = [None if edge in gables else slope for edge in range(base.edges)]
    return _planes(base, slopes, _checked(overhang))


def roof_shed(
    polygon: Solid, degrees: float, overhang: float = 0.0, ridge: float | None = None
) -> Solid:
    """One slope over all of the polygon, on upright sides.

    It rises towards +y from the polygon's front, or to the left of the direction `ridge` (degrees
    from x), along which the ridge runs. Raises GeometryError as `roof_hip` does.
    """
    base = footprint(polygon)
    slope = _slope(degrees)
    x, y = direction(_angle(ridge) or 0.0)
    rise = np.array([-y, x]) * slope
    low = float((base.points[0] @ rise).min())
    reach = _checked(overhang)
    around = eaves(base, reach, [1.0] * base.edges)
    drop = max(0.0, low - float((around.rings[0].points @ rise).min())) if reach else 0.0
    return _under_plane(base, replace(around, drop=drop), rise, low)


def roof_pyramid(polygon: Solid, height: float) -> Solid:
    """A triangle from each edge to one apex above the polygon's middle.

    The middle is the centroid where it sees all edges, else the middle of all points that do.
    Raises GeometryError where there is none, as over an L with long wings or around a courtyard.
    """
    base = footprint(polygon)
    if not (isfinite(height) and height > 0):
        raise GeometryError("a roof's height must be above 0")
    if len(base.rings) > 1:
        raise GeometryError(
            "a pyramid cannot stand around a courtyard", "a hip roof fits over any polygon"
        )
    made = Faces()
    ring = made.add_level(base.points[0], base.level)
    x, y = _middle(base.points[0])
    apex = made.add_points([(x, y, base.level + height)])
    for k in range(len(ring)):
        made.add([[ring[k - 1], ring[k], *apex]], SLOPE)
    made.add([ring[::-1]], BOTTOM)
    return made.solid()


def roof_mansard(
    polygon: Solid, lower: float, height: float, upper: float, overhang: float = 0.0
) -> Solid:
    """Slopes at the angle `lower` up to a height above the polygon, from there on at `upper`.

    Where the lower slopes meet below that height there is no upper one. Raises GeometryError as
    `roof_hip` does, and for a height that is not above 0.
    """
    base = footprint(polygon)
    steep, flat = _slope(lower), _slope(upper)
    if not (isfinite(height) and height > 0):
        raise GeometryError("a roof's height must be above 0")
    reach = _checked(overhang)
    around = eaves(base, reach * steep, [1 / steep] * base.edges)
    found = skeleton_of(around.rings, [1.0] * len(around.origins))
    turn = height / steep + reach
    made = Faces()
    faces, vertices = _cut_at(found.faces, found.vertices, turn)
    distance = vertices[:, 2]
    z = np.where(distance <= turn, distance * steep, turn * steep + (distance - turn) * flat)
    made.add_points(np.column_stack([vertices[:, :2], z]).tolist(), base.level - around.drop)
    for ring, above in faces:
        made.add([ring], UPPER if above else LOWER)
    add_underside(made, base, around, _border(around, found.faces))
    return made.solid()


def _slope(degrees: float) -> float:
    """The tangent of a roof's angle."""
    if not 0 < degrees < 90:
        raise GeometryError(
            f"a roof cannot slope by {degrees:g} degrees", "the angle is between 0 and 90"
        )
    return tan(radians(degrees))


def _for_each_edge(degrees: float | Sequence[float], edges: int) -> list[float]:
    if isinstance(degrees, int | float):
        return [float(degrees)] * edges
    given = [float(each) for each in degrees]
    if len(given) != edges:
        raise GeometryError(f"{edges} edges need {edges} angles, not {len(given)}")
    return given


def _checked(overhang: float) -> float:
    if not (isfinite(overhang) and overhang >= 0):
        raise GeometryError("a roof's overhang must be at least 0")
    return overhang


def _angle(ridge: float | None) -> float | None:
    if ridge is not None and not isfinite(ridge):
        raise GeometryError("a ridge's direction must be an angle in degrees")
    return ridge


def _planes(base: Footprint, slopes: Sequence[float | None], overhang: float) -> Solid:
    """A plane from each of a polygon's edges: of a slope (a tangent), or upright (None)."""
    rising = [slope for slope in slopes if slope is not None]
    drop = overhang * min(rising)
    outwards = [1 / slope if slope else 1 / min(rising) for slope in slopes]
    around = eaves(base, drop, outwards)
    inwards = [1 / slope if slope else 0.0 for slope in slopes]
    speeds = [inwards[edge] if edge >= 0 else 0.0 for edge in around.origins]
    return roofed(base, around, skeleton_of(around.rings, speeds), speeds)


def roofed(base: Footprint, around: Eaves, found: Skeleton, speeds: Sequence[float]) -> Solid:
    """The roof whose planes rise from the eaves as a skeleton has it; `speeds` of its edges."""
    made = Faces()
    made.add_points(found.vertices.tolist(), base.level - around.drop)
    for k, (ring, speed) in enumerate(zip(found.faces, speeds, strict=True)):
        if ring:
            made.add([ring, *found.holes.get(k, ())], SLOPE if speed else GABLE)
    for ring in found.walls:
        made.add([ring], GABLE)
    add_underside(made, base, around, _border(around, found.faces))
    return made.solid()


def _border(around: Eaves, faces: Sequence[list[int]]) -> list[list[int]]:
    """The vertices of the eaves' rings: the face of an edge begins with its ends."""
    return [[faces[edge][0] for edge in ring.edges] for ring in around.rings]


def _cut_at(
    faces: Sequence[list[int]], vertices: Floats, level: float
) -> tuple[list[tuple[list[int], bool]], Floats]:
    """Faces that rise from their edges, cut where the third coordinate is `level`.

    Gives rings and whether they lie above, and the vertices with those of the cuts.
    """
    size = float(np.ptp(vertices[:, :2], axis=0).max())
    z = vertices[:, 2]
    away = np.where(np.abs(z - level) <= THIN * size, 0, np.sign(z - level))
    sides: list[int] = away.astype(np.int64).tolist()
    points: list[list[float]] = vertices.tolist()
    cuts: dict[tuple[int, int], int] = {}
    found: list[tuple[list[int], bool]] = []
    for face in faces:
        ring: list[int] = []
        for one, other in zip(face, [*face[1:], *face[:1]], strict=True):
            ring.append(one)
            if sides[one] * sides[other] < 0:
                key = (min(one, other), max(one, other))
                if key not in cuts:
                    a, b = np.array(points[key[0]]), np.array(points[key[1]])
                    cuts[key] = len(points)
                    points.append((a + (level - a[2]) / (b[2] - a[2]) * (b - a)).tolist())
                    sides.append(0)
                ring.append(cuts[key])
        if face:
            found.append(([k for k in ring if sides[k] <= 0], False))
            found.extend((part, True) for part in _runs_above(ring, sides))
    return found, np.array(points)


def _runs_above(ring: list[int], sides: list[int]) -> list[list[int]]:
    """The parts of a ring that lie above, each with the cut's vertex before and after it."""
    found: list[list[int]] = []
    for k, vertex in enumerate(ring):  # a ring begins with its edge, below
        if sides[vertex] <= 0:
            continue
        if sides[ring[k - 1]] <= 0:
            found.append([ring[k - 1]])
        found[-1].append(vertex)
        if sides[after := ring[(k + 1) % len(ring)]] <= 0:
            found[-1].append(after)
    return found


def _under_plane(base: Footprint, around: Eaves, rise: Floats, low: float) -> Solid:
    """All between the eaves' rings and the plane z = rise . (x, y) - low above the footprint."""
    made = Faces()
    floor, roof = [], []
    ground = base.level - around.drop
    size = float(np.ptp(around.rings[0].points, axis=0).max())
    for points in (ring.points for ring in around.rings):
        height = points @ rise - low + around.drop
        floor.append(made.add_level(points, ground))
        upper = made.add_points(np.column_stack([points, height]).tolist(), ground)
        flat = height <= THIN * size
        roof.append([f if same else u for f, u, same in zip(floor[-1], upper, flat, strict=True)])
    made.add(roof, SLOPE)
    for below, above in zip(floor, roof, strict=True):
        for k in range(len(below)):
            side = list(dict.fromkeys([below[k - 1], below[k], above[k], above[k - 1]]))
            if len(side) > 2:
                made.add([side], SIDE)
    add_underside(made, base, around, floor)
    return made.solid()


def _middle(ring: Floats) -> tuple[float, float]:
    """A point that sees all of a ring (n, 2): the centroid, else that of all that do."""
    area, x, y = _moments(ring)
    size = float(np.ptp(ring, axis=0).max())
    onward = directions(ring)
    level = onward[:, 0] * ring[:, 1] - onward[:, 1] * ring[:, 0]
    if (onward[:, 0] * y - onward[:, 1] * x - level > THIN * size).all():
        return x, y
    low, high = ring.min(axis=0), ring.max(axis=0)
    seen = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    for (dx, dy), at in zip(onward, level, strict=True):
        seen = _clipped(seen, seen @ np.array([-dy, dx]) - at)
    area, x, y = _moments(seen) if len(seen) > 2 else (0.0, 0.0, 0.0)
    if area <= THIN * size * size:
        raise GeometryError(
            "no apex sees all edges of the polygon", "a hip roof fits over any polygon"
        )
    return x, y


def _moments(ring: Floats) -> tuple[float, float, float]:
    """The area within a ring, and its centroid."""
    points = ring - ring[0]
    after = following(points)
    cross = points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0]
    total = float(cross.sum())
    if total == 0:
        return 0.0, 0.0, 0.0
    x, y = (cross @ (points + after) / (3 * total) + ring[0]).tolist()
    return total / 2, x, y


def _clipped(ring: Floats, height: Floats) -> Floats:
    """The part of a convex ring whose heights are not below 0."""
    kept: list[Floats] = []
    for k in range(len(ring)):
        if height[k - 1] * height[k] < 0:
            part = height[k - 1] / (height[k - 1] - height[k])
            kept.append(ring[k - 1] + part * (ring[k] - ring[k - 1]))
        if height[k] >= 0:
            kept.append(ring[k])
    return np.array(kept).reshape(-1, 2)
