"""What stands in a box: symbols in frames with the boxes that they fill, and when two are the same.

In go rules of a scheme, out come rows that can be cut, moved and compared. Nothing here decides
where to cut.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    around,
    compose,
    identity,
    join,
    linear,
)
from ipmlang.inverse.split.distinct import numbered
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.paper.labelling import TURNED
from ipmlang.inverse.split.scheme import Rule, Scheme
from ipmlang.inverse.split.snapping import label_rows


@dataclass(frozen=True, slots=True, eq=False)
class Contents:
    """n symbols in frames. kind (n,): the same for one symbol turned in one way; low, high (n, 3):
    boxes of what they draw; item (n,): the item of the rule that places them, -1 for none; offset
    (3,): how far all was moved from where those items have it.
    """

    symbol: Integers
    frames: Frames
    kind: Integers
    low: Floats
    high: Floats
    item: Integers
    offset: Floats = field(default_factory=lambda: np.zeros(3))

    def __len__(self) -> int:
        return len(self.symbol)

    def __getitem__(self, rows: Integers | NDArray[np.bool_]) -> Contents:
        return Contents(
            self.symbol[rows],
            self.frames[rows],
            self.kind[rows],
            self.low[rows],
            self.high[rows],
            self.item[rows],
            self.offset,
        )

    def moved(self, by: Floats) -> Contents:
        """The same in coordinates that begin at `-by`."""
        frames = replace(self.frames, position=self.frames.position + by)
        return replace(
            self,
            frames=frames,
            low=self.low + by,
            high=self.high + by,
            offset=self.offset + by,
        )


@dataclass(slots=True, eq=False)
class Kinds:
    """Numbers for symbols that are turned alike, wherever they are met."""

    turns: dict[int, list[tuple[Floats, int]]] = field(default_factory=dict)
    count: int = 0

    def number(self, symbol: Integers, frames: Frames) -> Integers:
        """(n,) of each row."""
        turned = linear(frames).reshape(-1, 9)
        columns = [numbered(turned[:, column], TURNED) for column in range(9)]
        kind, count = label_rows(np.stack([symbol, *columns], axis=1))
        first = np.empty(len(count), np.int64)
        first[kind[::-1]] = np.arange(len(kind))[::-1]
        known = [self._known(int(symbol[row]), turned[row]) for row in first.tolist()]
        return np.array(known, np.int64)[kind]

    def _known(self, symbol: int, turn: Floats) -> int:
        turns = self.turns.setdefault(symbol, [])
        for other, number in turns:
            if np.abs(other - turn).max() <= TURNED:
                return number
        turns.append((turn, self.count))
        self.count += 1
        return self.count - 1


def contents(scheme: Scheme, rule: Rule, extents: Floats, depth: int, kinds: Kinds) -> Contents:
    """What a rule places, rules in it opened `depth` times. extents: (n, 2, 3) a box around what
    each symbol draws.
    """
    rows = [
        (symbol, frames, number)
        for number, item in enumerate(rule.items)
        for symbol, frames in placements(item)
    ]
    for _ in range(depth):
        rows = [each for row in rows for each in _opened(scheme, *row)]
    rows = rows or [(0, identity(0), -1)]
    symbol = np.concatenate([np.full(len(frames), each) for each, frames, _ in rows])
    frames = join([frames for _, frames, _ in rows])
    item = np.concatenate([np.full(len(frames), number) for _, frames, number in rows])
    low, high = around(frames, extents[symbol][:, 0], extents[symbol][:, 1])
    return Contents(symbol, frames, kinds.number(symbol, frames), low, high, item)


def _opened(
    scheme: Scheme, symbol: int, frames: Frames, item: int
) -> list[tuple[int, Frames, int]]:
    rule = scheme.symbols[symbol]
    if not isinstance(rule, Rule):
        return [(symbol, frames, item)]
    found = []
    for each in rule.items:
        for inner, own in placements(each):
            outer = np.repeat(np.arange(len(frames)), len(own))
            again = np.tile(np.arange(len(own)), len(frames))
            found.append((inner, compose(frames[outer], own[again]), -1))
    return found


def sorted_rows(inside: Contents, small: float) -> Contents:
    """In an order that does not hang on noise: by kind, then by place."""
    place = inside.frames.position
    columns = [numbered(place[:, axis], small) for axis in range(3)]
    return inside[np.lexsort((*columns, inside.kind))]


def same(a: Contents, b: Contents, small: float) -> bool:
    """Whether two, each sorted, stand alike in their own coordinates."""
    if len(a) != len(b) or not np.array_equal(a.kind, b.kind):
        return False
    return bool(np.abs(a.frames.position - b.frames.position).max(initial=0.0) <= small)
