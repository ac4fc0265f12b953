"""Boxes to look at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Material, Mesh, MeshScene


def cube() -> Mesh:
    """From -0.5 to 0.5 along x and y, from 0 to 1 along z; six quads that face outward."""
    corner = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], np.float64)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    none = np.full(6, -1, np.int64)
    uv = np.tile(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), (6, 1))
    corners = np.array(quads, np.int64).reshape(-1)
    vertices = corner - [0.5, 0.5, 0.0]
    return Mesh(vertices, corners, np.arange(7) * 4, none, none + 1, groups=((),), uv=uv)


def boxes(
    places: Sequence[Sequence[float]],
    *,
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    materials: Sequence[Material] = (),
    mesh: Mesh | None = None,
) -> MeshScene:
    """Copies of the cube, stretched and moved; the k-th material is the k-th copy's."""
    count = len(places)
    matrix: NDArray[np.float64] = np.zeros((count, 3, 4))
    matrix[:, [0, 1, 2], [0, 1, 2]] = scale
    matrix[:, :, 3] = places
    own = np.arange(count) if materials else np.full(count, -1)
    zero = np.zeros(count, np.int64)
    shown = cube() if mesh is None else mesh
    return MeshScene((shown,), zero, matrix, zero, own, ("box",), tuple(materials))
