"""Clusters of numbers that are equal within a slack: the spaces of the paper's section 4.3 hold
mostly exact repetitions, so sorting and splitting at gaps replaces mean shift.

Takes columns and gives a cluster number for each row, in n log n. Gaps chain, so a cluster is a
proposal: whoever uses one checks its members against what was observed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def cluster(labels: Integers, values: Floats, slack: Floats) -> Integers:
    """(n,) cluster numbers of rows with equal `labels` (n,) and values (n, k) that no gap larger
    than the slack (n, k) separates in any column.

    >>> ones = np.ones((3, 1))
    >>> cluster(np.zeros(3, np.int64), np.array([[5.0], [1.0], [5.1]]), 0.2 * ones).tolist()
    [1, 0, 1]
    """
    for column in range(values.shape[1]):
        labels = _split(labels, values[:, column], slack[:, column])
    return labels


def _split(labels: Integers, value: Floats, slack: Floats) -> Integers:
    order = np.lexsort((value, labels))
    label, sorted_value, room = labels[order], value[order], slack[order]
    apart = np.diff(sorted_value) > np.maximum(room[1:], room[:-1])
    new = (label[1:] != label[:-1]) | apart
    result = np.empty(len(labels), np.int64)
    if len(labels):
        result[order] = np.concatenate([[0], np.cumsum(new)])
    return result


def members(labels: Integers, least: int) -> list[Integers]:
    """Ascending rows of every cluster with at least `least` rows, by first row."""
    order = np.argsort(labels, kind="stable")
    edges = np.flatnonzero(np.diff(labels[order])) + 1
    groups = [rows for rows in np.split(order, edges) if len(rows) >= least]
    return sorted(groups, key=lambda rows: int(rows[0]))
