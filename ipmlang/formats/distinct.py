"""Equal rows of large tables, found by hashing instead of sorting rows.

In goes a table of numbers, out come the first of each kind of row and the kind of every row.
Nothing here knows what the numbers mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_FACTORS = (0xBF58476D1CE4E5B9, 0x94D049BB133111EB)


def distinct_rows(table: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """The number of the first row of each kind (k,), kinds in the order of these rows, and the kind
    of each row (n,). -0 is 0; no number may be NaN.

    >>> first, kind = distinct_rows(np.array([[1.0, 2], [0, 0], [1, 2]]))
    >>> first.tolist(), kind.tolist()
    ([0, 1], [0, 1, 0])
    """
    if not len(table) or not table.shape[1] or (table == table[0]).all():
        return np.arange(min(len(table), 1)), np.zeros(len(table), np.int64)
    table = table + 0.0
    _, first, kind = np.unique(_hashes(table), return_index=True, return_inverse=True)
    if not (table[first][kind.reshape(-1)] == table).all():  # two kinds of equal hash
        _, first, kind = np.unique(table, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[kind.reshape(-1)]


def _hashes(table: NDArray[np.float64]) -> NDArray[np.uint64]:
    """64 bits for each row."""
    found = np.zeros(len(table), np.uint64)
    for column in np.ascontiguousarray(table.T).view(np.uint64):
        found ^= column
        for factor in _FACTORS:
            found ^= found >> np.uint64(29)
            found *= np.uint64(factor)
    return found
