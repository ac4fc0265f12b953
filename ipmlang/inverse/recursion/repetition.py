"""Curves that repeat themselves: rows of one motif, a zigzag, a meander, the outline of a gear.

In come segments in paint order; out comes a proven program without rules, whose axiom repeats what
the segments repeat, repeats within repeats included, or None. A segment and the joint behind it are
one letter; what follows itself in the string of letters is folded, the longest first. What would
not be clearly shorter than the points themselves is not given.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes, Floats
from ipmlang.inverse.recursion.grammar import token_count
from ipmlang.inverse.recursion.program import Again, Body, Command, Draw, Move, Recursion, Turn
from ipmlang.inverse.recursion.refining import refined
from ipmlang.inverse.recursion.settle import settled
from ipmlang.inverse.recursion.strokes import Integers, Strokes, clustered, make_strokes

LONGEST_PERIOD = 1024
MOST_COMPARED = 50_000_000  # letters
MOST_RUNS = 32  # that are looked for
OVERHEAD = 4  # letters that a repeat costs
LEAST_COVERED = 0.5  # of the letters, by the first repeat
PAYS = 0.5  # of the numbers of the points that a program may take in tokens
HEAD = 16  # tokens besides, for place and settings
STILL = 1e-6  # steps, that a jump is none
STRAIGHT = 1e-7  # degrees, that a turn is none
END = -1  # the joint behind the last segment, which is any other's equal


@dataclass(frozen=True, slots=True, eq=False)
class _Letters:
    """size: (n,) kinds of lengths; joint: (n,) kinds of what is between a segment and the next."""

    size: Integers
    joint: Integers

    def __len__(self) -> int:
        return len(self.size)

    def part(self, first: int, after: int) -> _Letters:
        return _Letters(self.size[first:after], self.joint[first:after])


@dataclass(frozen=True, slots=True)
class _Run:
    """`count` equal stretches of `period` letters, one after the other; bent: but for the joint
    behind the last.
    """

    first: int
    period: int
    count: int
    bent: bool

    @property
    def saved(self) -> int:
        return self.period * (self.count - 1) - OVERHEAD - self.bent

    @property
    def after(self) -> int:
        return self.first + self.period * self.count


@dataclass(frozen=True, slots=True)
class _Letter:
    """A segment and its joint, by their place."""

    place: int


@dataclass(frozen=True, slots=True)
class _Again:
    """Parts so many times."""

    count: int
    parts: tuple[_Part, ...]


@dataclass(frozen=True, slots=True)
class _Bend:
    """What turns one joint into another, by the places of both."""

    said: int
    meant: int


_Part: TypeAlias = "_Letter | _Again | _Bend"


def fold_repeats(
    start: Complexes,
    end: Complexes,
    *,
    closed: bool = False,
    tolerance: float = 1e-6,
    grain: float = 0.0,
) -> Recursion | None:
    """The program whose turtle draws the segments start, end (n,) in this order (x + iy, y up).

    closed: the last one meets the first.
    tolerance, grain: see `fold`.
    None where nothing repeats so often that saying so is clearly shorter than the points.
    """
    strokes = make_strokes(start, end, tolerance, grain) if len(start) > OVERHEAD else None
    if strokes is None:
        return None
    spelt = _spelt(strokes, closed)
    whole = _longest(spelt)
    if whole is None or whole.period * whole.count < LEAST_COVERED * len(spelt):
        return None
    program = _program(strokes, spelt, _Folding(spelt).parts(0, len(spelt)))
    if _commands(program.start) > PAYS * 2 * len(strokes):
        return None
    found = settled(program, strokes) or settled(refined(program, strokes), strokes)
    if found is None or token_count(found) > PAYS * 2 * len(strokes) + HEAD:
        return None
    return found


def _commands(body: Body) -> int:
    return sum(_commands(each.body) if isinstance(each, Again) else 1 for each in body)


def _spelt(strokes: Strokes, closed: bool) -> _Letters:
    size = clustered(np.abs(strokes.along), strokes.tolerance)
    joints = _joints(strokes)
    slack = 2 * strokes.tolerance
    short = np.minimum(np.abs(strokes.along), np.abs(np.roll(strokes.along, -1)))
    heading = np.exp(1j * joints.turn)
    columns = [clustered(each, slack) for each in (joints.jump.real, joints.jump.imag)]
    columns += [clustered(each, slack / short) for each in (heading.real, heading.imag)]
    _, joint = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    joint = joint.ravel().astype(np.int64)
    if not closed:
        joint[-1] = END
    return _Letters(size, joint)


def _longest(spelt: _Letters) -> _Run | None:
    """The run that saves most letters, None if none saves any."""
    best: _Run | None = None
    count = len(spelt)
    most = min(count // 2, LONGEST_PERIOD, MOST_COMPARED // max(1, count))
    for period in range(1, most + 1):
        if best is not None and count - period - OVERHEAD <= best.saved:
            break
        alike = spelt.size[period:] == spelt.size[:-period]
        joint = spelt.joint[period:]
        same = alike & ((joint == spelt.joint[:-period]) | (joint == END))
        breaks = np.flatnonzero(np.concatenate([[True], ~same, [True]]))
        long = np.diff(breaks) - 1
        place = int(np.argmax(long))
        letters = int(long[place]) + period
        end = int(breaks[place + 1]) - 1  # the first letter, less a period, that is another
        bent = (letters + 1) % period == 0 and end < len(alike) and bool(alike[end])
        run = _Run(int(breaks[place]), period, (letters + bent) // period, bent)
        if run.count > 1 and run.saved > (0 if best is None else best.saved):
            best = run
    return best


class _Folding:
    """Folds runs, then what is in them and beside them, while there is room."""

    def __init__(self, spelt: _Letters) -> None:
        self._spelt = spelt
        self._left = MOST_RUNS

    def parts(self, first: int, after: int) -> tuple[_Part, ...]:
        """The letters from `first` on, with what repeats folded."""
        run = None
        if after - first > OVERHEAD and self._left:
            self._left -= 1
            run = _longest(self._spelt.part(first, after))
        if run is None:
            return tuple(map(_Letter, range(first, after)))
        begin, end = first + run.first, first + run.after
        inner = self.parts(begin, begin + run.period)
        before = self.parts(first, begin)
        bend = (_Bend(begin + run.period - 1, end - 1),) if run.bent else ()
        return (*before, _Again(run.count, inner), *bend, *self.parts(end, after))


def _program(strokes: Strokes, spelt: _Letters, parts: tuple[_Part, ...]) -> Recursion:
    """The program that says the parts, its step the usual length."""
    sizes = np.bincount(spelt.size, np.abs(strokes.along)) / np.bincount(spelt.size)
    usual = int(np.argmax(np.bincount(spelt.size)))
    step = float(sizes[usual])
    writer = _Writer(spelt, sizes / step, _mean_joints(_joints(strokes), spelt, step))
    return Recursion({}, writer.body(parts), 0, frozenset(), step)


@dataclass(frozen=True, slots=True, eq=False)
class _Joints:
    """jump: (n,) from the end of a segment to the next one's start, units along the heading; turn:
    (n,) radians; behind the last comes the first.
    """

    jump: Complexes
    turn: Floats


def _joints(strokes: Strokes) -> _Joints:
    after = np.append(np.arange(1, len(strokes)), 0)
    heading = strokes.along / np.abs(strokes.along)
    turn = np.angle(heading[after] / heading)
    # turns around are either way round, which no mean may be taken of
    turn[np.abs(turn) > np.pi - 1e-3] = np.pi
    return _Joints((strokes.start[after] - strokes.end) / heading, turn)


def _mean_joints(joints: _Joints, spelt: _Letters, step: float) -> _Joints:
    """By kind, in steps and degrees."""
    known = spelt.joint != END
    kind = spelt.joint[known]
    count = np.maximum(np.bincount(kind), 1)

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(kind, values[known]) / count, np.float64)

    jump = np.asarray(mean(joints.jump.real) + 1j * mean(joints.jump.imag), np.complex128)
    return _Joints(jump / step, np.degrees(mean(joints.turn)))


@dataclass(frozen=True, slots=True, eq=False)
class _Writer:
    """sizes: of segments, in steps, and joints, by kind."""

    spelt: _Letters
    sizes: Floats
    joints: _Joints

    def body(self, parts: tuple[_Part, ...]) -> Body:
        """Commands for letters and repeats."""
        made: list[Command] = []
        for part in parts:
            match part:
                case _Letter(place):
                    made += self._letter(place)
                case _Again(count, inner):
                    made.append(Again(count, self.body(inner)))
                case _Bend(said, meant):
                    made += self._undone(said) + self._joint(meant)
        return _plain(made)

    def _letter(self, place: int) -> list[Command]:
        return [Draw(float(self.sizes[self.spelt.size[place]])), *self._joint(place)]

    def _joint(self, place: int) -> list[Command]:
        """The way to the next segment, and the turn."""
        joint = int(self.spelt.joint[place])
        if joint == END:
            return []
        jump, turn = complex(self.joints.jump[joint]), float(self.joints.turn[joint])
        if abs(jump) <= STILL:
            return [Turn(turn)]
        aside = float(np.degrees(np.angle(jump)))
        return [Turn(aside), Move(abs(jump)), Turn(turn - aside)]

    def _undone(self, place: int) -> list[Command]:
        """The way back from a joint."""
        back: list[Command] = []
        for command in reversed(self._joint(place)):
            match command:
                case Turn(angle):
                    back.append(Turn(-angle))
                case Move(length):
                    back.append(Move(-length))
                case _:
                    back.append(command)
        return back


def _plain(commands: list[Command]) -> Body:
    """With turns that follow each other added up, and left out where they are none."""
    made: list[Command] = []
    for command in commands:
        match command:
            case Turn(angle):
                before = made.pop() if made and isinstance(made[-1], Turn) else Turn(0.0)
                assert isinstance(before, Turn)
                turn = _half(before.angle + angle)
                made += [Turn(turn)] if abs(turn) > STRAIGHT else []
            case _:
                made.append(command)
    return tuple(made)


def _half(angle: float) -> float:
    """At most half a turn, either way."""
    return angle if abs(angle) <= 180 + STRAIGHT else (angle + 180) % 360 - 180
