"""Frames that read well: of all equivalent ways to write a placement, the one with fewest tokens.

Takes a book of rules; symmetric shapes are placed unturned and unmirrored where they can be, and
each rule's own frame is turned so that most of its uses are plain. What is drawn stays the same.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.lsystem.frames import (
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
    replaced,
)
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.lsystem.symbols import Alphabet
from ipmlang.inverse.score import SMALL, placement_tokens
from ipmlang.inverse.simplify import AXIOM, Book, in_loop, naming, regauge

CANDIDATES = 6  # frames tried for one rule
MANY = 64  # equivalent frames beyond which a shape is left as it is placed


def make_upright(book: Book, alphabet: Alphabet) -> None:
    """Plain placements of symmetric symbols, then plain frames of rules, from the axiom down."""
    _place_simply(book, alphabet, every=True)
    for rule in _downwards(book):
        if rule != AXIOM and not in_loop(book, rule):
            _turn_rule(book, rule)
    _place_simply(book, alphabet, every=False)


def _downwards(book: Book) -> list[int]:
    """Rules before those that they name: later symbols are made of earlier ones."""
    return [AXIOM, *sorted((r for r in (*book.bodies, *book.loops) if r != AXIOM), reverse=True)]


# ------------------------------------------------------------------------ placements


def _place_simply(book: Book, alphabet: Alphabet, every: bool) -> None:
    """Equivalent frames with fewest tokens; `every`: for rules too, whose frames are as found."""
    for body in book.bodies.values():
        for part in np.unique(body.parts).tolist():
            definition = alphabet[part]
            plain = definition.terminal and part not in book.assets
            if not (plain or every) or len(definition.stabiliser) > MANY:
                continue
            if len(definition.stabiliser) > 1 or definition.free:
                rows = np.flatnonzero(body.parts == part)
                better = simplest_of(
                    body.places[rows], definition.stabiliser, definition.free, book.small
                )
                body.places = replaced(body.places, rows, better)


def simplest_of(places: Frames, group: Frames, free: bool, small: float) -> Frames:
    """(n,) for each place the equivalent one that takes fewest tokens; the given one on a tie."""
    if free:
        return frames(places.position, 0.0, places.scale)
    every = compose(places[:, None], group)
    cost = placement_tokens(every, small)
    best = np.argmin(cost, axis=1)
    return every[np.arange(len(places)), best]


# ------------------------------------------------------------------------ rules


def _turn_rule(book: Book, rule: int) -> None:
    """Give a rule the frame, among those of its uses, that takes fewest tokens in all."""
    uses = _uses(book, rule)
    if not len(uses.x) or (rule in book.loops and not _turnable(book, rule)):
        return
    back = inverse(frames(np.zeros(len(uses.x), np.complex128), uses.angle, 1.0, uses.handedness))
    kinds = np.stack([np.round(back.angle, 6), back.handedness], axis=1)
    _, first, often = np.unique(kinds, axis=0, return_index=True, return_counts=True)
    order = np.lexsort((first, -often))[:CANDIDATES]
    options = [identity(1), *(back[first[k] : first[k] + 1] for k in order.tolist())]
    costs = [_cost(book, rule, uses, option) for option in options]
    best = int(np.argmin(costs))
    if best and costs[best] < costs[0]:
        _turn(book, rule, options[best])


def _uses(book: Book, rule: int) -> Frames:
    return join([body.places[naming(book, body, rule)] for body in book.bodies.values()])


def _cost(book: Book, rule: int, uses: Frames, change: Frames) -> int:
    total = int(placement_tokens(compose(uses, change), book.small).sum())
    if rule in book.bodies:
        inner = compose(inverse(change), book.bodies[rule].places)
        return total + int(placement_tokens(inner, book.small).sum())
    x, y = _turned_step(book.loops[rule].pattern, change)
    return total + sum(1 + (each < 0) for each in (x, y) if abs(each) > book.small)


def _turn(book: Book, rule: int, change: Frames) -> None:
    if rule in book.bodies:
        regauge(book, rule, change)
        return
    loop = book.loops[rule]
    part = book.family.get(loop.part, loop.part)
    x, y = _turned_step(loop.pattern, change)
    place = loop.where
    regauge(book, rule, change)
    loop.where = place
    loop.pattern = Pattern("even", (x, y, 0.0, 0.0))
    if part in book.loops:
        _turn(book, part, change)
    else:
        regauge(book, part, change)


def _turned_step(pattern: Pattern, change: Frames) -> tuple[float, float]:
    step = compose(inverse(change), frames(np.array([complex(*pattern.base[:2])])))
    return float(step.x[0]), float(step.y[0])


def _turnable(book: Book, rule: int) -> bool:
    """Whether a row can be turned together with what it repeats, which nothing else may name."""
    loop = book.loops[rule]
    _, _, angle, growth = loop.pattern.base
    straight = loop.pattern.kind == "even" and abs(angle) <= SMALL and abs(growth) <= SMALL
    part = book.family.get(loop.part, loop.part)
    if not straight or book.uses()[part] != 1:
        return False
    return part in book.bodies or (part in book.loops and _turnable(book, part))
