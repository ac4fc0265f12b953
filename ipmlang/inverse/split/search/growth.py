"""Growing motifs: from a pair that occurs again to the largest groups that do.

A seed's motions are applied to what is near the first occurrence; what has an equal in all
occurrences joins. When nothing more does, the occurrences that lack the best next row are given
up, so that one seed gives a chain from small motifs used often to large ones used twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.search.fields import Field, look_up_moved
from ipmlang.inverse.split.search.seeds import Seed
from ipmlang.inverse.split.snapping import Flags

LARGEST = 600  # rows of one occurrence
LONGEST = 12  # times that occurrences are given up


@dataclass(frozen=True, slots=True, eq=False)
class Grown:
    """rows: (k, m) equal groups; motion: (k, 3, 4) from the first to each."""

    rows: Integers
    motion: Floats


class _Growth:
    """What a growing motif is: hits (x, a) says where motion a, to occurrence of[a], takes row
    known[x]; joined says which of these belong, taken (n + 1,) which rows they and their images
    are.
    """

    def __init__(self, around: Field, seed: Seed, error: float) -> None:
        count = len(around.draft)
        self._around = around
        self._error = error
        self._motion = seed.motion
        self._home = around.draft.body[seed.pairs[:, 0]]
        self._place = np.full(count, -1, np.int64)  # of a row in what is known
        self._fresh: list[int] = []
        self._of = seed.of
        self._first = _firsts(seed.of)
        self.known = np.zeros(0, np.int64)
        self._hits = np.zeros((0, len(seed.of)), np.int64)
        self.joined: list[int] = []
        self._taken = np.zeros(count + 1, np.bool_)
        self._taken[-1] = True
        self.work = 0

    def meet(self, rows: Integers) -> None:
        """Look where the motions take rows that were not asked about before."""
        new = rows[self._place[rows] < 0]
        body = self._home[self._of]
        found = look_up_moved(self._around, new, self._motion, body, self._error)
        self._place[new] = len(self.known) + np.arange(len(new))
        self.known = np.concatenate([self.known, new])
        self._hits = np.concatenate([self._hits, found])
        self.work += found.size

    def look_around(self) -> None:
        """Meet what is near to all that joined since this was asked last."""
        self.meet(self._around.around(self.known[self._fresh]))
        self._fresh = []

    def place(self, row: int) -> int:
        """Where a row is in what is known."""
        return int(self._place[row])

    def rows(self) -> Integers:
        """(k, m) the rows of all occurrences."""
        return self._hits[self.joined][:, self._first].T

    def support(self) -> Flags:
        """(x, k) whether known row x could join occurrence k, in some way."""
        free = ~self._taken[self._hits] & ~self._taken[self.known][:, None]
        free &= (self._hits != self.known[:, None]) | (self._of == 0)[None]
        return np.logical_or.reduceat(free, self._first, axis=1)

    def join(self, index: int) -> bool:
        """Take known row `index` in, unless two occurrences would have to share."""
        hits = self._hits[index]
        fits = ~self._taken[hits]
        whole = bool(fits.all())
        targets = hits[self._first] if whole else self._targets(hits, fits)
        if targets is None or len(set(targets.tolist())) < len(targets):
            return False
        self.joined.append(index)
        self._fresh.append(index)
        if whole:
            self._taken[targets] = True
        else:
            self._keep(fits)
        return True

    def _targets(self, hits: Integers, fits: Flags) -> Integers | None:
        """(k,) the first that fits for each occurrence, None where one has none."""
        kept = self._of[fits]
        first = _firsts(kept)
        return hits[fits][first] if len(first) == len(self._first) else None

    def _keep(self, ways: Flags) -> None:
        self._of, self._motion = self._of[ways], self._motion[ways]
        self._hits = self._hits[:, ways]
        self._first = _firsts(self._of)
        self._taken[:-1] = False
        self._taken[self.rows()] = True

    def give_up(self, lacking: Flags) -> None:
        """Go on without these occurrences."""
        self._keep(~lacking[self._of])
        number = np.cumsum(~lacking) - 1
        self._home, self._of = self._home[~lacking], number[self._of]

    def grown(self) -> Grown:
        """What there is now."""
        return Grown(self.rows(), self._motion[self._first])


def _firsts(numbers: Integers) -> Integers:
    """Where each number stands first, in numbers that are sorted."""
    new = np.ones(len(numbers), np.bool_)
    new[1:] = numbers[1:] != numbers[:-1]
    return np.nonzero(new)[0]


def grow(field: Field, seed: Seed, error: float) -> tuple[list[Grown], int]:
    """The chain of motifs from one seed, and the work it took in lookups."""
    growth = _Growth(field, seed, error)
    growth.meet(seed.pairs[0])
    chain: list[Grown] = []
    for row in seed.pairs[0].tolist():
        growth.join(growth.place(row))
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
        growth.look_around()
        full = np.nonzero(growth.support().all(axis=1))[0]
        if not [index for index in full.tolist() if growth.join(index)]:
            return
