"""Points that are one point, and faces that hang together by them.

Takes points and faces; gives labels. Two reaches are told apart at once: points that are the same
but for rounding, and points that a modeller meant to meet. Time grows with the number of points,
however close they lie. Nothing is moved.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.distinct import distinct_rows
from ipmlang.inverse.frames import Floats, Integers

SAME, MEETING = 1e-7, 1e-5  # shares of the diagonal


def welded(points: Floats, diagonal: float) -> tuple[Integers, Integers]:
    """For each point (n, 3) the label of the point that it is, and of those that meet there."""
    from scipy.spatial import cKDTree

    first, kind = distinct_rows(points)
    distinct = points[first]
    reach = MEETING * diagonal
    cells = np.floor((distinct - distinct.min(axis=0)) / max(reach, 1e-300) if len(distinct) else distinct)
    # One point a cell bounds the number of pairs; those in a cell meet anyway.
    cell_first, cell = distinct_rows(cells)
    near = cKDTree(distinct[cell_first]).query_pairs(reach, output_type="ndarray")
    apart = np.linalg.norm(distinct[cell_first][near[:, 0]] - distinct[cell_first][near[:, 1]], axis=1)
    met = linked(len(cell_first), near)[cell]
    same = linked(
        len(distinct),
        np.concatenate([cell_first[near[apart <= SAME * diagonal]], _same_in_cell(distinct, cell, cell_first, SAME * diagonal)]),
    )
    return same[kind], met[kind]


def _same_in_cell(points: Floats, cell: Integers, first: Integers, reach: float) -> Integers:
    """Pairs of a point and the first of its cell that are the same."""
    other = np.flatnonzero(first[cell] != np.arange(len(cell)))
    close = np.linalg.norm(points[other] - points[first[cell[other]]], axis=1) <= reach
    kept = other[close]
    return np.stack([kept, first[cell[kept]]], axis=1)


def linked(count: int, pairs: Integers) -> Integers:
    """The connected component of each of `count` nodes under pairs (p, 2)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    if not len(pairs):
        return np.arange(count)
    ones = np.ones(len(pairs), np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), (count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


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
