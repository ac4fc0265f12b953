"""Post-processing of found rules (section 5.7 of the paper): only rules that pay are left, each
symbol has the frame in which its rule is shortest.

Takes the string and alphabet of a search; gives a book of rules that `build` prints. What is drawn
stays the same: every step moves numbers from one rule to another. Nothing here prints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

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
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.score import COUNTED, HEAD, SMALL, placement_tokens

AXIOM = -1
LEAST = 6  # tokens that a group must save to be worth a name


@dataclass(slots=True, eq=False)
class Body:
    """Symbols at places, in paint order: what a group's rule or the axiom says."""

    parts: Integers
    places: Frames


@dataclass(slots=True, eq=False)
class Loop:
    """A sequence's rule: copies of `part` by a pattern; where[0] is the frame of the first copy,
    the identity until the rule is re-centred on a ring's middle.
    """

    part: int
    pattern: Pattern
    where: Frames


@dataclass(slots=True, eq=False)
class Book:
    """All rules that are left. bodies: by group symbol, AXIOM for the axiom; loops: by family;
    family, count: of every symbol that is a sequence; wrap: effects of the axiom's rows; size: of
    every symbol, in elements; small: units, what is printed as 0; assets: where a terminal's
    representative lies in its asset, the identity where none is given.
    """

    bodies: dict[int, Body]
    loops: dict[int, Loop]
    family: dict[int, int]
    count: dict[int, int]
    wrap: Integers
    size: Integers
    small: float
    assets: dict[int, Frames] = field(default_factory=dict)

    def uses(self) -> Counter[int]:
        """How often each rule or terminal is named (sequences by family)."""
        found: Counter[int] = Counter()
        for body in self.bodies.values():
            found.update(self.family.get(part, part) for part in body.parts.tolist())
        found.update(self.family.get(loop.part, loop.part) for loop in self.loops.values())
        return found

    def drop_unused(self) -> None:
        """Forget rules that nothing names any more."""
        while True:
            used = self.uses()
            dead = [rule for rule in self.bodies if rule != AXIOM and not used[rule]]
            idle = [rule for rule in self.loops if not used[rule]]
            for rule in dead:
                del self.bodies[rule]
            for rule in idle:
                del self.loops[rule]
            if not dead and not idle:
                return


def make_book(alphabet: Alphabet, string: Arrangement) -> Book:
    """The rules that the string needs, as they were found."""
    book = Book(
        {AXIOM: Body(string.symbol.copy(), string.placed)},
        {},
        {},
        {},
        string.wrap,
        np.array([each.size for each in alphabet.definitions], np.int64),
        alphabet.tolerance / 30,
    )
    waiting = np.unique(string.symbol).tolist()
    while waiting:
        symbol = waiting.pop()
        definition = alphabet[symbol]
        if definition.terminal or symbol in book.bodies or symbol in book.family:
            continue
        if definition.pattern is not None:
            book.family[symbol] = definition.family
            book.count[symbol] = len(definition.parts)
            part = int(definition.parts[0])
            loop = Loop(part, _plain(definition.pattern), identity(1))
            book.loops.setdefault(definition.family, loop)
            waiting.append(part)
        else:
            book.bodies[symbol] = Body(definition.parts, definition.places)
            waiting += np.unique(definition.parts).tolist()
    return book


def _plain(pattern: Pattern) -> Pattern:
    """A turtle that neither turns nor grows goes in even steps."""
    alpha, distance, scale, beta = pattern.base
    straight = abs(alpha + beta) <= SMALL and abs(scale - 1) <= SMALL
    if pattern.kind != "turtle" or pattern.mirrored or not pattern.constant or not straight:
        return pattern
    step = frames(np.array([distance + 0j]))
    turned = compose(frames(np.zeros(1, np.complex128), alpha), step)
    return Pattern("even", (float(turned.x[0]), float(turned.y[0]), 0.0, 0.0))


