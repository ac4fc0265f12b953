"""Which runs of segments are congruent, answered without comparing them.

The joints' letters are ranked for all windows of 1, 2, 4, … letters, in all four spellings at once;
any window is two of these. So a question about many runs of one length is one look-up. n log n to
build, exact, no hashing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """ranks[h]: (4 * (length + 1),) names of the windows of 2**h letters; length: joints."""

    ranks: tuple[Integers, ...]
    length: int
    variants: tuple[int, ...]

    def classes(self, start: Integers, count: int) -> tuple[Integers, Integers]:
        """For the runs of `count` segments from `start` on (any shape): a name that is equal for
        congruent runs, and the variant that makes each the representative.
        """
        start = np.asarray(start, np.int64)
        if count <= 1:
            return np.zeros_like(start), np.zeros_like(start)
        keys = np.stack([self.keys(variant, start, count - 1) for variant in self.variants])
        best = np.argmin(keys, axis=0)
        name = np.take_along_axis(keys, best[None], axis=0)[0]
        return name, np.array(self.variants, np.int64)[best]

    def keys(self, variant: int, start: Integers, letters: int) -> Integers:
        """Names of the runs of `letters` joints from `start` on as one variant sees them."""
        if variant & 2:
            start = self.length - start - letters
        place = start + variant * (self.length + 1)
        level = letters.bit_length() - 1
        rank = self.ranks[level]
        return rank[place] * len(rank) + rank[place + letters - (1 << level)]


def rank_windows(spellings: list[Integers], variants: tuple[int, ...]) -> Windows:
    """All windows of the four spellings."""
    length = len(spellings[0])
    closing = np.max(spellings) + 1 + np.arange(len(spellings))
    parts = [np.append(each, end) for each, end in zip(spellings, closing, strict=True)]
    ranks = [np.concatenate(parts)]
    reach = 1
    while 2 * reach <= length:
        last = ranks[-1]
        behind = np.append(last[reach:], np.full(reach, last.max() + 1))
        pairs = last * (int(behind.max()) + 1) + behind
        ranks.append(np.unique(pairs, return_inverse=True)[1].ravel().astype(np.int64))
        reach *= 2
    return Windows(tuple(ranks), length, variants)
