"""Angles and lengths of a program, fitted to all segments at once.

Takes a program whose numbers are means of what was measured, and the strokes it should draw; gives
the same with numbers that draw them nearest: by least squares, and where coordinates were rounded,
so that the largest deviation is the smallest. Means of single joints add up to an error along a
curve; what all points say together does not. Nothing here changes what a program does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.least_largest import least_largest
from ipmlang.inverse.lsystem.frames import Complexes, Floats
from ipmlang.inverse.recursion.program import (
    Again,
    Body,
    Command,
    Draw,
    Move,
    Recursion,
    Turn,
    expand,
)
from ipmlang.inverse.recursion.strokes import Strokes

MOST_NUMBERS = 24
MOST_POINTS = 20_000
ROUNDS = 3
STEP = 1e-6  # degrees and steps, for slopes
ALIKE = 5  # decimals in which numbers agree that are one
WHOLE = 1e-9  # of a turn or length that is the unit, which stays

_Key = tuple[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """Points of a program for some numbers, and where they are to be."""

    program: Recursion
    keys: tuple[_Key, ...]
    target: Complexes

    def points(self, values: Floats) -> Complexes:
        known = dict(zip(self.keys, values.tolist(), strict=True))
        plain = replace(_mapped(self.program, known), step=1.0, at=0j, heading=0.0)
        drawn = expand(plain)
        return np.concatenate([drawn.start, drawn.end])

    def system(self, values: Floats) -> tuple[Floats, Floats]:
        """How the points move with place, size, turn and the numbers, (2m, 4 + k), and what they
        are off then, (2m,): all x, then all y.
        """
        points = self.points(values)
        factor = _similar(points, self.target)
        offset = self.target.mean() - factor * points.mean()
        columns = [np.ones_like(points), np.full_like(points, 1j), points, 1j * points]
        for number in range(len(values)):
            moved = values.copy()
            moved[number] += STEP
            columns.append((self.points(moved) - points) * factor / STEP)
        slopes = np.stack(columns, axis=1)
        off = self.target - factor * points - offset
        return np.concatenate([slopes.real, slopes.imag]), np.concatenate([off.real, off.imag])


def refined(program: Recursion, strokes: Strokes) -> Recursion:
    """The program with its numbers fitted; as it is where there are too many of them."""
    keys = tuple(dict.fromkeys(_keys(program.start)))
    target = np.concatenate([strokes.start, strokes.end])
    if not 0 < len(keys) <= MOST_NUMBERS or len(target) > 2 * MOST_POINTS:
        return program
    fit = _Fit(program, keys, target)
    values = np.array([value for _, value in keys])
    for round_ in range(ROUNDS):
        slopes, off = fit.system(values)
        last = round_ == ROUNDS - 1
        nearest = least_largest(slopes, off) if strokes.grain and last else None
        if nearest is None:
            nearest = np.asarray(np.linalg.lstsq(slopes, off, rcond=1e-12)[0], np.float64)
        values = values + nearest[4:]
    known = dict(zip(keys, values.tolist(), strict=True))
    return _mapped(program, known)


def _similar(points: Complexes, target: Complexes) -> complex:
    """The factor that takes points to their targets by least squares."""
    spread = points - points.mean()
    size = float(np.sum(np.abs(spread) ** 2)) or 1.0
    return complex(np.sum(spread.conj() * (target - target.mean()))) / size


def _key(command: Command) -> _Key | None:
    """What number of a command is fitted: angles are one whatever their sign; a length of one step
    is the unit, and half a turn the other way round.
    """
    match command:
        case Turn(angle) if abs(abs(angle) - 180) > WHOLE:
            return "turn", round(abs(angle), ALIKE)
        case Draw(length) | Move(length) if abs(length - 1) > WHOLE:
            return "length", round(length, ALIKE)
        case _:
            return None


def _keys(body: Body) -> list[_Key]:
    found: list[_Key] = []
    for command in body:
        key = _key(command)
        if isinstance(command, Again):
            found += _keys(command.body)
        elif key is not None:
            found.append(key)
    return found


def _mapped(program: Recursion, known: dict[_Key, float]) -> Recursion:
    """The program with other numbers."""

    def each(command: Command) -> Command:
        key = _key(command)
        match command:
            case Again(count, inner):
                return Again(count, tuple(map(each, inner)))
            case Turn(angle) if key is not None:
                return Turn(known[key] if angle > 0 else -known[key])
            case Draw() if key is not None:
                return Draw(known[key])
            case Move() if key is not None:
                return Move(known[key])
            case _:
                return command

    return replace(program, start=tuple(map(each, program.start)))
