"""One polygon in the plane of its scope: its rings as 2-D points, and polygons made of such rings.

What planar operations share: the way in from a `Solid` of one face that lies level and faces up,
the way to shapely and back, and texture coordinates carried from the whole to its parts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.rings import repeated, spikes, straight
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Solid,
    ring_points,
)

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry as Shape

Shapes = NDArray[np.object_]
"""Shapely geometries."""
Known = dict[tuple[int, int], list[float]]
"""Points, by where the grid of an overlay moves them."""
Rings = list[Floats]
"""One polygon: rings (n, 2), the outline counter-clockwise, then holes clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """What the parts of a polygon take over from it: its height, its tags, its uv.

    uv (3, 2): the affine map from (x, y, 1) to texture coordinates, or None where the polygon has
    none, or some that are not affine.
    """

    height: float
    tags: frozenset[str]
    uv: Floats | None


def opened(solid: Solid, operation: str) -> tuple[Rings, Plane]:
    """The rings of a solid that is one level polygon, and what its parts take over.

    Raises `GeometryError`, naming the operation, for anything else.
    """
    if len(solid) != 1:
        faces = "none" if not len(solid) else f"{len(solid)} faces"
        raise GeometryError(
            f"{operation} needs one polygon, and the shape has {faces}",
            "take a face of it with comp first",
        )
    points = ring_points(solid, 0)
    heights = solid.vertices[solid.corners, 2]
    size = float(np.ptp(solid.vertices[solid.corners, :2], axis=0).max())
    if float(np.ptp(heights)) > 1e-6 * size:
        raise GeometryError(
            f"{operation} needs a polygon in the xy plane of its scope",
            "take the face with comp first: that gives it a scope of its own",
        )
    rings = [np.ascontiguousarray(ring[:, :2]) for ring in points]
    if signed_area(rings[0]) <= 0:
        raise GeometryError(
            f"{operation} needs a polygon that faces up (+z)", "turn it with reverseNormals first"
        )
    holes = [ring if signed_area(ring) < 0 else ring[::-1] for ring in rings[1:]]
    return [rings[0], *holes], Plane(float(heights[0]), solid.tags[0], _affine_uv(solid))


def signed_area(ring: Floats) -> float:
    """The area of a ring (n, 2), negative where it runs clockwise."""
    x, y = (ring - ring[0]).T
    return float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2


def rings_area(rings: Iterable[Floats]) -> float:
    """The area of a polygon of rings, holes taken off."""
    return sum(signed_area(ring) for ring in rings)


def extent(rings: Rings) -> float:
    """The diagonal of the box around the outline."""
    return float(np.hypot(*(rings[0].max(axis=0) - rings[0].min(axis=0))))


def _affine_uv(solid: Solid) -> Floats | None:
    if solid.uv is None:
        return None
    points = solid.vertices[solid.corners, :2]
    table = np.column_stack([points, np.ones(len(points))])
    found, *_ = np.linalg.lstsq(table, solid.uv, rcond=None)
    scale = float(np.abs(solid.uv).max(initial=1.0))
    off = float(np.abs(table @ found - solid.uv).max())
    return found.astype(np.float64) if off <= 1e-9 * scale else None


def closed(polygons: Sequence[Rings], plane: Plane) -> Solid:
    """The polygons of rings as the faces of one solid, in the plane that they came from."""
    rings = [ring for polygon in polygons for ring in polygon]
    points = np.concatenate(rings)
    vertices = np.empty((len(points), 3))
    vertices[:, :2], vertices[:, 2] = points, plane.height
    return Solid(
        vertices,
        np.arange(len(points)),
        np.array([0, *accumulate(map(len, rings))]),
        np.array([0, *accumulate(map(len, polygons))]),
        (plane.tags,) * len(polygons),
        None if plane.uv is None else points @ plane.uv[:2] + plane.uv[2],
    )


# --- shapely -------------------------------------------------------------------------------------


def shape_of(rings: Rings) -> Shape:
    """The polygon as shapely has it; `GeometryError` where it crosses itself."""
    import shapely

    shape = shapely.Polygon(rings[0], rings[1:])
    if not shape.is_valid:
        reason = shapely.is_valid_reason(shape)
        raise GeometryError(
            f"the polygon crosses or touches itself ({reason})", "give a polygon with simple rings"
        )
    return shape


