"""L, U and ring shapes cut from a polygon by the widths of their arms.

Arms lie along the sides of the box around the polygon; what lies beyond all arms is the rest. The
two parts of each cut are together the whole polygon, whatever its outline.
"""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.planar import (
    closed,
    common,
    grid_of,
    opened,
    rings_of_shape,
    shape_of,
    without,
)
from ipmlang.geometry.solid import GeometryError, Solid

SHAPE = frozenset({"shape"})
REST = frozenset({"rest", "remainder"})


def shape_l(polygon: Solid, front: float, left: float) -> list[Piece]:
    """An L, `shape`, of arms of these widths along front (-y) and left (-x); `rest` (`remainder`)
    is what is beyond both. `GeometryError` for a width below 0.

    >>> from ipmlang.geometry import solid
    >>> yard = solid.polygon([(0, 0), (10, 0), (10, 8), (0, 8)])
    >>> [solid.area(piece.solid) for piece in shape_l(yard, 3, 4)]
    [50.0, 30.0]
    """
    return _cut("shapeL", polygon, front=front, left=left)


def shape_u(polygon: Solid, front: float, left: float, right: float) -> list[Piece]:
    """A U of arms along front, left and right, as `shape_l`."""
    return _cut("shapeU", polygon, front=front, left=left, right=right)


def shape_o(polygon: Solid, front: float, left: float, right: float, back: float) -> list[Piece]:
    """A ring of arms along all four sides, as `shape_l`; the rest is its court."""
    return _cut("shapeO", polygon, front=front, left=left, right=right, back=back)


def _cut(operation: str, polygon: Solid, **arms: float) -> list[Piece]:
    import shapely

    for name, width in arms.items():
        if not (np.isfinite(width) and width >= 0):
            raise GeometryError(f"{operation}: the {name} arm is {width:g} wide; give 0 or more")
    rings, plane = opened(polygon, operation)
    (x0, y0), (x1, y1) = rings[0].min(axis=0), rings[0].max(axis=0)
    beyond = (
        x0 + arms.get("left", 0.0),
        y0 + arms["front"],
        x1 - arms.get("right", 0.0),
        y1 - arms.get("back", 0.0),
    )
    if beyond[0] >= beyond[2] or beyond[1] >= beyond[3]:
        return [Piece(SHAPE, closed([rings], plane))]
    whole, court = shape_of(rings), shapely.box(*beyond)
    grid = grid_of(whole)
    known = np.concatenate([*rings, shapely.get_coordinates(court)])
    found: list[Piece] = []
    for words, part in ((SHAPE, without(whole, court, grid)), (REST, common(whole, court, grid))):
        parts = rings_of_shape(part.item(), known, grid)
        found.extend(Piece(words, closed([each], plane)) for each in parts)
    return found
