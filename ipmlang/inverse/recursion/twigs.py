"""One branch of a branching rule as numbers, and what a few of them grow into.

A twig's step is +(turn) f(length) *(scale) +(spin) with four numbers that may change evenly with
the depth m. `grow` derives a structure generation by generation in batches; `fitted` takes the
numbers from all pairs that the structure explains. Nothing here looks at what is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, frames, join, unit, wrap
from ipmlang.inverse.recursion.nodes import between
from ipmlang.inverse.recursion.strokes import Integers

TURN, LENGTH, SCALE, SPIN = range(4)
MANY = 1 << 40  # nodes, which nobody asks for


@dataclass(frozen=True, slots=True, eq=False)
class Twig:
    """first: (4,) turn, length, scale, spin at m = 0 (degrees, units of the parent, factor,
    degrees); slope: (4,) their change for m + 1; hand: -1 if the child is mirrored; less: what the
    child's m is smaller by.
    """

    first: Floats
    slope: Floats
    hand: int
    less: int


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """Nodes by generation: frames (n,), depth m (n,), parent (n,) -1 at the root, twig (n,) by
    which each grew, offset (n,) its place in the order of derivation.
    """

    frames: Frames
    depth: Integers
    parent: Integers
    twig: Integers
    offset: Integers

    def preorder(self) -> Integers:
        """The nodes in the order of derivation."""
        return np.argsort(self.offset, kind="stable")


def steps_of(relative: Frames) -> Floats:
    """(n, 4) turn, length, scale, spin of frames relative to their parents; a step without length
    has no turn.
    """
    length = np.abs(relative.position)
    still = length <= 1e-9 * np.maximum(relative.scale, 1e-9)
    turn = np.where(still, 0.0, np.angle(relative.position, deg=True))
    return np.stack([turn, length, relative.scale, wrap(relative.angle - turn)], axis=1)


def frames_of(steps: Floats, hand: int) -> Frames:
    """The frames relative to the parents, from steps (n, 4)."""
    turn, length, scale, spin = steps.T
    return frames(length * unit(turn), turn + spin, scale, hand)


def grow(root: Frames, twigs: list[Twig], depth: int, most: int) -> Grown | None:
    """The structure of `depth` generations, None if it has more than `most` nodes."""
    sizes = np.array(node_counts([twig.less for twig in twigs], depth), np.int64)
    if sizes[depth] > most:
        return None
    parts, now, base = [(root, *_root(depth))], 0, 0
    while now < len(parts):
        placed, levels, _, _, offset = parts[now]
        before = np.ones(len(levels), np.int64)
        for number, twig in enumerate(twigs):
            rows = np.flatnonzero(levels >= twig.less)
            if len(rows):
                steps = twig.first + twig.slope * levels[rows, None]
                if np.any(steps[:, SCALE] <= 0):
                    return None
                inner = compose(placed[rows], frames_of(steps, twig.hand))
                left = levels[rows] - twig.less
                kind = np.full(len(rows), number, np.int64)
                parts.append((inner, left, rows + base, kind, offset[rows] + before[rows]))
                before[rows] += sizes[left]
        base += len(levels)
        now += 1
    columns = [np.concatenate([part[k] for part in parts]) for k in range(1, 5)]
    return Grown(join([part[0] for part in parts]), *columns)


def _root(depth: int) -> tuple[Integers, Integers, Integers, Integers]:
    none, zero = np.array([-1], np.int64), np.zeros(1, np.int64)
    return np.array([depth], np.int64), none, none, zero


def node_counts(decreases: Sequence[int], depth: int) -> list[int]:
    """How many nodes there are below and with a node of each m up to `depth`, where the branches
    take so much from m.
    """
    counts = [1]
    for level in range(1, depth + 1):
        below = [counts[level - less] for less in decreases if less <= level]
        counts.append(min(1 + sum(below), MANY))
    return counts


def fitted(twigs: list[Twig], grown: Grown, seen: Frames, depth: int) -> list[Twig]:
    """The twigs with numbers that fit all their pairs best. seen: (n,) what stands at the nodes."""
    result = []
    for number, twig in enumerate(twigs):
        rows = np.flatnonzero(grown.twig == number)
        parent = grown.parent[rows]
        steps = steps_of(between(seen[parent], seen[rows]))
        level = grown.depth[parent].astype(np.float64)
        guess = twig.first + twig.slope * level[:, None]
        gap = steps - guess
        gap[:, [TURN, SPIN]] = wrap(gap[:, [TURN, SPIN]])
        slope = np.zeros(4)
        if np.any(twig.slope) and np.ptp(level) > 0:
            middle = level - level.mean()
            slope = (middle[:, None] * gap).sum(axis=0) / float((middle**2).sum())
        first = twig.first + gap.mean(axis=0) - slope * level.mean()
        result.append(Twig(first, twig.slope + slope, twig.hand, twig.less))
    return result


def rounded(twig: Twig, places: int) -> Twig:
    """With fewer digits, those of the scale relative to 1."""
    digits = np.array([places, places, places + 2, places])
    first = [round(float(v), int(d)) for v, d in zip(twig.first, digits, strict=True)]
    slope = [round(float(v), int(d) + 1) for v, d in zip(twig.slope, digits, strict=True)]
    return Twig(np.array(first), np.array(slope), twig.hand, twig.less)
