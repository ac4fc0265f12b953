"""Who stands in whom, for all rows of a derivation at once.

In go the parents of rows, which have lower numbers than their children; out comes an interval for
each row that holds those of all that stand in it and no others. No loop goes over rows: only over
how deep they stand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Nesting:
    """Where the interval of each row (n,) begins, and how long it is."""

    begin: Numbers
    size: Numbers

    def holds(self, outer: Numbers, inner: Numbers) -> NDArray[np.bool_]:
        """Whether each row of `outer` is its partner in `inner`, or stands around it; no row (-1)
        does.
        """
        begin = self.begin[np.maximum(outer, 0)]
        inside = self.begin[np.maximum(inner, 0)] - begin
        found: NDArray[np.bool_] = (inside >= 0) & (inside < self.size[np.maximum(outer, 0)])
        return found & (outer >= 0) & (inner >= 0)


def nesting(parent: Numbers) -> Nesting:
    """The intervals of rows (n,) with these parents, -1 for none.

    >>> found = nesting(np.array([-1, 0, 0, 1]))
    >>> found.holds(np.array([0, 1, 2]), np.array([3, 3, 3])).tolist()
    [True, True, False]
    """
    if not len(parent):
        return Nesting(np.zeros(1, np.int64), np.zeros(1, np.int64))
    size = _sizes(parent)
    order = np.argsort(parent, kind="stable")
    before = np.cumsum(size[order]) - size[order]
    first = np.searchsorted(parent[order], parent[order])
    step = np.empty(len(parent), np.int64)
    step[order] = before - before[first] + (parent[order] >= 0)
    return Nesting(_along(parent, step), size)


def _sizes(parent: Numbers) -> Numbers:
    """How many rows stand in each, itself included: from the deepest up."""
    depth = _along(parent, np.ones(len(parent), np.int64))
    order = np.argsort(depth, kind="stable")
    ends = np.searchsorted(depth[order], np.arange(1, int(depth.max()) + 2))
    size = np.ones(len(parent), np.int64)
    for begin, end in zip(ends[-2:0:-1].tolist(), ends[:1:-1].tolist(), strict=True):
        rows = order[begin:end]
        np.add.at(size, parent[rows], size[rows])
    return size


def _along(parent: Numbers, values: Numbers) -> Numbers:
    """The sums of values on the way from each row to the outermost, by doubling steps."""
    total, above = values.copy(), parent.copy()
    open_ = np.flatnonzero(above >= 0)
    while len(open_):
        further = above[open_]
        total[open_] = total[open_] + total[further]
        above[open_] = above[further]
        open_ = open_[above[open_] >= 0]
    return total
