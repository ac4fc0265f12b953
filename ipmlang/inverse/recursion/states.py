"""Where the turtle stands before and after each element of a body, at every level.

In come strokes, sizes and a layout; out come, per level, the elements' states in the frame of the
symbol whose body it is. What counts as the frame of a symbol (a gauge) and after which element its
turtle leaves are choices; the caller tries them until the states are the same at all levels, as a
body that does not know its level needs. Only geometry here, no commands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.inverse.recursion.layout import Layout
from ipmlang.inverse.recursion.sizes import Sizes
from ipmlang.inverse.recursion.strokes import MIRRORED, REVERSED, Strokes

Gauge: TypeAlias = "Literal['piece', 'first', 'chord', 'last']"
GAUGES: tuple[Gauge, ...] = ("piece", "first", "chord", "last")


@dataclass(frozen=True, slots=True)
class Element:
    """variant: of a copy, None for a piece; first, count: the segments it covers."""

    variant: int | None
    first: int
    count: int


@dataclass(frozen=True, slots=True)
class State:
    """Position and factor (heading and scale) at the start and at the end, units of the drawing."""

    at: complex
    factor: complex
    exit_at: complex
    exit_factor: complex


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """gauge, and `leaves`: 0 if the turtle leaves the body where it began, else the number of the
    element, counted from 1, after which it does.
    """

    gauge: Gauge
    leaves: int


def elements(layout: Layout, count: int, piece: int) -> list[Element]:
    """The elements of a run whose copies have `count` segments and whose pieces `piece`."""
    made, place, spent = [], 0, 0
    for before, variant in zip(
        (*layout.before, layout.pieces), (*layout.variant, None), strict=True
    ):
        for _ in range(before - spent):
            made.append(Element(None, place, piece))
            place += piece
        spent = before
        if variant is not None:
            made.append(Element(variant, place, count))
            place += count
    return made


def level_strokes(strokes: Strokes, sizes: Sizes, layout: Layout, first: int) -> list[Strokes]:
    """The plain symbol's own segments by the number of steps left, empty where it draws none."""
    result = [strokes.part(first, sizes.count(sizes.steps))]
    for steps in range(sizes.steps, 0, -1):
        count = sizes.count(steps - 1)
        start = int(layout.starts(count, sizes.piece(steps - 1))[0])
        result.append(result[-1].part(start, count).seen_as(layout.variant[0]))
    return result[::-1]


def exits(sizes: Sizes, layout: Layout, leaves: int) -> list[int]:
    """By steps left: the segment at whose end the turtle leaves the symbol, -1: where it began."""
    found = [0 if sizes.drawn else -1]
    for steps in range(1, sizes.steps + 1):
        found.append(_exit(layout, sizes, steps, leaves, found[-1]))
    return found


def _exit(layout: Layout, sizes: Sizes, steps: int, leaves: int, inner: int) -> int:
    if leaves == 0:
        return -1
    inside = elements(layout, sizes.count(steps - 1), sizes.piece(steps - 1))
    last = inside[leaves - 1]
    if last.variant is not None and last.count == 0:
        pieces = [each for each in inside[: leaves - 1] if each.variant is None]
        return pieces[-1].first + pieces[-1].count - 1 if pieces else -1
    if last.variant is None:
        return last.first + last.count - 1
    if last.variant & REVERSED:
        return last.first + last.count - 1
    return last.first + inner if inner >= 0 else -1


def symbol_state(own: Strokes, gauge: Gauge, leaves_at: int, piece: Element | None) -> State | None:
    """Of the plain symbol that draws `own`; None where the gauge says nothing."""
    at = complex(own.start[0])
    out = at if leaves_at < 0 else complex(own.end[leaves_at])
    first = complex(own.along[0])
    factor: complex
    match gauge:
        case "first":
            factor = first
        case "last":
            factor = complex(own.along[-1])
        case "chord":
            chord = out - at
            if abs(chord) <= 16 * own.tolerance:
                return None
            factor = chord / abs(chord) * abs(first)
        case "piece":
            factor = first if piece is None else complex(own.along[piece.first])
    return State(at, factor, out, factor)


def placed_state(state: State, variant: int) -> State:
    """The state of a copy from that of the plain symbol its segments were seen as."""
    at, factor, out, last = state.at, state.factor, state.exit_at, state.exit_factor
    if variant & MIRRORED:
        at, factor, out, last = (
            at.conjugate(),
            factor.conjugate(),
            out.conjugate(),
            last.conjugate(),
        )
    if variant & REVERSED:
        at, factor, out, last = out, -last, at, -factor
    return State(at, factor, out, last)


def piece_state(own: Strokes, element: Element) -> State | None:
    """Of a piece, None if it is bent: its factor is the heading and the length of one segment."""
    last = element.first + element.count - 1
    start, end = complex(own.start[element.first]), complex(own.end[last])
    factor = complex(own.along[element.first])
    if element.count > 1:
        along = start + (end - start) / element.count * np.arange(1, element.count)
        gap = np.abs(own.start[element.first + 1 : last + 1] - along).max()
        gap = max(gap, np.abs(own.end[element.first : last] - along).max())
        if gap > own.tolerance * 2:
            return None
    return State(start, factor, end, factor)


def body_states(
    own: Strokes,
    inside: list[Element],
    gauge: Gauge,
    inner_exit: int,
    inner_piece: Element | None,
) -> list[State] | None:
    """The states of all elements of one body, units of the drawing."""
    states = []
    for element in inside:
        if element.variant is None:
            state = piece_state(own, element)
        else:
            seen = own.part(element.first, element.count).seen_as(element.variant)
            plain = symbol_state(seen, gauge, inner_exit, inner_piece)
            state = placed_state(plain, element.variant) if plain is not None else None
        if state is None:
            return None
        states.append(state)
    return states


def relative(states: list[State], frame: State) -> list[State]:
    """The states as seen from a symbol's start."""
    return [
        State(
            (each.at - frame.at) / frame.factor,
            each.factor / frame.factor,
            (each.exit_at - frame.at) / frame.factor,
            each.exit_factor / frame.factor,
        )
        for each in states
    ]


def first_piece(inside: list[Element]) -> Element | None:
    """The first piece of a body."""
    return next((each for each in inside if each.variant is None), None)
