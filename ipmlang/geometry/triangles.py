"""Triangles that fill the faces of a solid (by manifold3d)."""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.loops import frame
from ipmlang.geometry.solid import Floats, Indices, Solid, normals


def triangles(solid: Solid) -> tuple[Indices, Indices]:
    """Vertex numbers (t, 3) of triangles that fill all faces, and the face (t,) of each.

    They use every vertex, those on straight edges too, so that what is closed stays closed.
    """
    import manifold3d

    found: list[Indices] = [np.zeros((0, 3), np.int64)]
    counts: list[int] = []
    outward = normals(solid)
    rings, starts = solid.rings.tolist(), solid.faces.tolist()
    points = solid.vertices[solid.corners]
    for face in range(len(solid)):
        spans = [(rings[k], rings[k + 1]) for k in range(starts[face], starts[face + 1])]
        corners = solid.corners[spans[0][0] : spans[-1][1]]
        if len(corners) == 3:
            own = corners[None]
        else:
            plane = _plane(outward[face]).T
            flat = [np.ascontiguousarray(points[a:b] @ plane) for a, b in spans]
            own = corners[manifold3d.triangulate(flat)]
        found.append(own)
        counts.append(len(own))
    return np.concatenate(found), np.repeat(np.arange(len(solid)), counts)


def _plane(normal: Floats) -> Floats:
    """Two unit vectors (2, 3) across a normal."""
    up = normal if normal.any() else np.array([0.0, 0.0, 1.0])
    return np.array(frame((float(up[0]), float(up[1]), float(up[2]))))
