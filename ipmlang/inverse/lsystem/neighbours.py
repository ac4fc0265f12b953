"""Pairs of neighbours with equal steps as candidates: the rules r2 of the paper.

Takes the spaces of an arrangement with a label for each point, equal for equal steps; gives those
whose rule saves enough tokens, all weighed at once. Whether an occurrence is exact is for whoever
takes one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.candidates import Candidate
from ipmlang.inverse.lsystem.frames import Frames, frames, wrap
from ipmlang.inverse.lsystem.spaces import Pairs
from ipmlang.inverse.lsystem.symbols import Integers
from ipmlang.inverse.score import HEAD, Tabled, followed_tokens, placement_tokens


def pair_candidates(
    pairs: Pairs, labels: Integers, cost: Tabled, small: float, least: float
) -> list[Candidate]:
    """Two pairs or more of one label (m,) that share no symbol; cost: of the string; small: units,
    as for `placement_tokens`; least: tokens to be saved.
    """
    rows, begin = _groups(pairs.first, labels)
    if not len(begin):
        return []
    first, lead = pairs.first[rows], pairs.lead[rows]
    left = np.add.reduceat(placement_tokens(lead, small), begin)
    saved = cost.saved_by(first, np.full(len(first), 2), begin)
    # A step takes one token at least; what does not pay alone may do so as a row.
    less = np.where(_in_rows(first, begin), 0, left)
    good = np.flatnonzero(saved - (less + HEAD + 2) >= least)
    ends = np.append(begin, len(rows)).tolist()
    bounds = [(ends[k], ends[k + 1]) for k in good.tolist()]
    if not bounds:
        return []
    step = _middles(pairs.step[rows], bounds)
    room = saved[good] - (HEAD + 1 + placement_tokens(step, small))
    gain = room - left[good]
    for k in np.flatnonzero(gain < least).tolist():
        a, b = bounds[k]
        # At the end, when nothing else pays.
        gain[k] = min(least, room[k] - followed_tokens(lead[a:b], first[a:b], 2, small))
    return [
        Candidate(saves, int(first[a]), first[a:b], lead[a:b], step[k : k + 1])
        for k, (saves, (a, b)) in enumerate(zip(gain.tolist(), bounds, strict=True))
        if saves >= least
    ]


def _in_rows(first: Integers, begin: Integers) -> NDArray[np.bool_]:
    """Which groups of pairs have three that follow each other."""
    near = np.zeros(len(first), np.bool_)
    near[2:] = (first[1:-1] - first[:-2] == 2) & (first[2:] - first[1:-1] == 2)
    for later in (0, 1):
        own = begin[begin + later < len(near)]
        near[own + later] = False
    return np.asarray(np.logical_or.reduceat(near, begin), np.bool_)


def _groups(first: Integers, labels: Integers) -> tuple[Integers, Integers]:
    """Rows of two pairs or more of one label, group by group, by the first of each; where groups
    begin. Of pairs that overlap every second one is left out, from left to right.
    """
    order = np.argsort(labels, kind="stable")
    label, at = labels[order], first[order]
    index = np.arange(len(order))
    new = np.diff(label, prepend=-1) != 0
    chain = new | (np.diff(at, prepend=-2) != 1)
    keep = (index - np.maximum.accumulate(np.where(chain, index, 0))) % 2 == 0
    order, group = order[keep], np.cumsum(new)[keep] - 1
    begin = np.flatnonzero(np.diff(group, prepend=-1))
    several = np.bincount(group, minlength=1) > 1
    # Groups by their first rows, which none of them shares.
    leading = np.repeat(order[begin], np.diff(np.append(begin, len(order))))
    order, leading = order[several[group]], leading[several[group]]
    order = order[np.argsort(leading, kind="stable")]
    begin = np.flatnonzero(np.diff(np.sort(leading), prepend=-1))
    return order, begin


def _middles(steps: Frames, bounds: list[tuple[int, int]]) -> Frames:
    """The mean of the equal steps between each two bounds."""
    begin = np.array([a for a, _ in bounds])
    size = np.array([b - a for a, b in bounds])
    first = np.zeros(len(steps))
    for a, b in bounds:
        first[a:b] = steps.angle[a]
    turned, at = wrap(steps.angle - first), steps.position
    middle = np.array([np.add.reduce(at[a:b]) for a, b in bounds]) / size
    turn = np.array([np.add.reduce(turned[a:b]) for a, b in bounds]) / size
    scale = np.array([np.add.reduce(steps.scale[a:b]) for a, b in bounds]) / size
    return frames(middle, steps.angle[begin] + turn, scale, steps.handedness[begin])
