"""Replace a geometry by what stands for it: its box, its outline, its plane, its inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.geometry.aligning import alignment, largest_face
from ipmlang.geometry.planar import grid_of, rings_of_shape, together
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    bounds,
    joined,
    placed,
    polygon,
    rings_of,
    solid_of,
    unit_box,
    unit_square,
)
from ipmlang.geometry.triangles import triangles


def reversed_normals(solid: Solid) -> Solid:
    """All faces turned inside out: each ring runs the other way, from the same corner.

    >>> from ipmlang.geometry.solid import unit_square
    >>> reversed_normals(unit_square()).corners.tolist()
    [0, 3, 2, 1]
    """
    lengths = np.diff(solid.rings)
    start = np.repeat(solid.rings[:-1], lengths)
    within = np.arange(len(solid.corners)) - start
    source = start + (-within) % np.repeat(lengths, lengths)
    uv = None if solid.uv is None else solid.uv[source]
    return replace(solid, corners=solid.corners[source], uv=uv)


def converted(solid: Solid, to: str) -> Solid:
    """What stands for a solid.

    box: the box around it, a rectangle where it is flat. outline: what it covers seen from above,
    polygons in the plane of its lowest point, facing up. plane: the rectangle around it in the
    plane of its largest face. GeometryError where there is nothing to convert.

    >>> from ipmlang.geometry.solid import area
    >>> area(converted(unit_box(), "outline"))
    1.0
    """
    if not len(solid):
        raise GeometryError("there is nothing to convert", "make a geometry first")
    return {"box": _box, "outline": _outline, "plane": _plane}[to](solid)


def _box(solid: Solid) -> Solid:
    low, high = bounds(solid)
    size = high - low
    flat = np.flatnonzero(size <= 1e-9 * size.max())
    if len(flat) > 1:
        raise GeometryError("a line or a point has no box", "convert a polygon or a solid")
    if not len(flat):
        return placed(unit_box(), size, low)
    turns = np.roll(unit_square().vertices, int(flat[0]) + 1, axis=1)  # z, x, y become flat
    return placed(solid_of(turns, [[[0, 1, 2, 3]]]), size, low)


def _outline(solid: Solid) -> Solid:
    import shapely

    corners, _ = triangles(solid)
    flat = solid.vertices[corners][:, :, :2]
    one, other = (flat[:, 1] - flat[:, 0]).T, (flat[:, 2] - flat[:, 0]).T
    twice = one[0] * other[1] - one[1] * other[0]
    covered = shapely.polygons(flat[np.abs(twice) > 1e-12 * np.ptp(flat, axis=(0, 1)).max() ** 2])
    if not len(covered):
        raise GeometryError(
            "seen from above the geometry covers nothing",
            "turn its scope so that a face lies level",
        )
    grid = grid_of(shapely.multipolygons(covered))
    rings = rings_of_shape(together(covered, grid), solid.vertices[:, :2], grid)
    parts = [polygon(outline, holes) for outline, *holes in rings]
    low = float(solid.vertices[:, 2].min())
    return placed(joined(parts), (1.0, 1.0, 1.0), (0.0, 0.0, low))


def _plane(solid: Solid) -> Solid:
    axes = alignment(solid)
    own = solid.vertices @ axes.T
    low, high = own.min(axis=0), own.max(axis=0)
    corners = placed(unit_square(), high - low, low).vertices
    corners[:, 2] = own[next(rings_of(solid, largest_face(solid)))[0], 2]
    return solid_of(corners @ axes, [[[0, 1, 2, 3]]])
