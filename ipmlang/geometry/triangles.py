"""Triangles that fill the faces of a solid (by manifold3d)."""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.loops import frame
from ipmlang.geometry.solid import Floats, Indices, Solid, normals, ring_points, rings_of


def triangles(solid: Solid) -> tuple[Indices, Indices]:
    """Vertex numbers (t, 3) of triangles that fill all faces, and the face (t,) of each.

    They use every vertex, those on straight edges too, so that what is closed stays closed.
    """
    import manifold3d

    found: list[Indices] = [np.zeros((0, 3), np.int64)]
    faces: list[int] = []
    outward = normals(solid)
    for face in range(len(solid)):
        corners = np.concatenate(list(rings_of(solid, face)))
        if len(corners) == 3:
            own = corners[None]
        else:
            plane = _plane(outward[face])
            flat = [np.ascontiguousarray(ring @ plane.T) for ring in ring_points(solid, face)]
            own = corners[manifold3d.triangulate(flat)]
        found.append(own)
        faces += [face] * len(own)
    return np.concatenate(found), np.array(faces, np.int64)


def _plane(normal: Floats) -> Floats:
    """Two unit vectors (2, 3) across a normal."""
    up = normal if normal.any() else np.array([0.0, 0.0, 1.0])
    return np.array(frame((float(up[0]), float(up[1]), float(up[2]))))
