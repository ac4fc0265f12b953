"""Which of many boxes are near others: a tree of boxes along the axes of the world.

In go corners of boxes, out come pairs whose boxes meet, or that may be the nearest. Boxes are put
in the order of a curve through space (Morton), every 2 neighbours make a node of the level above:
queries go down all levels together, so that no loop goes over boxes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats

Numbers = NDArray[np.int64]
Pairs = tuple[Numbers, Numbers]  # of queries, of boxes
_BITS = 20


class Tree:
    """A hierarchy over boxes with corners low, high (n, 3), n > 0."""

    def __init__(self, low: Floats, high: Floats) -> None:
        self._order = np.argsort(_curve((low + high) / 2), kind="stable")
        self._levels = [(low[self._order], high[self._order])]
        while len(self._levels[-1][0]) > 1:
            self._levels.append(_halved(*self._levels[-1]))

    def meeting(self, low: Floats, high: Floats) -> Pairs:
        """The pairs of queries (m, 3) and boxes that have a point in common."""
        return self.within(low, high, np.zeros(len(low)))

    def within(self, low: Floats, high: Floats, reach: Floats) -> Pairs:
        """The pairs that are no farther apart than the reach (m,) of the query."""
        queries = np.arange(len(low))
        nodes = np.zeros(len(low), np.int64)
        for number in reversed(range(len(self._levels))):
            own = self._levels[number]
            if number < len(self._levels) - 1:
                queries = np.repeat(queries, 2)
                nodes = np.repeat(nodes * 2, 2)
                nodes[1::2] += 1
                there = nodes < len(own[0])
                queries, nodes = queries[there], nodes[there]
            near = gaps(low[queries], high[queries], own[0][nodes], own[1][nodes])
            kept = near <= reach[queries]
            queries, nodes = queries[kept], nodes[kept]
        return queries, self._order[nodes]


def gaps(low: Floats, high: Floats, other_low: Floats, other_high: Floats) -> Floats:
    """How far boxes along the axes are from others (n,), row by row."""
    apart = np.maximum(np.maximum(low - other_high, other_low - high), 0.0)
    found: Floats = np.sqrt(np.einsum("nc,nc->n", apart, apart))
    return found


def _halved(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The boxes around every two neighbours."""
    if len(low) % 2:
        low, high = np.concatenate([low, low[-1:]]), np.concatenate([high, high[-1:]])
    return np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])


def _curve(points: Floats) -> NDArray[np.uint64]:
    """The places of points (n, 3) on a curve that visits neighbours one after the other."""
    low = points.min(axis=0)
    size = np.maximum(points.max(axis=0) - low, 1e-300)
    cells = ((points - low) / size * ((1 << _BITS) - 1)).astype(np.uint64)
    found = np.zeros(len(points), np.uint64)
    for bit in range(_BITS):
        for axis in range(3):
            one = (cells[:, axis] >> np.uint64(bit)) & np.uint64(1)
            found |= one << np.uint64(3 * bit + axis)
    return found
