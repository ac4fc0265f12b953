"""The split tree of a model (Demir and Aliaga 2016, sections 3.2 and 3.3): boxes within boxes.

In go the boxes of parts, out come for each the tightest box that encloses it and the point splits
that lead from one box to the other. Shapes and repetition are not looked at; which boxes touch is
asked by edits alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.scheme import Cut

LAST, FIRST = 8, 1  # the octants beyond a point in every axis, and before it


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """n + 1 nodes: node 0 is the box of everything, node i + 1 that of part i.

    parent (n + 1,): nodes, -1 for the root; low, high (n + 1, 3): boxes in the world; order
    (n + 1,): nodes by decreasing volume, so that each comes behind its parent.
    """

    parent: Integers
    low: Floats
    high: Floats
    order: Integers

    def children(self) -> list[Integers]:
        """The nodes right below each node."""
        by_parent = np.argsort(self.parent[1:], kind="stable") + 1
        counts = np.bincount(self.parent[1:], minlength=len(self.parent))
        return np.split(by_parent, np.cumsum(counts)[:-1])


def split_tree(low: Floats, high: Floats, small: float) -> Tree:
    """Insert the boxes (n, 3) of parts one after the other by decreasing volume, each under the
    tightest box that encloses it; flat boxes enclose nothing. small: units that do not count.

    >>> low = np.array([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]])
    >>> split_tree(low, np.array([[9.0], [5], [3]]) * np.ones(3), 1e-9).parent.tolist()
    [-1, 0, 1, 2]
    """
    count = len(low)
    extent = high - low
    order = np.lexsort((np.arange(count), -extent.sum(axis=1), -np.prod(extent, axis=1)))
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    inner, outer = _enclosed(low, high, small)
    kept = (rank[outer] < rank[inner]) & (extent[outer].min(axis=1, initial=np.inf) > small)
    tightest = np.full(count, -1, np.int64)
    np.maximum.at(tightest, inner[kept], rank[outer[kept]])
    parent = np.full(count + 1, -1, np.int64)
    parent[1:] = np.where(tightest >= 0, order[tightest] + 1, 0)
    corner = low.min(axis=0, keepdims=True), high.max(axis=0, keepdims=True)
    return Tree(
        parent,
        np.concatenate([corner[0], low]),
        np.concatenate([corner[1], high]),
        np.concatenate([[0], order + 1]),
    )


def _enclosed(low: Floats, high: Floats, small: float) -> tuple[Integers, Integers]:
    """Pairs of an enclosed box and one that encloses it."""
    from shapely import STRtree, box, points

    first, second = _telling_axes(low, high)
    flat = (low[:, first], low[:, second], high[:, first], high[:, second])
    middle = (low + high) / 2
    found = STRtree(box(*flat)).query(points(middle[:, first], middle[:, second]))
    inner, outer = found[0].astype(np.int64), found[1].astype(np.int64)
    inside = (low[outer] <= low[inner] + small) & (high[outer] >= high[inner] - small)
    kept = inside.all(axis=1) & (inner != outer)
    return inner[kept], outer[kept]


def _telling_axes(low: Floats, high: Floats) -> tuple[int, int]:
    """The two axes along which boxes are short, measured by all of them together."""
    whole = np.maximum(high.max(axis=0) - low.min(axis=0), 1e-300)
    longest = int(np.argmax((high - low).mean(axis=0) / whole))
    first, second = (axis for axis in range(3) if axis != longest)
    return first, second


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """What point splits leave of a box: where it begins in the world, and its size."""

    cuts: tuple[Cut, ...]
    low: Floats
    size: Floats


def point_splits(outer: tuple[Floats, Floats], inner: tuple[Floats, Floats], small: float) -> Taken:
    """The one or two point splits that take the inner box out of the outer (low and high, (3,)).

    A box that is flat along an axis gets all that there is beyond it: no split leaves nothing.
    One that does not reach into the outer box is met as nearly as can be.

    >>> box = np.zeros(3), np.array([9.0, 9, 9])
    >>> taken = point_splits(box, (np.array([4.0, 0, 3]), np.array([9.0, 5, 9])), 1e-9)
    >>> [(cut.point.tolist(), cut.octant) for cut in taken.cuts]
    [([4.0, 5.0, 3.0], 6)]
    """
    whole = outer[1] - outer[0]
    low, high = inner[0] - outer[0], inner[1] - outer[0]
    flat = high - low <= small
    at_end = flat & (high >= whole - small)
    low = np.where(at_end | (low <= small), 0.0, low)
    high = np.where(flat | (high >= whole - small), whole, high)
    first, last = low == 0.0, high == whole
    cuts: tuple[Cut, ...]
    if bool((first & last).all()):
        cuts = ()
    elif bool((first | last).all()):
        cuts = (Cut(np.where(first, high, low), _octant(~first)),)
    else:
        cuts = (Cut(low, LAST), Cut(high - low, FIRST))
    return Taken(cuts, outer[0] + low, high - low)


def _octant(beyond: NDArray[np.bool_]) -> int:
    return 1 + int(beyond @ np.array([1, 2, 4]))
