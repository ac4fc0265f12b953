"""Straight segments in paint order, and the letters that say how each follows the one before.

In come start and end points; headings and lengths that are equal but for the rounding of points are
made equal. Out goes one letter per joint, equal where the step from one segment to the next (jump,
turn and ratio of lengths, all seen from the first) is equal. The same joints are also spelt as a
mirror sees them, and as one who walks backwards does. Nothing here searches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Complexes, Floats

FAR = 0.5  # of a segment's own slack, which its mean heading has less of
Integers = NDArray[np.int64]

PLAIN, MIRRORED, REVERSED, BOTH = 0, 1, 2, 3


@dataclass(frozen=True, slots=True, eq=False)
class Strokes:
    """start, end: (n,) x + iy; along: (n,) heading and length as one number, without the noise of
    the points; tolerance: units that a point may be off; grain: what coordinates were rounded to,
    units, 0 for nothing.
    """

    start: Complexes
    end: Complexes
    along: Complexes
    tolerance: float
    grain: float = 0.0

    def __len__(self) -> int:
        return len(self.start)

    def part(self, first: int, count: int) -> Strokes:
        """`count` segments from `first` on."""
        span = slice(first, first + count)
        return Strokes(self.start[span], self.end[span], self.along[span], self.tolerance)

    def seen_as(self, variant: int) -> Strokes:
        """As a mirror in the x axis sees them, or one who walks backwards, or both; each undoes
        itself.
        """
        start, end, along = self.start, self.end, self.along
        if variant & REVERSED:
            start, end, along = end[::-1], start[::-1], -along[::-1]
        if variant & MIRRORED:
            start, end, along = start.conj(), end.conj(), along.conj()
        return Strokes(start, end, along, self.tolerance)

    @property
    def connected(self) -> bool:
        """Each segment starts where the one before ends: one curve."""
        return bool(np.all(np.abs(self.start[1:] - self.end[:-1]) <= self.tolerance))

    @property
    def longest_run(self) -> int:
        """How many segments follow each other straight on, at most."""
        follows = np.abs(self.start[1:] - self.end[:-1]) <= 2 * self.tolerance
        follows &= np.abs(np.diff(self.along)) <= 2 * self.tolerance
        breaks = np.flatnonzero(np.concatenate([[True], ~follows, [True]]))
        return int(np.diff(breaks).max())


def make_strokes(
    start: Complexes, end: Complexes, tolerance: float, grain: float = 0.0
) -> Strokes | None:
    """Segments start, end (n,); tolerance: share of the diagonal; grain: what coordinates were
    rounded to, units. None if one has no length.
    """
    points = np.concatenate([start, end])
    extent = complex(np.ptp(points.real), np.ptp(points.imag))
    slack = tolerance * abs(extent)
    along = end - start
    length = np.abs(along)
    if float(length.min()) <= 4 * slack:
        return None
    size = _mean(length, clustered(length, slack))
    return Strokes(start, end, size * _headings(along / length, slack / length), slack, grain)


def _headings(direction: Complexes, slack: Floats) -> Complexes:
    """(n,) directions, those that are equal within their slack (radians) replaced by their mean."""
    angle = np.angle(direction)
    order = np.sort(angle)
    gaps = np.diff(order, append=order[0] + 2 * np.pi)
    cut = order[int(np.argmax(gaps))]
    kind = clustered(np.mod(angle - cut - 1e-9, 2 * np.pi), slack)
    mean = np.array(_mean(direction.real, kind) + 1j * _mean(direction.imag, kind))
    return np.asarray(mean / np.abs(mean), np.complex128)


def _mean(values: Floats, kind: Integers) -> Floats:
    """(n,) the mean of each value's kind."""
    return np.asarray((np.bincount(kind, values) / np.bincount(kind))[kind], np.float64)


def letters(strokes: Strokes) -> list[Integers]:
    """Four spellings (n - 1,) of the joints: plain, mirrored, reversed, both. Equal numbers mean
    equal joints, across the spellings too.
    """
    seen = [strokes.seen_as(variant) for variant in range(4)]
    every = np.concatenate([_joints(each) for each in seen])
    slack = np.concatenate([2 * strokes.tolerance / np.abs(each.along[:-1]) for each in seen])
    # A far jump is off by what the segment that it is measured with is off, so often.
    far = slack * (1 + FAR * np.hypot(every[:, 0], every[:, 1]))
    rooms = (far, far, slack, slack, slack)
    columns = [clustered(column, room) for column, room in zip(every.T, rooms, strict=True)]
    _, names = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    return np.split(names.ravel().astype(np.int64), 4)


def _joints(strokes: Strokes) -> Floats:
    """(n - 1, 5): jump, turn and ratio as seen from the segment before, in its length."""
    jump = (strokes.start[1:] - strokes.end[:-1]) / strokes.along[:-1]
    turn = strokes.along[1:] / strokes.along[:-1]
    size = np.abs(turn)
    turn = turn / size
    return np.stack([jump.real, jump.imag, turn.real, turn.imag, np.log(size)], axis=1)


def clustered(values: Floats, slack: Floats | float) -> Integers:
    """(n,) numbers that are equal where the values are, each within its slack to both sides."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    room = np.broadcast_to(np.asarray(slack, np.float64), values.shape)[order]
    reach = np.maximum.accumulate(ordered + room)
    result = np.zeros(len(values), np.int64)
    result[order[1:]] = np.cumsum(ordered[1:] - room[1:] > reach[:-1])
    return result
