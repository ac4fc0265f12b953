"""Candidates: rules that a search could make next, with what ranks them.

Takes what was found in the string (pairs, motifs, runs, trees); says of each what it is called,
which neighbours it joins, and what it is worth. Nothing here finds or takes one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.lsystem.importance import Cluster, Terms
from ipmlang.inverse.lsystem.journal import Outcome, Trial
from ipmlang.inverse.lsystem.motifs import Motif
from ipmlang.inverse.lsystem.sequences import Run
from ipmlang.inverse.lsystem.symbols import Arrangement, Integers
from ipmlang.inverse.lsystem.trees import Tree


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A rule that could be made. gain: tokens it would save if all occurrences were free.

    A pair has rows of its first symbols, their leads and the step; a longer stretch is a `motif`;
    runs of one pattern have `runs`.
    """

    gain: float
    order: int
    rows: Integers
    lead: Frames
    step: Frames | None = None
    runs: tuple[Run, ...] = ()
    motif: Motif | None = None
    tree: Tree | None = None
    terms: Terms | None = None
    multiplier: float = 1.0

    @property
    def worth(self) -> float:
        """What ranks candidates: the gain, times what the weights make of it."""
        return self.gain * self.multiplier

    @property
    def kind(self) -> str:
        """In a person's words."""
        named = (("sequence", self.runs), ("tree", self.tree), ("motif", self.motif))
        return next((word for word, own in named if own), "pair" if self.step else "lattice")

    def cluster(self) -> Cluster:
        """The neighbours that the rule would join; members of a lattice follow each other in it."""
        if self.kind == "lattice":
            return Cluster(self.rows[:-1], self.rows[1:], 1, float(len(self.rows)))
        sizes = [run.count for run in self.runs] or [2] * len(self.rows)
        if self.tree is not None:
            sizes = [self.tree.count]
        elif self.motif is not None:
            sizes = [self.motif.length] * len(self.rows)
        inside = zip(self.rows.tolist(), sizes, strict=True)
        first = np.concatenate([np.arange(row, row + size - 1) for row, size in inside])
        return Cluster(first, first + 1, len(sizes), float(np.mean(sizes)))

    def trial(self, string: Arrangement, terms: Terms, outcome: Outcome, symbol: int) -> Trial:
        """What a journal keeps of it: the symbols in its first place, and what became of it."""
        known = self.cluster()
        first = int(self.rows[0])
        shown = {"pair": 2, "motif": self.motif.length if self.motif is not None else 1}
        symbols = string.symbol[first : first + shown.get(self.kind, 1)]
        return Trial(
            self.kind,
            tuple(symbols.tolist()),
            known.places,
            known.length,
            self.gain,
            self.multiplier,
            terms,
            outcome,
            symbol,
        )
