"""Copies of one symbol that can be asked what stands at a frame.

In come frames and the symmetries of the shape; every copy stands at all the frames that its shape
cannot tell apart. Questions about many frames are answered at once through a tree of positions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Frames, compose, inverse
from ipmlang.inverse.recursion.strokes import Integers

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

CROWD = 8  # so many copies may stand at one place


def between(outer: Frames, inner: Frames) -> Frames:
    """Frames `inner` as seen from `outer`, row by row."""
    return compose(inverse(outer), inner)


@dataclass(slots=True, eq=False)
class Nodes:
    """every: (n * k,) the equivalent frames, those of one copy together; count: n; each: k; own:
    (n,) the first frame of each; places: a tree of all positions.
    """

    every: Frames
    count: int
    each: int
    free: bool
    radius: float
    tolerance: float
    own: Frames
    places: cKDTree

    def at(self, wanted: Frames) -> Integers:
        """(m, CROWD) rows of `every` that stand at the frames, -1 where there are fewer."""
        at = np.stack([wanted.x, wanted.y], axis=1)
        crowd = min(CROWD * self.each, len(self.every))
        bound = self.tolerance * 1.0000001
        _, found = self.places.query(at, k=list(range(1, crowd + 1)), distance_upper_bound=bound)
        rows = np.asarray(found, np.int64)
        there = rows < len(self.every)
        rows = np.where(there, rows, 0)
        return np.where(there & self._faces(wanted, rows), rows, -1)

    def _faces(self, wanted: Frames, rows: Integers) -> NDArray[np.bool_]:
        factor, seen = wanted.factor[:, None], self.every.factor[rows]
        if self.free:
            near = np.abs(np.abs(factor) - np.abs(seen)) * self.radius <= self.tolerance
            return np.asarray(near)
        near = np.abs(factor - seen) * self.radius <= self.tolerance
        return np.asarray(near & (wanted.handedness[:, None] == self.every.handedness[rows]))

    def match(self, wanted: Frames) -> Integers | None:
        """(m,) different copies that stand at the frames, None if any is missing."""
        rows = self.at(wanted)
        if np.any(np.all(rows < 0, axis=1)):
            return None
        copies = np.where(rows < 0, -1, rows // self.each)
        first = copies[np.arange(len(copies)), np.argmax(rows >= 0, axis=1)]
        if len(np.unique(first)) == len(first):
            return np.asarray(first, np.int64)
        return _different(copies)

    def facing(self, copies: Integers, wanted: Frames) -> Frames:
        """The frames of the copies, of those equivalent the ones nearest to what is wanted."""
        rows = copies[:, None] * self.each + np.arange(self.each)
        every = self.every[rows]
        gap = np.abs(every.position - wanted.position[:, None])
        gap += np.abs(every.factor - wanted.factor[:, None]) * self.radius
        gap += 1e300 * (every.handedness != wanted.handedness[:, None])
        if self.free:
            gap = np.abs(every.position - wanted.position[:, None])
        best = self.every[rows[np.arange(len(rows)), np.argmin(gap, axis=1)]]
        if not self.free:
            return best
        return Frames(best.x, best.y, wanted.angle, best.scale, wanted.handedness)

    def largest_gap(self, wanted: Frames, copies: Integers) -> float:
        """Units that the copies' points are off the wanted frames, at most."""
        seen = self.facing(copies, wanted)
        gap = np.abs(seen.position - wanted.position)
        gap = gap + np.abs(seen.factor - wanted.factor) * self.radius
        return float(gap.max())


def _different(copies: Integers) -> Integers | None:
    """One copy for each row, none twice, taken in order."""
    used: set[int] = set()
    taken = []
    for row in copies.tolist():
        mine = next((copy for copy in row if copy >= 0 and copy not in used), None)
        if mine is None:
            return None
        used.add(mine)
        taken.append(mine)
    return np.array(taken, np.int64)


def make_nodes(
    placed: Frames, stabiliser: Frames, free: bool, radius: float, tolerance: float
) -> Nodes:
    """Copies at `placed` (n,) of a shape that `stabiliser` (k,) keeps."""
    from scipy.spatial import cKDTree

    known = stabiliser[:1] if free else stabiliser
    every = compose(placed[:, None], known[None, :])
    each = len(known)
    copy, kept = np.divmod(np.arange(len(placed) * each), each)
    flat = every[copy, kept]
    places = cKDTree(np.stack([flat.x, flat.y], axis=1))
    return Nodes(flat, len(placed), each, free, radius, tolerance, placed, places)
