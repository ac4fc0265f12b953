"""What a wavefront is made of: moving lines, corners between them, and regions that corners bound.

In go linked corners; out come the loops that they form and the regions that these bound. Nothing
moves here: see `skeleton_contacts` for when things meet and `skeleton_wavefront` for what follows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan2

import numpy as np

from ipmlang.geometry.solid import Floats


class BrokenError(Exception):
    """The wavefront contradicts itself: try again with other tolerances."""


class OpenError(BrokenError):
    """A part of the polygon is never reached: all that is left around it stands still."""


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
class Region:
    """A connected part of what the wavefront has not reached, at a moment."""

    time: float
    corners: list[Corner]


def regions_of(lines: Lines, time: float, corners: list[Corner]) -> list[Region]:
    """The regions that linked corners bound; numbers the corners within them."""
    loops = loops_of(corners)
    if len(loops) > 1:
        left = [_turns_left(lines, loop) for loop in loops]
        outer = [loop for loop, yes in zip(loops, left, strict=True) if yes]
        inner = [loop for loop, yes in zip(loops, left, strict=True) if not yes]
    else:
        outer, inner = loops, []
    found = [list(loop) for loop in outer] or [[]]
    for hole in inner:
        best = 0
        if len(outer) > 1:
            counts = [_count_inside(hole, loop, time) for loop in outer]
            best = max(range(len(outer)), key=lambda k: (counts[k], -len(outer[k])))
        found[best].extend(hole)
    regions = [Region(time, each) for each in found if each]
    for region in regions:
        for number, corner in enumerate(region.corners):
            corner.number = number
    return regions


def loops_of(corners: list[Corner]) -> list[list[Corner]]:
    """The loops that linked corners form."""
    for corner in corners:
        corner.number = -1
    loops: list[list[Corner]] = []
    for corner in corners:
        if corner.number >= 0:
            continue
        loop: list[Corner] = []
        while corner.number < 0:
            corner.number = len(loop)
            loop.append(corner)
            corner = corner.on
        if corner is not loop[0] or len(loop) < 3:
            raise BrokenError("the wavefront does not close")
        loops.append(loop)
    return loops


def _turns_left(lines: Lines, loop: list[Corner]) -> bool:
    """Whether a loop runs counter-clockwise; directions say so of the smallest loop, too."""
    pairs = ((corner.before, corner.after) for corner in loop)
    return sum(atan2(lines.sine(*pair), lines.cosine(*pair)) for pair in pairs) > 0


def _count_inside(hole: list[Corner], loop: list[Corner], time: float) -> int:
    """How many corners of a hole lie within a loop (a ray to the right crosses it oddly)."""
    points = [corner.at(time) for corner in loop]
    count = 0
    for x, y in (corner.at(time) for corner in hole):
        odd = False
        for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1], strict=True):
            if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                odd = not odd
        count += odd
    return count