def drop_poor_rules(book: Book) -> None:
    """Merge what is named once and write out what does not pay, until every rule does."""
    _merge_single(book)
    while _drop_poor(book):
        _merge_single(book)
    book.drop_unused()


def recentre(book: Book) -> None:
    """Give rings, and groups that are turned about a point, that point as their origin."""
    _recentre_rings(book)
    _recentre_groups(book)


def _merge_single(book: Book) -> None:
    """Groups that are named once, in another group or the axiom, become part of it."""
    used = book.uses()
    named = {part for body in book.bodies.values() for part in body.parts.tolist()}
    single = {rule for rule in book.bodies if used[rule] == 1 and rule in named}
    if not single:
        return

    def merged(part: int) -> Body | None:
        return book.bodies[part] if part in single else None

    # Symbols are made of earlier ones, so what is merged into a body is complete itself.
    for rule in [*sorted(rule for rule in book.bodies if rule != AXIOM), AXIOM]:
        if any(part in single for part in book.bodies[rule].parts.tolist()):
            _spread(book, rule, merged)
    for rule in single:
        del book.bodies[rule]


def _inline(book: Book, rule: int) -> None:
    """Replace a group by its members in all bodies; loops keep naming it."""
    inner = book.bodies[rule]
    for name, body in book.bodies.items():
        if name != rule and (body.parts == rule).any():
            _spread(book, name, lambda part: inner if part == rule else None)
    if not any(loop.part == rule for loop in book.loops.values()):
        del book.bodies[rule]


def _spread(book: Book, name: int, inner: Callable[[int], Body | None]) -> None:
    """Write members in place of the parts for which `inner` gives a body."""
    body = book.bodies[name]
    parts: list[Integers] = []
    places: list[Frames] = []
    wraps: list[Integers] = []
    for index, part in enumerate(body.parts.tolist()):
        outer = body.places[index : index + 1]
        group = inner(part)
        if group is None:
            group = Body(np.array([part], np.int64), identity(1))
        parts.append(group.parts)
        places.append(compose(outer, group.places))
        if name == AXIOM:
            wraps.append(np.repeat(book.wrap[index], len(group.parts)))
    book.bodies[name] = Body(np.concatenate(parts), join(places))
    if name == AXIOM:
        book.wrap = np.concatenate(wraps)


def _drop_poor(book: Book) -> bool:
    """Write out the group whose rule costs most more than it saves; whether there was one."""
    costs = {
        rule: cost
        for rule in book.bodies
        if rule != AXIOM and (cost := _excess(book, rule)) is not None and cost > -LEAST
    }
    if not costs:
        return False
    worst = max(costs, key=lambda rule: (costs[rule], -rule))
    _inline(book, worst)
    book.drop_unused()
    return True


def _excess(book: Book, rule: int) -> int | None:
    """Tokens that a group's rule adds (negative: saves); None where a loop needs it."""
    if any(loop.part == rule for loop in book.loops.values()):
        return None
    inner = book.bodies[rule]
    with_rule = HEAD + int(placement_tokens(inner.places, book.small).sum())
    without = 0
    for name, body in book.bodies.items():
        rows = np.flatnonzero(body.parts == rule)
        if name != rule and len(rows):
            with_rule += int(placement_tokens(body.places[rows], book.small).sum())
            every = compose(body.places[rows][:, None], inner.places)
            without += int(placement_tokens(every, book.small).sum())
    counted = sum(COUNTED for part in inner.parts.tolist() if part in book.family)
    return with_rule - without - counted * (int(book.uses()[rule]) - 1)


# ------------------------------------------------------------------------ frames


