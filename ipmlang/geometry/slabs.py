"""Cut polygons and solids by planes: into slabs along an axis, or in two by any plane.

Parts of a closed solid are closed again, their new faces tagged `split.cut`; parts of anything
else stay open. Areas and volumes add up to those of the whole, tags are kept, texture coordinates
follow the cut.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf

import numpy as np

from ipmlang.geometry.loops import Vector
from ipmlang.geometry.slicing import sliced, tolerance
from ipmlang.geometry.solid import Floats, GeometryError, Solid

_UP: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def slab(solid: Solid, axis: int, low: float, high: float) -> Solid | None:
    """The part of a solid where low <= coordinate[axis] <= high, or None.

    >>> from ipmlang.geometry.solid import unit_box, volume
    >>> part = slab(unit_box(), 2, 0.25, 2)
    >>> volume(part), len(part)
    (0.75, 6)
    """
    return slabs(solid, axis, [low, high])[0]


def slabs(solid: Solid, axis: int, cuts: Sequence[float]) -> list[Solid | None]:
    """The parts between each two of n ascending cuts along an axis: n - 1 of them.

    None where a part has nothing in it, or no thickness. A polygon that lies in a cut as a whole
    belongs to the part above.

    >>> from ipmlang.geometry.solid import area, unit_square
    >>> [area(part) for part in slabs(unit_square(), 0, [0, 0.25, 1]) if part]
    [0.25, 0.75]
    """
    heights = solid.vertices[:, axis]
    extent = float(heights.max() - heights.min()) if len(heights) else 0.0
    planes: list[float] = []
    at: list[int] = []
    for cut in cuts:
        if not planes or cut > planes[-1] + 2 * tolerance(extent, heights):
            planes.append(float(cut))
        at.append(len(planes))
    parts = sliced(solid, heights, planes, _UP[axis], axis)
    return [parts[a - 1] if a < b else None for a, b in pairwise(at)]


def cut(
    solid: Solid, point: Floats | Sequence[float], normal: Floats | Sequence[float]
) -> tuple[Solid | None, Solid | None]:
    """The part below the plane through a point with this normal, and the part above."""
    up = np.asarray(normal, np.float64)
    length = float(np.sqrt(up @ up))
    if not length > 0:
        raise GeometryError("a plane to cut with has no direction", "give a normal other than 0")
    up = up / length
    heights = (solid.vertices - np.asarray(point, np.float64)) @ up
    way = (float(up[0]), float(up[1]), float(up[2]))
    below, above = sliced(solid, heights, [-inf, 0.0, inf], way)
    return below, above


def trim(
    solid: Solid, planes: Iterable[tuple[Floats | Sequence[float], Floats | Sequence[float]]]
) -> Solid | None:
    """What is below all planes, each a point and a normal; None where nothing is."""
    left: Solid | None = solid
    for point, normal in planes:
        if left is not None:
            left, _ = cut(left, point, normal)
    return left
