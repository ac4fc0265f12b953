"""Which node of a grid each of many places stands on, where they are painted line by line.

Takes places in paint order; gives the longest stretch of them that runs along the lines of a grid
and from line to line, as a picture is scanned, with the node of each. Lines may be staggered or
aslant, and nodes may be empty. What stands there, and where exactly, is for others to say.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes, Floats
from ipmlang.inverse.lsystem.symbols import Integers

LEAST = 24  # places that are worth a board
LINES = 2  # it has at least
MEMBERS = 3  # a line has at least
NEAR = 0.12  # of a step: what a place may be off its node
FULL = 0.5  # of the nodes have a place at least


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """Places `start` to `stop` stand on nodes of a grid; node: (stop - start,) of each, ascending,
    i + across * j; i, j: which step along a line, and which line.
    """

    start: int
    stop: int
    across: int
    node: Integers

    @property
    def i(self) -> Floats:
        """(n,) steps along the line."""
        return np.asarray(self.node % self.across, np.float64)

    @property
    def j(self) -> Floats:
        """(n,) lines."""
        return np.asarray(self.node // self.across, np.float64)


def rasters(places: Complexes, group: Integers) -> list[Raster]:
    """The stretches of places (n,) that are scanned, one after the other; group: (n,) what is
    looked at by itself where all together are no grid (things of one style).
    """
    found: list[Raster] = []
    waiting = [(0, len(places), True)]
    while waiting:
        start, stop, whole = waiting.pop()
        if stop - start < LEAST:
            continue
        raster = _raster(places, start, stop)
        if raster is not None:
            found.append(raster)
            waiting += [(start, raster.start, whole), (raster.stop, stop, whole)]
        elif whole:
            ends = start + 1 + np.flatnonzero(np.diff(group[start:stop]))
            cuts = [start, *ends.tolist(), stop]
            if len(cuts) > 2:
                waiting += [(a, b, False) for a, b in pairwise(cuts)]
    return sorted(found, key=lambda each: each.start)


def _raster(places: Complexes, start: int, stop: int) -> Raster | None:
    """The longest stretch between two places, if one is long enough."""
    steps = np.diff(places[start:stop])
    usual = complex(np.median(steps.real), np.median(steps.imag))
    if abs(usual) == 0:
        return None
    # In steps: along the line, and across.
    local = np.asarray(places[start:stop] / usual, np.complex128)
    ahead = np.diff(local)
    count = np.rint(ahead.real)
    on = (np.abs(ahead - count) <= NEAR) & (count >= 1)
    first = np.concatenate([[0], np.flatnonzero(~on) + 1])
    lines = _regular_lines(local[first])
    if lines is None:
        return None
    low, high = int(first[lines[0]]), [*first.tolist(), len(local)][lines[1]]
    own = (first >= low) & (first < high)
    return _on_nodes(local[low:high], first[own] - low, start + low)


def _regular_lines(first: Complexes) -> tuple[int, int] | None:
    """The longest stretch of lines, by their first places (m,), that lie evenly apart."""
    if len(first) < LINES:
        return None
    apart = np.diff(first.imag)
    usual = float(np.median(apart))
    if abs(usual) < NEAR:
        return None
    count = np.rint(apart / usual)
    even = (np.abs(apart - count * usual) <= NEAR * max(1.0, abs(usual))) & (count >= 1)
    cuts = np.concatenate([[0], np.flatnonzero(~even) + 1, [len(first)]])
    longest = int(np.argmax(np.diff(cuts)))
    low, high = int(cuts[longest]), int(cuts[longest + 1])
    return (low, high) if high - low >= LINES else None


def _on_nodes(local: Complexes, first: Integers, start: int) -> Raster | None:
    """The nodes of places in units of steps; first: (m,) where each line begins."""
    line = np.zeros(len(local), np.int64)
    line[first] = 1
    line = np.cumsum(line) - 1
    height = np.diff(local.imag[first])
    even = float(np.median(height))
    j = np.concatenate([[0], np.cumsum(np.rint(height / even))])[line]
    shifted = local.real - _shift(local.real[first], j[first], np.bincount(line))[line]
    i = np.rint(shifted)
    if np.abs(shifted - i).max() > 2 * NEAR:
        return None
    i = (i - i.min()).astype(np.int64)
    across = int(i.max()) + 1
    node = i + across * j.astype(np.int64)
    total = int(node[-1]) - int(node[0]) + 1
    if across < MEMBERS or (np.diff(node) <= 0).any() or len(local) < max(LEAST, FULL * total):
        return None
    return Raster(start, start + len(local), across, node)


def _shift(first: Floats, j: Floats, members: Integers) -> Floats:
    """(m,) where the nodes of each line lie, a share of a step: all alike, every second line
    alike, or further by the same share from each line to the next.
    """
    lead = int(np.argmax(members))
    off = first - first[lead]
    off = off - np.rint(off)  # in [-0.5, 0.5]
    odd = (j - j[lead]) % 2
    if np.abs(off).max(initial=0.0) <= NEAR:
        return np.full(len(first), first[lead])
    apart = off[odd == 1]
    apart = np.abs(apart) if np.abs(apart).min(initial=1.0) > 0.5 - NEAR else apart  # a half
    if np.abs(off[odd == 0]).max(initial=0.0) <= NEAR and np.ptp(apart) <= 2 * NEAR:
        return np.asarray(first[lead] + odd * float(np.median(apart)))
    turn = np.diff(first) / np.maximum(np.diff(j), 1)
    each = float(np.median(turn - np.rint(turn)))
    return np.asarray(first[lead] + each * (j - j[lead]))
