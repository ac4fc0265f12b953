"""From a layout to a program: choices of frames are tried until one body fits every level.

In come strokes with the layouts of the axiom and of the body; out comes a program with one symbol
for each way in which the copies are seen (plain, mirrored, backwards, both). It has not been proven
yet. Nothing here looks for layouts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.recursion.attach import Hop, Leap, Level, Tree, Write, attach, commands
from ipmlang.inverse.recursion.layout import Layout
from ipmlang.inverse.recursion.program import (
    Body,
    Branch,
    Command,
    Draw,
    Grow,
    Move,
    Recursion,
    Symbol,
    Turn,
)
from ipmlang.inverse.recursion.sizes import Sizes
from ipmlang.inverse.recursion.states import (
    GAUGES,
    Element,
    Gauge,
    State,
    body_states,
    elements,
    exits,
    first_piece,
    level_strokes,
    relative,
    symbol_state,
)
from ipmlang.inverse.recursion.strokes import MIRRORED, REVERSED, Strokes

PIECE, MOVE = "piece", "move"
MOST_HOPS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What the segments say: the sizes, where the copies are in axiom and body."""

    strokes: Strokes
    sizes: Sizes
    axiom: Layout
    body: Layout

    @property
    def first(self) -> int:
        """The first segment of the axiom's first copy."""
        return self.axiom.before[0] * self.sizes.piece(self.sizes.steps)


def programs(found: Found) -> Iterator[Recursion]:
    """Programs for one finding, the most likely first."""
    own = level_strokes(found.strokes, found.sizes, found.body, found.first)
    count = found.sizes.copies + found.sizes.pieces
    for gauge in GAUGES:
        if gauge == "piece" and not found.sizes.pieces:
            continue
        if not _steady(found, own, gauge, count):
            continue
        tries = (
            _program(found, own, gauge, leaves, hopping)
            for hopping in (False, True)
            for leaves in range(count, -1, -1)
        )
        made = next((each for each in tries if each is not None), None)
        if made is not None:
            yield made


def _steady(found: Found, own: list[Strokes], gauge: Gauge, leaves: int) -> bool:
    """Whether the elements stand at the same angles and scales at every level."""
    levels = _levels(found, own, gauge, leaves)
    if not levels:
        return False
    factors = [np.array([state.factor for state in level.states]) for level in levels]
    return all(
        bool(np.all(np.abs(factor - factors[0]) <= level.slack + levels[0].slack))
        for factor, level in zip(factors, levels, strict=True)
    )


def _levels(found: Found, own: list[Strokes], gauge: Gauge, leaves: int) -> list[Level]:
    """All bodies whose copies draw something, top level first; empty if the gauge does not do."""
    sizes, out = found.sizes, exits(found.sizes, found.body, leaves)
    levels = []
    for steps in range(sizes.steps, 0, -1):
        if sizes.count(steps - 1) == 0:
            break
        inside = elements(found.body, sizes.count(steps - 1), sizes.piece(steps - 1))
        lower = _own_piece(found, steps - 1)
        frame = symbol_state(own[steps], gauge, out[steps], first_piece(inside))
        states = body_states(own[steps], inside, gauge, out[steps - 1], lower)
        if frame is None or states is None:
            return []
        slack = 8 * found.strokes.tolerance / abs(frame.factor)
        levels.append(Level(_lengthless(relative(states, frame), inside), slack, steps - 1))
    return levels


def _own_piece(found: Found, steps: int) -> Element | None:
    """The first piece of the body of a symbol with so many steps left."""
    if steps == 0:
        return None
    sizes = found.sizes
    return first_piece(elements(found.body, sizes.count(steps - 1), sizes.piece(steps - 1)))


def _lengthless(states: list[State], inside: list[Element]) -> list[State]:
    """A piece has the turtle's scale, whatever its length."""
    return [
        state
        if element.variant is not None
        else State(
            state.at,
            state.factor / abs(state.factor),
            state.exit_at,
            state.factor / abs(state.factor),
        )
        for state, element in zip(states, inside, strict=True)
    ]


def _program(
    found: Found, own: list[Strokes], gauge: Gauge, leaves: int, hopping: bool
) -> Recursion | None:
    levels = _levels(found, own, gauge, leaves)
    if not levels:
        return None
    tree = attach(levels, hopping)
    if tree is None:
        return None
    top = _axiom_states(found, own, gauge, leaves)
    if top is None:
        return None
    start_tree = attach([top], hopping)
    if start_tree is None:
        return None
    inside = elements(found.body, 1, 1)
    followed = _followed(tree, inside) or _followed(start_tree, elements(found.axiom, 1, 1))
    strides = {hop.growth for hop in tree.hops if hop is not None and hop.growth > 1}
    if len(strides) > 1:
        return None
    stride = max(strides, default=1)
    leap = _leaper(stride, 0)
    end = leaves if followed else None
    body = commands(tree, levels[0].states, end, _writer(found, inside), leap)
    writer = _writer(found, elements(found.axiom, 1, 1))
    start = commands(start_tree, top.states, None, writer, _leaper(stride, found.sizes.steps))
    if body is None or start is None:
        return None
    return _closed(found, body, start, stride)


