"""How important a cluster is: the four terms of the paper's equation 5, and what weights make of
them.

Takes the outlines of terminals, a string of symbols and the neighbours that clusters join; gives
near (h), similar (φ), long (l) and many (n) for each cluster, all from 0 to 1. One description
length ranks clusters; the terms only multiply what it says. Nothing here chooses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ipmlang.formats.drawing import Outline
from ipmlang.inverse.lsystem.curvature import Samples, sample
from ipmlang.inverse.lsystem.frames import Complexes, Floats, mirrored
from ipmlang.inverse.lsystem.similarity import match
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.options import Weights

POINTS = 24  # samples of each symbol between which distances are measured
FLOOR = 0.05  # of a term: what nothing at all counts as, so that no weight divides by 0
BATCH = 4096  # pairs that are measured at once


@dataclass(frozen=True, slots=True)
class Terms:
    """The four terms of one cluster, 0 to 1."""

    near: float
    similar: float
    long: float
    many: float

    def multiplier(self, weights: Weights) -> float:
        """What a cluster's gain in tokens is multiplied by: Π term^(weight - 1).

        The gain itself grows with n and l, so weight 1 leaves a term as the description length has
        it, 0 takes it out, and more stresses it.

        >>> Terms(0.5, 1.0, 1.0, 1.0).multiplier(Weights(near=3.0))
        0.25
        """
        terms = (self.near, self.similar, self.long, self.many)
        exponents = (weights.near, weights.similar, weights.long, weights.many)
        result = 1.0
        for term, exponent in zip(terms, exponents, strict=True):
            result *= max(term, FLOOR) ** (exponent - 1.0)
        return result

    def importance(self, weights: Weights) -> float:
        """Equation 5 itself, for clusters that save nothing: Σ weight · term.

        >>> Terms(0.5, 1.0, 0.25, 0.25).importance(Weights(near=2.0, long=0.0))
        2.25
        """
        return (
            weights.near * self.near
            + weights.similar * self.similar
            + weights.long * self.long
            + weights.many * self.many
        )


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Elements that one rule would make. first, second: (k,) rows of the neighbours that it joins,
    pair by pair; places: how many sequences there are; length: their mean length, in symbols.
    """

    first: Integers
    second: Integers
    places: int
    length: float


