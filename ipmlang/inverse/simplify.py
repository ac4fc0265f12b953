"""Post-processing of found rules (section 5.7 of the paper): only rules that pay are left, each
symbol has the frame in which its rule is shortest.

Takes the string and alphabet of a search; gives a book of rules that `build` prints. What is drawn
stays the same: every step moves numbers from one rule to another. Nothing here prints.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.inverse.lattices.formula import LatticeRule
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
from ipmlang.inverse.recursion.branching import Branching
from ipmlang.inverse.score import COUNTED, HEAD, placement_tokens

if TYPE_CHECKING:
    from ipmlang.inverse.boards import Block

AXIOM = -1
LEAST = 6  # tokens that a group must save to be worth a name


@dataclass(slots=True, eq=False)
class Body:
    """Symbols at places, in paint order: what a group's rule or the axiom says.

    parts: never changed in place; rows: (k,) where each symbol stands, the first one first.
    """

    parts: Integers
    places: Frames
    rows: dict[int, Integers] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.rows:
            found: dict[int, list[int]] = {}
            for row, part in enumerate(self.parts.tolist()):
                found.setdefault(part, []).append(row)
            self.rows = {part: np.array(rows, np.int64) for part, rows in found.items()}

    def moved(self, places: Frames) -> Body:
        """The symbols at other places."""
        return Body(self.parts, places, self.rows)


@dataclass(slots=True, eq=False)
class Loop:
    """A sequence's rule: copies of `part` by a pattern."""

    part: int
    pattern: Pattern


@dataclass(frozen=True, slots=True, eq=False)
class Branches:
    """A branching structure's rules: copies of `part` at its nodes."""

    part: int
    branching: Branching


@dataclass(slots=True, eq=False)
class Book:
    """All rules that are left. bodies: by group symbol, AXIOM for the axiom; loops: by family;
    trees, lattices: by symbol; extent: rows of every symbol in what was seen; ranks: of the axiom's
    rows in paint order; family, count: of every symbol that is a sequence; size: of every symbol,
    in elements; small: units, what is printed as 0; assets: where a terminal's representative lies
    in its asset, the identity where none is given; effects: the class of the effect that wraps a
    group's body; anchored: symbols whose frame is bound, by an effect or a structure; scattered: by
    rank, the ranks of all elements of a row of the axiom that are not painted one after the other;
    shift: by rank, how far elements are from where rules have them, x + iy; boards: what stands for
    many rows of the axiom, by the first of them.
    """

    bodies: dict[int, Body]
    loops: dict[int, Loop]
    family: dict[int, int]
    count: dict[int, int]
    size: Integers
    small: float
    assets: dict[int, Frames] = field(default_factory=dict)
    trees: dict[int, Branches] = field(default_factory=dict)
    lattices: dict[int, LatticeRule] = field(default_factory=dict)
    extent: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    ranks: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    effects: dict[int, int] = field(default_factory=dict)
    anchored: set[int] = field(default_factory=set)
    scattered: dict[int, Integers] = field(default_factory=dict)
    shift: dict[int, complex] = field(default_factory=dict)
    boards: dict[int, Block] = field(default_factory=dict)

    def uses(self) -> Counter[int]:
        """How often each rule or terminal is named (sequences by family)."""
        found: Counter[int] = Counter()
        for body in self.bodies.values():
            for part, rows in body.rows.items():
                found[self.family.get(part, part)] += len(rows)
        found.update(self.family.get(part, part) for part in self.repeated())
        return found

    def inlined(self) -> set[int]:
        """Groups under an effect that one body names once: they are written where they stand."""
        used = self.uses()
        named = {part for body in self.bodies.values() for part in body.rows}
        return {rule for rule in self.effects if used[rule] == 1 and rule in named}

    def written_once(self) -> set[int]:
        """The axiom, and the groups under an effect that are written out in it."""
        once = {AXIOM}
        waiting = [AXIOM]
        inlined = self.inlined()
        while waiting:
            inside = inlined & self.bodies[waiting.pop()].rows.keys()
            once |= inside
            waiting += inside
        return once

    def drop_unused(self) -> None:
        """Forget rules that nothing names any more."""
        while True:
            used = self.uses()
            dead = [rule for rule in self.bodies if rule != AXIOM and not used[rule]]
            idle = [rule for rule in self.loops if not used[rule]]
            for rule in dead:
                del self.bodies[rule]
                self.effects.pop(rule, None)
            for rule in idle:
                del self.loops[rule]
            bare = [rule for rule in (*self.trees, *self.lattices) if not used[rule]]
            for rule in bare:
                self.trees.pop(rule, None)
                self.lattices.pop(rule, None)
            if not dead and not idle and not bare:
                return

    def repeated(self) -> list[int]:
        """What sequences and structures repeat; their patterns bind its frame."""
        return list(self.repeats().values())

    def repeats(self) -> dict[int, int]:
        """The part of every sequence, branching structure and lattice."""
        made = {rule: each.part for rule, each in self.loops.items()}
        made |= {rule: each.part for rule, each in self.trees.items()}
        return made | {rule: each.part for rule, each in self.lattices.items()}

    def rules(self) -> list[int]:
        """All rules but the axiom: groups, sequences, branching structures, lattices."""
        every = (*self.bodies, *self.loops, *self.trees, *self.lattices)
        return [rule for rule in every if rule != AXIOM]

    def paint_order(self) -> Integers | None:
        """(n,) ranks of all elements in the order of derivation, None where that is their order:
        where the members of every lattice and group are painted one after the other.
        """
        made = []
        parts = self.bodies[AXIOM].parts.tolist()
        for part, rank in zip(parts, self.ranks.tolist(), strict=True):
            rule = self.lattices.get(part)
            starts = np.array([rank]) if rule is None else rule.drawn
            inside = np.arange(int(self.extent[part if rule is None else rule.part]))
            made.append(self.scattered.get(rank, (starts[:, None] + inside).ravel()))
        order = np.concatenate([np.zeros(0, np.int64), *made])
        return None if (np.diff(order) == 1).all() else order