def _axiom_states(found: Found, own: list[Strokes], gauge: Gauge, leaves: int) -> Level | None:
    sizes = found.sizes
    out = exits(sizes, found.body, leaves)[sizes.steps]
    inside = elements(found.axiom, sizes.count(sizes.steps), sizes.piece(sizes.steps))
    states = body_states(found.strokes, inside, gauge, out, _own_piece(found, sizes.steps))
    if states is None:
        return None
    scale = abs(states[[each.variant is not None for each in inside].index(True)].factor)
    heading = states[0].factor / abs(states[0].factor)
    frame = State(states[0].at, heading * scale, 0j, 1 + 0j)
    slack = 8 * found.strokes.tolerance / scale
    return Level(_lengthless(relative(states, frame), inside), slack, sizes.steps)


def _followed(tree: Tree, inside: list[Element]) -> bool:
    """Whether anything begins where a copy ends."""
    return any(node and inside[node - 1].variant is not None for node in tree.parent)


def _writer(found: Found, inside: list[Element]) -> Write:
    """Names the elements of a body."""

    def write(index: int) -> Command:
        variant = inside[index].variant
        if variant is not None:
            return Symbol(_name(variant))
        return Draw() if found.sizes.growth == 1 else Symbol(PIECE)

    return write


def _leaper(stride: int, steps: int) -> Leap:
    """Writes hops where what moves grows `stride`-fold in each of so many steps. Lengths that are
    no whole number of steps then, or do not grow, are moves.
    """

    def leap(hop: Hop) -> list[Command]:
        length = hop.length / stride**steps
        whole = round(length)
        grows = stride > 1 and (hop.growth == stride or steps > 0)
        if grows and abs(length - whole) < 0.01 and 1 <= whole <= MOST_HOPS:
            return [Symbol(MOVE)] * whole
        return [Move(hop.length)]

    return leap


def _name(variant: int) -> str:
    return f"copy{variant}"


def _closed(found: Found, body: Body, start: Body, stride: int) -> Recursion | None:
    """The rules of all variants that are reached."""
    rules: dict[str, Body] = {}
    todo = sorted(_variants(start))
    while todo:
        variant = todo.pop(0)
        if _name(variant) in rules:
            continue
        own = seen_body(body, variant)
        if own is None:
            return None
        rules[_name(variant)] = own
        todo += sorted(_variants(own))
    drawn = set(rules) if found.sizes.drawn else set()
    growth = found.sizes.growth
    if growth > 1:
        rules[PIECE] = (Symbol(PIECE),) * growth
        drawn.add(PIECE)
    if stride > 1:
        rules[MOVE] = (Symbol(MOVE),) * stride
    return Recursion(
        rules,
        start,
        found.sizes.steps,
        frozenset(drawn),
        1.0,
        moved=frozenset({MOVE} & rules.keys()),
        pieces=frozenset({PIECE, MOVE} & rules.keys()),
    )


def _variants(body: Body) -> set[int]:
    found: set[int] = set()
    for command in body:
        match command:
            case Symbol(name) if name not in (PIECE, MOVE):
                found.add(int(name[-1]))
            case Branch(inner):
                found |= _variants(inner)
            case _:
                pass
    return found


def seen_body(body: Body, variant: int) -> Body | None:
    """The body as a mirror sees it, or backwards; None where brackets forbid it.

    >>> seen_body((Turn(90.0), Symbol("copy0")), REVERSED)
    (Symbol(name='copy2'), Turn(angle=-90.0))
    """
    if variant & REVERSED:
        if any(isinstance(command, Branch) for command in body):
            return None
        body = body[::-1]
    made: list[Command] = []
    for command in body:
        inner = _seen_command(command, variant)
        if inner is None:
            return None
        made.append(inner)
    return tuple(made)


def _seen_command(command: Command, variant: int) -> Command | None:
    match command:
        case Turn(angle):
            back = bool(variant & MIRRORED) != bool(variant & REVERSED)
            return Turn(-angle if back and abs(angle) < 180 else angle)
        case Grow(factor):
            return Grow(1 / factor if variant & REVERSED else factor)
        case Symbol(name) if name not in (PIECE, MOVE):
            return Symbol(_name(int(name[-1]) ^ variant))
        case Branch(inner):
            seen = seen_body(inner, variant)
            return None if seen is None else Branch(seen)
        case _:
            return command
