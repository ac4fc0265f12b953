"""Equal up to noise: numbers and rows of numbers to integer labels, and the same run after run.

Values that stand closer together than a gap get one label. Nothing here knows what they measure.
"""

from __future__ import annotations

from math import prod
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
    label = np.zeros(len(rows), np.int64)
    keys = _keys(rows)
    if keys is None:
        order = np.lexsort(rows.T[::-1])
        ordered = rows[order]
        label[order[1:]] = (ordered[1:] != ordered[:-1]).any(axis=1).cumsum()
    else:
        order = keys.argsort(kind="stable")
        ordered = keys[order]
        label[order[1:]] = (ordered[1:] != ordered[:-1]).cumsum()
    return label, np.bincount(label)


def _keys(rows: NDArray[np.int64]) -> Integers | None:
    """(n,) one number for each row, in lexical order; None where they would be too large."""
    if rows.shape[1] == 1:
        return rows[:, 0]
    low = rows.min(axis=0)
    extent: list[int] = (rows.max(axis=0) - low + 1).tolist()
    if prod(map(float, extent)) > 2.0**62:
        return None
    steps = [prod(extent[column:]) for column in range(1, len(extent) + 1)]
    return np.asarray((rows - low) @ np.array(steps, np.int64))


def members(label: Integers, count: int) -> list[Integers]:
    """For each of `count` labels the rows that have it, in order."""
    order = label.argsort(kind="stable")
    ends = np.bincount(label, minlength=count).cumsum().tolist()
    return [order[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]
