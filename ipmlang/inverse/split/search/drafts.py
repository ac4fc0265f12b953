"""Drafts: a scheme while it is being looked for, as one table of placed symbols.

A row says in which body (0 the axiom, r the r-th rule) which symbol stands in which frame. A motif
that is found becomes one more body, and its occurrences become rows. Nothing here searches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    around,
    compose,
    join,
    linear,
    moved_to,
    spread,
)
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.search.figures import Figure, of_class, simplest


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """error: units, how far a placement may be off; small: units that are printed as nothing."""

    error: float
    small: float


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """n rows of placed symbols.

    classes: how many figures are classes of parts; the others are rules, figure classes + r - 1
    that of body r. body, symbol (n,), frames: the table, in the coordinates of each body.
    """

    figures: tuple[Figure, ...]
    classes: int
    body: Integers
    symbol: Integers
    frames: Frames

    @property
    def bodies(self) -> int:
        """How many bodies there are, the axiom among them."""
        return len(self.figures) - self.classes + 1

    def __len__(self) -> int:
        return len(self.body)


@dataclass(frozen=True, slots=True, eq=False)
class Motif:
    """A group of rows that stands k times: rows (k, m), column by column the same symbol; places
    (k,) frames that lay the body over each occurrence; inside (m,) frames of the body.
    """

    rows: Integers
    places: Frames
    inside: Frames


def first_draft(parts: Parts, origin: Floats, limits: Limits) -> Draft:
    """Every part by itself in the axiom, in coordinates that begin at `origin`."""
    figures = tuple(of_class(part) for part in parts.classes)
    frames = compose(moved_to(-origin[None]), parts.frames)
    symbol = np.asarray(parts.shape, np.int64)
    rows = [np.nonzero(symbol == index)[0] for index in range(len(figures))]
    chosen = [
        simplest(shape, frames[own], limits.small) for shape, own in zip(figures, rows, strict=True)
    ]
    order = np.argsort(np.concatenate([*rows, np.zeros(0, np.int64)]).astype(np.int64))
    body = np.zeros(len(symbol), np.int64)
    return Draft(figures, len(figures), body, symbol, join(chosen)[order])


def boxes(draft: Draft) -> tuple[Floats, Floats]:
    """(n, 3) low and high corners of every row's box in its body."""
    low = np.stack([shape.low for shape in draft.figures])[draft.symbol]
    high = np.stack([shape.high for shape in draft.figures])[draft.symbol]
    return around(draft.frames, low, high)


def with_motif(draft: Draft, motif: Motif, shape: Figure) -> Draft:
    """The draft in which a motif's occurrences are uses of one more rule; shape: its figure."""
    body, symbol = draft.bodies, len(draft.figures)
    kept = np.ones(len(draft), np.bool_)
    kept[motif.rows.ravel()] = False
    count, size = motif.rows.shape
    return Draft(
        (*draft.figures, shape),
        draft.classes,
        np.concatenate([draft.body[kept], np.full(size, body), draft.body[motif.rows[:, 0]]]),
        np.concatenate([draft.symbol[kept], draft.symbol[motif.rows[0]], np.full(count, symbol)]),
        join([draft.frames[kept], motif.inside, motif.places]),
    )


def motif_box(draft: Draft, motif: Motif) -> tuple[Floats, Floats]:
    """The corners of the box around a motif's body, in the body's coordinates."""
    own = Draft(
        draft.figures,
        draft.classes,
        np.zeros(len(motif.inside), np.int64),
        draft.symbol[motif.rows[0]],
        motif.inside,
    )
    low, high = boxes(own)
    return low.min(axis=0), high.max(axis=0)


def points(draft: Draft) -> Floats:
    """(n, 4, 3) the probes of every row in its body."""
    probes = np.stack([shape.probes for shape in draft.figures])[draft.symbol]
    placed = np.einsum("nij,nkj->nki", linear(draft.frames), probes)
    return np.asarray(placed + draft.frames.position[:, None])


def centered(shape: Figure, frames: Frames) -> Floats:
    """(n, 3) where the centers stand."""
    return np.asarray(spread(frames, shape.center[None])[:, 0])
