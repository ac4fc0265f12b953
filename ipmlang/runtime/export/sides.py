"""Texture coordinates of a mesh by its own shape: on the sides of its box, or along its faces.

In goes a mesh, out come coordinates of its corners, u to the right and v up as seen from outside.
Where copies stand and which image they show is not known here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Mesh

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_UPRIGHT = 0.9999  # the cosine from which on a face is straight on a side of the box
_NEAR = 1e6  # places are compared to a millionth of the mesh's size

# Of the six sides of a box, seen from outside: the axes of u and v, and whether u or v runs back.
# By the axis of the normal, for the side that faces down it and the one that faces up.
_SIDES = np.array(
    [[[1, 2, 1, 0], [1, 2, 0, 0]], [[0, 2, 0, 0], [0, 2, 1, 0]], [[0, 1, 0, 1], [0, 1, 0, 0]]]
)


def side_axes(axis: int, up: bool) -> tuple[int, int, int, int]:
    """The axes of u and v on the side of a box across an axis, which faces up it or down, and
    whether (1) or not (0) each of them runs back.

    >>> side_axes(1, False)
    (0, 2, 0, 0)
    """
    u, v, u_back, v_back = _SIDES[axis, int(up)].tolist()
    return u, v, u_back, v_back


@dataclass(frozen=True, slots=True, eq=False)
class _Faces:
    """The corners of a mesh's faces in a box from 0: points (c, 3); face (c,) the face of each;
    normal (f, 3) of unit length, 0 for faces without area.
    """

    points: Floats
    face: Indices
    normal: Floats


def on_sides(mesh: Mesh) -> Floats:
    """Coordinates (c, 2) of corners on the sides of the mesh's box: each side is 0 to 1 from its
    lower left. A face belongs to the side that it faces most.
    """
    return _boxed(_faces(mesh, np.ones(3)), np.ones(3))


def in_tiles(mesh: Mesh, size: Floats) -> Floats:
    """Coordinates (c, 2) of corners in lengths, once the mesh's box has that size (3,).

    Faces along the box count from the lower left of its sides. Others, such as the slopes of a
    roof, count along themselves: level to the right and up the slope, each plane from its lower
    left.
    """
    faces = _faces(mesh, size)
    aslant = np.abs(faces.normal).max(axis=1, initial=0.0) < _UPRIGHT
    uv = _boxed(faces, size)
    if not aslant.any():
        return uv
    own = aslant[faces.face]
    number, uv[own] = _along(faces, own)
    lowest = np.full((number.max() + 1, 2), np.inf)
    np.minimum.at(lowest, number, uv[own])
    uv[own] -= lowest[number]
    return uv


def _faces(mesh: Mesh, size: Floats) -> _Faces:
    points = mesh.vertices[mesh.corners]
    if not len(points):
        return _Faces(points, np.zeros(0, np.int64), np.zeros((0, 3)))
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    points = (points - low) / np.where(extent > 0, extent, 1.0) * size
    begins = mesh.offsets[:-1]
    face = np.repeat(np.arange(len(begins)), np.diff(mesh.offsets))
    after = np.arange(1, len(points) + 1)
    after[mesh.offsets[1:] - 1] = begins
    first = points[begins][face]
    normal = np.add.reduceat(np.cross(points - first, points[after] - first), begins, axis=0)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return _Faces(points, face, normal / np.where(length > 0, length, 1.0))


def _boxed(faces: _Faces, size: Floats) -> Floats:
    """Coordinates on the sides of a box of that size, in lengths."""
    axis = np.argmax(np.abs(faces.normal), axis=1)
    up = np.take_along_axis(faces.normal, axis[:, None], axis=1)[:, 0] >= 0
    sides = _SIDES[axis, up.astype(np.int64)][faces.face]
    found = np.take_along_axis(faces.points, sides[:, :2], axis=1)
    return np.where(sides[:, 2:] == 1, size[sides[:, :2]] - found, found)


def _along(faces: _Faces, own: NDArray[np.bool_]) -> tuple[Indices, Floats]:
    """For some corners (c,): the number of the plane that each lies in, and coordinates there."""
    face, points = faces.face[own], faces.points[own]
    normal = faces.normal[face]
    right = np.stack([-normal[:, 1], normal[:, 0], np.zeros(len(normal))], axis=1)
    length = np.linalg.norm(right, axis=1, keepdims=True)
    right = np.where(length > 0, right / np.where(length > 0, length, 1.0), [1.0, 0.0, 0.0])
    uv = np.stack(
        [np.einsum("ci,ci->c", points, each) for each in (right, np.cross(normal, right))], axis=1
    )
    begins = np.flatnonzero(np.diff(face, prepend=-1))
    away = np.einsum("ci,ci->c", points[begins], normal[begins])
    away /= np.abs(faces.points).max() or 1.0
    planes = np.rint(np.concatenate([normal[begins], away[:, None]], axis=1) * _NEAR) + 0.0
    _, number = np.unique(planes, axis=0, return_inverse=True)
    return number.reshape(-1)[np.cumsum(np.diff(face, prepend=-1) != 0) - 1], uv
