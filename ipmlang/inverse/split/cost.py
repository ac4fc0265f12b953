"""Description length: how many tokens a scheme takes when it is printed.

The one measure that decides whether a rule pays, by `compiler.tokens`: a name, a number, a sign, a
mark or a bracket is one token. Follows what `printing` prints; nothing here prints or searches.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeGuard, assert_never

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, join
from ipmlang.inverse.split.listing import FEWEST as ROWS
from ipmlang.inverse.split.listing import every_token, singly_tokens
from ipmlang.inverse.split.scheme import (
    Array,
    Cell,
    Direction,
    Item,
    Octant,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Terminal,
)
from ipmlang.inverse.split.turning import around_axis

SMALL = 1e-9  # what is printed as nothing at all, in degrees or as a ratio
HEAD = 2  # `Name -->`
LOOP = 8  # `repeat(i < n) { … }`
STEP = 4  # `+ d * i`
TABLE = 6  # `table T(at) =`
EXCEPT = 3  # `except (…)`
ANCHOR = 2  # `scope.sz - 3` for a number
AROUND = 3  # `[… A]`
VECTOR = 6  # `translate(x, y, z)` without signs
SPLIT = 4  # `split x { … }`
OCTANT = 7  # `octant(x, y, z, 1)`
CIRCLE = 9  # `+ r * cos(a * i)`
GROWTH = 5  # `pow(g, i)`
FEWEST = LOOP + VECTOR + 2 + AROUND  # of a ring, which is the shortest of all patterns
ASSET = 1  # one more name in `asset a, b, c in "…"`
SHAPE = 6  # for a shape in the parts file, beside its name: where schemes differ in these


def placement_tokens(frames: Frames, small: float) -> Integers:
    """(n,) tokens of `[translate(x, y, z) rotate(a, b, c) mirror A]`, what is not needed left out.

    small: units, distances that are printed as 0.

    >>> from ipmlang.inverse.frames import moved_to
    >>> placement_tokens(moved_to(np.array([[0.0, 0, 0], [3, 4, 0], [0, -3, 0]])), 1e-9).tolist()
    [1, 9, 10]
    """
    moved = (np.abs(frames.position) > small).any(axis=1)
    inside = VECTOR * moved + _negative(frames.position, small) + (frames.hand < 0)
    if frames.rotation[:, 1:].any():
        inside += (VECTOR + 1) * (np.abs(frames.rotation[:, 1:]) > SMALL).any(axis=1)
    inside += 4 * (np.abs(frames.scale - 1) > SMALL)
    return np.asarray(np.where(inside > 0, inside + AROUND, 1), np.int64)


def _negative(values: Floats, small: float) -> Integers:
    return np.asarray((values < -small).sum(axis=-1), np.int64)


def item_tokens(item: Item, small: float) -> int:
    """Tokens of an item in a rule's body."""
    match item:
        case Place():
            alone = placement_tokens(item.frames, small) + ANCHOR * len(item.anchors)
            if item.stretch is not None:
                return int(alone.sum()) + stretch_tokens(item, small)
            return int(every_token(item.frames, alone, small)[0])
        case Array() | Ring():
            return int(tokens_from(item, item.first, small)[0])
        case Split():
            return SPLIT + sum(_cell_tokens(cell) for cell in item.cells) + len(item.cells) - 1
        case Octant():
            cells = VECTOR if max(item.counts) > 1 else 0
            inner = int(placement_tokens(item.inner, small)[0])
            return 2 + OCTANT * len(item.cuts) + cells + inner
        case _:
            assert_never(item)


def stretch_tokens(place: Place, small: float) -> int:
    """Tokens of `size(scope.sx - 1, y, z) insert(A) B` beyond those of `A`, brackets included."""
    margins = np.zeros((0, 3)) if place.margins is None else place.margins
    follows = np.isfinite(margins) & (np.abs(margins) > small)
    return (VECTOR + 4) * len(place.frames) + 2 * int(follows.sum())


def tokens_from(item: Array | Ring, first: Frames, small: float) -> Integers:
    """(n,) tokens of a row or a ring if its first member stood in one of these frames (n,)."""
    if isinstance(item, Array):
        return _array_tokens(item, first, small)
    return _ring_tokens(item, first, small)


