"""The order of a derivation from the tree of its records, which a card makes in any order.

In go where each record and each leaf stands (its parent, the copy, its number among what was made
there), out come the places of the leaves, from left to right. Weights go up level by level and
places come down: no loop goes over records.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.gpu.isa import NONE

Words = NDArray[np.uint32]
Numbers = NDArray[np.int64]


def places(
    parent: Words, copy: Words, sequence: Words, depth: Numbers, leaves: tuple[Words, Words, Words]
) -> tuple[Numbers, Numbers]:
    """The place (m,) of each leaf from left to right, and how many leaves each first record has.

    parent, copy, sequence, depth: (n,) of the records, in any order but parents first by depth;
    `leaves` are the first three (m,) of the leaves.
    """
    count, many = len(parent), len(leaves[0])
    roots = int(np.count_nonzero(parent == NONE))
    above = np.concatenate([parent, leaves[0]]).astype(np.int64)
    above[above == NONE] = -1
    order = _sorted(above, np.concatenate([copy, leaves[1]]), np.concatenate([sequence, leaves[2]]))
    weight = np.concatenate([np.zeros(count, np.int64), np.ones(many, np.int64)])
    _added(weight, above[count:], 1)
    levels = _levels(depth)
    for level in reversed(levels[1:]):
        _added(weight, above[level], weight[level])
    within = np.empty(count + many, np.int64)
    ranked = weight[order]
    before = np.cumsum(ranked) - ranked
    parents = above[order]
    begins = np.flatnonzero(np.append(True, parents[1:] != parents[:-1])) if len(order) else order
    starts = np.repeat(before[begins], np.diff(np.append(begins, len(order))))
    within[order] = before - starts
    place = within.copy()
    for level in levels[1:]:
        place[level] += place[above[level]]
    return place[count:] + place[above[count:]], weight[:roots]


def _added(weight: Numbers, rows: Numbers, values: Numbers | int) -> None:
    """Add values to rows of weights, which may occur again and again."""
    if len(rows):
        amounts = None if isinstance(values, int) else values
        found = np.bincount(rows, amounts, minlength=0)
        weight[: len(found)] += found.astype(np.int64)


def _levels(depth: Numbers) -> list[Numbers]:
    """The records of each depth."""
    order = np.argsort(depth, kind="stable")
    ends = np.cumsum(np.bincount(depth)) if len(depth) else np.zeros(0, np.int64)
    return np.split(order, ends[:-1]) if len(depth) else []


def _sorted(above: Numbers, copy: Words, sequence: Words) -> Numbers:
    """The rows by parent, copy and sequence."""
    bits = [int(max(column.max(initial=0), 1)).bit_length() for column in (copy, sequence)]
    if int(above.max(initial=0) + 1).bit_length() + sum(bits) <= 63:
        code = (above + 1) << sum(bits)
        code |= copy.astype(np.int64) << bits[1]
        code |= sequence
        return np.argsort(code, kind="stable")
    return np.lexsort((sequence, copy, above))
