"""Where the copies of a symbol lie in its run of segments, the same at every level.

In come the sizes of a recursion and the windows of the drawing; out come layouts: how many pieces
stand before each copy, and which copies are mirrored or run backwards. A layout is given only if
the runs are congruent down to the last level but one. Only counts and congruence are used here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from ipmlang.inverse.recursion.sizes import Sizes
from ipmlang.inverse.recursion.strokes import REVERSED, Integers
from ipmlang.inverse.recursion.windows import Windows

MOST_LAYOUTS = 24


@dataclass(frozen=True, slots=True)
class Layout:
    """before: (copies,) pieces before each copy, counted from the first; variant: (copies,) how
    each is to be seen to be the plain symbol; pieces: all of them.
    """

    before: tuple[int, ...]
    variant: tuple[int, ...]
    pieces: int

    def starts(self, count: int, piece: int) -> Integers:
        """First segments of the copies where a copy has `count` and a piece `piece` segments."""
        return np.arange(len(self.before)) * count + np.array(self.before, np.int64) * piece


def axiom_layouts(windows: Windows, sizes: Sizes) -> Iterator[Layout]:
    """Of the axiom's symbols in the whole drawing. The variants are relative to the first copy."""
    count, piece = sizes.count(sizes.steps), sizes.piece(sizes.steps)
    yield from _layouts(windows, 0, count, piece, sizes.axiom_copies, sizes.axiom_pieces)


def body_layouts(windows: Windows, sizes: Sizes, first: int) -> Iterator[Layout]:
    """Of the body's copies in a symbol whose run starts at `first`; proven down the levels."""
    count, piece = sizes.count(sizes.steps - 1), sizes.piece(sizes.steps - 1)
    for layout in _layouts(windows, first, count, piece, sizes.copies, sizes.pieces):
        for shift in windows.variants:
            variant = tuple(each ^ shift for each in layout.variant)
            turned = Layout(layout.before, variant, layout.pieces)
            if _holds(windows, sizes, turned, first):
                yield turned


def _layouts(
    windows: Windows, first: int, count: int, piece: int, copies: int, pieces: int
) -> Iterator[Layout]:
    """Non-overlapping congruent runs of `count` segments with whole pieces between."""
    shift = np.arange(pieces + 1) * piece
    start = first + np.arange(copies)[:, None] * count + shift
    names, variants = windows.classes(start, count)
    for name in dict.fromkeys(names[0].tolist()):
        chains = _chains(names == name, 0, 0)
        for chain in islice(chains, MOST_LAYOUTS):
            seen = [int(variants[copy, place]) for copy, place in enumerate(chain)]
            yield Layout(tuple(chain), tuple(each ^ seen[0] for each in seen), pieces)


def _chains(
    fits: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], copy: int, least: int
) -> Iterator[tuple[int, ...]]:
    """Ascending columns, one of each row, where `fits` holds."""
    if copy == len(fits):
        yield ()
        return
    for place in (least + np.flatnonzero(fits[copy, least:])).tolist():
        for rest in _chains(fits, copy + 1, place):
            yield (place, *rest)


def _holds(windows: Windows, sizes: Sizes, layout: Layout, first: int) -> bool:
    """Whether the first copy has the same layout inside, and so on down."""
    variant = 0
    for steps in range(sizes.steps, 1, -1):
        count, piece = sizes.count(steps - 1), sizes.piece(steps - 1)
        if count < 2:
            return True
        inside = layout.starts(count, piece)
        turned = np.array(layout.variant) ^ variant
        if variant & REVERSED:
            inside = sizes.count(steps) - inside - count
        names = [
            int(windows.keys(int(seen), first + place, count - 1))
            for seen, place in zip(turned, inside, strict=True)
        ]
        if any(name != names[0] for name in names):
            return False
        first, variant = first + int(inside[0]), int(turned[0])
    return True