def make_book(alphabet: Alphabet, string: Arrangement) -> Book:
    """The rules that the string needs, as they were found."""
    sizes = np.array([each.size for each in alphabet.definitions], np.int64)
    book = Book(
        {AXIOM: Body(string.symbol.copy(), string.placed)},
        {},
        {},
        {},
        np.array([each.drawn for each in alphabet.definitions], np.int64),
        alphabet.tolerance / 30,
    )
    book.extent, book.ranks = sizes, string.start.copy()
    waiting = np.unique(string.symbol).tolist()
    while waiting:
        symbol = waiting.pop()
        definition = alphabet[symbol]
        known = symbol in book.bodies or symbol in book.family or symbol in book.trees
        known |= symbol in book.lattices
        if definition.terminal or known:
            continue
        if definition.lattice is not None:
            part = int(definition.parts[0])
            book.lattices[symbol] = replace(definition.lattice, part=part)
            book.anchored.add(symbol)
            waiting.append(part)
            continue
        if definition.branching is not None:
            part = int(definition.parts[0])
            book.trees[symbol] = Branches(part, definition.branching)
            book.anchored.add(symbol)
            waiting.append(part)
            continue
        if definition.pattern is not None:
            book.family[symbol] = definition.family
            book.count[symbol] = len(definition.parts)
            part = int(definition.parts[0])
            loop = Loop(part, definition.pattern)
            book.loops.setdefault(definition.family, loop)
            waiting.append(part)
        else:
            book.bodies[symbol] = Body(definition.parts, definition.places)
            if definition.effect >= 0:
                book.effects[symbol] = definition.effect
            if definition.anchored:
                book.anchored.add(symbol)
            waiting += np.unique(definition.parts).tolist()
    return book


def drop_poor_rules(book: Book) -> None:
    """Merge what is named once and write out what does not pay, until every rule does."""
    _merge_single(book)
    while _drop_poor(book):
        _merge_single(book)
    book.drop_unused()


def recentre(book: Book) -> None:
    """Give groups that are turned about a point that point as their origin."""
    _recentre_groups(book)


def _merge_single(book: Book) -> None:
    """Groups that are named once, in another group or the axiom, become part of it."""
    used = book.uses()
    named = {part for body in book.bodies.values() for part in body.rows}
    single = {rule for rule in book.bodies if used[rule] == 1 and rule in named}
    single -= book.effects.keys()
    if not single:
        return

    def merged(part: int) -> Body | None:
        return book.bodies[part] if part in single else None

    # Symbols are made of earlier ones, so what is merged into a body is complete itself.
    for rule in [*sorted(rule for rule in book.bodies if rule != AXIOM), AXIOM]:
        if not single.isdisjoint(book.bodies[rule].rows):
            _spread(book, rule, merged)
    for rule in single:
        del book.bodies[rule]


def _inline(book: Book, rule: int, users: list[int]) -> None:
    """Replace a group by its members in the bodies that name it; loops keep naming it."""
    inner = book.bodies[rule]
    for name in users:
        _spread(book, name, lambda part: inner if part == rule else None)
    if rule not in book.repeated():
        del book.bodies[rule]


def _spread(book: Book, name: int, inner: Callable[[int], Body | None]) -> None:
    """Write members in place of the parts for which `inner` gives a body."""
    body = book.bodies[name]
    known = {part: inner(part) for part in body.rows}
    groups = {part: group for part, group in known.items() if group is not None}
    counts = np.ones(len(body.parts), np.int64)
    for part, group in groups.items():
        counts[body.rows[part]] = len(group.parts)
    first, row = np.cumsum(counts) - counts, np.repeat(np.arange(len(counts)), counts)
    parts, places = body.parts[row], body.places[row]
    ranks = book.ranks[row] if name == AXIOM else np.zeros(len(row), np.int64)
    for part, group in groups.items():
        own = body.rows[part]
        there = first[own][:, None] + np.arange(len(group.parts))
        parts[there] = group.parts
        places = replaced(places, there, compose(body.places[own][:, None], group.places))
        before = np.cumsum(book.extent[group.parts]) - book.extent[group.parts]
        if name == AXIOM:
            ranks[there] = [_ranks(book, rank, before) for rank in book.ranks[own].tolist()]
    if name == AXIOM:
        book.ranks = ranks
    book.bodies[name] = Body(parts, places)


