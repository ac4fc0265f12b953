"""Boxes with their neighbours and the faces that coincide: what attachments are made of.

In go boxes, out come pairs, and numbers for faces: those of neighbours that lie in one plane are
one unknown, so that no solution takes them apart. By how little they do not lie in one plane is
kept, so that nothing moves that no edit moves. What follows from that is said elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.edit.buildings.contacts import neighbours, touching

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Attached:
    """n boxes low, high (n, 3) with their neighbours, pairs (k, 2); faces (2n, 3): the unknown of
    the low faces, then of the high faces, by axis; off (2n, 3): how far each lies from where its
    unknown is; near: the neighbours of each box, and along how many axes they abut it.
    """

    low: Floats
    high: Floats
    pairs: Integers
    faces: Integers
    off: Floats
    near: tuple[list[tuple[int, int]], ...]
    tolerance: float

    def __len__(self) -> int:
        return len(self.low)


def attach(low: Floats, high: Floats, tolerance: float, held: Integers | None = None) -> Attached:
    """Find the neighbours of n boxes and the faces that coincide. held (h, 2): pairs that belong
    together whether they touch or not.
    """
    pairs = neighbours(low, high, tolerance)
    if held is not None and len(held):
        pairs = np.unique(np.concatenate([pairs, np.sort(held, axis=1)]), axis=0)
    values = np.concatenate([low, high])
    faces = np.stack([_merged(values[:, axis], pairs, tolerance) for axis in range(3)], axis=1)
    off = np.stack([_off(values[:, k], faces[:, k]) for k in range(3)], axis=1)
    near: list[list[tuple[int, int]]] = [[] for _ in range(len(low))]
    abut = touching(low, high, pairs, tolerance).sum(axis=1).tolist()
    for (i, j), many in zip(pairs.tolist(), abut, strict=True):
        near[i].append((j, many))
        near[j].append((i, many))
    return Attached(low, high, pairs, faces, off, tuple(near), tolerance)


def _off(values: Floats, numbers: Integers) -> Floats:
    """(2n,) how far faces lie from the middle of those that are one unknown."""
    count = int(numbers.max(initial=-1)) + 1
    least, most = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(least, numbers, values)
    np.maximum.at(most, numbers, values)
    return np.asarray(values - (0.5 * (least + most))[numbers])


def _merged(values: Floats, pairs: Integers, tolerance: float) -> Integers:
    """(2n,) a number for each face along one axis, the same for those of neighbours that lie in
    one plane.
    """
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    count = len(values) // 2
    i, j = pairs.T
    sets = [(i, j), (i + count, j + count), (i, j + count), (i + count, j)]
    own = np.arange(count)
    a = np.concatenate([own, *(one for one, _ in sets)])
    b = np.concatenate([own + count, *(other for _, other in sets)])
    same = np.abs(values[a] - values[b]) <= tolerance
    graph = sparse.coo_matrix((np.ones(same.sum()), (a[same], b[same])), (2 * count, 2 * count))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)
