"""Figures: what the search needs to know of a symbol, a class of parts or a rule alike.

A figure says where the symbol's box is, in which frames it looks the same, and by which points two
placements of it are told apart. Nothing here knows where anything stands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, compose, linear, spread
from ipmlang.inverse.parts.observation import PartClass
from ipmlang.inverse.split.cost import placement_tokens

MOST_FRAMES = 64  # of a symmetry; what is rounder than that counts as this round


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """low, high: (3,) the box in the symbol's own coordinates; center: (3,) a point that its
    symmetry leaves alone; symmetry: (s,) frames that map it onto itself, identity first, proper
    ones before mirrored ones; images: (s, 4, 3) a frame of probe points, as large as the symbol,
    under each of these.
    """

    low: Floats
    high: Floats
    center: Floats
    symmetry: Frames
    images: Floats

    @property
    def probes(self) -> Floats:
        """(4, 3) the center and a point out from it along each axis."""
        return np.asarray(self.images[0])

    @property
    def reach(self) -> float:
        """How far its box reaches from its middle, at least."""
        return float(np.linalg.norm(self.high - self.low)) / 2


def figure(low: Floats, high: Floats, symmetry: Frames) -> Figure:
    """The figure of a symbol with this box and symmetry (identity first)."""
    order = np.argsort(symmetry.hand < 0, kind="stable")[:MOST_FRAMES]
    kept = symmetry[order]
    center = spread(symmetry, ((low + high) / 2)[None]).mean(axis=(0, 1))
    reach = max(float(np.linalg.norm(high - low)) / 2, 1e-9)
    probes = center + np.concatenate([np.zeros((1, 3)), reach * np.eye(3)])
    return Figure(low, high, center, kept, spread(kept, probes))


def of_class(part: PartClass) -> Figure:
    """The figure of a class of parts."""
    return figure(np.zeros(3), np.asarray(part.size, np.float64), part.symmetry)


def alternatives(shape: Figure, frames: Frames) -> Frames:
    """(n * s,) every frame under every symmetry, the symmetries of the first frame first."""
    count, many = len(frames), len(shape.symmetry)
    outer = np.repeat(np.arange(count), many)
    return compose(frames[outer], shape.symmetry[np.tile(np.arange(many), count)])


def simplest(shape: Figure, frames: Frames, small: float) -> Frames:
    """The same placements in frames that take the fewest tokens, and turn least among those."""
    many = len(shape.symmetry)
    if many == 1 or len(frames) == 0:
        return frames
    every = alternatives(shape, frames)
    turn = np.round(1 - every.rotation[:, 0], 6)
    effort = placement_tokens(every, small) + 0.25 * turn + 0.01 * (every.hand < 0)
    best = np.argmin(effort.reshape(-1, many), axis=1)
    return every[np.arange(len(frames)) * many + best]


def probed(shape: Figure, frames: Frames) -> Floats:
    """(n, 4, 3) where the probes stand."""
    return spread(frames, shape.probes)


def misses(shape: Figure, points: Floats, frames: Frames) -> tuple[Floats, Integers]:
    """(n,) how far probes at (n, 4, 3) are from those of the frames, and by which symmetry."""
    step = max(1, 200_000 // len(shape.symmetry))
    found, which = [np.zeros(0)], [np.zeros(0, np.int64)]
    for begin in range(0, len(frames), step):
        rows = slice(begin, begin + step)
        turned = np.einsum("nij,skj->nski", linear(frames[rows]), shape.images)
        off = turned + frames.position[rows, None, None] - points[rows, None]
        error = np.sqrt((off**2).sum(axis=-1).max(axis=-1))
        which.append(np.argmin(error, axis=1))
        found.append(error.min(axis=1))
    return np.concatenate(found), np.concatenate(which)
