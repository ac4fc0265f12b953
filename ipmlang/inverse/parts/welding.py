"""Points that are one point, and faces that hang together by them.

Takes points and faces; gives labels. Two reaches are told apart at once: points that are the same
but for rounding, and points that a modeller meant to meet. Time grows with the number of points,
however close they lie. Nothing is moved.
"""

from __future__ import annotations

import numpy as np

from ipmlang.formats.distinct import by_first, distinct_numbers, distinct_rows
from ipmlang.inverse.frames import Floats, Integers

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

    >>> linked(5, np.array([[3, 1], [4, 3]])).tolist()
    [0, 1, 2, 1, 1]
    """
    lead = np.arange(count)  # the least node of each component comes to lead it
    one, two = pairs.T.copy()
    while True:
        apart = one != two
        if not apart.any():
            return np.asarray((np.cumsum(lead == np.arange(count)) - 1)[lead])
        low, high = np.minimum(one, two)[apart], np.maximum(one, two)[apart]
        np.minimum.at(lead, high, low)
        above = lead[lead]
        while (above != lead).any():
            lead, above = above, above[above]
        one, two = lead[low], lead[high]


def connected_faces(nodes: Integers, offsets: Integers) -> Integers:
    """The component of each face (f,) by the nodes of its corners (c,), numbered in the order of
    their first faces.
    """
    _, nodes = distinct_numbers(nodes)
    sizes = np.diff(offsets)
    begin = nodes[offsets[:-1]]
    pairs = np.stack([np.repeat(begin, sizes), nodes], axis=1)
    label = linked(int(nodes.max()) + 1, pairs[pairs[:, 0] != pairs[:, 1]])[begin]
    return by_first(*distinct_numbers(label))[1]
