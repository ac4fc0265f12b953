"""Repeated stretches of a string of labels: the longest, the most frequent, all that no longer one
explains.

Takes integers, one for each step from a symbol to its neighbour; gives the branching nodes of the
suffix tree as (length, places), by way of a suffix array built by doubling: n log² n in numpy.
Nothing here knows frames or tokens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Repeat:
    """The same `length` labels start at every one of `places` (k,), ascending."""

    length: int
    places: Integers


def find_repeats(labels: Integers, weight: NDArray[np.float64], most: int) -> list[Repeat]:
    """Repeats that cover much, by the sum of the weights (n,) of their labels: of each order of
    magnitude in length the `most` best ones, longest first.

    None of them can go on to the right: every longer stretch occurs less often. What repeats
    without a gap gives its period: `abcabcabc` is three times `abc`.

    >>> found = find_repeats(np.array([7, 8, 1, 7, 8, 2]), np.ones(6), 5)
    >>> [(each.length, each.places.tolist()) for each in found]
    [(2, [0, 3]), (1, [1, 4])]
    >>> [each.places.tolist() for each in find_repeats(np.array([5, 6, 5, 6, 5]), np.ones(5), 5)]
    [[0, 2, 4], [1, 3]]
    """
    if len(labels) < 2:
        return []
    suffixes, common = _suffixes(labels)
    total = np.concatenate([[0.0], np.cumsum(weight)]).tolist()
    begins = suffixes.tolist()
    sized: dict[int, list[tuple[float, int, int, int]]] = {}
    for length, left, right in _nodes(common):
        first = begins[left]
        often = min(right - left, (len(labels) + length) // length)
        covered = (total[first + length] - total[first]) * often
        sized.setdefault(length.bit_length(), []).append((-covered, length, left, right))
    found: dict[tuple[int, int, int], Repeat] = {}
    for bits in sorted(sized, reverse=True):
        for _, length, left, right in sorted(sized[bits])[:most]:
            places = suffixes[left:right].copy()
            places.sort()
            repeat = _primitive(Repeat(length, places))
            found.setdefault((repeat.length, int(repeat.places[0]), len(repeat.places)), repeat)
    return list(found.values())


def _primitive(repeat: Repeat) -> Repeat:
    """The period of a stretch that overlaps its next occurrence, else the stretch itself."""
    places = repeat.places
    gap = int((places[1:] - places[:-1]).min())
    if gap > repeat.length:
        return repeat
    more = np.arange(gap, repeat.length - gap + 2, gap)
    if not len(more):
        return Repeat(gap - 1, places)
    # Only where a chain of overlapping occurrences ends are there places not known yet.
    after = np.searchsorted(places, places + gap)
    ends = places[np.append(places, -1)[after] != places + gap]
    if len(ends) * len(more) > 4 * (len(places) + repeat.length):
        return Repeat(gap - 1, places)
    return Repeat(gap - 1, np.union1d(places, (ends[:, None] + more).ravel()))


def _suffixes(labels: Integers) -> tuple[Integers, Integers]:
    """Suffixes in order (n,), and the common length of each with the one before it (n,)."""
    count = len(labels)
    rank = _ranks(labels)
    ranks = [rank]
    step = 1
    while step < count and int(rank.max()) < count - 1:
        later = np.full(count, -1, np.int64)
        later[: count - step] = rank[step:]
        key = rank * (count + 1) + later + 1
        rank = _ranks(key)
        ranks.append(rank)
        step *= 2
    order = np.argsort(rank, kind="stable")
    return order, _common(ranks, order)


def _ranks(keys: Integers) -> Integers:
    """(n,) how many smaller keys there are, equal ones counting once."""
    order = np.argsort(keys, kind="stable")
    known = keys[order]
    rank = np.empty(len(keys), np.int64)
    rank[order[0]] = 0
    rank[order[1:]] = np.cumsum(known[1:] != known[:-1])
    return rank


def _common(ranks: list[Integers], order: Integers) -> Integers:
    """How many labels neighbours in `order` share, from the ranks of stretches of 1, 2, 4, …."""
    count = len(order)
    one, other = order[1:].copy(), order[:-1].copy()
    shared = np.zeros(count - 1, np.int64)
    for level in range(len(ranks) - 1, -1, -1):
        inside = (one < count) & (other < count)
        same = np.zeros(count - 1, np.bool_)
        same[inside] = ranks[level][one[inside]] == ranks[level][other[inside]]
        # Ranks are of stretches cut at the end, so only stretches that fit may be counted.
        same &= np.maximum(one, other) + (1 << level) <= count
        shared[same] += 1 << level
        one[same] += 1 << level
        other[same] += 1 << level
    return np.concatenate([[0], shared])


def _nodes(common: Integers) -> Iterator[tuple[int, int, int]]:
    """(length, left, right) of every range of suffixes that share `length` labels and no more."""
    open_nodes: list[tuple[int, int]] = [(0, 0)]
    for index, length in enumerate([*common[1:].tolist(), 0], start=1):
        left = index - 1
        while open_nodes[-1][0] > length:
            shared, left = open_nodes.pop()
            yield shared, left, index
        if open_nodes[-1][0] < length:
            open_nodes.append((length, left))


def apart(places: Integers, length: int) -> Integers:
    """From left to right, the places whose stretches of `length` do not overlap.

    >>> apart(np.array([0, 1, 2, 3, 7]), 2).tolist()
    [0, 2, 7]
    """
    if len(places) < 2 or int(np.diff(places).min()) >= length:
        return places
    kept, end = [], -1
    for place in places.tolist():
        if place >= end:
            kept.append(place)
            end = place + length
    return np.array(kept, np.int64)
