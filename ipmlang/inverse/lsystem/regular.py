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
    order = np.array([_rotations(each.stabiliser, each.free) for each in alphabet.definitions])
    cell = 360.0 / np.maximum(order, 1)[arrangement.symbol]
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
    alphabet: Alphabet, arrangement: Arrangement, regular: Frames
) -> Iterator[tuple[Frames, NDArray[np.bool_]]]:
    """The frames that turn by one, two, … more of a symbol's own rotations at each row, and which
    rows (n,) have so many: seeds of a sunflower turn by 137.5°, which is -42.5° for an ellipse.
    """
    order = np.array([_rotations(each.stabiliser, each.free) for each in alphabet.definitions])
    index = np.arange(len(arrangement))
    for more in range(1, min(MOST_ROTATIONS, int(order.max(initial=1)))):
        rows = order[arrangement.symbol] > more
        if rows.any():
            steps = np.where(rows, more * index, 0)
            yield _spun(alphabet, arrangement.symbol, regular, steps, order), rows


def _rotations(stabiliser: Frames, free: bool) -> int:
    return 1 if free else int((stabiliser.handedness > 0).sum())


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
    free = np.array([each.free for each in alphabet.definitions])[arrangement.symbol]
    angle = np.where(free & (result.handedness > 0), 0.0, result.angle)
    return Frames(result.x, result.y, angle, result.scale, result.handedness)


def _spun(
    alphabet: Alphabet, symbol: Integers, placed: Frames, steps: Integers, order: Integers
) -> Frames:
    """Frames after so many of the symbol's own rotations."""
    changed = np.flatnonzero(steps % np.maximum(order, 1)[symbol])
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
