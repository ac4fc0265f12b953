"""Where the branches of a bracketed string lie, and what a state that follows them becomes.

In go the length of a string and the positions of its brackets. Rows are sorted by bracket depth, so
that each branch is one run of rows that opens with its `[`; what holds at a branch's start is what
holds at the row before its `[`, one depth up. All states of a turtle (angle, rotation, place, pen)
are scans over this one arrangement. Knows no symbols and draws nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.scan import Columns, Whole

Flags = NDArray[np.bool_]
Numbers = NDArray[np.int32] | NDArray[np.int64]
# columns and the lengths of their segments -> the columns scanned; the first row of each segment
# already holds the state that the segment starts from
Scan = Callable[[Columns, Whole], Columns]


class Branches:
    """The arrangement of `length` rows with brackets at `opens` and `closes`, positions from 0.

    Row 0 of the arrangement is an opening bracket of the whole string, so position p is row p + 1.
    `order` (rows by depth, then position), `place` (its inverse), `opens` (the places of opening
    brackets, ascending), `parent` (for each of them the place of the row before it, one depth up;
    -1 for the first), `levels` (how many opening brackets each depth has).
    """

    def __init__(self, length: int, opens: Whole, closes: Whole) -> None:
        step = np.zeros(length + 2, np.int32)
        step[opens + 1] += 1
        step[closes + 2] -= 1
        depth = np.cumsum(step[: length + 1])
        deepest = int(depth.max()) if length else 0
        small = np.uint8 if deepest < 256 else np.uint16 if deepest < 65536 else np.int64
        self.length = length
        self.order = _narrow(np.argsort(depth.astype(small), kind="stable"))
        self.place = np.empty_like(self.order)
        self.place[self.order] = _narrow(np.arange(length + 1))
        rows = np.sort(np.append(opens + 1, 0))
        self.opens: Whole = np.sort(self.place[rows]).astype(np.int64)
        self.levels = np.bincount(depth[rows], minlength=deepest + 1)
        self.parent = self._parents(depth)

    def _parents(self, depth: NDArray[np.int32]) -> Whole:
        ends = np.cumsum(np.bincount(depth))
        parent = np.full(len(self.opens), -1, np.int64)
        done = 1
        for level, count in enumerate(self.levels[1:].tolist(), start=1):
            chosen = slice(done, done + count)
            begin = int(ends[level - 2]) if level > 1 else 0
            above = self.order[begin : ends[level - 1]]
            rows = self.order[self.opens[chosen]]
            parent[chosen] = begin + np.searchsorted(above, rows) - 1
            done += count
        return parent

    def branch(self) -> Whole:
        """For each place, the number of the branch it stands in (0 is the whole string)."""
        opening = np.zeros(self.length + 1, np.int64)
        opening[self.opens] = 1
        number: Whole = np.cumsum(opening) - 1
        return number

    def ends(self) -> Whole:
        """For each branch, the position of its closing bracket, or the length of the string."""
        last = np.append(self.opens[1:], self.length + 1) - 1
        ends: Whole = self.order[last].astype(np.int64) - 1
        ends[0] = self.length
        return ends


class Path:
    """Those rows of an arrangement that matter to one part of the state, and the opening brackets.

    `keep` marks places; the state of any place is that of the last kept one at or before it, which
    is always in its own branch.
    """

    def __init__(self, branches: Branches, positions: list[Whole]) -> None:
        keep = np.zeros(branches.length + 1, np.bool_)
        keep[branches.opens] = True
        for each in positions:
            keep[branches.place[each + 1]] = True
        self._keep = keep
        self._rank = _narrow(np.cumsum(keep) - 1)
        self._place = branches.place
        self.count = int(self._rank[-1]) + 1
        self.first: Whole = self._rank[branches.opens].astype(np.int64)
        self._parent: Whole = self._rank[branches.parent].astype(np.int64)
        self._levels = branches.levels.tolist()
        self._lengths = np.diff(np.append(self.first, self.count))

    def rows(self, positions: Whole) -> Whole:
        """The kept row that holds the state after each position."""
        rows: Whole = self._rank[self._place[positions + 1]].astype(np.int64)
        return rows

    def before(self, positions: Whole) -> Whole:
        """The kept row that holds the state each position finds."""
        place = self._place[positions + 1]
        rows: Whole = self._rank[place].astype(np.int64) - self._keep[place]
        return rows

    def resolve(self, columns: Columns, scan: Scan | None) -> Columns:
        """States at all kept rows, in place: `columns` hold what each row does, and at row 0 the
        state at the start; `scan` turns one level's rows into states (None: they are states).
        """
        done = 0
        for count in self._levels:
            first = self.first[done : done + count]
            if done:
                source = self._parent[done : done + count]
                for column in columns:
                    column[first] = column[source]
            lengths = self._lengths[done : done + count]
            rows = slice(int(first[0]), int(first[-1] + lengths[-1]))
            if scan is not None:
                part = tuple(column[rows] for column in columns)
                for column, values in zip(columns, scan(part, lengths), strict=True):
                    column[rows] = values
            done += count
        return columns


def _narrow(numbers: Whole) -> Numbers:
    """Numbers of rows in four bytes each where these suffice: there is one for every module."""
    return numbers.astype(np.int32) if len(numbers) < 2**31 else numbers
