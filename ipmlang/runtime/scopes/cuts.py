"""The cuts of splits, moved to lines beside them.

In go the pieces of many splits, as columns, and the lines next to each of their cuts; out come
pieces that begin and end elsewhere. Pieces of absolute size keep it: they and the cuts around them
move as one block, and what gives way is on either side. The order of pieces never changes, and
none of them vanishes. No line, shape or rule is known here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
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


def moved(
    pieces: Pieces, below: Floats, above: Floats, reach: Floats, whole: Floats
) -> tuple[Floats, Floats]:
    """Where pieces begin and how long they are (m,), once each cut is at the line that it snaps to.

    below, above (c,): the lines next to each cut, -inf and inf where there is none. reach (m,): how
    far cuts may move; whole (m,): the length of the split. A block of cuts between two pieces that
    give way moves by the least distance that brings one of them to a line, and by less than half of
    the piece that it moves into; of lines that are equally near the lower one counts.

    >>> row = np.zeros(3, np.int64)
    >>> own = Pieces(row, np.array([0., 4, 6]), np.array([4., 2, 4]), row, row == 0)
    >>> lines = np.array([3.5, -np.inf]), np.array([np.inf, 7.0])
    >>> moved(own, *lines, np.full(3, np.inf), np.full(3, 10.0))
    (array([0. , 3.5, 7. ]), array([3.5, 3.5, 3. ]))
    """
    cuts = pieces.cuts
    low, high = pieces.low.copy(), pieces.low + pieces.size
    if len(cuts):
        by = _shifts(pieces, cuts, (below, above), reach, whole)
        low[cuts + 1] += by
        high[cuts] = low[cuts + 1]
    return low, np.where(pieces.gives, high - low, pieces.size)


def _shifts(
    pieces: Pieces, cuts: Numbers, lines: tuple[Floats, Floats], reach: Floats, whole: Floats
) -> Floats:
    """How far each cut moves (c,)."""
    first = np.ones(len(cuts), np.bool_)
    first[1:] = pieces.gives[cuts[1:]] | (cuts[1:] != cuts[:-1] + 1)
    begins = np.flatnonzero(first)
    ends = np.append(begins[1:], len(cuts)) - 1
    block = np.cumsum(first) - 1
    left, right = cuts[begins], cuts[ends] + 1  # the pieces around each block
    free = pieces.gives[left] & pieces.gives[right]
    near = NEAR * whole[cuts]
    best = np.zeros(len(cuts))
    least = np.full(len(cuts), np.inf)
    for line in lines:
        by = line - pieces.low[cuts + 1]
        into = np.where(by < 0, left[block], right[block])
        far = np.abs(by)
        fits = free[block] & (far < pieces.size[into] / 2 - near) & (far <= reach[cuts] + near)
        nearer = fits & (far < least - near)
        best[nearer], least[nearer] = by[nearer], far[nearer]
    nearest = np.minimum.reduceat(least, begins)
    number = np.where(least <= nearest[block] + near, np.arange(len(cuts)), len(cuts))
    chosen = np.minimum.reduceat(number, begins)
    shift: Floats = best[chosen][block]
    return shift
