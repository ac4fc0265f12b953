"""Circles of what is not turned: the gondolas of a wheel, posts about a well that all stand square.

Takes points of symbols that are turned alike; gives circles about the axes with their members, as
directions of arrays. Found by the circles through points and the two nearest to them; nothing here
counts tokens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.expansion import offsets
from ipmlang.inverse.split.scheme import Direction
from ipmlang.inverse.split.snapping import label_rows, members, snap_columns

FEWEST = 5  # members; of a square there are four
SLACK = 64.0  # times the error that centers found from three points may be apart
NARROWEST = 2.0  # degrees of a step
WHOLE = 0.05  # members more or less in a full turn that do not count
MISSING = 0.25  # of the members of a circle, that may be
PLANES = ((1, 2, 1.0), (0, 2, -1.0), (0, 1, 1.0))
"""By axis: the coordinates that turn, and which way about it the first turns to the second."""


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """rows (k,) of points, in the order of their members; first (3,): where the first stands, which
    may be missing; holes: members that are.
    """

    rows: Integers
    first: Floats
    direction: Direction
    holes: frozenset[tuple[int, ...]]


def circles(points: Floats, error: float) -> Iterator[Circle]:
    """Circles of points (n, 3) in planes square to the axes; error: what they may be off, units."""
    for axis, (u, v, sign) in enumerate(PLANES):
        if len(points) < FEWEST:
            return
        label, count = label_rows(snap_columns(points[:, axis : axis + 1], 2 * error))
        for rows in members(label, len(count)):
            if len(rows) < FEWEST:
                continue
            flat = points[rows][:, [u, v]]
            for center in _centers(flat, error):
                found = _around(flat, center, error)
                if found is not None:
                    yield _circle(points[rows], rows, (axis, u, v, sign), found, error)


def _centers(flat: Floats, error: float) -> list[Floats]:
    """Where the circles through points (m, 2) and those nearest to them have their centers, if
    enough of them agree.
    """
    from scipy.spatial import cKDTree

    told = cKDTree(flat).query(flat, k=3)
    far, near = np.asarray(told[0]), np.asarray(told[1])
    arms = flat[near[:, 1:]] - flat[:, None]
    cross = arms[:, 0, 0] * arms[:, 1, 1] - arms[:, 0, 1] * arms[:, 1, 0]
    even = (np.abs(far[:, 1] - far[:, 2]) <= 8 * error) & (far[:, 1] > 8 * error)
    good = np.flatnonzero(even & (np.abs(cross) > 1e-3 * far[:, 1] ** 2))
    if len(good) < FEWEST:
        return []
    square = (arms[good] ** 2).sum(axis=2)
    one, two = arms[good, 0], arms[good, 1]
    away = square[:, :1] * two[:, ::-1] - square[:, 1:] * one[:, ::-1]
    middle = flat[good] + away * [1.0, -1.0] / (2 * cross[good, None])
    label, count = label_rows(snap_columns(middle, SLACK * error))
    return [middle[rows].mean(axis=0) for rows in members(label, len(count))
            if len(rows) >= FEWEST]  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """rows (k,) of points about a center (2,), at these digits (k,); of `count` members, the first
    at an angle in degrees, others by steps of `step` beyond it.
    """

    rows: Integers
    digits: Integers
    count: int
    center: Floats
    radius: float
    angle: float
    step: float


def _around(flat: Floats, center: Floats, error: float) -> _Around | None:
    """The members of a circle of points (m, 2), None where they do not go round evenly."""
    radii = np.linalg.norm(flat - center, axis=1)
    usual = np.flatnonzero(np.abs(radii - _most(radii, SLACK * error)) <= SLACK * error)
    if len(usual) < FEWEST:
        return None
    own = flat[usual]
    known = np.column_stack([2 * own, np.ones(len(own))])
    solved = np.linalg.lstsq(known, (own**2).sum(axis=1), rcond=None)[0]
    center = np.array([shortest(each, error / 16) for each in solved[:2].tolist()])
    radius = shortest(float(np.linalg.norm(own - center, axis=1).mean()), error / 16)
    turned = np.degrees(np.arctan2(*(own - center).T[::-1]))
    order = np.argsort(turned, kind="stable")
    gaps = np.diff(np.append(turned[order], turned[order[0]] + 360))
    step, room = float(gaps.min()), float(np.degrees(error / radius))
    if step < NARROWEST:
        return None
    whole = round(360 / step)
    closed = abs(360 / step - whole) < WHOLE
    begin = _begin(turned[order], room) if closed and len(own) == whole else _behind(gaps)
    order = np.roll(order, -begin)
    after = (turned[order] - turned[order[0]]) % 360
    digits = np.rint(after / step).astype(np.int64)
    count = int(digits[-1]) + 1
    if len(np.unique(digits)) < len(digits) or count - len(digits) > MISSING * count:
        return None
    fine = 360 / whole if closed else float(digits @ after / (digits @ digits))
    fine = fine if closed else shortest(fine, room / (4 * count))
    apart = (turned[order] - fine * digits - turned[order[0]] + 180) % 360 - 180
    angle = shortest(float(turned[order[0]] + apart.mean()), room / 8)
    return _Around(usual[order], digits, count, center, radius, angle, fine)


def _most(values: Floats, gap: float) -> float:
    """The value that most of some are near to."""
    label, count = label_rows(snap_columns(values[:, None], gap))
    return float(values[label == np.argmax(count)].mean())


def _begin(turned: Floats, room: float) -> int:
    """The member with which a full circle begins: at a quarter if there is one, to the right."""
    quarter = np.abs((turned + 45) % 90 - 45) <= 8 * room
    return int(np.lexsort((np.abs(turned), ~quarter))[0])


def _behind(gaps: Floats) -> int:
    """The member behind the widest gap."""
    return (int(np.argmax(gaps)) + 1) % len(gaps)


def _circle(
    points: Floats, rows: Integers, plane: tuple[int, int, int, float], own: _Around, error: float
) -> Circle:
    axis, u, v, sign = plane
    arm, first, about = np.zeros(3), np.zeros(3), np.zeros(3)
    turned = np.radians(own.angle)
    arm[[u, v]] = own.radius * np.array([np.cos(turned), np.sin(turned)])
    first[[u, v]] = own.center + arm[[u, v]]
    first[axis] = shortest(float(points[own.rows, axis].mean()), error / 8)
    about[axis] = sign
    direction = Direction(own.count, arm, angle=own.step, axis=about)
    there = set(own.digits.tolist())
    holes = frozenset((k,) for k in range(own.count) if k not in there)
    return Circle(rows[own.rows], first, direction, holes)


def apart(points: Floats, found: Circle) -> float:
    """How far the members of a circle are at most from the points (n, 3) that they stand for."""
    kept = [k for k in range(found.direction.count) if (k,) not in found.holes]
    there = found.first + offsets(found.direction)[kept]
    return float(np.linalg.norm(there - points[found.rows], axis=1).max())
