"""When the corners of a region meet what.

In go the corners of a region at a moment; out comes the first later moment at which a segment
has lost its length or a corner has run into a segment, with all the contacts of that moment. It
never changes a corner or a link.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.skeleton_lines import Corner, Lines
from ipmlang.geometry.solid import Floats

STILL = 1e-12  # a speed below this is rounding
FEW = 1 << 16  # pairs of corners and segments that are all looked at
FLAT = 1e-3  # corners this straight are looked at when opposite sides fall together


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
    waits = np.where(growth < -STILL, np.maximum(length, 0) / np.maximum(-growth, STILL), inf)
    closing = int(waits.argmin())
    wait = float(waits[closing])
    sunk = _Sinking(front, length, growth, reach, wait)
    hit = sunk.first(wait)
    if hit is not None:
        wait = hit[0]
    if wait == inf:
        return None
    (short,) = (length + wait * growth <= reach).nonzero()
    pairs = dict(zip(short.tolist(), front.on[short].tolist(), strict=True))
    touches = sunk.touches(wait)
    if hit is None:
        pairs[closing] = int(front.on[closing])
    elif (hit[1], hit[2]) not in {(a, b) for a, b, _, _ in touches}:
        touches.append(hit[1:])
    return Contacts(time + wait, list(pairs.items()), touches)


class _Sinking:
    """How corners that are not convex sink towards segments: pairs of them (p,) that may meet up to
    a moment.
    """

    def __init__(
        self, front: _Front, length: Floats, growth: Floats, reach: float, before: float
    ) -> None:
        self.front, self.length, self.growth, self.reach = front, length, growth, reach
        (rows,) = (front.turn < FLAT).nonzero()
        if len(rows) * len(length) <= FEW or before == inf:
            self.corner = np.repeat(rows, len(length))
            self.segment = np.tile(np.arange(len(length)), len(rows))
        else:
            self.corner, self.segment = _near(front, rows, reach, before)
        # What starts at one node parts at once and for good: one is never the other's obstacle.
        node, corner, segment = front.node, self.corner, self.segment
        apart = (node[corner] != node[segment]) & (node[corner] != node[front.on[segment]])
        corner, segment = self.corner, self.segment = corner[apart], segment[apart]
        dx, dy = front.dx[segment], front.dy[segment]
        self.height = front.y[corner] * dx - front.x[corner] * dy - front.level[segment]
        self.rise = front.vy[corner] * dx - front.vx[corner] * dy - front.speed[segment]

    def first(self, before: float) -> tuple[float, int, int, float, float] | None:
        """The first touch up to a moment: wait, corner, segment, how far along, its length."""
        reach = self.reach
        falls = (self.rise < -STILL) & (self.height > -reach)
        if before < inf:
            falls &= self.height <= -self.rise * before
        falls &= self.front.turn[self.corner] < STILL
        (pair,) = falls.nonzero()
        if not len(pair):
            return None
        wait = np.maximum(self.height[pair] / -self.rise[pair], 0)
        along, length = self._along(self.corner[pair], self.segment[pair], wait)
        (on,) = ((along >= -reach) & (along <= length + reach) & (length >= -reach)).nonzero()
        if not len(on):
            return None
        at = int(on[wait[on].argmin()])
        corner, segment = int(self.corner[pair[at]]), int(self.segment[pair[at]])
        return float(wait[at]), corner, segment, float(along[at]), float(length[at])

    def touches(self, wait: float) -> list[tuple[int, int, float, float]]:
        """All corners that lie on segments after a wait."""
        (pair,) = (np.abs(self.height + wait * self.rise) <= self.reach).nonzero()
        if not len(pair):
            return []
        corner, segment = self.corner[pair], self.segment[pair]
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


def _near(
    front: _Front, rows: NDArray[np.intp], reach: float, before: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of corners and segments whose ways up to a moment come near each other: by the boxes
    around all that each passes over.
    """
    import shapely

    x, y = front.x, front.y
    then_x, then_y = x + before * front.vx, y + before * front.vy
    low = np.stack([np.minimum(x, then_x), np.minimum(y, then_y)]) - 2 * reach
    high = np.stack([np.maximum(x, then_x), np.maximum(y, then_y)]) + 2 * reach
    on = front.on
    segments = shapely.box(*np.minimum(low, low[:, on]), *np.maximum(high, high[:, on]))
    corners = shapely.box(*low[:, rows], *high[:, rows])
    corner, segment = shapely.STRtree(segments).query(corners)
    order = np.lexsort([segment, corner])
    return rows[corner[order]], segment[order]
