"""Equal numbers and equal rows of large tables, found by hashing and quick sorts.

In go numbers or a table of them, out come the first of each kind and the kind of every one. Sorts
that keep the order of equals are several times slower than others: here they are put together from
those. Nothing here knows what the numbers mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_FEW = 64  # numbers that are sorted anyway
_DENSE = 4  # times as large as they are many: numbers below that are counted instead
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
    first, kind = distinct_numbers(_hashes(table))
    if not (table[first][kind] == table).all():  # two kinds of equal hash
        _, first, kind = np.unique(table, axis=0, return_index=True, return_inverse=True)
    return by_first(first, kind.reshape(-1))


def by_first(
    first: NDArray[np.intp], kind: NDArray[np.int64]
) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """Kinds (n,) with the first (k,) of each, renumbered in the order of these."""
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[kind]


def distinct_numbers(
    values: NDArray[np.int64] | NDArray[np.uint64],
) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """Where each of the whole numbers (n,) is first (k,), and which of these each is (n,), in the
    order of the numbers.

    >>> first, kind = distinct_numbers(np.array([7, 3, 7, 9]))
    >>> first.tolist(), kind.tolist()
    ([1, 0, 3], [1, 0, 1, 2])
    """
    if len(values) > _FEW and values.min() >= 0 and values.max() < _DENSE * len(values):
        return _counted(values.astype(np.int64, copy=False))
    order = np.argsort(values)
    ordered = values[order]
    new = np.ones(len(values), np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    kind = np.empty(len(values), np.int64)
    kind[order] = np.cumsum(new) - 1
    starts = np.flatnonzero(new)
    return np.minimum.reduceat(order, starts) if len(starts) else order, kind


def _counted(values: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """The same for small numbers, without sorting them."""
    place = np.full(int(values.max()) + 1, -1, np.int64)
    place[values[::-1]] = np.arange(len(values) - 1, -1, -1)  # the first is written last
    there = place >= 0
    return place[there], (np.cumsum(there) - 1)[values]


def stable_order(values: NDArray[np.int64] | NDArray[np.uint64]) -> NDArray[np.int64]:
    """(n,) whole numbers in order, of equal ones the first before the others.

    >>> stable_order(np.array([7, 3, 7, 9, 3])).tolist()
    [1, 4, 0, 2, 3]
    """
    count = len(values)
    _, kind = distinct_numbers(values)
    return np.sort(kind * count + np.arange(count)) % max(count, 1)


def _hashes(table: NDArray[np.float64]) -> NDArray[np.uint64]:
    """64 bits for each row."""
    found = np.zeros(len(table), np.uint64)
    for column in np.ascontiguousarray(table.T).view(np.uint64):
        found ^= column
        for factor in _FACTORS:
            found ^= found >> np.uint64(29)
            found *= np.uint64(factor)
    return found