def _array_tokens(array: Array, first: Frames, small: float) -> Integers:
    own = placement_tokens(first, small)
    still = np.abs(first.position).max(axis=1) <= small
    own = own + still * np.where(own > 1, VECTOR, VECTOR + AROUND - 1)
    loops = [_loop_tokens(each, small) for each in array.directions]
    if not array.holes:
        return np.asarray(own + sum(loops))
    if len(loops) == 1 or not any(direction.steps for direction in array.directions):
        through = 8 * (len(loops) - 1)
        return np.asarray(own + sum(loops) + EXCEPT + len(array.holes) + through)
    rows = len({hole[1:] for hole in array.holes})  # these are written again, with what is left out
    again = rows * (own + loops[0] + EXCEPT + 1) + len(array.holes)
    return np.asarray(own + sum(loops) + EXCEPT + again)


def fewest_tokens(directions: Sequence[tuple[int, bool]], holes: int) -> int:
    """No more than the tokens of any array with so many members along its directions, in even
    steps or not, and so many holes.
    """
    moved = VECTOR + AROUND
    loops = sum(
        LOOP + STEP if even else LOOP + STEP - 2 + TABLE + 3 * count for count, even in directions
    )
    return moved + loops + (EXCEPT + holes if holes else 0)


def _loop_tokens(direction: Direction, small: float) -> int:
    if direction.angle:
        aslant = np.count_nonzero(np.abs(direction.step) > small) > 1
        return LOOP + 2 * (CIRCLE + 2 * bool(aslant))
    moved = int((np.abs(direction.step) > small).sum())
    if not direction.steps:
        return LOOP + STEP * moved
    straight = int((np.abs(np.abs(direction.step) - 1) < SMALL).sum())
    return LOOP + STEP * moved - 2 * straight + TABLE + 3 * direction.count


def _ring_tokens(ring: Ring, first: Frames, small: float) -> Integers:
    if not ring.angle:
        return _swelling_tokens(ring, first, small)
    upright = float(ring.axis[2]) > 1 - SMALL
    center = float(np.abs(ring.center).max()) > small
    outer = 2 * (center or not upright) + VECTOR * center + (VECTOR + 1) * (not upright)
    outer += int(_negative(ring.center, small))
    placed = placement_tokens(around_axis(ring, first), small)
    inner = VECTOR + 2 + AROUND + np.maximum(placed - AROUND, 0)
    rise = VECTOR + 2 if abs(ring.rise) > small else 0
    growth = VECTOR + 2 if abs(ring.growth - 1) > SMALL else 0
    holes = EXCEPT + len(ring.holes) if ring.holes else 0
    return LOOP + outer + inner + rise + growth + holes


def _swelling_tokens(ring: Ring, first: Frames, small: float) -> Integers:
    """Of `repeat(i < n) { [translate(x, y, z + d * i) *(s * pow(g, i)) A] }`."""
    moved = np.abs(ring.rise * ring.axis) > small
    begun = np.abs(ring.center) > small
    steps = STEP * int(moved.sum()) - 2 * int((moved & ~begun).sum())
    place = (VECTOR + steps + int(_negative(ring.center, small))) * bool((moved | begun).any())
    scaled = np.abs(first.scale - 1) > SMALL
    inner = placement_tokens(around_axis(ring, first), small) - 4 * scaled
    whole = LOOP + place + AROUND + 3 + GROWTH + 2 * scaled + np.maximum(inner - AROUND, 0)
    return np.asarray(whole, np.int64)


def _cell_tokens(cell: Cell) -> int:
    return 3 + cell.elastic + (3 if cell.count > 1 else 0)


def rule_tokens(rule: Rule, small: float) -> int:
    """Tokens of a rule with its head."""
    short = [item for item in rule.items if _is_short(item)]
    others = sum(item_tokens(item, small) for item in rule.items if not _is_short(item))
    if not short:
        return HEAD + others
    frames = join([item.frames for item in short])
    anchors = np.repeat([len(item.anchors) for item in short], [len(item.frames) for item in short])
    alone = placement_tokens(frames, small) + ANCHOR * anchors
    return HEAD + others + int(singly_tokens(frames, alone).sum())


def _is_short(item: Item) -> TypeGuard[Place]:
    """Whether an item is a list too short for a table: many are counted at once."""
    return isinstance(item, Place) and item.stretch is None and len(item.frames) < ROWS


def scheme_tokens(scheme: Scheme, small: float) -> int:
    """Tokens of all of it; `small` as in `placement_tokens`."""
    return sum(
        ASSET if isinstance(symbol, Terminal) else rule_tokens(symbol, small)
        for symbol in scheme.symbols
    )
