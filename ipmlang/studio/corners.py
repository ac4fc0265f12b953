"""What a mesh looks like at each corner: which way it faces there, and where its edges are sharp.

Takes a `Mesh`; gives normals and the edges worth a line, all faces at once. Faces that meet at a
small angle shade smoothly into each other. Nothing here knows OpenGL.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Mesh, face_normals

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_SMOOTH = np.cos(np.radians(32.0))  # faces that meet at less are one rounded surface
_CREASE = np.cos(np.radians(25.0))  # faces that meet at more have an edge between them


def corner_normals(mesh: Mesh) -> Floats:
    """(c, 3) normals of any length: of the faces around the corner that are nearly as steep as its
    own, by their areas.
    """
    normals = face_normals(mesh)
    unit = _unit(normals)
    face = np.repeat(np.arange(len(normals)), np.diff(mesh.offsets))
    vertex = same_places(mesh.vertices)[mesh.corners]
    order = np.argsort(vertex, kind="stable")
    result = normals[face]
    around = np.bincount(vertex, minlength=1)
    # Each corner in turn is compared with the k-th next one of its vertex, for all corners at once;
    # more than 32 faces around a vertex are the tip of a cone, which has no one direction.
    for step in range(1, min(int(around.max(initial=0)), 32)):
        first, second = order[:-step], order[step:]
        together = (vertex[first] == vertex[second]) & (around[vertex[first]] <= 32)
        first, second = first[together], second[together]
        a, b = face[first], face[second]
        smooth = (unit[a] * unit[b]).sum(axis=1) > _SMOOTH
        np.add.at(result, first[smooth], normals[b[smooth]])
        np.add.at(result, second[smooth], normals[a[smooth]])
    return result


def sharp_edges(mesh: Mesh) -> tuple[Indices, Indices]:
    """The vertices (e, 2) of edges where faces meet at an angle, or where a face ends, and a face
    (e,) at each; edges between triangles of one flat face are none.
    """
    face = np.repeat(np.arange(len(mesh.offsets) - 1), np.diff(mesh.offsets))
    place = same_places(mesh.vertices)
    ends = np.stack([mesh.corners, mesh.corners[_next_corner(mesh)]], axis=1)
    key = np.sort(place[ends], axis=1)
    key, ends, face = (part[key[:, 0] != key[:, 1]] for part in (key, ends, face))
    order = np.lexsort((key[:, 1], key[:, 0]))
    key, ends, face = key[order], ends[order], face[order]
    if not len(key):
        return ends, face
    new = np.concatenate([[True], (key[1:] != key[:-1]).any(axis=1)])
    begin = np.flatnonzero(new)
    uses = np.diff(np.append(begin, len(key)))
    unit = _unit(face_normals(mesh))
    second = np.minimum(begin + 1, len(face) - 1)
    # Faces of opposite order are one surface all the same, so the sign of the angle says nothing.
    flat = np.abs((unit[face[begin]] * unit[face[second]]).sum(axis=1)) > _CREASE
    chosen = begin[(uses != 2) | ~flat]
    return ends[chosen], face[chosen]


def _next_corner(mesh: Mesh) -> Indices:
    """(c,) the corner that follows each around its face."""
    after = np.arange(len(mesh.corners)) + 1
    filled = np.diff(mesh.offsets) > 0
    after[mesh.offsets[1:][filled] - 1] = mesh.offsets[:-1][filled]
    return after


def closed_faces(mesh: Mesh) -> NDArray[np.bool_]:
    """(f,) whether each edge of a face is passed the other way by exactly one other face."""
    first, second = mesh.corners, mesh.corners[_next_corner(mesh)]
    forth = first * len(mesh.vertices) + second
    back = second * len(mesh.vertices) + first
    known, way, uses = np.unique(forth, return_inverse=True, return_counts=True)
    place = np.minimum(np.searchsorted(known, back), max(len(known) - 1, 0))
    matched = (uses[way.reshape(-1)] == 1) & (known[place] == back) & (uses[place] == 1)
    unmatched = np.append(0, np.cumsum(~matched))
    closed: NDArray[np.bool_] = unmatched[mesh.offsets[1:]] == unmatched[mesh.offsets[:-1]]
    return closed


def same_places(vertices: Floats) -> Indices:
    """(v,) a number for each vertex, equal where vertices lie at one place: files split them along
    seams of normals and textures.
    """
    if not len(vertices):
        return np.zeros(0, np.int64)
    low = vertices.min(axis=0)
    unit = float(np.ptp(vertices, axis=0).max()) * 1e-7 or 1.0
    grid = np.rint((vertices - low) / unit).astype(np.int64)
    key = (grid[:, 0] * 20_000_003 + grid[:, 1]) * 20_000_003 + grid[:, 2]  # wraps: mixed enough
    return np.unique(key, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _sums(values: Floats, offsets: Indices) -> Floats:
    """The sums of runs of rows, each from one offset to the next; 0 for empty runs."""
    result = np.zeros((len(offsets) - 1, values.shape[1]))
    filled = np.diff(offsets) > 0
    if filled.any():
        result[filled] = np.add.reduceat(values, offsets[:-1][filled], axis=0)
    return result


def _unit(vectors: Floats) -> Floats:
    result: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
    return result
