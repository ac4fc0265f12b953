"""Transformation spaces (section 4.3 of the paper), sparse: one point for each pair of neighbours.

Takes an arrangement; gives, for every two symbols that follow each other in paint order, the
transformation from the first to the second, made unique under the symmetries of both. Only
neighbours in paint order can be derived next to each other, so all other pairs are left out:
n points, not n². Nothing here decides which points become rules.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import (
    Floats,
    Frames,
    compose,
    frames,
    identity,
    inverse,
    join,
    replaced,
)
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers

# A generic direction in the space of transformations: the largest component along it picks one of
# several equivalent transformations without comparing floats column by column.
GENERIC = (0.7390851332, 0.5671432904, 0.3183098862, 0.4142135624, 0.2718281828)
MOST_LEVERAGE = 100.0  # beyond this a step says nothing


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """m points. first: (m,) rows of the first of each pair; step: (m,) frame of the second in the
    frame of the first; lead: (m,) world frame of the first, which of its equivalent ones makes the
    step canonical; spaces: (m,) equal for pairs of the same two symbols.
    """

    first: Integers
    step: Frames
    lead: Frames
    spaces: Integers

    def values(self, alphabet: Alphabet, arrangement: Arrangement) -> tuple[Floats, Floats]:
        """(m, 5) coordinates in which equal steps are close, and (m, 5) the slack of each.

        The four of the paper (α, d, s, β), as two vectors so that no angle wraps around: where the
        second symbol stands, and where its rim is; and its handedness.
        """
        rim = np.maximum(alphabet.radii, alphabet.tolerance)
        arm = self.step.factor * rim[arrangement.symbol[self.first + 1]]
        at = self.step.position
        values = np.stack([self.step.handedness, at.real, at.imag, arm.real, arm.imag], axis=1)
        slack = np.repeat((alphabet.tolerance / self.lead.scale)[:, None], 5, axis=1)
        slack[:, 0] = 0.5
        return values, slack

    def leverage(self, alphabet: Alphabet, arrangement: Arrangement) -> Floats:
        """(m,) how many times a rounding of the first symbol is seen where the second one is: a
        short line tells its direction badly.
        """
        radius = np.maximum(alphabet.radii, alphabet.tolerance)
        first, second = arrangement.symbol[self.first], arrangement.symbol[self.first + 1]
        far = np.abs(self.step.position) + radius[second] * self.step.scale
        return np.asarray(1 + np.minimum(far / radius[first], MOST_LEVERAGE))


@dataclass(slots=True, eq=False)
class Steps:
    """Remembers what was made unique: most neighbours of one round of a search are there in the
    next one. key: (k,) rising, of the first element and both symbols; step, lead: as of pairs.
    """

    key: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    step: Frames = field(default_factory=lambda: identity(0))
    lead: Frames = field(default_factory=lambda: identity(0))


def pair_spaces(alphabet: Alphabet, arrangement: Arrangement, known: Steps | None = None) -> Pairs:
    """The points of all spaces that hold at least two; known: those of earlier rounds of one
    search, which become those of this one.
    """
    symbol, wrap = arrangement.symbol, arrangement.wrap
    first = np.flatnonzero(wrap[1:] == wrap[:-1])
    key = symbol[first] * len(alphabet) + symbol[first + 1]
    _, spaces, often = np.unique(key, return_inverse=True, return_counts=True)
    shared = often[spaces] > 1
    first, spaces = first[shared], spaces[shared]
    step, lead = _remembered(alphabet, arrangement, first, Steps() if known is None else known)
    return Pairs(first, step, lead, spaces.astype(np.int64))


def _remembered(
    alphabet: Alphabet, arrangement: Arrangement, first: Integers, known: Steps
) -> tuple[Frames, Frames]:
    """Unique steps and leads of pairs; only what was not there before is computed."""
    symbol, placed = arrangement.symbol, arrangement.placed
    left, right = symbol[first], symbol[first + 1]
    # A symbol that stands at an element stands there in one frame.
    key = (arrangement.start[first] << 40) + (left << 20) + right
    at = np.searchsorted(known.key, key)
    old = np.flatnonzero(np.append(known.key, -1)[at] == key)
    new = np.setdiff1d(np.arange(len(first)), old, assume_unique=True)
    lead = placed[first[new]]
    step = compose(inverse(lead), placed[first[new] + 1])
    made = _canonical(alphabet, left[new], right[new], step, lead)
    order = np.argsort(np.concatenate([old, new]))
    step = join([known.step[at[old]], made[0]])[order]
    lead = join([known.lead[at[old]], made[1]])[order]
    rising = np.argsort(key, kind="stable")
    known.key, known.step, known.lead = key[rising], step[rising], lead[rising]
    return step, lead


def _canonical(
    alphabet: Alphabet, left: Integers, right: Integers, step: Frames, lead: Frames
) -> tuple[Frames, Frames]:
    """Steps and leads made unique; pairs with equally large symmetry groups are done together."""
    sizes, free = alphabet.keeping, alphabet.frees
    kinds = 4 * (sizes[left] * (int(sizes.max(initial=0)) + 1) + sizes[right])
    kinds += 2 * free[left] + free[right]
    for kind in np.unique(kinds).tolist():
        rows = np.flatnonzero(kinds == kind)
        one, other = int(left[rows[0]]), int(right[rows[0]])
        many = len(rows) * int(sizes[one] * sizes[other])
        for part in np.array_split(rows, 1 + many // 500_000):
            groups = stabilisers(alphabet, left[part]), stabilisers(alphabet, right[part])
            made = _unique(step[part], lead[part], groups, bool(free[one]), bool(free[other]))
            step, lead = replaced(step, part, made[0]), replaced(lead, part, made[1])
    return step, lead


def stabilisers(alphabet: Alphabet, symbols: Integers) -> Frames:
    """(m, k) frames, where all these symbols have k."""
    known, which = np.unique(symbols, return_inverse=True)
    groups = [alphabet[int(symbol)].stabiliser for symbol in known]
    table = Frames(
        np.stack([each.x for each in groups]),
        np.stack([each.y for each in groups]),
        np.stack([each.angle for each in groups]),
        np.stack([each.scale for each in groups]),
        np.stack([each.handedness for each in groups]),
    )
    return table[which.ravel()]


def _unique(
    step: Frames, lead: Frames, groups: tuple[Frames, Frames], free_left: bool, free_right: bool
) -> tuple[Frames, Frames]:
    """The step and lead of the variant that reaches furthest in the generic direction."""
    left, right = groups
    variants = compose(compose(inverse(left)[:, :, None], step[:, None, None]), right[:, None])
    leads = compose(compose(lead[:, None], left)[:, :, None], identity(1)[None, None])
    leads = _broadcast(leads, variants.x.shape)
    if free_left:
        at = variants.position
        still = np.abs(at) * leads.scale <= 1e-9 * np.max(np.abs(leads.position) + 1e-9)
        turn = np.where(still, variants.angle, np.angle(at, deg=True))
        spin = frames(np.zeros(turn.shape, np.complex128), turn)
        variants, leads = compose(inverse(spin), variants), compose(leads, spin)
    if free_right:
        variants = frames(variants.position, 0.0, variants.scale, variants.handedness)
    return _furthest(variants, leads)


def _broadcast(given: Frames, shape: tuple[int, ...]) -> Frames:
    return frames(
        np.broadcast_to(given.position, shape),
        np.broadcast_to(given.angle, shape),
        np.broadcast_to(given.scale, shape),
        np.broadcast_to(given.handedness, shape),
    )


def _furthest(variants: Frames, leads: Frames) -> tuple[Frames, Frames]:
    at, arm = variants.position, variants.factor
    reach: NDArray[np.float64] = GENERIC[0] * at.real + GENERIC[1] * at.imag
    size = np.abs(at).max(axis=(1, 2), keepdims=True) + 1.0
    reach = reach + size * (GENERIC[2] * arm.real + GENERIC[3] * arm.imag)
    reach = reach + 8 * size * variants.scale * variants.handedness
    count = len(variants.x)
    best = np.argmax(reach.reshape(count, -1), axis=1)
    rows = np.arange(count)
    flat = (variants.x.shape[0], -1)
    return _reshaped(variants, flat)[rows, best], _reshaped(leads, flat)[rows, best]


def _reshaped(given: Frames, shape: tuple[int, int]) -> Frames:
    return Frames(
        given.x.reshape(shape),
        given.y.reshape(shape),
        given.angle.reshape(shape),
        given.scale.reshape(shape),
        given.handedness.reshape(shape),
    )