def regauge(book: Book, rule: int, change: Frames) -> None:
    """Give a symbol another frame: it is drawn the same, and every place of it takes `change`.

    A loop that repeats the symbol takes the same change, so that its first copy stays at `where`.
    """
    back = inverse(change)
    if rule in book.bodies:
        body = book.bodies[rule]
        book.bodies[rule] = Body(body.parts, compose(back, body.places))
    elif rule in book.loops:
        loop = book.loops[rule]
        loop.where = compose(back, loop.where)
    else:
        book.assets[rule] = compose(back, book.assets.get(rule, identity(1)))
    for name, body in book.bodies.items():
        rows = naming(book, body, rule)
        if rows.any():
            moved = compose(body.places[rows], change)
            book.bodies[name] = Body(body.parts, replaced(body.places, rows, moved))


def naming(book: Book, body: Body, rule: int) -> NDArray[np.bool_]:
    """(n,) which members of a body name a rule or terminal."""
    named = [book.family.get(part, part) == rule for part in body.parts.tolist()]
    return np.array(named, np.bool_)


def in_loop(book: Book, rule: int) -> bool:
    """Whether a loop repeats the symbol, so that its frame is bound to the loop's pattern."""
    return any(book.family.get(loop.part, loop.part) == rule for loop in book.loops.values())


def ring_centre(pattern: Pattern) -> complex | None:
    """The fixed point of a constant turning step in the first copy's frame, None if it has none."""
    alpha, _, scale, beta = pattern.base
    turn = alpha + beta
    if pattern.kind != "turtle" or not pattern.constant or pattern.mirrored:
        return None
    if abs(scale - 1) > SMALL or abs(turn) <= SMALL:
        return None
    step = pattern.places(2)
    return complex(step.position[1] / (1 - step.factor[1]))


def _recentre_rings(book: Book) -> None:
    """A ring's frame goes to its centre, turned so that the first copy lies ahead where that makes
    its places shorter.
    """
    for family, loop in book.loops.items():
        centre = ring_centre(loop.pattern)
        if centre is None or in_loop(book, family):
            continue
        ahead = float(np.angle(-centre, deg=True)) if abs(centre) > book.small else 0.0
        options = [frames(np.array([centre]), angle) for angle in (ahead, 0.0)]
        best = min(options, key=lambda each: _ring_cost(book, family, each))
        regauge(book, family, best)


def _ring_cost(book: Book, family: int, change: Frames) -> int:
    first = inverse(change)
    cost = 4 * (abs(float(first.angle[0])) > SMALL) + 2 * (abs(float(first.y[0])) > book.small)
    for body in book.bodies.values():
        rows = naming(book, body, family)
        if rows.any():
            moved = compose(body.places[rows], change)
            cost += int(placement_tokens(moved, book.small).sum())
    return cost


def _recentre_groups(book: Book) -> None:
    """Members of one symbol that are turned about one point take that point as their origin."""
    for rule in sorted(book.bodies):
        body = book.bodies.get(rule)
        if body is None or rule == AXIOM or len(body.parts) < 3:
            continue
        same = book.family.get(int(body.parts[0]), int(body.parts[0]))
        if any(book.family.get(part, part) != same for part in body.parts.tolist()):
            continue
        if same in book.loops or in_loop(book, same) or in_loop(book, rule):
            continue
        steps = compose(inverse(body.places[:1]), body.places)
        centre = _shared_point(steps, book.small * 30)
        if centre is not None:
            regauge(book, same, frames(np.array([centre])))
            regauge(book, rule, book.bodies[rule].places[:1])


def _shared_point(steps: Frames, near: float) -> complex | None:
    """The point that all steps keep, None if there is none."""
    turning = (np.abs(steps.factor - 1) > 1e-6) & (steps.handedness > 0)
    if not turning.any():
        return None
    which = int(np.argmax(turning))
    centre = complex(steps.position[which] / (1 - steps.factor[which]))
    local = centre.real * steps.handedness + 1j * centre.imag
    moved = steps.position + steps.factor * local
    return centre if bool(np.all(np.abs(moved - centre) <= near)) else None
