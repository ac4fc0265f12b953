"""Directions in space, and the body that measurements along them leave.

Takes numbers of directions, or how far something goes along each; gives unit vectors and the points
of a body that surely holds it, and hardly more. Whoever measures may thus keep only the largest of
many numbers. Nothing here knows what is measured.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_LOOSE = 1e-4  # of the extent: what a body is larger than measured, so that flat ones have a volume
_NEAR = 0.01  # of the size: a body that goes no farther beyond what it holds is good enough
_ALIKE = 0.995  # cosine between directions that are one


def even(count: int) -> Floats:
    """(count, 3) axes spread evenly: those of the world, then a spiral of golden angles over half
    a sphere.
    """
    spiral = np.arange(count - 3) + 0.5
    height = spiral / (count - 3)
    angle = spiral * np.pi * (3 - np.sqrt(5))
    around = np.sqrt(1 - height**2)
    half = np.stack([around * np.cos(angle), around * np.sin(angle), height], axis=1)
    return np.concatenate([np.eye(3), half])


def facing(points: Floats, count: int) -> Floats:
    """(count, 3) the directions that the largest faces of the hull of points (n, 3) look in, each
    once; even ones where there are fewer, or where the points lie in a plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return even(count)
    corners = points[hull.simplices]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    normals = hull.equations[np.argsort(-area, kind="stable"), :3]
    return np.concatenate([_apart(normals, count), even(count)])[:count]


def within(ways: Floats, reach: Floats) -> Floats:
    """(k, 3) the corners of the body that goes as far as `reach` (w, 2) says, along each of the
    ways (w, 3) and against it; its first three ways are the axes of the world.
    """
    from scipy.spatial import HalfspaceIntersection, QhullError

    high, low = reach[:3, 0], -reach[:3, 1]
    extent = float((high - low).max()) or 1.0
    sides = np.stack([ways, -ways], axis=1).reshape(-1, 3)
    # Measured in its own size: what is far from the origin, or very small, is as good as any other.
    middle = (high + low) / 2
    loose = (reach.reshape(-1) - sides @ middle) / extent + _LOOSE
    try:
        body = HalfspaceIntersection(np.column_stack([sides, -loose]), np.zeros(3))
        corners = body.intersections
    except (QhullError, ValueError):
        corners = _box((low - middle) / extent, (high - middle) / extent)
    return np.unique(corners, axis=0) * extent + middle


def toward(corners: Floats, points: Floats, count: int) -> Floats:
    """(count, 3) directions in which a body with these corners (k, 3) goes farther than the points
    (n, 3) that it was made for, the worst first; none where it hardly does.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    away = corners - middle
    length = np.linalg.norm(away, axis=1)
    out = away / np.maximum(length, 1e-300)[:, None]
    beyond = length - ((points - middle) @ out.T).max(axis=0)
    if beyond.max() < _NEAR * length.max():
        return corners[:0]
    worst = out[np.argsort(-beyond, kind="stable")]
    return np.concatenate([_apart(worst, count), even(count)])[:count]


def _apart(vectors: Floats, count: int) -> Floats:
    """The first (count, 3) of unit vectors (n, 3) that are not nearly one, whichever way along."""
    kept = vectors[:0]
    for each in vectors:
        if len(kept) < count and (np.abs(kept @ each) < _ALIKE).all():
            kept = np.concatenate([kept, each[None]])
    return kept


def _box(low: Floats, high: Floats) -> Floats:
    choice = np.array([[k >> 2 & 1, k >> 1 & 1, k & 1] for k in range(8)])
    corners: Floats = np.stack([low, high])[choice, np.arange(3)]
    return corners
