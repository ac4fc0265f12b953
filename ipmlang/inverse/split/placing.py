"""Placements as elements of a body: `[translate(1, 0, 2) rotate(0, 0, 90) [mirror tower]]`.

Frames come in with the room for error that there is; numbers are rounded to what a person would
write and turned into angles, and what says nothing is left out. Tables and repeats are made
elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import Floats, Frames, Integers, turns
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.wording import NOTHING, Vector, all_nothing, bracket, call

Said = TypeVar("Said")

WHOLE = 1e-9  # degrees or shares that are nothing
NEARLY = 3.0  # times the error that a length may be off which is then nothing
STEP = 6  # tokens of `translate(x, y, z)` or `rotate(a, b, c)` without signs
FACTOR = 4  # tokens of `*(s)`
BRACKET = 3  # tokens of `[… A]`
FEW = 8  # rows that are sooner said than compared
ROOM = 3.0  # times the error that an angle may be off which is then a round one


@dataclass(frozen=True, slots=True)
class Precision:
    """length: units that a printed length may be off."""

    length: float

    def number(self, value: float, share: float = 1.0) -> ast.Number:
        """A length, nothing if it nearly is; `share` of the room for one that is multiplied."""
        near = abs(value) <= NEARLY * self.length * share
        return ast.Number(0.0 if near else shortest(float(value), self.length * share))

    def vector(self, values: Floats | Sequence[float], share: float = 1.0) -> Vector:
        """Three lengths."""
        x, y, z = (self.number(float(value), share) for value in values)
        return (x, y, z)

    def degrees(self, reach: float) -> float:
        """Degrees that an angle may be off where what is turned reaches so far."""
        return float(np.degrees(self.length / max(reach, self.length)))

    def ratio(self, reach: float) -> float:
        """What a factor may be off."""
        return self.length / max(reach, self.length)


@dataclass(frozen=True, slots=True)
class Spot:
    """A frame as it is printed: a place, angles about x, y and z, a mirror, a factor."""

    place: Vector
    turn: Vector = (NOTHING, NOTHING, NOTHING)
    mirrored: bool = False
    scale: ast.Expr | None = None

    def at(self, place: Vector) -> Spot:
        """The same elsewhere."""
        return replace(self, place=place)

    @property
    def plain(self) -> bool:
        """Whether it is a translation at most."""
        return all_nothing(self.turn) and not self.mirrored and self.scale is None


def spots(frames: Frames, precision: Precision, reach: float) -> list[Spot]:
    """A spot for every frame; reach: how far what is placed gets from its own origin."""
    error = precision.degrees(reach)
    angles = euler_angles(frames.rotation, max(WHOLE, ROOM * error))
    places = _once_each(frames.position, precision.number)
    turned = _once_each(angles, lambda angle: ast.Number(_angle(angle, error)))
    scales = _once_each(frames.scale[:, None], lambda scale: _scale(scale, precision.ratio(reach)))
    mirrored = (frames.hand < 0).tolist()
    return [
        Spot((x, y, z), (a, b, c), hand, scale)
        for (x, y, z), (a, b, c), hand, (scale,) in zip(
            places, turned, mirrored, scales, strict=True
        )
    ]


def _once_each(table: Floats, said: Callable[[float], Said]) -> list[list[Said]]:
    """What is said for the numbers of a table (n, c), equal ones said once, if there are many."""
    if len(table) <= FEW:
        return [[said(value) for value in row] for row in table.tolist()]
    values, place = np.unique(table, return_inverse=True)
    known = [said(value) for value in values.tolist()]
    rows: list[list[int]] = place.reshape(len(table), table.shape[1]).tolist()
    return [[known[each] for each in row] for row in rows]


def _scale(value: float, error: float) -> ast.Number | None:
    scale = shortest(value, error)
    return None if scale == 1 else ast.Number(scale)


def _angle(angle: float, error: float) -> float:
    """The angle as a person says it: what is nearly a multiple of 15 degrees is one."""
    whole = 15.0 * round(angle / 15.0)
    if abs(angle - whole) <= ROOM * error:
        return whole + 0.0
    return shortest(angle, error)


def euler_angles(rotation: Floats, small: float = WHOLE) -> Floats:
    """(n, 3) degrees about own x, then y, then z for quaternions (n, 4): of the two ways to say a
    turn the one with more zeros; small: degrees that are nothing.
    """
    if not rotation[:, 1:3].any():
        upright = np.zeros((len(rotation), 3))
        if rotation[:, 3].any():
            matrix = turns(rotation)
            about = np.degrees(np.arctan2(-matrix[:, 0, 1], matrix[:, 0, 0]))
            upright[:, 2] = _settled(about, small)
        return upright
    first = _three_angles(turns(rotation))
    second = np.stack([first[:, 0] + 180, 180 - first[:, 1], first[:, 2] + 180], axis=1)
    first, second = _settled(first, small), _settled(second, small)
    chosen = np.count_nonzero(second, axis=1) < np.count_nonzero(first, axis=1)
    return np.where(chosen[:, None], second, first)


def _three_angles(matrix: Floats) -> Floats:
    """Angles a, b, c of Rx(a) Ry(b) Rz(c); where b is 90 degrees, a is 0."""
    sine = np.clip(matrix[:, 0, 2], -1.0, 1.0)
    locked = np.abs(sine) > 1 - 1e-14
    a = np.arctan2(-matrix[:, 1, 2], matrix[:, 2, 2])
    b = np.arctan2(sine, np.hypot(matrix[:, 0, 0], matrix[:, 0, 1]))
    c = np.arctan2(-matrix[:, 0, 1], matrix[:, 0, 0])
    c = np.where(locked, np.arctan2(matrix[:, 1, 0], matrix[:, 1, 1]), c)
    return np.asarray(np.degrees(np.stack([np.where(locked, 0.0, a), b, c], axis=1)))


def _settled(angles: Floats, small: float) -> Floats:
    """Angles in (-180, 180], almost nothing being nothing."""
    wrapped: Floats = 180.0 - np.mod(180.0 - angles, 360.0)
    wrapped[wrapped < small - 180.0] = 180.0
    wrapped[np.abs(wrapped) < small] = 0.0
    return wrapped + 0.0


def placed(spot: Spot, inner: Sequence[ast.Element]) -> ast.Element:
    """What is inner, at a spot: in a bracket where anything has to be said."""
    return bracket([*steps_to(spot), *inner])


def steps_to(spot: Spot) -> list[ast.Element]:
    """The operations that lead to a spot."""
    steps: list[ast.Element] = []
    if not all_nothing(spot.place):
        steps.append(call("translate", *spot.place))
    if not all_nothing(spot.turn):
        steps.append(call("rotate", *spot.turn))
    if spot.scale is not None:
        steps.append(call("*", spot.scale))
    if spot.mirrored:
        steps.append(ast.Module("mirror"))
    return steps


def placed_tokens(frames: Frames, precision: Precision, reach: float) -> Integers:
    """(n,) tokens of a bare symbol that is placed at each frame, without printing it.

    >>> from ipmlang.inverse.frames import moved_to
    >>> frames = moved_to(np.array([[0.0, 0, 0], [3, 4, 0], [0, -3, 0]]))
    >>> placed_tokens(frames, Precision(1e-9), 1.0).tolist()
    [1, 9, 10]
    """
    error = precision.degrees(reach)
    angles = euler_angles(frames.rotation, max(WHOLE, ROOM * error))
    turned = np.abs(angles) > ROOM * error
    moved = np.abs(frames.position) > NEARLY * precision.length
    scaled = np.abs(frames.scale - 1) > precision.ratio(reach)
    steps = (frames.hand < 0) + FACTOR * scaled
    for said, values in ((moved, frames.position), (turned, angles)):
        signs = np.count_nonzero(said & (values < 0), axis=1)
        steps = steps + np.where(said.any(axis=1), STEP + signs, 0)
    return np.asarray(np.where(steps > 0, steps + BRACKET, 1), np.int64)
