"""Frames that read well: of all equivalent ways to write a placement, the one with fewest tokens.

Takes a book of rules; symmetric shapes are placed unturned and unmirrored where they can be, and
each rule's own frame is turned so that most of its uses are plain. What is drawn stays the same.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

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
from ipmlang.inverse.lsystem.symbols import Alphabet, Integers
from ipmlang.inverse.score import SMALL, placement_tokens
from ipmlang.inverse.simplify import AXIOM, Body, Book, in_loop, naming, regauge

CANDIDATES = 6  # frames tried for one rule
MANY = 64  # equivalent frames beyond which a shape is left as it is placed


def make_upright(book: Book, alphabet: Alphabet) -> None:
    """Plain placements of symmetric symbols, then plain frames of rules, from the axiom down."""
    _place_simply(book, alphabet, every=True)
    _absorb_insides(book)
    for rule in _downwards(book):
        if rule != AXIOM and rule not in book.anchored and not in_loop(book, rule):
            _turn_rule(book, alphabet, rule)
    _place_simply(book, alphabet, every=False)
    _turn_terminals(book, alphabet)


def _downwards(book: Book) -> list[int]:
    """Rules before those that they name: later symbols are made of earlier ones."""
    return [AXIOM, *sorted(book.rules(), reverse=True)]


# ------------------------------------------------------------------------ placements


def _place_simply(book: Book, alphabet: Alphabet, every: bool) -> None:
    """Equivalent frames with fewest tokens; `every`: for rules too, whose frames are as found."""
    named: dict[int, list[tuple[Body, Integers]]] = {}
    for body in book.bodies.values():
        for part, rows in body.rows.items():
            named.setdefault(part, []).append((body, rows))
    for part, uses in named.items():
        definition, group = alphabet[part], alphabet[part].stabiliser
        plain = definition.terminal and part not in book.assets
        if not (plain or every) or len(group) > MANY or (len(group) == 1 and not definition.free):
            continue
        places = join([body.places[rows] for body, rows in uses])
        better, before = simplest_of(places, group, definition.free, book.small), 0
        for body, rows in uses:
            body.places = replaced(body.places, rows, better[before : before + len(rows)])
            before += len(rows)


def simplest_of(places: Frames, group: Frames, free: bool, small: float) -> Frames:
    """(n,) for each place the equivalent one that takes fewest tokens; the given one on a tie."""
    every = _equivalent(places, group, free)
    best = np.argmin(placement_tokens(every, small), axis=1)
    return every[np.arange(len(places)), best]


def _equivalent(places: Frames, group: Frames, free: bool) -> Frames:
    """(..., k) the frames at which a symbol looks as it does at places (...); of those that any
    turn keeps the plain one.
    """
    if free:
        return frames(places.position, 0.0, places.scale)[..., None]
    return compose(places[..., None], group)


# ------------------------------------------------------------------------ rules


def _absorb_insides(book: Book) -> None:
    """What a sequence turns and moves each copy by becomes part of the copy, where that is shorter.

    A sequence's own frame is bound to its pattern, so copies that are sequences stay.
    """
    for loop in book.loops.values():
        inside = loop.pattern.inside
        part = book.family.get(loop.part, loop.part)
        if not (loop.pattern.rest or loop.pattern.inner) or part in book.loops:
            continue
        if part in book.anchored or part in {each.part for each in book.trees.values()}:
            continue
        change = inverse(inside)
        before, after = _uses(book, part, identity(1)), _uses(book, part, change)
        if after < before:
            regauge(book, part, change)


def _uses(book: Book, part: int, change: Frames) -> int:
    """Tokens of all places of a symbol after a change of its frame."""
    total = 0
    for name, rows in naming(book, part):
        places = compose(book.bodies[name].places[rows], change)
        total += int(placement_tokens(places, book.small).sum())
    for loop in book.loops.values():
        if book.family.get(loop.part, loop.part) == part:
            inside = compose(loop.pattern.inside, change)
            total += int(placement_tokens(inside, book.small)[0])
    return total


def _places_of(book: Book, part: int) -> Frames:
    """All places of a rule or terminal, those in the same body together."""
    return join([book.bodies[name].places[rows] for name, rows in naming(book, part)])


def _are_plain(places: Frames) -> bool:
    """Whether all are moved alone."""
    turned = places.angle.any() or (places.scale != 1).any()
    return not turned and bool((places.handedness > 0).all())


def _turn_rule(book: Book, alphabet: Alphabet, rule: int) -> None:
    """Give a rule the frame, among those of its uses, that takes fewest tokens in all."""
    uses = _places_of(book, rule)
    if _are_plain(uses):
        return
    nowhere = np.zeros(len(uses.x), np.complex128)
    back = inverse(frames(nowhere, uses.angle, uses.scale, uses.handedness))
    kinds = zip(
        np.round(back.angle, 6).tolist(),
        back.handedness.tolist(),
        np.round(back.scale, 6).tolist(),
        strict=True,
    )
    alike: dict[tuple[float, int, float], list[int]] = {}
    for row, kind in enumerate(kinds):
        alike.setdefault(kind, []).append(row)
    often = sorted(alike.values(), key=lambda rows: (-len(rows), rows[0]))[:CANDIDATES]
    turns = [back[rows[0] : rows[0] + 1] for rows in often]
    if rule in book.loops:
        turns = [turn for turn in turns if _turnable(book, alphabet, rule, turn)]
    options = join([identity(1), *turns])
    costs = _costs(book, alphabet, rule, uses, options)
    best = int(np.argmin(costs))
    if costs[best] < costs[0]:
        _turn(book, rule, options[best : best + 1])


def _turn_terminals(book: Book, alphabet: Alphabet) -> None:
    """Turn and size an asset as the rules that name it do, where that takes fewer tokens: what is
    slanted in the drawing may be plain in its own rule. What is named outside of rules stays.
    """
    outside = {part for rule in book.written_once() for part in book.bodies[rule].rows}
    # What is named once takes its whole place into its asset, see `settle_terminals`.
    often = (part for part, count in book.uses().items() if count > 1)
    for part in sorted(part for part in often if alphabet[part].terminal):
        if part in outside or part in book.assets or in_loop(book, part):
            continue
        uses = _places_of(book, part)
        if _are_plain(uses):
            continue
        nowhere = np.zeros(len(uses), np.complex128)
        options = inverse(frames(nowhere, uses.angle, uses.scale, uses.handedness))[:CANDIDATES]
        costs = placement_tokens(compose(uses, options[:, None]), book.small).sum(axis=1)
        best = int(np.argmin(costs))
        if costs[best] < int(placement_tokens(uses, book.small).sum()):
            regauge(book, part, options[best : best + 1])


def settle_terminals(book: Book, alphabet: Alphabet) -> None:
    """What one rule alone names, and once, takes its place there into its asset: the parts of a
    thing lie in their file as they lie in the thing. What is named outside of rules stays.
    """
    used = book.uses()
    for rule in sorted(book.bodies.keys() - book.written_once()):
        body = book.bodies[rule]
        moved = placement_tokens(body.places, 0.0) > 1
        once = [used[part] == 1 and alphabet[part].terminal for part in body.parts.tolist()]
        rows = np.flatnonzero(moved & np.array(once))
        for row in rows.tolist():
            part = int(body.parts[row])
            own = book.assets.get(part, identity(1))
            book.assets[part] = compose(body.places[row : row + 1], own)
        body.places = replaced(body.places, rows, identity(len(rows)))


def _costs(
    book: Book, alphabet: Alphabet, rule: int, uses: Frames, changes: Frames
) -> NDArray[np.int64]:
    """(k,) tokens of all uses and of the rule itself after each change of its frame."""
    every = placement_tokens(compose(uses, changes[:, None]), book.small)
    totals: NDArray[np.int64] = every.sum(axis=1)
    if rule in book.loops:
        pattern = book.loops[rule].pattern
        for k in range(len(changes)):
            step = _turned(pattern, changes[k : k + 1]).base
            totals[k] += sum(1 + (each < 0) for each in step[:2] if abs(each) > book.small)
        return totals
    body = book.bodies[rule]
    places = compose(inverse(changes)[:, None], body.places)
    plain = np.ones(len(body.parts), np.bool_)
    for part in body.rows:
        group = alphabet[part].stabiliser
        several = alphabet[part].free or len(group) > 1
        if several and alphabet[part].terminal and part not in book.assets:
            own = body.rows[part]
            plain[own] = False
            equal = _equivalent(places[:, own], group, alphabet[part].free)
            totals += placement_tokens(equal, book.small).min(axis=-1).sum(axis=-1)
    totals += placement_tokens(places[:, plain], book.small).sum(axis=-1)
    return totals


def _turn(book: Book, rule: int, change: Frames) -> None:
    """Change the frame of a rule; a loop takes what it repeats along."""
    if rule in book.bodies:
        regauge(book, rule, change)
    elif rule in book.loops:
        loop = book.loops[rule]
        inside = compose(compose(inverse(change), loop.pattern.inside), change)
        regauge(book, rule, change)
        _turn(book, book.family.get(loop.part, loop.part), change)
        loop.pattern = _turned(loop.pattern, change).about(inside)


def _turned(pattern: Pattern, change: Frames) -> Pattern:
    """The pattern of a straight row whose frame, and whose members' frames, take a change."""
    if pattern.kind == "listed":
        return pattern
    step = compose(inverse(change), frames(np.array([complex(*pattern.base[:2])])))
    return replace(pattern, base=(float(step.x[0]), float(step.y[0]), 0.0, 0.0))


