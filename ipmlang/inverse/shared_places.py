"""Origins that read well: what always stands at one place of its surroundings has that as its own.

Takes a book of rules; where most uses of a group or of a shape inside of rules are moved alike (the
pips of every card by half its size), moves its origin there, if that takes fewer tokens in all.
What is drawn stays the same, and what stands outside of rules stays where it is.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames, compose, frames, identity, inverse, join
from ipmlang.inverse.lsystem.symbols import Alphabet, Integers
from ipmlang.inverse.score import placement_tokens
from ipmlang.inverse.simplify import AXIOM, Book, regauge

CANDIDATES = 4  # places tried for one symbol
ROUNDS = 3  # of moving everything: what moves brings its parts with it
NEAR = 30.0  # times what is printed as 0: places so near are one

Uses: TypeAlias = "dict[int, list[tuple[int, Integers]]]"


@dataclass(slots=True, eq=False)
class _Places:
    """Where every symbol stands: bodies and rows in them; once: shapes that one rule alone names,
    and once, whose places go into their assets; outside: what stands outside of rules.
    """

    book: Book
    alphabet: Alphabet
    uses: Uses = field(default_factory=dict)
    once: set[int] = field(default_factory=set)
    outside: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        book, often = self.book, self.book.uses()
        for name, body in book.bodies.items():
            for part, rows in body.rows.items():
                self.uses.setdefault(part, []).append((name, rows))
        free = book.written_once()
        self.outside = {part for rule in free for part in book.bodies[rule].rows}
        self.once = {
            part
            for part in self.uses
            if often[part] == 1 and self.alphabet[part].terminal and part not in self.outside
        }

    def of(self, symbol: int) -> Frames:
        """All places of a symbol."""
        return join([self.book.bodies[name].places[rows] for name, rows in self.uses[symbol]])

    def movable(self) -> list[int]:
        """Symbols whose origin is theirs to choose: groups from the axiom down, then shapes."""
        book = self.book
        bound = {book.family.get(part, part) for part in book.repeated()} | book.anchored
        groups = [rule for rule in sorted(book.bodies, reverse=True) if rule != AXIOM]
        shapes = [part for part in sorted(self.uses) if self.alphabet[part].terminal]
        shapes = [part for part in shapes if part not in self.once | self.outside]
        return [each for each in [*groups, *shapes] if each not in bound and each in self.uses]

    def costs(self, symbol: int, uses: Frames, changes: Frames) -> Integers:
        """(k,) tokens of all uses of a symbol, and of its rule, after each change of its frame."""
        book, change = self.book, changes[:, None]
        total: Integers = placement_tokens(compose(uses, change), book.small).sum(axis=1)
        if symbol not in book.bodies:
            return total
        body = book.bodies[symbol]
        tokens = placement_tokens(compose(inverse(change), body.places), book.small)
        settled = np.array([part in self.once for part in body.parts.tolist()])
        own: Integers = np.where(settled, 1, tokens).sum(axis=1)
        return np.asarray(total + own, np.int64)


def share_places(book: Book, alphabet: Alphabet) -> None:
    """Move the origins of groups and shapes to where most of their uses have them."""
    for _ in range(ROUNDS):
        known = _Places(book, alphabet)
        moved = [_move(known, symbol) for symbol in known.movable()]
        if not any(moved):
            break


def _move(known: _Places, symbol: int) -> bool:
    """Move one symbol's origin, if that is shorter; whether it was."""
    uses = known.of(symbol)
    options = join([identity(1), _options(uses, NEAR * known.book.small)])
    best = int(np.argmin(known.costs(symbol, uses, options))) if len(options) > 1 else 0
    if best:
        regauge(known.book, symbol, options[best : best + 1])
    return best > 0


def _options(uses: Frames, near: float) -> Frames:
    """Moves of the origin that leave the most uses where they are without a word."""
    back = inverse(uses).position
    grid = np.round(back / near)
    often = Counter(zip(grid.real.tolist(), grid.imag.tolist(), strict=True))
    often.pop((0.0, 0.0), None)
    wanted = [place for place, count in often.most_common(CANDIDATES) if count > 1]
    keys = list(zip(grid.real.tolist(), grid.imag.tolist(), strict=True))
    rows = [keys.index(place) for place in wanted]
    return frames(back[rows])
