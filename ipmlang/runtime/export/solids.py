"""Solids as meshes: faces stay polygons, those with holes become triangles.

Takes a `Solid` of the geometry layer; gives a `Mesh` of the formats over the same vertices, with
the same texture coordinates. Tags, which rules select by, are not kept. Where copies stand is not
known here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Mesh
from ipmlang.formats.triangles import ears
from ipmlang.geometry.solid import Solid

Indices = NDArray[np.int64]


def solid_mesh(solid: Solid) -> Mesh:
    """The mesh of a solid.

    >>> from ipmlang.geometry.solid import polygon
    >>> hole = [(1, 1), (1, 2), (2, 2), (2, 1)]
    >>> frame = solid_mesh(polygon([(0, 0), (3, 0), (3, 3), (0, 3)], [hole]))
    >>> len(frame.offsets) - 1
    8
    """
    chosen, offsets = _polygons(solid)
    count = len(offsets) - 1
    return Mesh(
        solid.vertices,
        solid.corners if chosen is None else solid.corners[chosen],
        offsets,
        np.full(count, -1, np.int64),
        np.zeros(count, np.int64),
        groups=((),),
        uv=solid.uv if chosen is None or solid.uv is None else solid.uv[chosen],
    )


def _polygons(solid: Solid) -> tuple[Indices | None, Indices]:
    """The corners (c,) of faces without holes, by their numbers in the solid (None: all in their
    order), and where each face begins (f + 1,).
    """
    rings = np.diff(solid.faces)
    pierced = np.flatnonzero(rings > 1)
    if not len(pierced) and len(solid.rings) == len(solid) + 1:
        return None, solid.rings
    whole = solid.faces[:-1][rings == 1]  # the only ring of each face without holes
    sizes = np.diff(solid.rings)[whole]
    within = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    triangles = [_triangles(solid, face) for face in pierced.tolist()]
    corners = [np.repeat(solid.rings[whole], sizes) + within, *triangles]
    cut = sum(map(len, triangles)) // 3
    lengths = np.concatenate([sizes, np.full(cut, 3)])
    return np.concatenate(corners), np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def _triangles(solid: Solid, face: int) -> Indices:
    """The corners (3 t,) of triangles that cover a face around its holes."""
    first, last = solid.faces[face : face + 2].tolist()
    begin, end = int(solid.rings[first]), int(solid.rings[last])
    points = solid.vertices[solid.corners[begin:end]]
    return ears(points, solid.rings[first + 1 : last + 1] - begin).reshape(-1) + begin
