"""Lines that things stand on: origins moved up or down so that what stands in one line, the letters
of a word, has one height there.

Takes a book of rules; what stands side by side again and again tells how far the origins of both
are apart, and where many such tellings agree, the origins are moved. What is drawn stays the same,
and nothing is moved for lines that little confirms.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lsystem.curves import Booleans
from ipmlang.inverse.lsystem.frames import Frames, frames
from ipmlang.inverse.lsystem.symbols import Alphabet, Integers
from ipmlang.inverse.score import SMALL
from ipmlang.inverse.simplify import AXIOM, Body, Book, regauge

CONFIRMED = 6  # agreeing pairs beyond those from which the heights were learnt,
AGREEING = 0.7  # and this share of all such pairs

Told: TypeAlias = "dict[tuple[int, int, int], list[float]]"


@dataclass(slots=True, eq=False)
class _Heights:
    """Symbols whose heights depend on each other: the root of each, and how far above the root's
    its origin has to go.
    """

    above: dict[int, tuple[int, float]] = field(default_factory=dict)

    def find(self, symbol: int) -> tuple[int, float]:
        """The root, and the height above it."""
        over, height = self.above.get(symbol, (symbol, 0.0))
        if over == symbol:
            return symbol, 0.0
        root, more = self.find(over)
        self.above[symbol] = root, height + more
        return self.above[symbol]

    def apart(self, one: int, two: int) -> float | None:
        """How far two goes above one, None where nothing tells."""
        (root, here), (other, there) = self.find(one), self.find(two)
        return there - here if root == other else None

    def join(self, one: int, two: int, height: float) -> None:
        """Say that two goes so far above one, which nothing told before."""
        (root, here), (other, there) = self.find(one), self.find(two)
        self.above[other] = root, here + height - there


def settle_baselines(book: Book, alphabet: Alphabet) -> None:
    """Move origins up or down to the lines that their symbols stand on."""
    free = _free(book, alphabet)
    heights = _Heights()
    for rule in sorted(free & book.bodies.keys()):
        # A group stands on the line of what comes first in it.
        first = int(book.bodies[rule].parts[0])
        if first in free and bool(_plain(book.bodies[rule].places)[0]):
            heights.join(first, rule, -float(book.bodies[rule].places.y[0]))
    told: Told = {}
    for body in book.bodies.values():
        for one, two, height in _neighbours(book, body, free):
            told.setdefault((one, two, round(height / alphabet.tolerance)), []).append(height)
    agreeing, others = _learnt(heights, told, alphabet.tolerance)
    for symbol in sorted(free, reverse=True):
        root, height = heights.find(symbol)
        sure = agreeing[root] >= max(CONFIRMED, AGREEING * (agreeing[root] + others[root]))
        if sure and abs(height) > book.small:
            regauge(book, symbol, frames(np.array([complex(0.0, height)])))


def _free(book: Book, alphabet: Alphabet) -> set[int]:
    """Groups and shapes whose origin is theirs to choose."""
    bound = {book.family.get(part, part) for part in book.repeated()} | book.anchored
    used = {part for body in book.bodies.values() for part in body.rows}
    shapes = {part for part in used if alphabet[part].terminal}
    return (shapes | book.bodies.keys()) - bound - {AXIOM}


def _plain(places: Frames) -> Booleans:
    """(n,) which are only moved."""
    upright = (np.abs(places.angle) <= SMALL) & (np.abs(places.scale - 1) <= SMALL)
    return np.asarray(upright & (places.handedness > 0), np.bool_)


def _neighbours(book: Book, body: Body, free: set[int]) -> Iterator[tuple[int, int, float]]:
    """Symbols that stand side by side, and how far the second would have to go above the first."""
    x, y = body.places.x, body.places.y
    movable = _plain(body.places) & np.isin(body.parts, list(free))
    beside = movable[1:] & movable[:-1] & (np.diff(x) > book.small)
    # Steps that rather go up or down lead to another line.
    beside &= np.abs(np.diff(y)) < np.diff(x)
    rows: Integers = np.flatnonzero(beside)
    for row in rows.tolist():
        yield int(body.parts[row]), int(body.parts[row + 1]), float(y[row] - y[row + 1])


def _learnt(heights: _Heights, told: Told, near: float) -> tuple[Counter[int], Counter[int]]:
    """Learn heights from what is told most often; of each root, how many more pairs say the same,
    and how many do not.
    """
    agreeing: Counter[tuple[int, int]] = Counter()
    others: Counter[tuple[int, int]] = Counter()
    for (one, two, _), values in sorted(told.items(), key=lambda each: (-len(each[1]), each[0])):
        height, known = float(np.median(values)), heights.apart(one, two)
        if known is None:
            heights.join(one, two, height)
            agreeing[one, two] += len(values) - 1
        else:
            same = abs(known - height) <= 2 * near
            (agreeing if same else others)[one, two] += len(values)
    return _by_root(heights, agreeing), _by_root(heights, others)


def _by_root(heights: _Heights, pairs: Counter[tuple[int, int]]) -> Counter[int]:
    total: Counter[int] = Counter()
    for (one, _), often in pairs.items():
        total[heights.find(one)[0]] += often
    return total
