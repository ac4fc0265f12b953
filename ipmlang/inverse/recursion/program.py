"""Turtle programs that inference writes, and what they draw: the proof of every recursion.

A program is an axiom, rules of turtle commands and a number of steps. `expand` draws it by levels
in batches, exactly as the language derives it, so that the result can be compared with the drawing
segment by segment. Nothing here looks for anything.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.frames import Complexes, unit
from ipmlang.inverse.recursion.strokes import Integers


@dataclass(frozen=True, slots=True)
class Turn:
    """Left, degrees."""

    angle: float


@dataclass(frozen=True, slots=True)
class Grow:
    """Multiplies the scale."""

    factor: float


@dataclass(frozen=True, slots=True)
class Draw:
    """A segment of so many steps."""

    length: float = 1.0


@dataclass(frozen=True, slots=True)
class Move:
    """A step that draws nothing."""

    length: float = 1.0


@dataclass(frozen=True, slots=True)
class Symbol:
    """A module with a rule."""

    name: str


@dataclass(frozen=True, slots=True)
class Branch:
    """Brackets."""

    body: Body


@dataclass(frozen=True, slots=True)
class Again:
    """A body so many times, each where the one before ended."""

    count: int
    body: Body


@dataclass(frozen=True, slots=True)
class Done:
    """A symbol whose drawing is known; only while a program is expanded."""

    drawn: Drawn


Command: TypeAlias = "Turn | Grow | Draw | Move | Symbol | Branch | Again | Done"
Body: TypeAlias = "tuple[Command, ...]"


@dataclass(frozen=True, slots=True)
class Alternative:
    """One production of a symbol that draws: its percentage and its body."""

    percent: int
    body: Body


@dataclass(frozen=True, slots=True)
class Recursion:
    """An L-system that draws the given segments.

    rules: successors by symbol; start: the axiom; steps: derivation steps.
    drawn, moved: symbols that draw or move a step when no step is left; the others do nothing then.
    step: length of a segment, units; angle: of the usual turn, degrees, 0 if there is none.
    at, heading: where the turtle begins, units and degrees.
    error: largest distance of an end point, units.
    pieces: symbols that only grow.
    alternatives, choices: productions of the symbol that draws one, and the numbers of those it
        took, generation by generation, each from left to right.
    styles: numbers of the styles of drawn symbols and of DRAW, where they differ.
    """

    rules: dict[str, Body]
    start: Body
    steps: int
    drawn: frozenset[str]
    step: float
    angle: float = 0.0
    at: complex = 0j
    heading: float = 0.0
    error: float = 0.0
    moved: frozenset[str] = frozenset()
    pieces: frozenset[str] = frozenset()
    alternatives: dict[str, tuple[Alternative, ...]] = field(default_factory=dict)
    choices: tuple[int, ...] = ()
    styles: dict[str, int] = field(default_factory=dict)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies, the axiom last."""
        drawn = (each.body for several in self.alternatives.values() for each in several)
        return (*self.rules.values(), *drawn, self.start)


@dataclass(slots=True, eq=False)
class Drawn:
    """Segments start, end (n,) in the frame of what drew them, with the numbers of their styles,
    and where the turtle stands then: position and factor (heading and scale as one number).
    """

    start: Complexes
    end: Complexes
    style: Integers
    at: complex
    factor: complex


DRAW = "draw"  # what stands for the plain command in `Recursion.styles`
PLAIN_DRAW = -1  # its style until the whole is drawn

Known: TypeAlias = "dict[tuple[str, int], Drawn]"


_NOTHING = np.zeros(0, np.complex128), np.zeros(0, np.complex128), np.zeros(0, np.int64)


@dataclass(slots=True, eq=False)
class _Turtle:
    at: complex = 0j
    factor: complex = 1 + 0j
    parts: list[tuple[Complexes, Complexes, Integers]] = field(default_factory=list)


