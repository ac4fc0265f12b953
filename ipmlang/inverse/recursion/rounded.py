"""Placement of a recursion whose segments were rounded when they were written.

Takes a program and strokes whose coordinates stand on a grain; gives the program with a position, a
heading and a step from which rounding leads to every point that was given, or None. Least squares
come near, but a point in a hundred rounds to its neighbour: so what is looked for is a placement
that keeps all points within half a grain, a linear program of few unknowns.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.least_largest import least_largest_of_few
from ipmlang.inverse.lsystem.frames import Complexes, Floats
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.recursion.program import Recursion, expand
from ipmlang.inverse.recursion.strokes import Strokes

PLACES = 10
WITHIN = 0.5 - 1e-6  # of the grain: what no rounding of the last bit makes another point
SHARE = 0.499  # of the room around a middle that fewer digits may take
FIRST = 64  # points that the first linear program holds
ROUNDS = 12  # of adding the points that it moved too far


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """unit: (n,) points of the program at step 1 from the origin; given: (n,) where they are to
    be; room: what a coordinate may be off.
    """

    unit: Complexes
    given: Complexes
    room: float

    def turned(self, heading: float) -> _Points:
        """With the program turned by degrees."""
        turn = complex(np.exp(1j * np.deg2rad(heading)))
        return replace(self, unit=self.unit * turn)

    def step(self, at: complex) -> float | None:
        """A short step that leads from a position to all points, None if there is none."""
        unit = np.concatenate([self.unit.real, self.unit.imag])
        apart = np.concatenate([(self.given - at).real, (self.given - at).imag])
        still = np.abs(unit) < 1e-12
        if (np.abs(apart[still]) > self.room).any():
            return None
        ends = np.stack([apart[~still] - self.room, apart[~still] + self.room]) / unit[~still]
        low, high = float(ends.min(axis=0).max()), float(ends.max(axis=0).min())
        if low > high or high <= 0:
            return None
        return shortest((low + high) / 2, (high - low) * SHARE)


def placed_on_grain(placed: Recursion, strokes: Strokes) -> Recursion | None:
    """The program with the shortest placement that is found to round to the strokes."""
    drawn = expand(replace(placed, step=1.0, at=0j, heading=0.0))
    unit = np.concatenate([drawn.start, drawn.end])
    given = np.concatenate([strokes.start, strokes.end])
    points = _Points(unit, given, WITHIN * strokes.grain)
    for heading in _headings(points, placed):
        turned = points.turned(heading)
        for at in _positions(turned, placed.at, placed.step):
            step = turned.step(at)
            if step is not None:
                made = replace(placed, at=at, heading=heading, step=step)
                again = expand(made)
                off = np.concatenate([again.start, again.end]) - given
                error = float(np.abs(off).max())
                if max(np.abs(off.real).max(), np.abs(off.imag).max()) <= points.room * 1.000001:
                    return replace(made, error=error)
    return None


def _headings(points: _Points, placed: Recursion) -> Iterator[float]:
    """Headings with few digits: near the one of least squares, then near that of the placement
    whose largest deviation is the smallest; none where that is too large.
    """
    factor = placed.step * complex(np.exp(1j * np.deg2rad(placed.heading)))
    middle = _middle(points, placed.at, factor, turning=True)
    if middle is None:
        return
    heading = float(np.degrees(np.angle(middle[1])))
    yield from dict.fromkeys(
        round(each, places) for each in (placed.heading, heading) for places in range(PLACES)
    )


def _positions(points: _Points, near: complex, step: float) -> Iterator[complex]:
    """Positions with few digits: near the one of least squares, then near the middle of all."""
    yield from _digits(near)
    middle = _middle(points, near, step, turning=False)
    if middle is not None:
        yield from _digits(middle[0])


def _digits(at: complex) -> Iterator[complex]:
    for places in range(PLACES):
        yield complex(round(at.real, places), round(at.imag, places))


def _middle(
    points: _Points, near: complex, factor: complex, *, turning: bool
) -> tuple[complex, complex] | None:
    """Position and factor of the placement whose largest deviation is the smallest, None if that is
    too large; by linear programs over the points that are furthest off, more from round to round.
    turning: whether the factor may turn.
    """
    chosen = np.zeros(0, np.int64)
    for _ in range(ROUNDS):
        off = _off(points, near, factor)
        worst = np.argsort(-off, kind="stable")[:FIRST]
        if off[worst[0]] <= points.room and len(chosen):
            return near, factor
        if np.isin(worst, chosen).all():
            return None
        chosen = np.union1d(chosen, worst)
        solved = _least_largest(points.unit[chosen], points.given[chosen], turning)
        if solved is None or solved[2] > points.room:
            return None
        near, factor, _ = solved
    return None


def _off(points: _Points, at: complex, factor: complex) -> Floats:
    apart = points.given - at - factor * points.unit
    return np.asarray(np.maximum(np.abs(apart.real), np.abs(apart.imag)))


def _least_largest(
    unit: Complexes, given: Complexes, turning: bool
) -> tuple[complex, complex, float] | None:
    """Position, factor and largest deviation where that is the smallest."""
    count, base = len(unit), given.mean()
    along = [np.concatenate([unit.real, unit.imag])]
    if turning:
        along.append(np.concatenate([-unit.imag, unit.real]))
    across = np.repeat(np.eye(2), count, axis=0)
    rows = np.column_stack([across, *along])
    target = np.concatenate([(given - base).real, (given - base).imag])
    found = least_largest_of_few(rows, target)
    if found is None:
        return None
    x, y, *factor = found[0].tolist()
    return complex(x, y) + base, complex(factor[0], sum(factor[1:])), found[1]
