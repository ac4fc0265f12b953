"""Moving lines, the corners between them, and when the corners of a region meet what.

In go the corners of a region at a moment; out comes the first later moment at which a segment
has lost its length or a corner has run into a segment, with all the contacts of that moment. It
never changes a corner or a link.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats

STILL = 1e-12  # a speed below this is rounding
FLAT = 1e-3  # corners this straight are looked at when opposite sides fall together


class Lines:
    """Lines that move to their left: (-dy, dx) . p = offset + speed * time, (dx, dy) of length 1.

    The columns are lists for one line at a time; `table` has them as an array (5, n) of rows.
    """

    def __init__(self) -> None:
        self.dx: list[float] = []
        self.dy: list[float] = []
        self.offset: list[float] = []
        self.speed: list[float] = []
        self._table: Floats | None = None

    def add(self, dx: float, dy: float, x: float, y: float, speed: float) -> int:
        """A line along (dx, dy) that is at (x, y) at time 0; its number."""
        self.dx.append(dx)
        self.dy.append(dy)
        self.offset.append(dx * y - dy * x)
        self.speed.append(speed)
        self._table = None
        return len(self.dx) - 1

    @property
    def table(self) -> Floats:
        """Rows dx, dy, offset, speed, a column for each line."""
        if self._table is None:
            self._table = np.array([self.dx, self.dy, self.offset, self.speed])
        return self._table

    def sine(self, one: int, other: int) -> float:
        """Of the angle from one line to another."""
        return self.dx[one] * self.dy[other] - self.dy[one] * self.dx[other]

    def cosine(self, one: int, other: int) -> float:
        """Of the angle between two lines."""
        return self.dx[one] * self.dx[other] + self.dy[one] * self.dy[other]

    def crossing(self, one: int, other: int, time: float) -> tuple[float, float]:
        """Where two lines cross at a moment."""
        sine = self.sine(one, other)
        a = (self.offset[one] + self.speed[one] * time) / sine
        b = (self.offset[other] + self.speed[other] * time) / sine
        return a * self.dx[other] - b * self.dx[one], a * self.dy[other] - b * self.dy[one]

    def velocity(self, one: int, other: int) -> tuple[float, float] | None:
        """How fast the crossing of two lines moves; None where they are parallel.

        Lines of nearly one direction move it along the sum of their normals, which is well known
        where their sine is not; other lines are solved for.
        """
        sine, cosine = self.sine(one, other), self.cosine(one, other)
        a, b = self.speed[one], self.speed[other]
        if cosine > 0:
            mean = (a + b) / 2 / (1 + cosine)
            part = 0.0 if a == b else (b - a) / 2 * (1 + cosine) / (sine * sine)
            return (
                -mean * (self.dy[one] + self.dy[other]) - part * (self.dy[other] - self.dy[one]),
                mean * (self.dx[one] + self.dx[other]) + part * (self.dx[other] - self.dx[one]),
            )
        if sine == 0:
            return None
        return (
            (a * self.dx[other] - b * self.dx[one]) / sine,
            (a * self.dy[other] - b * self.dy[one]) / sine,
        )


@dataclass(slots=True, eq=False)
class Corner:
    """A corner of the wavefront, at (x, y) since `time`: line `before` ends, `after` begins.

    uneven: its lines lie in one, at unequal speeds. number is its place in its region, back and on
    are its neighbours along the wavefront.
    """

    node: int
    before: int
    after: int
    x: float
    y: float
    time: float
    vx: float
    vy: float
    uneven: bool = False
    number: int = -1
    back: Corner = field(init=False, repr=False)
    on: Corner = field(init=False, repr=False)

    def at(self, time: float) -> tuple[float, float]:
        """Where the corner is at a moment."""
        wait = time - self.time
        return self.x + wait * self.vx, self.y + wait * self.vy


@dataclass(slots=True)
class Contacts:
    """What meets at a moment.

    pairs: numbers of two corners that meet; touches: a corner, the segment (by its first corner)
    that it lies on, how far along it, and the segment's length.
    """

    time: float
    pairs: list[tuple[int, int]]
    touches: list[tuple[int, int, float, float]]


@dataclass(slots=True)
class _Front:
    """The corners of a region as columns (n,), at one moment; segments begin at the corners."""

    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    dx: Floats
    dy: Floats
    level: Floats
    speed: Floats
    turn: Floats
    on: NDArray[np.intp]
    node: NDArray[np.intp]


def _front(lines: Lines, corners: list[Corner], time: float) -> _Front:
    rows = np.array(
        [(c.x, c.y, c.time, c.vx, c.vy, c.before, c.after, c.on.number, c.node) for c in corners]
    ).T
    wait = time - rows[2]
    before, after, on, node = rows[5:].astype(np.intp)
    table = lines.table
    dx, dy, offset, speed = table[:, after]
    return _Front(
        rows[0] + wait * rows[3],
        rows[1] + wait * rows[4],
        rows[3],
        rows[4],
        dx,
        dy,
        offset + speed * time,
        speed,
        table[0, before] * dy - table[1, before] * dx,
        on,
        node,
    )


def next_contacts(
    lines: Lines, corners: list[Corner], time: float, reach: float
) -> Contacts | None:
    """All contacts of the first moment that has one, or None; nearer than `reach` is contact."""
    front = _front(lines, corners, time)
    length = (front.x[front.on] - front.x) * front.dx + (front.y[front.on] - front.y) * front.dy
    growth = (front.vx[front.on] - front.vx) * front.dx
    growth += (front.vy[front.on] - front.vy) * front.dy
    shrinks = growth < -STILL
    waits = np.full(len(length), inf)
    waits[shrinks] = np.maximum(length[shrinks], 0) / -growth[shrinks]
    closing = int(waits.argmin())
    wait = float(waits[closing])
    sunk = _Sinking(front, length, growth, reach)
    hit = sunk.first(wait)
    if hit is not None:
        wait = hit[0]
    if wait == inf:
        return None
    pairs = {int(k): int(front.on[k]) for k in np.flatnonzero(length + wait * growth <= reach)}
    touches = sunk.touches(wait)
    if hit is None:
        pairs[closing] = int(front.on[closing])
    elif (hit[1], hit[2]) not in {(a, b) for a, b, _, _ in touches}:
        touches.append(hit[1:])
    return Contacts(time + wait, list(pairs.items()), touches)


class _Sinking:
    """How corners that are not convex sink towards the segments (r, n)."""

    def __init__(self, front: _Front, length: Floats, growth: Floats, reach: float) -> None:
        self.front, self.length, self.growth, self.reach = front, length, growth, reach
        self.rows = np.flatnonzero(front.turn < FLAT)
        rows = self.rows
        if not len(rows):
            return
        x, y, vx, vy = (column[rows, None] for column in (front.x, front.y, front.vx, front.vy))
        self.height = y * front.dx - x * front.dy - front.level
        self.rise = vy * front.dx - vx * front.dy - front.speed
        # What starts at one node parts at once and for good: one is never the other's obstacle.
        node = front.node[rows, None]
        self.height[(node == front.node) | (node == front.node[front.on])] = inf

    def first(self, before: float) -> tuple[float, int, int, float, float] | None:
        """The first touch up to a moment: wait, corner, segment, how far along, its length."""
        if not len(self.rows):
            return None
        front, reach = self.front, self.reach
        falls = (self.rise < -STILL) & (self.height > -reach)
        if before < inf:
            falls &= self.height <= -self.rise * before
        falls &= (front.turn[self.rows] < STILL)[:, None]
        row, segment = np.nonzero(falls & (self.height < inf))
        if not len(row):
            return None
        wait = np.maximum(self.height[row, segment] / -self.rise[row, segment], 0)
        along, length = self._along(self.rows[row], segment, wait)
        on = np.flatnonzero((along >= -reach) & (along <= length + reach) & (length >= -reach))
        if not len(on):
            return None
        at = int(on[wait[on].argmin()])
        corner = int(self.rows[row[at]])
        return float(wait[at]), corner, int(segment[at]), float(along[at]), float(length[at])

    def touches(self, wait: float) -> list[tuple[int, int, float, float]]:
        """All corners that lie on segments after a wait."""
        if not len(self.rows):
            return []
        with np.errstate(invalid="ignore"):
            near = np.abs(self.height + wait * self.rise) <= self.reach
        row, segment = np.nonzero(near)
        if not len(row):
            return []
        corner = self.rows[row]
        along, length = self._along(corner, segment, np.float64(wait))
        on = (along >= -self.reach) & (along <= length + self.reach)
        columns = (corner[on], segment[on], along[on], length[on])
        return list(zip(*(column.tolist() for column in columns), strict=True))

    def _along(
        self, corner: NDArray[np.intp], segment: NDArray[np.intp], wait: Floats | np.float64
    ) -> tuple[Floats, Floats]:
        """How far along segments corners are after waits, and the segments' lengths then."""
        front = self.front
        x = front.x[corner] - front.x[segment] + wait * (front.vx[corner] - front.vx[segment])
        y = front.y[corner] - front.y[segment] + wait * (front.vy[corner] - front.vy[segment])
        along = x * front.dx[segment] + y * front.dy[segment]
        return along, self.length[segment] + wait * self.growth[segment]
