"""Where a box can be cut: groups of what stands side by side along an axis, and which repeat.

In go intervals, out come groups between which a plane passes, and runs of groups that follow each
other at one step. What protrudes a little into its neighbour does not hinder a cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.distinct import numbered
from ipmlang.inverse.split.facades.contents import Contents

PROTRUDING = 0.15  # of its length that anything may stand out of its cell at either end
LONGEST_PERIOD = 6  # groups that repeat together
BACKDROPS = (1.0, 0.75, 0.45)  # of the whole length: what is longer may be left out of a cut
FEW = 12  # rows that may be left out, or a third of all


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """rows: of each group, from the first to the last along the axis; low, high (g,): where their
    contents begin and end; backdrop: rows in no group.
    """

    rows: list[Integers]
    low: Floats
    high: Floats
    backdrop: Integers


def side_by_side(inside: Contents, axis: int, small: float) -> list[Groups]:
    """The ways to cut along an axis, with more or less left standing behind the cut."""
    low, high = inside.low[:, axis], inside.high[:, axis]
    whole = float(high.max(initial=0.0) - low.min(initial=0.0))
    found: list[Groups] = []
    before = -1
    for share in BACKDROPS:
        behind = high - low > share * whole + small
        many = int(np.count_nonzero(behind))
        if many in (before, len(inside)) or many > max(FEW, len(inside) // 3):
            continue
        before = many
        groups = _groups(low, high, np.flatnonzero(~behind), np.flatnonzero(behind), small)
        if not found or len(groups.rows) > len(found[-1].rows):
            found.append(groups)
    return [groups for groups in found if len(groups.rows) > 1]


def _groups(low: Floats, high: Floats, rows: Integers, backdrop: Integers, small: float) -> Groups:
    """Connected groups of the middles of intervals."""
    give = PROTRUDING * (high[rows] - low[rows])
    first, last = low[rows] + give, high[rows] - give
    order = np.argsort(first, kind="stable")
    rows, first, last = rows[order], first[order], last[order]
    reached = np.maximum.accumulate(last)
    ends = [*(np.flatnonzero(first[1:] > reached[:-1] + small) + 1).tolist(), len(rows)]
    begins = [0, *ends[:-1]]
    return Groups(
        [rows[begin:end] for begin, end in zip(begins, ends, strict=True)],
        np.minimum.reduceat(low[rows], begins),
        np.maximum.reduceat(high[rows], begins),
        backdrop,
    )


@dataclass(frozen=True, slots=True)
class Run:
    """`count` periods of `period` groups from group `first`, each `step` behind the one before;
    count 1: no repetition. kind: the same for equal groups.
    """

    first: int
    period: int
    count: int
    step: float = 0.0
    kind: int = -1


def runs(inside: Contents, groups: Groups, axis: int, small: float) -> list[Run]:
    """The groups as runs, the longest stretch of equal periods first chosen."""
    label = _labels(inside, groups, axis, small)
    found: list[Run] = []
    waiting = [(0, len(label))]
    while waiting:
        begin, end = waiting.pop()
        best = _longest(label, groups.low, begin, end, small)
        if best is None:
            found += [Run(each, 1, 1, kind=int(label[each])) for each in range(begin, end)]
            continue
        found.append(best)
        waiting.append((begin, best.first))
        waiting.append((best.first + best.period * best.count, end))
    return _without_chance(sorted(found, key=lambda run: run.first), label, small)


def ways(found: list[Run]) -> list[list[Run]]:
    """The runs as they are, and with what stands alone between them together in one cell: a ground
    floor, a roof.
    """
    together: list[Run] = []
    for run in found:
        before = together[-1] if together else None
        if before is not None and before.count == run.count == 1:
            together[-1] = Run(before.first, before.period + run.period, 1)
        else:
            together.append(run)
    return [found] if len(together) in (1, len(found)) else [found, together]


def _without_chance(found: list[Run], label: Integers, small: float) -> list[Run]:
    """Two of a kind always have one step: they are no run where the same stands at another."""
    steps = np.full(len(label), np.nan)
    for run in found:
        if run.count > 1:
            steps[run.first : run.first + run.period * run.count] = run.step
    kept: list[Run] = []
    for run in found:
        stop = run.first + run.period * run.count
        if run.count == 2:
            inside = np.zeros(int(label.max()) + 1, np.bool_)
            inside[label[run.first : stop]] = True
            if not bool((np.abs(steps[inside[label]] - run.step) <= small).all()):
                kept += [Run(each, 1, 1, kind=int(label[each])) for each in range(run.first, stop)]
                continue
        kept.append(run)
    return kept


def _labels(inside: Contents, groups: Groups, axis: int, small: float) -> Integers:
    """(g,) the same for groups that are the same but for their place along the axis."""
    count = len(groups.rows)
    owner = np.repeat(np.arange(count), [len(each) for each in groups.rows])
    rows = np.concatenate(groups.rows)
    place = inside.frames.position[rows].copy()
    place[:, axis] -= groups.low[owner]
    columns = [numbered(place[:, each], small) for each in range(3)]
    told = np.stack([inside.kind[rows], *columns], axis=1)
    order = np.lexsort((*told.T, owner))
    parts = np.split(told[order], np.cumsum([len(each) for each in groups.rows])[:-1])
    known: dict[bytes, int] = {}
    return np.array([known.setdefault(each.tobytes(), len(known)) for each in parts])


def _longest(label: Integers, low: Floats, begin: int, end: int, small: float) -> Run | None:
    """The run that takes in most groups; of those the one with the shortest period."""
    best: Run | None = None
    for period in range(1, min(LONGEST_PERIOD, (end - begin) // 2) + 1):
        step = low[begin + period : end] - low[begin : end - period]
        equal = label[begin + period : end] == label[begin : end - period]
        start = 0
        while start < len(step):
            stop = start
            while (
                stop < len(step)
                and equal[stop]
                and step[stop] > small
                and abs(step[stop] - step[start]) <= small
            ):
                stop += 1
            count = (stop - start) // period + 1
            if count > 1 and (best is None or count * period > best.count * best.period):
                first = begin + start
                length = float(low[first + (count - 1) * period] - low[first])
                best = Run(first, period, count, length / (count - 1))
            start = max(stop, start + 1)
    return best
