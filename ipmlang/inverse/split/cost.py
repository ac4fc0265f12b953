"""Description length: how many tokens a scheme takes when it is printed.

The one measure that decides whether a rule pays, by `compiler.tokens`: a name, a number, a sign, a
mark or a bracket is one token. Follows what `printing` prints; nothing here prints or searches.
"""

from __future__ import annotations

from typing import assert_never

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers
from ipmlang.inverse.split.scheme import (
    Array,
    Cell,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Terminal,
)

SMALL = 1e-9  # what is printed as nothing at all, in degrees or as a ratio
HEAD = 2  # `Name -->`
LOOP = 9  # `repeat(i < n) { … }`
AROUND = 3  # `[… A]`
VECTOR = 6  # `translate(x, y, z)` without signs
SPLIT = 4  # `split x { … }`
OCTANT = 7  # `octant(x, y, z, 1)`
ASSET = 4  # `asset a = "…"`


def placement_tokens(frames: Frames, small: float) -> Integers:
    """(n,) tokens of `[translate(x, y, z) rotate(a, b, c) mirror A]`, what is not needed left out.

    small: units, distances that are printed as 0.

    >>> from ipmlang.inverse.frames import moved_to
    >>> placement_tokens(moved_to(np.array([[0.0, 0, 0], [3, 4, 0], [0, -3, 0]])), 1e-9).tolist()
    [1, 9, 10]
    """
    moved = np.abs(frames.position) > small
    turned = np.abs(frames.rotation[:, 1:]).max(axis=1, initial=0.0) > SMALL
    inside = np.where(moved.any(axis=1), VECTOR + _negative(frames.position, small), 0)
    inside = inside + np.where(turned, VECTOR + 1, 0) + (frames.hand < 0)
    inside = inside + np.where(np.abs(frames.scale - 1) > SMALL, 4, 0)
    return np.where(inside > 0, inside + AROUND, 1).astype(np.int64)


def _negative(values: Floats, small: float) -> Integers:
    return np.asarray((values < -small).sum(axis=-1), np.int64)


def item_tokens(item: Item, small: float) -> int:
    """Tokens of an item in a rule's body."""
    match item:
        case Place():
            stretched = 0 if item.stretch is None else (VECTOR + 3) * len(item.frames)
            return int(placement_tokens(item.frames, small).sum()) + stretched
        case Array():
            return _array_tokens(item, small)
        case Ring():
            own = int(placement_tokens(item.first, small)[0])
            center = VECTOR if float(np.abs(item.center).max()) > small else 0
            rise = 4 if abs(item.rise) > small else 0
            growth = 4 if abs(item.growth - 1) > SMALL else 0
            return LOOP + AROUND + VECTOR + 2 + own + center + rise + growth + len(item.holes)
        case Split():
            return SPLIT + sum(_cell_tokens(cell) for cell in item.cells) + len(item.cells) - 1
        case Octant():
            cells = VECTOR if max(item.counts) > 1 else 0
            inner = int(placement_tokens(item.inner, small)[0])
            return 2 + OCTANT * len(item.cuts) + cells + inner
        case _:
            assert_never(item)


def _array_tokens(array: Array, small: float) -> int:
    own = int(placement_tokens(array.first, small)[0])
    step = sum(
        LOOP + 2 * int((np.abs(direction.step) > small).sum()) + 2 * len(direction.steps)
        for direction in array.directions
    )
    return AROUND + VECTOR + own + step + len(array.holes) * len(array.directions)


def _cell_tokens(cell: Cell) -> int:
    return 3 + cell.elastic + (3 if cell.count > 1 else 0)


def rule_tokens(rule: Rule, small: float) -> int:
    """Tokens of a rule with its head."""
    return HEAD + sum(item_tokens(item, small) for item in rule.items)


def scheme_tokens(scheme: Scheme, small: float) -> int:
    """Tokens of all of it; `small` as in `placement_tokens`."""
    return sum(
        ASSET if isinstance(symbol, Terminal) else rule_tokens(symbol, small)
        for symbol in scheme.symbols
    )
