"""Points that are one point, and faces that hang together by them.

Takes points and faces; gives labels. Two reaches are told apart at once: points that are the same
but for rounding, and points that a modeller meant to meet. Time grows with the number of points,
however close they lie. Nothing is moved.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.distinct import distinct_rows
from ipmlang.inverse.frames import Floats, Integers

_FEW = 2000  # pairs for which no matrix is made
SAME, MEETING = 1e-7, 5e-6  # shares of the diagonal; bricks that lie near are not one


def welded(points: Floats, diagonal: float) -> tuple[Integers, Integers]:
    """For each point (n, 3) the label of the point that it is, and of those that meet there."""
    from scipy.spatial import cKDTree

    first, kind = distinct_rows(points)
    distinct = points[first]
    reach = MEETING * diagonal
    cells = np.floor((distinct - distinct.min(axis=0)) / max(reach, 1e-300))
    # One point a cell bounds the number of pairs; those in a cell meet anyway.
    leader, cell = distinct_rows(cells)
    near = leader[cKDTree(distinct[leader]).query_pairs(reach, output_type="ndarray")]
    other = np.flatnonzero(leader[cell] != np.arange(len(cell)))
    pairs = np.concatenate([near, np.stack([leader[cell[other]], other], axis=1)])
    apart = np.linalg.norm(distinct[pairs[:, 0]] - distinct[pairs[:, 1]], axis=1)
    same = linked(len(distinct), pairs[apart <= SAME * diagonal])
    return same[kind], linked(len(distinct), pairs)[kind]


def linked(count: int, pairs: Integers) -> Integers:
    """The connected component of each of `count` nodes under pairs (p, 2), numbered in the order
    of their first nodes.
    """
    if len(pairs) <= _FEW:
        return _linked(count, pairs)
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(pairs), np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), (count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _linked(count: int, pairs: Integers) -> Integers:
    """The same without a matrix: the least node of each component leads it."""
    lead = np.arange(count)
    while True:
        ends = lead[pairs]
        apart = ends[:, 0] != ends[:, 1]
        if not apart.any():
            break
        pairs, ends = pairs[apart], ends[apart]
        np.minimum.at(lead, ends.max(axis=1), ends.min(axis=1))
        above = lead[lead]
        while (above != lead).any():
            lead, above = above, above[above]
    return np.asarray((np.cumsum(lead == np.arange(count)) - 1)[lead])


def connected_faces(nodes: Integers, offsets: Integers) -> Integers:
    """The component of each face (f,) by the nodes of its corners (c,), numbered in the order of
    their first faces.
    """
    _, nodes = np.unique(nodes, return_inverse=True)
    sizes = np.diff(offsets)
    begin = nodes[offsets[:-1]]
    pairs = np.stack([np.repeat(begin, sizes), nodes], axis=1)
    label = linked(int(nodes.max()) + 1, pairs[pairs[:, 0] != pairs[:, 1]])[begin]
    _, first, kind = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[kind]
