"""Placement and round numbers: the last step to a recursion, and its proof.

In comes a program in its own units; out comes the same with the turtle's first position, heading
and step, with the angles as a person would write them, expanded and compared with the segments; or
None where it does not draw them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.recursion.program import (
    Again,
    Body,
    Branch,
    Command,
    Draw,
    Grow,
    Move,
    Recursion,
    Turn,
    expand,
    largest_error,
)
from ipmlang.inverse.recursion.rounded import placed_on_grain
from ipmlang.inverse.recursion.strokes import Strokes

PLACES = 7
UNIT_PLACES = 3  # of decimals, one more for lengths, where these are in the drawing's units
PLAIN = 1e-3  # what a multiple may be off to be a plain one
NEAR = 0.02  # of the usual turn: what a multiple of it may be off before it is rounded
CLOSE = 100.0  # times the bound that a program may miss before its numbers are rounded


def settled(program: Recursion, strokes: Strokes) -> Recursion | None:
    """The program placed, with the shortest numbers that still draw the strokes."""
    bound = strokes.tolerance
    raw = _placed(program, strokes)
    if raw is None or raw.error > CLOSE * bound:
        return None
    if _uneven(program):
        for rounded in _rounded(_grown(program, raw.step), UNIT_PLACES):
            short = _placed_short(rounded, strokes)
            if short is not None and short.step == 1:
                return short
    for rounded in _rounded(program):
        short = _placed_short(rounded, strokes)
        if short is not None:
            return short
    return _short_placement(raw, strokes)


def _placed_short(program: Recursion, strokes: Strokes) -> Recursion | None:
    placed = _placed(program, strokes)
    return None if placed is None else _short_placement(placed, strokes)


def _placed(program: Recursion, strokes: Strokes) -> Recursion | None:
    """Moved, turned and scaled to the strokes, by least squares over all end points."""
    drawn = expand(replace(program, step=1.0, at=0j, heading=0.0))
    if len(drawn.start) != len(strokes):
        return None
    points = np.concatenate([drawn.start, drawn.end])
    target = np.concatenate([strokes.start, strokes.end])
    middle, aim = points.mean(), target.mean()
    spread = float(np.sum(np.abs(points - middle) ** 2))
    if spread == 0:
        return None
    factor = complex(np.sum((points - middle).conj() * (target - aim))) / spread
    made = replace(
        program,
        step=abs(factor),
        at=complex(aim - factor * middle),
        heading=float(np.degrees(np.angle(factor))),
    )
    return _measured(made, strokes)


def _measured(program: Recursion, strokes: Strokes) -> Recursion:
    return replace(program, error=largest_error(expand(program), strokes.start, strokes.end))


def _short_placement(placed: Recursion, strokes: Strokes) -> Recursion | None:
    """Position, heading and step with as few digits as the error allows; None where it is too large
    whatever they are.
    """
    if strokes.grain:  # least squares are off a little more than what is to be found
        return placed_on_grain(placed, strokes) if placed.error <= 2 * strokes.tolerance else None
    if placed.error > strokes.tolerance:
        return None
    bound = min(strokes.tolerance, max(1.5 * placed.error, strokes.tolerance / 4))
    for places in range(PLACES + 3):
        shorter = replace(
            placed,
            step=round(placed.step, places),
            heading=round(placed.heading, places),
            at=complex(round(placed.at.real, places), round(placed.at.imag, places)),
        )
        if shorter.step > 0 and _measured(shorter, strokes).error <= bound:
            return _measured(shorter, strokes)
    return placed


def _uneven(program: Recursion) -> bool:
    """Whether a length is no plain multiple of another: then all are in the drawing's units."""
    lengths = _lengths(program.bodies)
    return any(abs(each - round(each, 1)) > PLAIN for each in lengths)


def _lengths(bodies: tuple[Body, ...]) -> list[float]:
    """How far all commands go."""
    found: list[float] = []
    for body in bodies:
        for command in body:
            match command:
                case Draw(length) | Move(length):
                    found.append(length)
                case Branch(inner) | Again(_, inner):
                    found += _lengths((inner,))
                case _:
                    pass
    return found


def _rounded(program: Recursion, most: int = PLACES) -> Iterator[Recursion]:
    """The program with its angles as multiples of one short angle, then each short by itself; most:
    how many decimals are tried.
    """
    base = _common(_angles(program.bodies[:-1])) or _common(_angles(program.bodies))
    for places in range(most):
        if base:
            angle = round(base, places)
            if angle:
                turn = partial(_whole, angle, places)
                yield replace(_mapped(program, turn, places), angle=angle)
    for places in range(most):
        plain = _mapped(program, partial(round, ndigits=places), places)
        yield replace(plain, angle=_usual(plain))


def _whole(unit: float, places: int, angle: float) -> float:
    """The nearest multiple, the angle itself with fewer digits if none is near."""
    times = round(angle / unit)
    near = abs(times * unit - angle) <= NEAR * unit
    return times * unit if near else round(angle, places)


def _angles(bodies: tuple[Body, ...]) -> list[float]:
    """All turns, without their signs, ascending."""
    found: list[float] = []
    for body in bodies:
        for command in body:
            match command:
                case Turn(angle):
                    found.append(abs(angle))
                case Branch(inner) | Again(_, inner):
                    found += _angles((inner,))
                case _:
                    pass
    return sorted(found)


def _usual(program: Recursion) -> float:
    """The most frequent angle."""
    angles = _angles(program.bodies)
    return max(sorted(set(angles)), key=angles.count) if angles else 0.0


def _common(angles: list[float]) -> float:
    """The largest angle of which all are small multiples, 0 if there is none."""
    if not angles:
        return 0.0
    smallest = min(angles)
    for divisor in range(1, 7):
        base = smallest / divisor
        times = [round(angle / base) for angle in angles]
        if all(abs(n * base - a) <= NEAR * base for n, a in zip(times, angles, strict=True)):
            return sum(angles) / sum(times)
    return 0.0


def _grown(program: Recursion, factor: float) -> Recursion:
    """The program with all lengths times a factor."""
    return _changed(program, lambda angle: angle, lambda length: length * factor, lambda by: by)


def _mapped(program: Recursion, turn: Callable[[float], float], places: int) -> Recursion:
    """The program with its angles mapped and its lengths and scales rounded."""
    short = partial(shortest, error=0.5 * 10.0 ** -(places + 1))
    return _changed(program, turn, short, short)


def _changed(
    program: Recursion,
    turn: Callable[[float], float],
    go: Callable[[float], float],
    grow: Callable[[float], float],
) -> Recursion:
    """The program with its angles, lengths and scales changed."""

    def command(each: Command) -> Command:
        match each:
            case Turn(angle):
                return Turn(turn(angle))
            case Grow(factor):
                return Grow(grow(factor))
            case Draw(length):
                return Draw(go(length))
            case Move(length):
                return Move(go(length))
            case Branch(inner):
                return Branch(tuple(command(part) for part in inner))
            case Again(count, inner):
                return Again(count, tuple(command(part) for part in inner))
            case _:
                return each

    rules = {name: tuple(map(command, body)) for name, body in program.rules.items()}
    alternatives = {
        name: tuple(replace(each, body=tuple(map(command, each.body))) for each in several)
        for name, several in program.alternatives.items()
    }
    start = tuple(map(command, program.start))
    return replace(program, rules=rules, start=start, alternatives=alternatives)
