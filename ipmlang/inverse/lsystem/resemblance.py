"""Classes whose curves are similar enough made one: the threshold of the 2010 paper, section 4.1.

In come classes and a similarity, out go fewer classes, each shown by the one with most members.
Shapes are compared only where the distances of their points from their centres, in order of size,
and how much they turn are about the same. `similarity` measures how similar two curves are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.inverse.distance import Locus
from ipmlang.inverse.lsystem.curvature import sample
from ipmlang.inverse.lsystem.curves import Integers, stack
from ipmlang.inverse.lsystem.elements import Found
from ipmlang.inverse.lsystem.merging import (
    NEAREST,
    Fits,
    deviation,
    matched,
    merged,
    symmetries,
)
from ipmlang.inverse.lsystem.similarity import APART, BENT, bent

SLACK = 0.05  # radii, what sampling may change of a profile


def merge_similar(found: Sequence[Found], similarity: float) -> list[Found]:
    """Classes whose curves are at least so similar (0 to 1) made one."""
    return merged(found, lambda shapes: _Similar(shapes, similarity))


class _Similar:
    """Shapes of which some are similar."""

    def __init__(self, shapes: list[Found], similarity: float) -> None:
        from scipy.spatial import cKDTree

        self.similarity, self.directed = similarity, shapes[0].directed
        outlines = [each.outline for each in shapes]
        self.loci = [Locus((each.kind, stack([each]).points)) for each in outlines]
        self.samples = sample(outlines)
        keys = [(-len(each.members), -symmetries(each), row) for row, each in enumerate(shapes)]
        self.order = [row for _, _, row in sorted(keys)]
        distances = np.sort(np.abs(self.samples.points), axis=1)[:, 4::8]
        bends = np.abs(bent(self.samples.turn)).mean(axis=1) * (APART / BENT)
        self.profile = np.column_stack([distances, bends])
        self.room = SLACK + APART * float(np.sqrt(1 - similarity))
        self.tree = cKDTree(self.profile)
        count = min(NEAREST + 1, len(shapes))
        _, known = self.tree.query(self.profile, count, distance_upper_bound=self.room, p=np.inf)
        self.known = np.asarray(known).reshape(len(shapes), count)

    def near(self, lead: int) -> Integers:
        """Shapes with about the same distances from their centres."""
        rows = self.known[lead]
        rows = rows[rows < len(self.profile)]
        if len(rows) > NEAREST:
            ball = self.tree.query_ball_point(self.profile[lead], self.room, p=np.inf)
            rows = np.sort(np.array(ball, np.int64))
            away = np.abs(self.profile[rows] - self.profile[lead]).max(axis=1)
            rows = rows[np.argsort(away, kind="stable")]
        return np.asarray(rows[rows != lead])

    def fit(self, lead: int, rows: Integers) -> Fits:
        """Those above the threshold, with their largest distances."""
        found, placed = matched(self.samples, lead, rows, self.directed, self.similarity)
        good = np.flatnonzero(found >= self.similarity)
        error = [
            deviation(placed[row], self.loci[lead], self.loci[rows[row]]) for row in good.tolist()
        ]
        return Fits(rows[good], placed[good], np.array(error))
