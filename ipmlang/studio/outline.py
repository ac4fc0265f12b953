"""The few points that say how far a model reaches in every direction.

Takes points, or meshes with copies; gives points with the same convex hull, or the corners of a box
where they lie in a plane. Cameras and shadows are fitted to these, however many copies there are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FEW = 32  # points that are not worth reducing
_MANY = 4_000_000  # points in the world from which boxes stand for meshes
_STEP = 1_000_000  # points looked at together


def hull(points: Floats) -> Floats:
    """Points (k, 3) with the hull of `points` (n, 3)."""
    from scipy.spatial import ConvexHull, QhullError

    kept = points[:0]
    for begin in range(0, len(points), _STEP):
        part = np.concatenate([kept, points[begin : begin + _STEP]])
        if len(part) <= _FEW:
            kept = part
            continue
        try:
            kept = part[ConvexHull(part).vertices]
        except (QhullError, ValueError):  # all in a plane, or nearly so
            kept = box(part)
    return kept


def box(points: Floats) -> Floats:
    """The eight corners (8, 3) of the box around points."""
    ends = np.stack([points.min(axis=0), points.max(axis=0)])
    choice = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)])
    corners: Floats = ends[choice, np.arange(3)]
    return corners


def hull_of_copies(vertices: Floats, matrices: Floats) -> Floats:
    """The hull of the copies (k, 3, 4) of a mesh's vertices (v, 3), in the world."""
    local = hull(vertices)
    if len(local) * len(matrices) > _MANY:
        local = box(local)
    step = max(1, _STEP // len(local))
    kept = np.zeros((0, 3))
    for begin in range(0, len(matrices), step):
        part = matrices[begin : begin + step]
        world = np.einsum("kij,vj->kvi", part[:, :, :3], local) + part[:, None, :, 3]
        kept = hull(np.concatenate([kept, world.reshape(-1, 3)]))
    return kept
