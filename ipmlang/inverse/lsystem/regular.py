"""Frames that show regularity: of all equivalent frames of symmetric symbols, those that turn least
from one neighbour to the next.

Takes an arrangement; gives its stretches of one symbol and a world frame for every row. What is
drawn stays the same. Nothing here fits patterns.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Frames, compose, replaced
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers

MOST_ROTATIONS = 6  # of a symbol that are tried for spirals


def stretches(arrangement: Arrangement) -> Integers:
    """(n,) equal for neighbours of the same symbol under the same effects."""
    symbol, effects = arrangement.symbol, arrangement.wrap
    new = (symbol[1:] != symbol[:-1]) | (effects[1:] != effects[:-1])
    return np.concatenate([[0], np.cumsum(new)])


def regular_frames(alphabet: Alphabet, arrangement: Arrangement, stretch: Integers) -> Frames:
    """World frames chosen among the equivalent ones: the handedness of the first in the stretch,
    then the smallest turn from one member to the next.
    """
    placed = _same_handed(alphabet, arrangement)
    inner = np.concatenate([[False], stretch[1:] == stretch[:-1]])
    order = _orders(alphabet, arrangement.symbol)
    cell = 360.0 / order
    turn = np.diff(placed.angle, prepend=0.0)
    before = np.roll(placed.handedness, 1)
    local = before * turn
    least = local - cell * np.ceil(local / cell - 0.5 - 1e-9)
    moved = np.where(inner, before * (least - local), 0.0)
    total = np.cumsum(moved)
    starts = np.maximum.accumulate(np.where(inner, 0, np.arange(len(inner))))
    extra = total - total[starts]
    quarter = np.round(extra * placed.handedness / cell).astype(np.int64)
    return _spun(alphabet, arrangement.symbol, placed, quarter, order)


def further_turned(
    alphabet: Alphabet, symbol: Integers, regular: Frames, index: Integers
) -> Iterator[tuple[Frames, NDArray[np.bool_]]]:
    """The frames that turn by one, two, … more of a symbol's own rotations from one index (n,) to
    the next, and which rows (n,) have so many: seeds of a sunflower turn by 137.5°, which is -42.5°
    for an ellipse.
    """
    order = _orders(alphabet, symbol)
    for more in range(1, min(MOST_ROTATIONS, int(order.max(initial=1)))):
        rows = order > more
        steps = np.where(rows, more * index, 0)
        yield _spun(alphabet, symbol, regular, steps, order), rows


def _orders(alphabet: Alphabet, symbol: Integers) -> Integers:
    """(n,) how many rotations keep each symbol, 1 for circles."""
    known, which = np.unique(symbol, return_inverse=True)
    order = [
        1 if each.free else int((each.stabiliser.handedness > 0).sum())
        for each in (alphabet[number] for number in known.tolist())
    ]
    return np.maximum(np.array(order, np.int64), 1)[which.ravel()]


def _same_handed(alphabet: Alphabet, arrangement: Arrangement) -> Frames:
    """Right-handed frames wherever the shape has a mirror; no turn for circles."""
    result = arrangement.placed
    for symbol in np.unique(arrangement.symbol[result.handedness < 0]).tolist():
        definition = alphabet[symbol]
        mirrors = np.flatnonzero(definition.stabiliser.handedness < 0)
        rows = np.flatnonzero((arrangement.symbol == symbol) & (result.handedness < 0))
        if len(mirrors):
            mirror = definition.stabiliser[mirrors[:1]]
            result = replaced(result, rows, compose(result[rows], mirror))
    free = alphabet.frees[arrangement.symbol]
    angle = np.where(free & (result.handedness > 0), 0.0, result.angle)
    return Frames(result.x, result.y, angle, result.scale, result.handedness)


def _spun(
    alphabet: Alphabet, symbol: Integers, placed: Frames, steps: Integers, order: Integers
) -> Frames:
    """Frames after so many of the symbol's own rotations; order: (n,) how many there are."""
    changed = np.flatnonzero(steps % order)
    for each in np.unique(symbol[changed]).tolist():
        rows = changed[symbol[changed] == each]
        known = alphabet[each].stabiliser
        turns = known[known.handedness > 0]
        cell = 360.0 / len(turns)
        which = np.round((turns.angle % 360.0) / cell).astype(np.int64) % len(turns)
        by_step = np.argsort(which)
        placed = replaced(
            placed, rows, compose(placed[rows], turns[by_step[steps[rows] % len(turns)]])
        )
    return placed