def expand(recursion: Recursion) -> Drawn:
    """What the recursion draws, placed, units."""
    known: Known = {}
    for steps in range(recursion.steps + 1):
        for name, body in recursion.rules.items():
            known[name, steps] = _symbol(recursion, known, name, body, steps)
    drawn = _derived(recursion, known)
    drawn.style[drawn.style == PLAIN_DRAW] = recursion.styles.get(DRAW, 0)
    placed = recursion.step * complex(unit(np.array(recursion.heading)))
    return Drawn(
        drawn.start * placed + recursion.at,
        drawn.end * placed + recursion.at,
        drawn.style,
        drawn.at * placed + recursion.at,
        drawn.factor * placed,
    )


def _derived(recursion: Recursion, known: Known) -> Drawn:
    """The axiom after all steps, with the choices that were taken."""
    if not recursion.alternatives:
        return _drawn(recursion.start, known, recursion.steps)
    ((name, alternatives),) = recursion.alternatives.items()
    bodies = [alternative.body for alternative in alternatives]
    taken = iter(recursion.choices)
    string: Body = recursion.start
    for steps in range(recursion.steps, 0, -1):
        string = _rewritten(string, name, bodies, taken, known, steps - 1)
    known[name, 0] = _symbol(recursion, known, name, (), 0)
    return _drawn(string, known, 0)


def _rewritten(
    string: Body, name: str, bodies: list[Body], taken: Iterator[int], known: Known, steps: int
) -> Body:
    """One generation on, left to right; the other symbols are replaced by what they draw."""
    made: list[Command] = []
    for command in string:
        match command:
            case Symbol(other) if other == name:
                made += _finished(bodies[next(taken)], name, known, steps)
            case Branch(inner):
                made.append(Branch(_rewritten(inner, name, bodies, taken, known, steps)))
            case _:
                made.append(command)
    return tuple(made)


def _finished(body: Body, name: str, known: Known, steps: int) -> list[Command]:
    """The body with its other symbols replaced by what they draw with so many steps left."""
    made: list[Command] = []
    for command in body:
        match command:
            case Symbol(other) if other != name:
                made.append(Done(known[other, steps]))
            case Branch(inner):
                made.append(Branch(tuple(_finished(inner, name, known, steps))))
            case _:
                made.append(command)
    return made


def _symbol(recursion: Recursion, known: Known, name: str, body: Body, steps: int) -> Drawn:
    if steps:
        return _drawn(body, known, steps - 1)
    last: Body = (Draw(),) if name in recursion.drawn else ()
    made = _drawn((Move(),) if name in recursion.moved else last, known, 0)
    made.style[:] = recursion.styles.get(name, 0)
    return made


def _drawn(body: Body, known: Known, steps: int) -> Drawn:
    turtle = _Turtle()
    _run(body, known, steps, turtle)
    parts = turtle.parts or [_NOTHING]
    start, end, style = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return Drawn(start, end, style, turtle.at, turtle.factor)


def _run(body: Body, known: Known, steps: int, turtle: _Turtle) -> None:
    for command in body:
        match command:
            case Turn():
                turtle.factor *= complex(unit(np.array(command.angle)))
            case Grow():
                turtle.factor *= command.factor
            case Draw():
                end = turtle.at + turtle.factor * command.length
                turtle.parts.append(
                    (np.array([turtle.at]), np.array([end]), np.full(1, PLAIN_DRAW))
                )
                turtle.at = end
            case Move():
                turtle.at += turtle.factor * command.length
            case Symbol(name):
                _follow(turtle, known[name, steps])
            case Done(drawn):
                _follow(turtle, drawn)
            case Again(count, inner):
                drawn = _drawn(inner, known, steps)
                for _ in range(count):
                    _follow(turtle, drawn)
            case Branch():
                saved = turtle.at, turtle.factor
                _run(command.body, known, steps, turtle)
                turtle.at, turtle.factor = saved


def _follow(turtle: _Turtle, inner: Drawn) -> None:
    """Draws what a symbol draws, and goes where it goes."""
    start = turtle.at + turtle.factor * inner.start
    end = turtle.at + turtle.factor * inner.end
    turtle.parts.append((start, end, inner.style))
    turtle.at += turtle.factor * inner.at
    turtle.factor *= inner.factor


def largest_error(drawn: Drawn, start: Complexes, end: Complexes) -> float:
    """Units; infinite where the counts differ."""
    if len(drawn.start) != len(start):
        return float("inf")
    return float(max(np.abs(drawn.start - start).max(), np.abs(drawn.end - end).max()))
