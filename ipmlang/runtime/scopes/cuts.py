"""The cuts of splits, moved to lines beside them.

In go the pieces of many splits, as columns, and who knows the lines beside places; out come pieces
that begin and end elsewhere. Pieces of absolute size keep it: they and the cuts around them
move as one block, and what gives way is on either side. The order of pieces never changes, and
none of them vanishes. No line, shape or rule is known here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
Beside = Callable[[Numbers, Floats], tuple[Floats, Floats]]
NEAR = 1e-9  # of the whole length: distances that differ by less are the same


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """The pieces of splits, one after the other, those of each split together: the row of its
    split, where it begins, how long it is, its part, and whether it gives way; all (m,).
    """

    row: Numbers
    low: Floats
    size: Floats
    part: Numbers
    gives: NDArray[np.bool_]

    def ordered(self, chosen: NDArray[np.bool_]) -> Pieces:
        """Those that are chosen, in the order in which they stand."""
        rows = np.flatnonzero(chosen)
        rows = rows[np.lexsort((self.low[rows], self.row[rows]))]
        return Pieces(
            self.row[rows], self.low[rows], self.size[rows], self.part[rows], self.gives[rows]
        )

    @property
    def cuts(self) -> Numbers:
        """The pieces (c,) that end at a cut, which is where the next one of the split begins."""
        found: Numbers = np.flatnonzero(self.row[1:] == self.row[:-1])
        return found


def together(parts: Sequence[Pieces]) -> Pieces:
    """Several batches as one."""
    none = np.zeros(0, np.int64)
    return Pieces(
        np.concatenate([none, *(each.row for each in parts)]),
        np.concatenate([none * 0.0, *(each.low for each in parts)]),
        np.concatenate([none * 0.0, *(each.size for each in parts)]),
        np.concatenate([none, *(each.part for each in parts)]),
        np.concatenate([none > 0, *(each.gives for each in parts)]),
    )


def moved(pieces: Pieces, beside: Beside, reach: Floats, whole: Floats) -> tuple[Floats, Floats]:
    """Where pieces begin and how long they are (m,), once each cut is at the line that it snaps to.

    beside: gives of rows and places in them (p,) the lines at or below, and at or above, -inf and
    inf where there is none. reach (m,): how far cuts may move; whole (m,): the length of the split.
    A block of cuts between two pieces that give way moves so that one of them comes to a line next
    to it: so that as many of them as can be come to lines, then as little as can be, then toward
    the start, and by less than half of the piece that it moves into.

    >>> row = np.zeros(3, np.int64)
    >>> own = Pieces(row, np.array([0., 4, 6]), np.array([4., 2, 4]), row, row + [1, 0, 1] > 0)
    >>> moved(own, lambda _, at: (at * 0 + 3.5, at * 0 + 7), np.full(3, 9.), np.full(3, 10.))
    (array([0. , 3.5, 5.5]), array([3.5, 2. , 4.5]))
    """
    cuts = pieces.cuts
    low, high = pieces.low.copy(), pieces.low + pieces.size
    if len(cuts):
        by = _shifts(pieces, cuts, beside, reach, whole)
        low[cuts + 1] += by
        high[cuts] = low[cuts + 1]
    return low, np.where(pieces.gives, high - low, pieces.size)


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Cuts that move together: the block of each cut (c,); the first cut of each block and how many
    it has (b,); and the pieces on either side that give way, -1 for a block that cannot move.
    """

    of: Numbers
    first: Numbers
    many: Numbers
    left: Numbers
    right: Numbers


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Where cuts are: the row and the place of each, and what is near there (c,)."""

    row: Numbers
    at: Floats
    near: Floats


def _shifts(pieces: Pieces, cuts: Numbers, beside: Beside, reach: Floats, whole: Floats) -> Floats:
    """How far each cut moves (c,)."""
    blocks = _blocks(pieces, cuts)
    near = NEAR * whole[cuts]
    row, at = pieces.row[cuts], pieces.low[cuts + 1]
    below, above = (line - at for line in beside(row, at))
    moves = np.concatenate([below, np.where(above - below > near, above, np.inf)])
    block, slack = np.tile(blocks.of, 2), np.tile(near, 2)
    into = np.where(moves < 0, blocks.left[block], blocks.right[block])
    far = np.abs(moves)
    fits = (into >= 0) & (far <= np.tile(reach[cuts], 2) + slack)
    fits &= far < pieces.size[into] / 2 - slack
    rows = np.flatnonzero(fits)
    rows = rows[np.lexsort((moves[rows], block[rows]))]
    many = _brought(blocks, block[rows], moves[rows], _Places(row, at, near), beside)
    rows = rows[_least(block[rows], -many, np.zeros(len(rows)))]
    rows = rows[_least(block[rows], far[rows], slack[rows])]
    rows = rows[_changes(block[rows])]  # the first of each block
    shift = np.zeros(len(blocks.first))
    shift[block[rows]] = moves[rows]
    return shift[blocks.of]


def _blocks(pieces: Pieces, cuts: Numbers) -> _Blocks:
    """The blocks that cuts belong to."""
    first = np.ones(len(cuts), np.bool_)
    first[1:] = pieces.gives[cuts[1:]] | (cuts[1:] != cuts[:-1] + 1)
    begins = np.flatnonzero(first)
    many = np.diff(begins, append=len(cuts))
    left, right = cuts[begins], cuts[begins + many - 1] + 1
    free = pieces.gives[left] & pieces.gives[right]
    left, right = np.where(free, left, -1), np.where(free, right, -1)
    return _Blocks(np.cumsum(first) - 1, begins, many, left, right)


def _brought(
    blocks: _Blocks,
    block: Numbers,
    moves: Floats,
    cuts: _Places,
    beside: Beside,
) -> Floats:
    """How many cuts each move (m,) of a block brings to lines."""
    found = np.ones(len(moves))
    several = np.flatnonzero(blocks.many[block] > 1)
    many = blocks.many[block[several]]
    owner = np.repeat(np.arange(len(several)), many)
    number = np.arange(len(owner)) - (np.cumsum(many) - many)[owner]
    cut = blocks.first[block[several]][owner] + number
    at = cuts.at[cut] + moves[several][owner]
    below, above = beside(cuts.row[cut], at)
    there = (at - below <= cuts.near[cut]) | (above - at <= cuts.near[cut])
    found[several] = np.bincount(owner, there, minlength=len(several))
    return found


def _least(block: Numbers, values: Floats, slack: Floats) -> Numbers:
    """Where a value is the least of its block, up to some slack; blocks stand together."""
    if not len(block):
        return block
    begins = _changes(block)
    least = np.minimum.reduceat(values, np.flatnonzero(begins))
    found: Numbers = np.flatnonzero(values <= least[np.cumsum(begins) - 1] + slack)
    return found


def _changes(block: Numbers) -> NDArray[np.bool_]:
    """Where another block begins."""
    found = np.ones(len(block), np.bool_)
    found[1:] = block[1:] != block[:-1]
    return found