@dataclass(slots=True, eq=False)
class Measure:
    """Measures clusters. outlines: of each terminal, None for what has none; extent: units, the
    largest distance in the drawing.
    """

    outlines: Sequence[Outline | None]
    extent: float
    _points: Complexes = field(default_factory=lambda: np.zeros((0, POINTS), np.complex128))
    _likeness: dict[tuple[int, int], float] = field(default_factory=dict)
    _samples: Samples | None = None
    _sampled: dict[int, int] = field(default_factory=dict)

    def terms(
        self, alphabet: Alphabet, string: Arrangement, clusters: Sequence[Cluster]
    ) -> list[Terms]:
        """The terms of each cluster; n and l are shares of the largest."""
        if not clusters:
            return []
        self._learn(alphabet)
        first, second = (
            np.concatenate([getattr(each, side) for each in clusters])
            for side in ("first", "second")
        )
        near = 1.0 - np.minimum(self._gaps(string, first, second) / self.extent, 1.0)
        similar = self._similar(alphabet, string.symbol[first], string.symbol[second])
        sizes = np.array([len(each.first) for each in clusters])
        owner = np.repeat(np.arange(len(clusters)), sizes)
        means = [
            np.bincount(owner, each, len(clusters)) / np.maximum(sizes, 1)
            for each in (near, similar)
        ]
        longest = max(each.length for each in clusters)
        most = max(len(each.first) for each in clusters)
        return [
            Terms(
                float(means[0][k]),
                float(means[1][k]),
                each.length / longest,
                float(sizes[k] / most),
            )
            for k, each in enumerate(clusters)
        ]

    # ----------------------------------------------------------------------- near

    def _learn(self, alphabet: Alphabet) -> None:
        """Points along every symbol, in its own frame."""
        rows = [self._points]
        known = list(self._points)
        for symbol in range(len(known), len(alphabet)):
            known.append(self._along(alphabet, symbol, known))
            rows.append(known[-1][None])
        self._points = np.concatenate(rows)

    def _along(self, alphabet: Alphabet, symbol: int, known: Sequence[Complexes]) -> Complexes:
        definition = alphabet[symbol]
        if definition.terminal:
            outline = self.outlines[symbol] if symbol < len(self.outlines) else None
            if outline is None or not len(outline.kind):
                return np.zeros(POINTS, np.complex128)
            drawn = sample([outline])
            every = drawn.centre[0] + drawn.radius[0] * drawn.points[0]
        else:
            places = definition.places
            local = np.stack([known[part] for part in definition.parts.tolist()])
            hand = places.handedness[:, None]
            every = places.position[:, None] + places.factor[:, None] * mirrored(local, hand)
        spread = np.linspace(0, every.size - 1, POINTS).astype(np.int64)
        return np.asarray(every.ravel()[spread])

    def _gaps(self, string: Arrangement, first: Integers, second: Integers) -> Floats:
        """(k,) units between the nearest points of the symbols in two rows."""
        placed = string.placed
        local = mirrored(self._points[string.symbol], placed.handedness[:, None])
        world = placed.position[:, None] + placed.factor[:, None] * local
        found = [np.zeros(0)]
        for start in range(0, len(first), BATCH):
            one = world[first[start : start + BATCH]]
            other = world[second[start : start + BATCH]]
            found.append(np.abs(one[:, :, None] - other[:, None, :]).min(axis=(1, 2)))
        return np.concatenate(found)

    # -------------------------------------------------------------------- similar

    def _similar(self, alphabet: Alphabet, left: Integers, right: Integers) -> Floats:
        """(k,) how similar symbols are."""
        both = np.stack([np.minimum(left, right), np.maximum(left, right)], axis=1)
        pairs, which = np.unique(both, axis=0, return_inverse=True)
        values = [self._pair(alphabet, one, other) for one, other in pairs.tolist()]
        return np.array(values)[which.ravel()] if values else np.zeros(0)

    def _pair(self, alphabet: Alphabet, one: int, other: int) -> float:
        """Terminals by their curves; groups by the share of terminals that both have."""
        if one == other:
            return 1.0
        if (one, other) not in self._likeness:
            both = alphabet[one], alphabet[other]
            terminal = both[0].terminal and both[1].terminal
            self._likeness[one, other] = (
                self._alike(one, other) if terminal else _shared(both[0].leaves, both[1].leaves)
            )
        return self._likeness[one, other]

    def _alike(self, one: int, other: int) -> float:
        """The similarity of two terminals' shapes, flips included: 0 where one cannot lie on the
        other, since they have other numbers of subpaths, or of closed ones.
        """
        shapes = [
            self.outlines[each] if each < len(self.outlines) else None for each in (one, other)
        ]
        if any(shape is None or not len(shape.kind) for shape in shapes):
            return 0.0
        closed = [sorted(shape.closed.tolist()) for shape in shapes if shape is not None]
        if closed[0] != closed[1]:
            return 0.0
        samples = self._sample()
        lead, beside = self._sampled[one], np.array([self._sampled[other]])
        found = match(samples, lead, beside, directed=False)
        return float(np.clip(found.similarity[0], 0.0, 1.0))

    def _sample(self) -> Samples:
        """Samples of all outlines that have any segment."""
        if self._samples is None:
            drawn = [
                k for k, each in enumerate(self.outlines) if each is not None and len(each.kind)
            ]
            self._sampled = {terminal: row for row, terminal in enumerate(drawn)}
            every = [self.outlines[k] for k in drawn]
            self._samples = sample([each for each in every if each is not None])
        return self._samples


def _shared(one: Integers, other: Integers) -> float:
    """The share of terminals (n,) and (m,) that are in both, each as often as it comes."""
    count = int(max(one.max(), other.max())) + 1
    both = np.bincount(one, minlength=count), np.bincount(other, minlength=count)
    return float(np.minimum(*both).sum() / np.maximum(*both).sum())
