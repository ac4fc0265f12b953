"""Parts that follow each other by one motion: rows, rings and spiral stairs as one repeat.

In go parts in frames, out comes how many of them follow by one step, or by one turn about an axis
and one rise along it, and the element that draws these. A motif of several parts may repeat. What
is not regular is laid out elsewhere, and nothing is derived.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.edit.symbols import Elements
from ipmlang.inverse.frames import Floats, Frames, turns
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.placing import Precision, placed, spots
from ipmlang.inverse.split.wording import NOTHING, bracket, call, plus, times

Part: TypeAlias = tuple[Frames, Elements]

ROW, RING = 3, 4  # members at least: three parts lie on some circle wherever they stand
MOST = 6  # parts of a motif
LEAST = 1e-4  # degrees of a turn
ALIKE = 1e-9  # by which turns may differ that are one


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A step (3,), or a turn of so many degrees about an axis (0, 1, 2) through a point (3,), with
    what of the step is along that axis.
    """

    step: Floats
    axis: int = 2
    angle: float = 0.0
    middle: Floats | None = None

    def moved(self, place: Floats, times: int) -> Floats:
        """(3,) where a place goes."""
        if self.middle is None:
            return place + times * self.step
        turned = _rotation(self.axis, self.angle * times) @ (place - self.middle)
        return np.asarray(self.middle + turned + times * self.step)


@dataclass(frozen=True, slots=True, eq=False)
class Regular:
    """`count` motifs of `size` parts each, moved alike."""

    motion: Motion
    size: int
    count: int

    @property
    def parts(self) -> int:
        """How many parts there are in all."""
        return self.size * self.count


