"""Which boxes touch or overlap: the neighbours in a building.

In go boxes as low and high corners, out come pairs. Candidates come from a tree over two axes, from
all pairs only where boxes are few. What a contact means for an edit is decided in `attachments.py`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FEW = 400  # boxes all of whose pairs are sooner looked at than sorted
Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def neighbours(low: Floats, high: Floats, tolerance: float) -> Integers:
    """(k, 2) the pairs i < j of n boxes, corners (n, 3), that share a point within `tolerance`.

    >>> low = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    >>> neighbours(low, low + 1, 1e-6).tolist()
    [[0, 1]]
    """
    if len(low) <= FEW:
        return _among_all(low, high, tolerance)
    import shapely

    first, second, third = _axes(low, high)
    half = 0.5 * tolerance
    flat = shapely.box(
        low[:, first] - half, low[:, second] - half, high[:, first] + half, high[:, second] + half
    )
    pairs = shapely.STRtree(flat).query(flat).T.astype(np.int64)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    i, j = pairs.T
    meets = (low[i, third] <= high[j, third] + tolerance) & (
        low[j, third] <= high[i, third] + tolerance
    )
    pairs = pairs[meets]
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def _among_all(low: Floats, high: Floats, tolerance: float) -> Integers:
    """The same by a look at all pairs."""
    below, above = (low - 0.5 * tolerance).T, (high + 0.5 * tolerance).T
    meets = below[0] <= above[0][:, None]
    for k in (1, 2):
        meets &= below[k] <= above[k][:, None]
    i, j = np.nonzero(np.triu(meets & meets.T, 1))
    return np.stack([i, j], axis=1)


def _axes(low: Floats, high: Floats) -> tuple[int, int, int]:
    """The axes from the one along which boxes part best."""
    own = np.maximum((high - low).mean(axis=0), 1e-12)
    order = np.argsort(-(high.max(axis=0) - low.min(axis=0)) / own, kind="stable").tolist()
    return order[0], order[1], order[2]


def touching(low: Floats, high: Floats, pairs: Integers, tolerance: float) -> NDArray[np.bool_]:
    """(k, 3) along which axes each pair abuts: one ends where the other begins."""
    i, j = pairs.T
    return np.asarray(
        (np.abs(high[i] - low[j]) <= tolerance) | (np.abs(high[j] - low[i]) <= tolerance)
    )


def gaps(low: Floats, high: Floats, pairs: Integers) -> Floats:
    """(k,) how far each pair is apart, 0 where it touches or overlaps."""
    i, j = pairs.T
    apart = np.maximum(low[i] - high[j], low[j] - high[i])
    return np.asarray(np.maximum(apart, 0.0).max(axis=1, initial=0.0))
