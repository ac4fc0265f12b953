"""Transformation spaces (section 4.3 of the paper), sparse: one point for each pair of neighbours.

Takes an arrangement; gives, for every two symbols that follow each other in paint order, the
transformation from the first to the second, made unique under the symmetries of both. Only
neighbours in paint order can be derived next to each other, so all other pairs are left out:
n points, not n². Nothing here decides which points become rules.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import (
    Floats,
    Frames,
    compose,
    frames,
    identity,
    inverse,
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
        rim = np.array([max(each.radius, alphabet.tolerance) for each in alphabet.definitions])
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
        radius = np.array([max(each.radius, alphabet.tolerance) for each in alphabet.definitions])
        first, second = arrangement.symbol[self.first], arrangement.symbol[self.first + 1]
        far = np.abs(self.step.position) + radius[second] * self.step.scale
        return np.asarray(1 + np.minimum(far / radius[first], MOST_LEVERAGE))


def pair_spaces(alphabet: Alphabet, arrangement: Arrangement) -> Pairs:
    """The points of all spaces that hold at least two."""
    symbol, wrap = arrangement.symbol, arrangement.wrap
    first = np.flatnonzero(wrap[1:] == wrap[:-1])
    key = symbol[first] * len(alphabet) + symbol[first + 1]
    _, spaces, often = np.unique(key, return_inverse=True, return_counts=True)
    shared = often[spaces] > 1
    first, spaces = first[shared], spaces[shared]
    placed = arrangement.placed
    step = compose(inverse(placed[first]), placed[first + 1])
    lead = placed[first]
    step, lead = _canonical(alphabet, symbol[first], symbol[first + 1], step, lead)
    return Pairs(first, step, lead, spaces.astype(np.int64))


def _canonical(
    alphabet: Alphabet, left: Integers, right: Integers, step: Frames, lead: Frames
) -> tuple[Frames, Frames]:
    """Steps and leads made unique; pairs with equally large symmetry groups are done together."""
    sizes = np.array([len(each.stabiliser) for each in alphabet.definitions], np.int64)
    free = np.array([each.free for each in alphabet.definitions], np.bool_)
    kinds = np.stack([sizes[left], sizes[right], free[left], free[right]], axis=1)
    for kind in np.unique(kinds, axis=0):
        rows = np.flatnonzero((kinds == kind).all(axis=1))
        for part in np.array_split(rows, 1 + len(rows) * int(kind[0] * kind[1]) // 500_000):
            groups = _stabilisers(alphabet, left[part]), _stabilisers(alphabet, right[part])
            made = _unique(step[part], lead[part], groups, bool(kind[2]), bool(kind[3]))
            step, lead = replaced(step, part, made[0]), replaced(lead, part, made[1])
    return step, lead


def _stabilisers(alphabet: Alphabet, symbols: Integers) -> Frames:
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
