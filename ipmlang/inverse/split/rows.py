"""Rows, rings and stairs that run along an axis of their rule: what a person would lengthen.

In goes a scheme, out come for its rules the directions in which something repeats often enough to
be set by one count, and the same scheme with all of them begun at the bottom. Nothing is printed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.frames import Floats, around, compose, moved_to
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Array, Direction, Item, Ring, Rule, Scheme, Symbol

FEWEST = 3  # members or cells that repeat so often are what a person would have more or fewer of
MOST_OF = 0.6  # of its rule's scope, by a row that a person would lengthen the scope for
STRAIGHT = 1e-9  # of a step, that it may be off its axis


@dataclass(frozen=True, slots=True)
class Row:
    """What repeats `count` times along `axis`, each `period` beyond the one before: the direction
    of this number of the item of this number. low, high: from where to where it reaches.
    """

    item: int
    direction: int
    axis: int
    count: int
    period: float
    low: float
    high: float


def rows(symbol: Symbol, boxes: Floats) -> Iterator[Row]:
    """The rows of a rule that go most of the way through its scope; boxes: (n, 2, 3) what each
    symbol draws, in its own coordinates.
    """
    if not isinstance(symbol, Rule):
        return
    for number, item in enumerate(symbol.items):
        for direction, axis, count, period in _steps(item):
            low, high = np.inf, -np.inf
            for inner, frames in placements(item):
                begin, end = around(frames, *boxes[inner])
                low = min(low, float(begin[:, axis].min(initial=np.inf)))
                high = max(high, float(end[:, axis].max(initial=-np.inf)))
            if high - low >= MOST_OF * symbol.size[axis]:
                yield Row(number, direction, axis, count, period, low, high)


def _steps(item: Item) -> Iterator[tuple[int, int, int, float]]:
    """The directions of an item that go up an axis evenly: number, axis, count and step."""
    if isinstance(item, Array) and (len(item.directions) == 1 or not item.holes):
        for number, direction in enumerate(item.directions):
            axis = int(np.argmax(np.abs(direction.step)))
            step = float(direction.step[axis])
            straight = not direction.steps and not direction.angle
            even = direction.count >= FEWEST and straight and step > 0
            if even and np.abs(np.delete(direction.step, axis)).max() <= STRAIGHT * step:
                yield number, axis, direction.count, step
    if isinstance(item, Ring) and item.count >= FEWEST and not item.grows:
        upright = float(item.axis[2]) > 1 - STRAIGHT
        if upright and item.rise > 0:
            yield 0, 2, item.count, item.rise


# ------------------------------------------------------------------------ from the bottom


def risen(scheme: Scheme) -> Scheme:
    """The scheme with rows and stairs that begin at their lowest member, so that more of them go
    up, not into the ground. What grows with each step is let be.
    """
    return replace(scheme, symbols=tuple(
        replace(symbol, items=tuple(map(_risen, symbol.items)))
        if isinstance(symbol, Rule)
        else symbol
        for symbol in scheme.symbols
    ))  # fmt: skip


def _risen(item: Item) -> Item:
    if isinstance(item, Ring) and item.rise * item.axis[2] < 0 and not item.grows:
        return _ring_risen(item)
    if isinstance(item, Array):
        for number, direction in enumerate(item.directions):
            if not direction.angle and _sinks(direction.step):
                item = _array_risen(item, number)
    return item


def _sinks(step: Floats) -> bool:
    """Whether a step goes down; one that keeps its height may go anywhere."""
    return bool(step[2] < -STRAIGHT * np.abs(step).max())


def _array_risen(array: Array, number: int) -> Array:
    direction = array.directions[number]
    last = direction.count - 1
    whole = sum(direction.steps) if direction.steps else float(last)
    turned = Direction(direction.count, -direction.step, direction.steps[::-1])
    directions = (*array.directions[:number], turned, *array.directions[number + 1 :])
    holes = frozenset(
        (*hole[:number], last - hole[number], *hole[number + 1 :]) for hole in array.holes
    )
    first = compose(moved_to((whole * direction.step)[None]), array.first)
    return replace(array, first=first, directions=directions, holes=holes)


def _ring_risen(ring: Ring) -> Ring:
    last = ring.count - 1
    begun = replace(ring, holes=frozenset(range(last)))
    ((_, first),) = placements(begun)
    return replace(
        ring,
        first=first,
        angle=-ring.angle,
        rise=-ring.rise,
        holes=frozenset(last - hole for hole in ring.holes),
    )
