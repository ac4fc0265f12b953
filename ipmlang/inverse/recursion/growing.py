"""Lines that grow as they turn: a square spiral, a zigzag that opens, sides that shrink by a ratio.

In come the connected segments of one open outline; out comes a proven `Growing`: turns that come
again every few segments, and lengths that change evenly, or by one ratio, from each such stretch to
the next. Numbers are as short as the points allow. What only repeats is for `repetition`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.frames import Complexes, Floats, unit, wrap
from ipmlang.inverse.numbers import linear

PERIODS = (1, 2, 3, 4)
FEWEST = 5  # stretches that grow
MOST_PLACES = 10  # decimals of numbers that are tried
PASSES = 6  # of fitting the numbers to the points
NEAR = (1.0, 0.72)  # of the last decimal: what points may be off while numbers are shortened
GROWS = 8.0  # times what points may be off: growth that is none
COUNTER = "i"


@dataclass(frozen=True, slots=True, eq=False)
class Growing:
    """`count` stretches of p segments: segment j of stretch i is length[j] + growth[j] * i long, or
    length[j] if stretches are `ratio` times as large as those before, and then turns by turn[j].

    at, heading: where it begins, units and degrees; length, growth: units; turn: (p,) degrees.
    """

    count: int
    at: complex
    heading: float
    length: Floats
    growth: Floats
    turn: Floats
    ratio: float = 1.0

    def points(self) -> Complexes:
        """(count * p + 1,) where segments begin and end."""
        index = np.arange(self.count)[:, None]
        lengths = (self.length + self.growth * index) * self.ratio**index
        turned = np.cumsum(np.tile(self.turn, self.count))
        headings = unit(self.heading + np.concatenate([[0.0], turned[:-1]]))
        return np.asarray(self.at + np.concatenate([[0j], np.cumsum(lengths.ravel() * headings)]))

    def way(self) -> tuple[ast.Element, ...]:
        """`at(x, y, heading)`."""
        values = [self.at.real, self.at.imag] + [self.heading] * (self.heading != 0)
        return (ast.Module("at", tuple(ast.Argument(ast.Number(value + 0.0)) for value in values)),)

    def body(self) -> tuple[ast.Element, ...]:
        """`repeat(i < n) { F(4 + 2 * i) +(90) }`."""
        inside: list[ast.Element] = []
        for length, growth, turn in zip(
            self.length.tolist(), self.growth.tolist(), self.turn.tolist(), strict=True
        ):
            told = linear(length, growth, COUNTER, (0.0, 0.0))
            inside.append(ast.Module("F", (ast.Argument(told),)))
            if turn:
                mark, size = "+" if turn > 0 else "-", ast.Number(abs(turn))
                inside.append(ast.Module(mark, (ast.Argument(size),)))
        if self.ratio != 1:
            inside.append(ast.Module("*", (ast.Argument(ast.Number(self.ratio)),)))
        head = ast.Count(COUNTER, ast.Number(float(self.count)))
        return (ast.Repeat(head, tuple(inside)),)


def fold_growing(
    start: Complexes, end: Complexes, *, tolerance: float, decimals: int | None = None
) -> Growing | None:
    """What draws the segments start, end (n,), None if nothing here does.

    tolerance: units that a point may be off; decimals: to which the points were rounded, so that
    those of the result must round to the same.
    """
    if len(start) < FEWEST or np.abs(start[1:] - end[:-1]).max() > tolerance:
        return None
    seen = np.append(start, end[-1])
    off = tolerance if decimals is None else 2.0 * 10.0**-decimals
    for period in PERIODS:
        if len(start) % period or len(start) < FEWEST * period:
            continue
        for guess in _guesses(seen, period, off):
            for made in _shortened(guess, seen, tolerance, decimals):
                if decimals is None or _rounds_to(made, seen, decimals):
                    return made
    return None


def _guesses(seen: Complexes, period: int, off: float) -> Iterator[Growing]:
    """Lengths that change evenly or by a ratio, where the points agree with either roughly."""
    along = np.diff(seen)
    size = np.abs(along)
    if size.min() <= 4 * off:
        return
    turn = wrap(np.diff(np.angle(along, deg=True)))
    slack = np.rad2deg(2 * off / np.minimum(size[1:], size[:-1]))
    count = len(size) // period
    turns = np.empty(period)
    for phase in range(period):
        own, room = turn[phase::period], slack[phase::period]
        best = int(np.argmin(room))
        if (np.abs(wrap(own - own[best])) > room + room[best]).any():
            return
        turns[phase] = own[best]
    lengths = size.reshape(count, period)
    index = np.arange(count, dtype=np.float64)
    heading = float(np.angle(along[0], deg=True))
    still, at = np.zeros(period), complex(seen[0])
    powers = np.stack([np.ones(count), index], axis=1)
    even = np.linalg.lstsq(powers, lengths, rcond=None)[0]
    grows = np.abs(even[1]).max() * count > GROWS * off
    if grows and np.abs(powers @ even - lengths).max() <= 2 * off:
        yield Growing(count, at, heading, even[0], even[1], turns)
    by = np.linalg.lstsq(powers, np.log(lengths), rcond=None)[0]
    ratio = float(np.exp(by[1].mean()))
    first = (lengths * ratio ** -index[:, None])[int(np.argmax(lengths[:, 0]))]
    off_by = np.abs(first * ratio ** index[:, None] - lengths)
    if grows and (off_by <= 4 * off + 1e-3 * lengths).all():
        yield Growing(count, at, heading, first, still, turns, ratio)


# ------------------------------------------------------------------------ fitting


def _vector(given: Growing) -> Floats:
    more = given.growth if given.ratio == 1 else np.array([given.ratio])
    place = [given.at.real, given.at.imag, given.heading]
    return np.concatenate([place, given.length, given.turn, more])


def _with(given: Growing, values: Floats) -> Growing:
    p = len(given.turn)
    x, y, heading = values[:3].tolist()
    length, turn, more = values[3 : 3 + p], values[3 + p : 3 + 2 * p], values[3 + 2 * p :]
    made = replace(given, at=complex(x, y), heading=heading, length=length, turn=turn)
    return replace(made, growth=more) if given.ratio == 1 else replace(made, ratio=float(more[0]))


def _fitted(given: Growing, seen: Complexes, free: NDArray[np.bool_]) -> Growing:
    """The same with the free numbers fitted to the points, by Gauss and Newton."""
    values = _vector(given)
    for _ in range(PASSES):
        base = _with(given, values).points()
        steps = 1e-6 * np.maximum(1.0, np.abs(values))
        columns = [
            (_with(given, values + steps[k] * row).points() - base) / steps[k]
            for k, row in enumerate(np.eye(len(values)))
            if free[k]
        ]
        jacobian = np.stack([np.concatenate([each.real, each.imag]) for each in columns], axis=1)
        rest = np.concatenate([(seen - base).real, (seen - base).imag])
        change = np.linalg.lstsq(jacobian, rest, rcond=None)[0]
        values[free] += change
        if (np.abs(change) <= 1e-10 * np.maximum(1.0, np.abs(values[free]))).all():
            break
    return _with(given, values)


def _shortened(
    given: Growing, seen: Complexes, tolerance: float, decimals: int | None
) -> Iterator[Growing]:
    """With as few decimals as the points allow, each number in turn while those left are fitted
    again.
    """
    count, p = len(_vector(given)), len(given.turn)
    fitted = _fitted(given, seen, np.ones(count, np.bool_))
    rooms = [tolerance] if decimals is None else [near * 10.0**-decimals for near in NEAR]
    for room in rooms:
        made, free = fitted, np.ones(count, np.bool_)
        if _off(made, seen) > room:
            return
        # What all later points hang on first, the place last.
        for number in chain(range(3 + p, count), range(3, 3 + p), (2, 0, 1)):
            free[number] = False
            made = _rounded(made, number, seen, free, room)
        yield made


def _rounded(
    given: Growing, number: int, seen: Complexes, free: NDArray[np.bool_], room: float
) -> Growing:
    """With one number as short as the others, fitted to it, allow."""
    values = _vector(given)
    for places in range(MOST_PLACES):
        short = values.copy()
        short[number] = np.round(values[number], places) + 0.0
        made = _with(given, short)
        made = _fitted(made, seen, free) if free.any() else made
        if _off(made, seen) <= room:
            return made
    return given


def _off(made: Growing, seen: Complexes) -> float:
    """Units that the worst point is off."""
    with np.errstate(all="ignore"):
        off = float(np.abs(made.points() - seen).max())
    return off if np.isfinite(off) else np.inf


def _rounds_to(made: Growing, seen: Complexes, decimals: int) -> bool:
    return bool((np.round(made.points(), decimals) == np.round(seen, decimals)).all())
