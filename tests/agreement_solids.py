"""Whether two solids are the same, however a boolean cut and numbered their faces.

In go two solids and how far their vertices may lie apart; out comes what differs, in a word.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Solid

Column = NDArray[np.generic]


def is_close(one: Column, other: Column, allowed: float, signed: bool = True) -> bool:
    """Whether all numbers lie within the bound; unsigned ones may have the other sign by row."""
    if one.shape != other.shape:
        return False
    if not signed:
        other = np.where(np.sum(one * other, axis=-1, keepdims=True) < 0, -other, other)
    return bool(np.all(np.abs(one - other) <= allowed))


def same_surface(one: Solid, other: Solid, allowed: float) -> str:
    """What differs between two solids, if anything. Booleans number faces, merge those in one
    plane, and choose whose tags they bear where two parts share a plane, as last bits have it: so
    solids are the same, too, if they have the same tags, box, volume and area, all ways round.
    """
    names = ("corners", "rings", "faces")
    if one.tags == other.tags and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in names
    ):
        if not is_close(one.vertices, other.vertices, allowed):
            return "vertices"
        both = one.uv is not None and other.uv is not None
        return "" if not both or is_close(one.uv, other.uv, allowed) else "texture coordinates"
    if frozenset().union(*one.tags) != frozenset().union(*other.tags):
        return "tags"
    measures = _measures(one), _measures(other)
    return "" if is_close(*measures, allowed * len(one.corners)) else "surface"


def _measures(solid: Solid) -> NDArray[np.float64]:
    """The box, the volume, the area and its shadows along x, y and z."""
    normals, moments = _faces(solid)
    return np.concatenate(
        (
            solid.vertices.min(axis=0),
            solid.vertices.max(axis=0),
            [moments.sum(), np.linalg.norm(normals, axis=1).sum()],
            np.abs(normals).sum(axis=0),
        )
    )


def _faces(solid: Solid) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The vector area of each face, and what it adds to the volume."""
    following = np.arange(1, len(solid.corners) + 1)
    following[solid.rings[1:] - 1] = solid.rings[:-1]
    corners = solid.vertices[solid.corners]
    crossed = np.cross(corners, corners[following]) / 2
    begins = solid.rings[solid.faces[:-1]]
    normals = np.add.reduceat(crossed, begins, axis=0)
    return normals, np.sum(normals * corners[begins], axis=1) / 3
