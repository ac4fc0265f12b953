"""Frames that read well: of all equivalent ways to write a placement, the one with fewest tokens.

Takes a book of rules; symmetric shapes are placed unturned and unmirrored where they can be, and
each rule's own frame is turned so that most of its uses are plain. What is drawn stays the same.
"""

from __future__ import annotations

from dataclasses import replace

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
    _absorb_turns(book)
    for rule in _downwards(book):
        if rule != AXIOM and not in_loop(book, rule):
            _turn_rule(book, alphabet, rule)
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


def _absorb_turns(book: Book) -> None:
    """What a row turns each copy by becomes part of the copy, where only that row names it."""
    for loop in book.loops.values():
        turn = loop.pattern.base[0]
        if loop.pattern.kind != "listed" or abs(turn) <= SMALL or loop.part not in book.bodies:
            continue
        if book.uses()[loop.part] == 1:
            regauge(book, loop.part, frames(np.zeros(1, np.complex128), -turn))
            loop.pattern = replace(loop.pattern, base=(0.0, 0.0, 0.0, 0.0))


def _turn_rule(book: Book, alphabet: Alphabet, rule: int) -> None:
    """Give a rule the frame, among those of its uses, that takes fewest tokens in all."""
    uses = join([body.places[naming(book, body, rule)] for body in book.bodies.values()])
    if not len(uses.x):
        return
    back = inverse(frames(np.zeros(len(uses.x), np.complex128), uses.angle, 1.0, uses.handedness))
    kinds = np.stack([np.round(back.angle, 6), back.handedness], axis=1)
    _, first, often = np.unique(kinds, axis=0, return_index=True, return_counts=True)
    order = np.lexsort((first, -often))[:CANDIDATES]
    turns = [back[first[k] : first[k] + 1] for k in order.tolist()]
    if rule in book.loops:
        turns = [turn for turn in turns if _turnable(book, alphabet, rule, turn)]
    options = [identity(1), *turns]
    costs = [_cost(book, alphabet, rule, uses, option) for option in options]
    best = int(np.argmin(costs))
    if costs[best] < costs[0]:
        _turn(book, rule, options[best])


def _cost(book: Book, alphabet: Alphabet, rule: int, uses: Frames, change: Frames) -> int:
    """Tokens of all uses and of the rule itself after a change of its frame."""
    total = int(placement_tokens(compose(uses, change), book.small).sum())
    if rule in book.loops:
        step = _turned(book.loops[rule].pattern, change).base
        return total + sum(1 + (each < 0) for each in step[:2] if abs(each) > book.small)
    body = book.bodies[rule]
    places = compose(inverse(change), body.places)
    for part in np.unique(body.parts).tolist():
        rows = np.flatnonzero(body.parts == part)
        if alphabet[part].terminal and part not in book.assets:
            group = alphabet[part].stabiliser
            better = simplest_of(places[rows], group, alphabet[part].free, book.small)
            total += int(placement_tokens(better, book.small).sum())
        else:
            total += int(placement_tokens(places[rows], book.small).sum())
    return total


def _turn(book: Book, rule: int, change: Frames) -> None:
    """Change the frame of a rule; a loop takes what it repeats along."""
    if rule in book.bodies:
        regauge(book, rule, change)
    elif rule in book.loops:
        loop = book.loops[rule]
        place = loop.where
        regauge(book, rule, change)
        loop.where, loop.pattern = place, _turned(loop.pattern, change)
        _turn(book, book.family.get(loop.part, loop.part), change)


def _turned(pattern: Pattern, change: Frames) -> Pattern:
    """The pattern of a straight row whose frame, and whose members' frames, take a change."""
    if pattern.kind == "listed":
        return replace(pattern, base=(pattern.base[0] * int(change.handedness[0]), 0.0, 0.0, 0.0))
    step = compose(inverse(change), frames(np.array([complex(*pattern.base[:2])])))
    return replace(pattern, base=(float(step.x[0]), float(step.y[0]), 0.0, 0.0))


def _turnable(book: Book, alphabet: Alphabet, rule: int, change: Frames) -> bool:
    """Whether a straight row can be turned together with what it repeats: that must look the same
    afterwards, or be named nowhere else.
    """
    loop = book.loops[rule]
    _, _, angle, growth = loop.pattern.base
    straight = loop.pattern.kind == "even" and abs(angle) <= SMALL and abs(growth) <= SMALL
    ahead = complex(change.factor[0]) * int(change.handedness[0])
    if not straight and not (loop.pattern.kind == "listed" and abs(ahead - 1) <= SMALL):
        return False
    part = book.family.get(loop.part, loop.part)
    if part in book.loops:
        return book.uses()[part] == 1 and _turnable(book, alphabet, part, change)
    if part in book.bodies:
        return book.uses()[part] == 1
    return _keeps(alphabet, part, change)


def _keeps(alphabet: Alphabet, terminal: int, change: Frames) -> bool:
    """Whether a change of frame maps a terminal onto itself."""
    definition = alphabet[terminal]
    group = definition.stabiliser
    same = (np.abs(group.factor - change.factor) <= SMALL) & (np.abs(group.position) <= SMALL)
    return definition.free or bool((same & (group.handedness == change.handedness)).any())