def _turnable(book: Book, alphabet: Alphabet, rule: int, change: Frames) -> bool:
    """Whether a straight row can be turned together with what it repeats: that must look the same
    afterwards, or be named nowhere else.
    """
    loop = book.loops[rule]
    _, _, angle, growth = loop.pattern.base
    straight = loop.pattern.kind == "even" and loop.pattern.constant
    straight &= abs(angle) <= SMALL and abs(growth) <= SMALL
    ahead = complex(change.factor[0]) * int(change.handedness[0])
    if not straight and not (loop.pattern.kind == "listed" and abs(ahead - 1) <= SMALL):
        return False
    part = book.family.get(loop.part, loop.part)
    if part in book.loops:
        return book.uses()[part] == 1 and _turnable(book, alphabet, part, change)
    if part in book.bodies:
        return book.uses()[part] == 1 and part not in book.anchored
    return _keeps(alphabet, part, change)


def _keeps(alphabet: Alphabet, terminal: int, change: Frames) -> bool:
    """Whether a change of frame maps a terminal onto itself."""
    definition = alphabet[terminal]
    group = definition.stabiliser
    same = (np.abs(group.factor - change.factor) <= SMALL) & (np.abs(group.position) <= SMALL)
    return definition.free or bool((same & (group.handedness == change.handedness)).any())
