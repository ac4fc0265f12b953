"""Equal up to noise: numbers and rows of numbers to integer labels, and the same run after run.

Values that stand closer together than a gap get one label. Nothing here knows what they measure.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Integers

Flags: TypeAlias = NDArray[np.bool_]


def snap(values: Floats, gap: float) -> Integers:
    """(n,) labels in the order of the values; neighbours nearer than `gap` share one.

    >>> snap(np.array([3.0, 1.0, 1.0000001, 2.0]), 1e-3).tolist()
    [2, 0, 0, 1]
    """
    order = values.argsort(kind="stable")
    ordered = values[order]
    labels = np.zeros(len(values), np.int64)
    labels[order[1:]] = (ordered[1:] - ordered[:-1] > gap).cumsum()
    return labels


def snap_columns(values: Floats, gap: float) -> Integers:
    """(n, c) labels, each column by itself; the gap is the same for all."""
    labels = np.zeros(values.shape, np.int64)
    for column in range(values.shape[1]):
        labels[:, column] = snap(values[:, column], gap)
    return labels


def label_rows(rows: NDArray[np.int64]) -> tuple[Integers, Integers]:
    """(n,) which rows of integers are equal, numbered in lexical order, and (k,) how many of each.

    >>> [each.tolist() for each in label_rows(np.array([[1, 2], [0, 5], [1, 2]]))]
    [[1, 0, 1], [1, 2]]
    """
    if len(rows) == 0:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    keys = _keys(rows)
    if keys is None:
        _, label, count = np.unique(rows, axis=0, return_inverse=True, return_counts=True)
        return np.asarray(label, np.int64).reshape(-1), np.asarray(count, np.int64)
    order = keys.argsort(kind="stable")
    ordered = keys[order]
    label = np.zeros(len(keys), np.int64)
    label[order[1:]] = (ordered[1:] != ordered[:-1]).cumsum()
    return label, np.bincount(label)


def _keys(rows: NDArray[np.int64]) -> Integers | None:
    """(n,) one number for each row, in lexical order; None where they would be too large."""
    low = rows.min(axis=0)
    extent = rows.max(axis=0) - low + 1
    if float(np.prod(extent.astype(np.float64))) > 2.0**62:
        return None
    keys = np.zeros(len(rows), np.int64)
    for column in range(rows.shape[1]):
        keys = keys * extent[column] + (rows[:, column] - low[column])
    return keys


def members(label: Integers, count: int) -> list[Integers]:
    """For each of `count` labels the rows that have it, in order."""
    order = label.argsort(kind="stable")
    ends = np.bincount(label, minlength=count).cumsum().tolist()
    return [order[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]
