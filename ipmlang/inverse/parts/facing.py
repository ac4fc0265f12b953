"""Which faces belong to one solid where more than two meet in an edge.

Takes the corners of faces by the edge that each begins; gives pairs of them. Solids that touch
share edges, even whole faces that lie in one another: around such an edge the faces are sorted by
their angle, and each looks through its own solid at the next. Nothing is cut here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers

_SAME = 1e-4  # radians by which faces that lie in one another may seem to part


def facing(
    mesh: Mesh,
    edge: Integers,
    corner: Integers,
    area: Floats,
    after: Integers,
    forth: np.ndarray,
) -> Integers:
    """(q, 2) pairs of corners whose faces bound one solid at an edge.

    edge (k,): number of the edge, ascending, that each of `corner` (k,) begins; area (k, 3) of
    their faces along the normals; after (c,): the next corner of each in its face; forth (c,):
    whether a corner runs along its edge the way in which the edge counts. Faces look outward.
    """
    if not len(edge):
        return np.zeros((0, 2), np.int64)
    runs = forth[corner]
    ends = mesh.vertices[mesh.corners[np.stack([corner, after[corner]])]]
    angle = _angles(edge, ends[1] - ends[0], area, runs)
    order = np.lexsort([angle, edge])
    edge, corner, runs, angle = edge[order], corner[order], runs[order], angle[order]
    # Of faces in one place, the one that ends a solid goes before the one that begins another.
    place = np.cumsum(np.concatenate([[0], (np.diff(edge) != 0) | (np.diff(angle) > _SAME)]))
    order = np.lexsort([~runs, place])
    corner, runs, edge = corner[order], runs[order], edge[order]
    starts = np.flatnonzero(np.concatenate([[True], edge[1:] != edge[:-1]]))
    count = np.diff(np.append(starts, len(edge)))
    following = np.arange(len(edge)) + 1
    following[starts + count - 1] = starts
    through = ~runs & runs[following]
    return np.stack([corner[through], corner[following[through]]], axis=1)


def _angles(edge: Integers, along: Floats, area: Floats, runs: np.ndarray) -> Floats:
    """(k,) how far each face is turned about its edge from the first there that begins a solid, in
    radians from 0 to 2 pi.
    """
    along = _unit(np.where(runs[:, None], along, -along))
    # A face that runs along its edge has its inside on the left of it, seen from outside.
    inward = _unit(np.cross(np.where(runs[:, None], area, -area), along))
    begins = np.lexsort([runs, edge])
    first = begins[np.searchsorted(edge[begins], edge)]
    along = along[first]
    right = inward[first]
    up = np.cross(along, right)
    turned = np.arctan2(np.einsum("ki,ki->k", inward, up), np.einsum("ki,ki->k", inward, right))
    turned = np.where(turned < -0.5 * _SAME, turned + 2 * np.pi, np.maximum(turned, 0.0))
    return np.asarray(turned)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-300))