def _ranks(book: Book, rank: int, before: Integers) -> Integers:
    """The ranks of the parts (m,) of a row of the axiom that is written out, and begins with a
    rank; before: (m,) how many elements there are before each.
    """
    scattered = book.scattered.pop(rank, None)
    return rank + before if scattered is None else scattered[before]


def _drop_poor(book: Book) -> bool:
    """Write out the groups whose rules cost more than they save, the worst first, as long as none
    is changed by another one's end; whether there was one.
    """
    used, users = book.uses(), _users(book)
    costs = {
        rule: cost
        for rule in book.bodies.keys() - book.effects.keys()
        if rule != AXIOM
        and (cost := _excess(book, rule, used, users.get(rule, []))) is not None
        and cost > -LEAST
    }
    touched: set[int] = set()
    for rule in sorted(costs, key=lambda each: (-costs[each], each)):
        if rule in touched:
            continue
        touched |= {rule, *users.get(rule, []), *book.bodies[rule].rows}
        _inline(book, rule, users.get(rule, []))
    if costs:
        book.drop_unused()
    return bool(costs)


def _users(book: Book) -> dict[int, list[int]]:
    """The bodies that name each symbol."""
    found: dict[int, list[int]] = {}
    for name, body in book.bodies.items():
        for part in body.rows:
            found.setdefault(part, []).append(name)
    return found


def _excess(book: Book, rule: int, used: Counter[int], users: list[int]) -> int | None:
    """Tokens that a group's rule adds (negative: saves); None where a loop needs it."""
    if rule in book.repeated():
        return None
    inner = book.bodies[rule]
    bodies = [book.bodies[name] for name in users]
    places = join([body.places[body.rows[rule]] for body in bodies])
    every = compose(places[:, None], inner.places)
    with_rule = HEAD + int(placement_tokens(inner.places, book.small).sum())
    with_rule += int(placement_tokens(places, book.small).sum())
    without = int(placement_tokens(every, book.small).sum())
    counted = sum(COUNTED * len(rows) for part, rows in inner.rows.items() if part in book.family)
    return with_rule - without - counted * (used[rule] - 1)


# ------------------------------------------------------------------------ frames


def regauge(book: Book, rule: int, change: Frames) -> None:
    """Give a symbol another frame: it is drawn the same, and every place of it takes `change`.

    The pattern of a sequence that is given another frame is for the caller to change.
    """
    back = inverse(change)
    if rule in book.bodies:
        body = book.bodies[rule]
        book.bodies[rule] = body.moved(compose(back, body.places))
    elif rule in book.trees or rule in book.lattices:
        raise ValueError("the frame of a structure is bound to its rule")
    elif rule not in book.loops:
        book.assets[rule] = compose(back, book.assets.get(rule, identity(1)))
    for loop in book.loops.values():
        if book.family.get(loop.part, loop.part) == rule and rule not in book.loops:
            loop.pattern = loop.pattern.about(compose(loop.pattern.inside, change))
    for name, rows in naming(book, rule):
        body = book.bodies[name]
        moved = compose(body.places[rows], change)
        book.bodies[name] = body.moved(replaced(body.places, rows, moved))


def naming(book: Book, rule: int) -> list[tuple[int, Integers]]:
    """The bodies that name a rule or terminal, and which of their members (k,) do."""
    kin = {part for part, family in book.family.items() if family == rule}
    kin |= {rule} if book.family.get(rule, rule) == rule else set()
    found: list[tuple[int, Integers]] = []
    for name, body in book.bodies.items():
        rows = [body.rows[part] for part in kin if part in body.rows]
        if rows:
            found.append((name, rows[0] if len(rows) == 1 else np.sort(np.concatenate(rows))))
    return found


def in_loop(book: Book, rule: int) -> bool:
    """Whether a loop repeats the symbol, so that its frame is bound to the loop's pattern."""
    return any(book.family.get(part, part) == rule for part in book.repeated())


def _recentre_groups(book: Book) -> None:
    """Members of one symbol that are turned about one point take that point as their origin."""
    for rule in sorted(book.bodies):
        body = book.bodies.get(rule)
        if body is None or rule == AXIOM or len(body.parts) < 3:
            continue
        same = book.family.get(int(body.parts[0]), int(body.parts[0]))
        if any(book.family.get(part, part) != same for part in body.rows):
            continue
        if same in book.loops or in_loop(book, same) or in_loop(book, rule):
            continue
        if same in book.anchored or rule in book.anchored:
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
