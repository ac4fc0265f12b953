"""The planes along which what stands on the faces of a solid meets: they halve its edges' angles.

In goes a solid and one of its faces, out come planes in the solid's coordinates. Nothing is cut
here.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ipmlang.geometry.sharing import first_at_place, following, neighbours
from ipmlang.geometry.solid import Floats, Indices, Solid, face_of_corners, normals

Edges = Literal["all", "vertical", "horizontal"]
NEAR = 1e-9  # of a solid's size: vertices this near are one, what is off a plane by less lies on it


def mitres(solid: Solid, face: int, edges: Edges = "all") -> tuple[Floats, Floats]:
    """Points and normals (k, 3), (k, 3) of the planes between a face and those beside it, at all
    its edges, or at those that are nearer to the vertical, or to the horizontal.

    Each holds an edge of the face and halves the angle to the face across it; what stands on the
    face lies below (against the normal). A plane that would cut the face itself, as those at the
    inner corners of an L do, is left out.

    >>> from ipmlang.geometry.solid import unit_box
    >>> points, planes = mitres(unit_box(), 2)
    >>> sorted(np.round(planes[:, :2], 3).tolist())
    [[-0.707, 0.707], [0.0, 0.707], [0.0, 0.707], [0.707, 0.707]]
    """
    welded, size = _welded(solid)
    outward = normals(solid)
    begin, beside = _edges(welded, face)
    after = welded.corners[following(welded)[begin]]
    points = solid.vertices[welded.corners[begin]]
    along = solid.vertices[after] - points
    inward = np.cross(outward[face], along)  # counter-clockwise: the face is on the left
    other = outward[beside]
    side = -np.sign(_dot(inward, other))[:, None]
    lengths = np.linalg.norm(inward, axis=1, keepdims=True)
    flat = np.abs(_dot(inward, other))[:, None] <= 1e-9 * lengths
    planes = np.where(flat, -inward / lengths, side * (other - outward[face]))
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    own = solid.vertices[solid.corners[face_of_corners(solid) == face]]
    over = np.einsum("kvj,kj->kv", own[None] - points[:, None], planes)
    chosen = (over <= NEAR * size).all(axis=1)
    if edges != "all":
        rise = np.abs(along[:, 2]) > np.sqrt(0.5) * np.linalg.norm(along, axis=1)
        chosen &= rise if edges == "vertical" else ~rise
    return points[chosen], planes[chosen]


def _dot(a: Floats, b: Floats) -> Floats:
    found: Floats = np.einsum("ij,ij->i", a, b)
    return found


def _welded(solid: Solid) -> tuple[Solid, float]:
    """The solid with one vertex at each place, and its size."""
    from dataclasses import replace

    size = float(np.ptp(solid.vertices, axis=0).max(initial=0.0))
    one = first_at_place(solid.vertices, NEAR * size)
    return replace(solid, corners=one[solid.corners]), size


def _edges(solid: Solid, face: int) -> tuple[Indices, Indices]:
    """The corners where the edges of a face begin that another face shares, and those faces."""
    one, other = neighbours(solid)
    owner = face_of_corners(solid)
    here, there = np.concatenate([one, other]), np.concatenate([other, one])
    own = (owner[here] == face) & (owner[there] != face)
    return here[own], owner[there[own]]
