"""Growing motifs: from a pair that occurs again to the largest groups that do.

A seed's motions are applied to what is near the first occurrence; what has an equal in all
occurrences joins. When nothing more does, the occurrences that lack the best next row are given
up, so that one seed gives a chain from small motifs used often to large ones used twice.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.search.fields import Field, look_up
from ipmlang.inverse.split.search.seeds import Seed
from ipmlang.inverse.split.snapping import Flags

LARGEST = 600  # rows of one occurrence
LONGEST = 12  # times that occurrences are given up


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """rows: (k, m) equal groups; motion: (k, 3, 4) from the first to each."""

    rows: Integers
    motion: Floats


@dataclass(slots=True, eq=False)
class _Growth:
    """What a growing motif is: hits (x, a) says where motion a takes row known[x]; joined says
    which of these belong.
    """

    around: Field
    error: float
    of: Integers
    motion: Floats
    home: Integers
    known: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    hits: Integers = field(default_factory=lambda: np.zeros((0, 0), np.int64))
    joined: list[int] = field(default_factory=list)
    work: int = 0

    def meet(self, rows: Integers) -> None:
        """Look where the motions take rows that were not asked about before."""
        new = np.setdiff1d(rows, self.known)
        count, ways = len(new), len(self.of)
        wanted = np.einsum("aij,xkj->xaki", self.motion[:, :, :3], self.around.points[new])
        wanted = (wanted + self.motion[None, :, None, :, 3]).reshape(-1, 4, 3)
        symbol = np.repeat(self.around.draft.symbol[new], ways)
        body = np.tile(self.home[self.of], count)
        found = look_up(self.around, wanted, symbol, body, self.error).reshape(count, ways)
        self.known = np.concatenate([self.known, new])
        self.hits = np.concatenate([self.hits.reshape(-1, ways), found])
        self.work += count * ways

    def first_ways(self) -> Integers:
        """(k,) the first motion to each occurrence."""
        return np.searchsorted(self.of, np.arange(self.of[-1] + 1))

    def rows(self) -> Integers:
        """(k, m) the rows of all occurrences."""
        return self.hits[self.joined][:, self.first_ways()].T

    def support(self) -> Flags:
        """(x, k) whether known row x could join occurrence k, in some way."""
        used = np.zeros(len(self.around.draft) + 1, np.bool_)
        used[self.rows().ravel()] = True
        used[-1] = True
        free = ~used[self.hits] & ~used[self.known][:, None]
        free &= (self.hits != self.known[:, None]) | (self.of == 0)[None]
        return np.logical_or.reduceat(free, self.first_ways(), axis=1)

    def join(self, index: int) -> bool:
        """Take known row `index` in, unless two occurrences would have to share."""
        taken = np.zeros(len(self.around.draft) + 1, np.bool_)
        taken[-1] = True
        if self.joined:
            taken[self.rows()] = True
        fits = ~taken[self.hits[index]]
        kept = self.of[fits]
        if len(np.unique(kept)) < self.of[-1] + 1:
            return False
        targets = self.hits[index][fits][np.searchsorted(kept, np.arange(self.of[-1] + 1))]
        if len(np.unique(targets)) < len(targets):
            return False
        self._keep(fits)
        self.joined.append(index)
        return True

    def _keep(self, ways: Flags) -> None:
        self.of, self.motion, self.hits = self.of[ways], self.motion[ways], self.hits[:, ways]

    def give_up(self, lacking: Flags) -> None:
        """Go on without these occurrences."""
        self._keep(~lacking[self.of])
        number = np.cumsum(~lacking) - 1
        self.home, self.of = self.home[~lacking], number[self.of]

    def grown(self) -> Grown:
        """What there is now."""
        return Grown(self.rows(), self.motion[self.first_ways()])


def grow(field: Field, seed: Seed, error: float) -> tuple[list[Grown], int]:
    """The chain of motifs from one seed, and the work it took in lookups."""
    growth = _Growth(field, error, seed.of, seed.motion, field.draft.body[seed.pairs[:, 0]])
    growth.meet(seed.pairs[0])
    chain: list[Grown] = []
    for row in seed.pairs[0].tolist():
        growth.join(int(np.nonzero(growth.known == row)[0][0]))
    if len(growth.joined) < 2:
        return [], growth.work
    for _ in range(LONGEST):
        _saturate(growth)
        chain.append(growth.grown())
        support = growth.support()
        count = support.sum(axis=1) * support[:, 0] if len(support) else np.zeros(0)
        if len(count) == 0 or count.max() < 2 or len(growth.joined) >= LARGEST:
            break
        best = int(np.argmax(count))
        growth.give_up(~support[best])
        if not growth.join(best):
            break
    return chain, growth.work


def _saturate(growth: _Growth) -> None:
    """Let everything join that all occurrences have."""
    while len(growth.joined) < LARGEST:
        growth.meet(growth.around.around(growth.known[growth.joined]))
        full = np.nonzero(growth.support().all(axis=1))[0]
        if not [index for index in full.tolist() if growth.join(index)]:
            return