@dataclass(slots=True, eq=False)
class Arranged:
    """Parts that follow each other with their frames, ready to be looked at again and again. kinds:
    equal numbers for those that are drawn alike, turns apart; turns: their axes, row by row.
    """

    parts: Sequence[Part]
    frames: Frames
    near: float
    kinds: list[int] = field(init=False)
    places: list[list[float]] = field(init=False)
    scales: list[float] = field(init=False)
    turns: list[list[float]] = field(init=False)
    _known: dict[int, Regular | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        frames = self.frames
        numbers: dict[object, int] = {}
        self.kinds = [
            numbers.setdefault((hand, elements), len(numbers))
            for hand, (_, elements) in zip(frames.hand.tolist(), self.parts, strict=True)
        ]
        self.places, self.scales = frames.position.tolist(), frames.scale.tolist()
        self.turns = turns(frames.rotation).reshape(-1, 9).tolist()

    def regular(self, begin: int) -> Regular | None:
        """The longest regular sequence that begins with a part, if there is one. Places may be off
        by an eighth of `near`.
        """
        if begin not in self._known:
            self._known[begin] = self._longest(begin)
        return self._known[begin]

    def _longest(self, begin: int) -> Regular | None:
        best: Regular | None = None
        for size in range(1, MOST + 1):
            if begin + ROW * size > len(self.parts):
                break
            second, third = begin + size, begin + 2 * size
            if not (self._alike(begin, second) and self._alike(begin, third)):
                continue
            if not self._may_go_on(begin, second, third):
                continue
            motion = self._motion(begin, second)
            if motion is None:
                continue
            count = self._count(begin, size, motion)
            fewest = ROW if motion.middle is None else RING
            if count >= fewest and (best is None or size * count > best.parts):
                best = Regular(motion, size, count)
        return best

    def _may_go_on(self, first: int, second: int, third: int) -> bool:
        """Whether a third part may follow two: where those are not turned, as far behind."""
        if self.turns[first] != self.turns[second]:
            return True
        every = zip(self.places[first], self.places[second], self.places[third], strict=True)
        return all(abs(c - (a + 2 * (b - a))) <= self.near / 8 for a, b, c in every)

    def _count(self, begin: int, size: int, motion: Motion) -> int:
        """How many motifs follow each other."""
        place = begin + size
        while place < len(self.parts):
            first = begin + (place - begin) % size
            times = (place - begin) // size
            if not self._alike(place, first) or not self._turned(place, first, motion, times):
                break
            expected = motion.moved(np.array(self.places[first]), times)
            if np.abs(self.places[place] - expected).max() > self.near / 8:
                break
            place += 1
        return (place - begin) // size

    def _alike(self, one: int, other: int) -> bool:
        """Whether parts are drawn alike, turns apart."""
        same = self.kinds[one] == self.kinds[other]
        return same and abs(self.scales[one] - self.scales[other]) <= ALIKE

    def _turned(self, place: int, first: int, motion: Motion, times: int) -> bool:
        """Whether a part stands as the first one does, turned so many times."""
        own, expected = self.turns[place], self.turns[first]
        if motion.middle is not None:
            before = np.array(expected).reshape(3, 3)
            expected = (_rotation(motion.axis, motion.angle * times) @ before).ravel().tolist()
        if own == expected:
            return True
        return all(abs(x - y) <= 1e2 * ALIKE for x, y in zip(own, expected, strict=True))

    def _motion(self, one: int, other: int) -> Motion | None:
        """What takes one part to another; None for neither a step nor a turn about x, y, z."""
        first, second = np.array(self.places[one]), np.array(self.places[other])
        if self.turns[one] == self.turns[other]:
            return Motion(second - first) if (second != first).any() else None
        before, after = (np.array(self.turns[row]).reshape(3, 3) for row in (one, other))
        return _between(first, second, after @ before.T)


def _between(first: Floats, second: Floats, turn: Floats) -> Motion | None:
    """The motion that takes a place (3,) to another and turns by (3, 3)."""
    step = second - first
    if np.abs(turn - np.eye(3)).max() <= ALIKE:
        return Motion(step) if np.abs(step).max() > 0 else None
    axis = int(np.argmax(np.diag(turn)))
    if abs(turn[axis, axis] - 1) > ALIKE:
        return None
    a, b = (axis + 1) % 3, (axis + 2) % 3
    angle = float(np.degrees(np.arctan2(turn[b, a], turn[a, a])))
    if abs(angle) < LEAST:
        return None
    flat = [a, b]
    inside = turn[np.ix_(flat, flat)]
    middle = np.zeros(3)
    middle[flat] = np.linalg.solve(np.eye(2) - inside, second[flat] - inside @ first[flat])
    along = np.zeros(3)
    along[axis] = step[axis]
    return Motion(along, axis, angle, middle)


def _rotation(axis: int, degrees: float) -> Floats:
    angle = np.radians(degrees)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(3)
    found[a, a] = found[b, b] = np.cos(angle)
    found[b, a], found[a, b] = np.sin(angle), -np.sin(angle)
    return found


# --------------------------------------------------------------------------- as elements


def said(
    own: Regular, parts: Sequence[Part], begin: int, precision: Precision, reach: float
) -> ast.Element:
    """A repeat that draws the parts of a regular sequence; reach: how far what is drawn gets from
    its origin.
    """
    motif = parts[begin : begin + own.size]
    last = begin + own.size * (own.count - 1)
    row = own.motion.middle is None
    body = _row(own, parts, begin, last, precision, reach) if row else None
    body = body or _ring(own, motif, precision, reach)
    return ast.Repeat(ast.Count("i", ast.Number(float(own.count))), (body,))


def _row(
    own: Regular, parts: Sequence[Part], begin: int, last: int, precision: Precision, reach: float
) -> ast.Element:
    share = 1 / (own.count - 1)
    first = parts[begin][0]
    step = precision.vector((parts[last][0].position[0] - first.position[0]) * share, share)
    motif = parts[begin : begin + own.size]
    spot = spots(first, precision, reach)[0]
    x, y, z = (plus(at, _times_i(by)) for at, by in zip(spot.place, step, strict=True))
    if own.size == 1:
        return placed(spot.at((x, y, z)), motif[0][1])
    inner = _inside(motif, first.position[0], precision, reach)
    return ast.Bracket((call("translate", x, y, z), *inner))


def _ring(own: Regular, motif: Sequence[Part], precision: Precision, reach: float) -> ast.Element:
    motion, share = own.motion, 1 / (own.count - 1)
    middle = motion.middle
    assert middle is not None
    radius = max(float(np.linalg.norm(frame.position[0] - middle)) for frame, _ in motif)
    angle = shortest(motion.angle, precision.degrees(radius + reach) * share)
    rise = _times_i(precision.number(float(motion.step[motion.axis]), share))
    place = list(precision.vector(middle))
    place[motion.axis] = rise
    turn: list[ast.Expr] = [NOTHING] * 3
    turn[motion.axis] = _times_i(ast.Number(angle))
    still = all(each == NOTHING for each in place)
    steps = [] if still else [call("translate", *place)]
    inner = _inside(motif, middle, precision, reach)
    return bracket([*steps, call("rotate", *turn), *inner])


def _inside(
    motif: Sequence[Part], origin: Floats, precision: Precision, reach: float
) -> list[ast.Element]:
    """The parts of a motif from an origin; the last one needs no bracket."""
    found: list[ast.Element] = []
    for frame, elements in motif:
        local = Frames(frame.position - origin, frame.rotation, frame.hand, frame.scale)
        found.append(placed(spots(local, precision, reach)[0], elements))
    last = found.pop()
    return [*found, *(last.body if isinstance(last, ast.Bracket) else (last,))]


def _times_i(value: ast.Expr) -> ast.Expr:
    return times(value, ast.Name("i"))


__all__ = ["Arranged", "Motion", "Part", "Regular", "said"]