def grid_of(shape: Shape) -> float:
    """The grid that overlays round to: a power of 2, some 1e-12 of the size.

    Overlays of lines that nearly lie on each other can go wrong, without a word, when computed in
    floating coordinates (GEOS 3.14); on a grid they cannot.
    """
    low_x, low_y, high_x, high_y = shape.bounds
    size = max(high_x - low_x, high_y - low_y)
    return float(2.0 ** (np.ceil(np.log2(size)) - 38))


def common(some: Shapes | Shape, others: Shapes | Shape, grid: float) -> Shapes:
    """What both have, pair by pair."""
    import shapely

    return _only_areas(shapely.intersection(some, others, grid_size=grid))


def without(some: Shapes | Shape, others: Shapes | Shape, grid: float) -> Shapes:
    """What the first of each pair has and the other has not."""
    import shapely

    return _only_areas(shapely.difference(some, others, grid_size=grid))


def together(shapes: Shapes | Sequence[Shape], grid: float) -> Shape:
    """What any of them has."""
    import shapely

    return _only_areas(shapely.union_all(shapes, grid_size=grid)).item()


def _only_areas(shapes: Shapes | Shape) -> Shapes:
    """The shapes without the points and lines that overlays leave where parts only touch."""
    import shapely

    found = np.array(shapes, np.object_)
    kinds = shapely.get_type_id(found)
    for place in np.argwhere((kinds != _POLYGON) & (kinds != _POLYGONS)):
        parts = shapely.get_parts(shapely.get_parts(found[tuple(place)]))
        found[tuple(place)] = shapely.multipolygons(parts[shapely.get_type_id(parts) == _POLYGON])
    return found


_POLYGON, _POLYGONS = 3, 6  # shapely's numbers for kinds of geometry


def known_points(points: Floats, grid: float) -> Known:
    """Points (k, 2) by the cell of the grid that each is rounded to."""
    return {_cell(x, y, grid): [x, y] for x, y in points.tolist()}


def rings_of_shape(shape: Shape, points: Floats, grid: float) -> list[Rings]:
    """As `exact_rings`, with the known points (k, 2) themselves."""
    return exact_rings(shape, known_points(points, grid), grid)


def exact_rings(shape: Shape, known: Known, grid: float) -> list[Rings]:
    """The polygons in an overlay, largest first; what is as thin as the grid falls away.

    Points that were known before they were rounded to the grid are put back; others that stand
    nearly on those or on straight lines are left out. Rings begin at their lowest, then leftmost
    point: the same geometry is the same array.
    """
    import shapely

    found: list[tuple[float, Rings]] = []
    for part in shapely.get_parts(shapely.get_parts(shape)):
        if part.area <= 4 * grid * part.length:
            continue
        lines = [shapely.get_coordinates(line)[:-1] for line in (part.exterior, *part.interiors)]
        rings = [ring for ring in (_tidied(line, known, grid) for line in lines) if len(ring) > 2]
        if not (rings and shapely.Polygon(rings[0], rings[1:]).is_valid):
            rings = lines  # as they were rounded
        found.append((part.area, [_begun(ring, hole=k > 0) for k, ring in enumerate(rings)]))
    return [rings for _, rings in sorted(found, key=lambda each: (-each[0], *each[1][0][0]))]


def _cell(x: float, y: float, grid: float) -> tuple[int, int]:
    return round(x / grid), round(y / grid)


def _tidied(ring: Floats, known: Known, grid: float) -> Floats:
    rounded = ring.tolist()
    back = [known.get(_cell(x, y, grid)) for x, y in rounded]
    ring = np.array([old or new for old, new in zip(back, rounded, strict=True)])
    ours = np.array([old is None for old in back])
    if not ours.any():
        return ring
    for way in (1, -1):
        drop = repeated(ring[::way], 8 * grid)[::way] & ours
        ring, ours = ring[~drop], ours[~drop]
    sharp = spikes(ring, 4 * grid)
    ring, ours = ring[~sharp], ours[~sharp]
    return ring[~(straight(ring, 4 * grid) & ours)] if len(ring) > 2 else ring


def _begun(ring: Floats, *, hole: bool) -> Floats:
    if (signed_area(ring) > 0) == hole:
        ring = ring[::-1]
    points = ring.tolist()
    first = min(range(len(points)), key=lambda place: (points[place][1], points[place][0]))
    return np.concatenate([ring[first:], ring[:first]])
