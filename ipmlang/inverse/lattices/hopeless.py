"""Which seeds of what bends lead nowhere, many of them at once: most do, and one by one that takes
longer than to grow the others.

Takes seeds, each a few points with their indices; says of each kind whether no chain comes of it,
because it cannot be so, the members are too far off, or it finds no other member and has too few.
All bounds are wider than those of `chains` by more than the arithmetic of many differs from that of
one. Nothing here grows.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.lattices.chains import (
    EARLY,
    GAP,
    HOLES,
    LATE,
    LEAST_EXACT,
    TAIL,
    Mask,
)
from ipmlang.inverse.lattices.cloud import Cloud, Integers
from ipmlang.inverse.lattices.models import (
    ENOUGH,
    NOTHING,
    ROUNDS,
    STILL,
    TURN,
    Kind,
    Model,
    at,
    slopes,
    turning,
)
from ipmlang.inverse.lsystem.frames import Complexes, Floats

WIDER = 1.01  # times the bounds
FEWEST = 3  # members that a chain is trimmed to


def hopeless(
    known: Cloud, used: Mask, share: float, rows: Integers, kinds: tuple[Kind, ...]
) -> Mask:
    """(s, k) whether nothing of each kind (k,) grows from seeds (s, 7): rows by index, -1 for none;
    used: (n,) points that others have; share: as for `grow`.
    """
    made = np.zeros((len(rows), len(kinds)), np.bool_)
    for column, kind in enumerate(kinds):
        seeds = _Seeds(known, kind, rows)
        none = seeds.still | seeds.far
        left = np.flatnonzero(~none & seeds.weak(share))
        none[left] = seeds.alone(used, share, left)
        made[:, column] = none
    return made


class _Seeds:
    """Seeds fitted as one kind. there: (s, 7) which members they have; still: (s,) which turn about
    nothing; numbers: (k, s, 1) of the models; off: (s, 7) how far off members are; step: (s, 15)
    units to the nearer neighbour, at the indices `around`.
    """

    def __init__(self, known: Cloud, kind: Kind, rows: Integers) -> None:
        self.known, self.kind, self.rows = known, kind, rows
        self.there = rows >= 0
        self.index = np.arange(rows.shape[1])
        self.around = np.arange(-GAP - 1, rows.shape[1] + GAP + 1)
        places = np.where(self.there, known.at[rows], 0)
        fitted = _parabolas if kind == "parabola" else _turned
        with np.errstate(all="ignore"):  # what has no value is not hopeless
            numbers, self.still = fitted(kind, places, self.there)
            self.model = Model(kind, numbers[:, :, None])
            self.off = np.where(self.there, np.abs(places - at(self.model, self.index)), 0.0)
            wide = at(self.model, np.arange(self.around[0] - 1, self.around[-1] + 2))
            steps = np.abs(np.diff(wide, axis=1))
        self.step = np.minimum(steps[:, 1:], steps[:, :-1])
        self.fine = np.isfinite(numbers).all(axis=0)

    def _allowed(self, share: float, members: bool) -> Floats:
        """(s, i) units that members may be off, or what is found around them."""
        step = self.step[:, self.index - self.around[0]] if members else self.step
        if self.kind == "log":
            step = np.where(self.there, step, 0.0) if members else step
            step = np.broadcast_to(step.max(axis=1, keepdims=True), step.shape)
        return np.asarray(WIDER * np.maximum(self.known.exact, share * step))

    @property
    def far(self) -> Mask:
        """(s,) which have members that are too far off."""
        allowed = LATE * self._allowed(self.known.loose, members=True)
        return np.asarray((self.off > allowed).any(axis=1) & self.fine)

    def weak(self, share: float) -> Mask:
        """(s,) which are no chain without further members."""
        allowed = self._allowed(share, members=True) * (TAIL if share else 1.0)
        members = self.there.sum(axis=1)
        few = members < LEAST_EXACT[self.kind]
        trimmed = (self.there & (self.off <= allowed)).sum(axis=1) < FEWEST
        if self.kind == "ring":  # with a step that goes around members are off by other amounts
            trimmed &= members < (1 - HOLES) * (self._nodes_around() - 1)
        return np.asarray((few | trimmed) & self.fine)

    def alone(self, used: Mask, share: float, left: Integers) -> Mask:
        """(l,) which of some seeds find no further member."""
        rows, around = self.rows[left], self.around
        wanted = np.ones((len(left), len(around)), np.bool_)
        wanted[:, -around[0] : -around[0] + rows.shape[1]] = rows < 0
        wanted &= self._window()[left]
        numbers = self.model.numbers[:, left]
        reach = EARLY * self._allowed(share, members=False)[left]
        hit = np.full(wanted.shape, -1)
        places = at(Model(self.kind, numbers), around)
        hit[wanted] = self.known.find(places[wanted], reach[wanted])
        own = (hit[:, :, None] == rows[:, None]).any(axis=2)
        return np.asarray(~((hit >= 0) & ~own & ~used[hit]).any(axis=1))

    def _window(self) -> Mask:
        """(s, 15) where further members are looked for: so far before and after the known ones."""
        first = self.there.argmax(axis=1)[:, None]
        last = self.rows.shape[1] - 1 - self.there[:, ::-1].argmax(axis=1)[:, None]
        near = (self.around >= first - GAP - 1) & (self.around <= last + GAP + 1)
        return np.asarray(near)

    def _nodes_around(self) -> Floats:
        """(s,) steps that go around once."""
        return np.asarray(2 * np.pi / np.maximum(np.abs(self.model.numbers[TURN, :, 0]), 1e-9))


# ---------------------------------------------------------------------------- fits


def _parabolas(kind: Kind, places: Complexes, there: Mask) -> tuple[Floats, Mask]:
    """(6, s) numbers of the parabolas through seeds (s, 7); none is still."""
    powers = np.arange(there.shape[1], dtype=np.float64)[:, None] ** np.arange(3)
    basis = powers * there[:, :, None]
    known = _solved(basis, np.stack([places.real, places.imag], axis=2))
    return known.reshape(len(there), -1).T, np.zeros(len(there), np.bool_)


def _turned(kind: Kind, places: Complexes, there: Mask) -> tuple[Floats, Mask]:
    """(k, s) numbers of what turns about a centre, and which seeds do not: as `start` and `fit`."""
    index = np.arange(there.shape[1])
    step, ahead = np.diff(places, axis=1), there[:, 1:] & there[:, :-1]
    twice = ahead[:, 1:] & ahead[:, :-1]
    ratio = np.where(twice, step[:, 1:] / step[:, :-1], 1.0)
    often = twice.sum(axis=1)
    grown = np.log(np.abs(ratio)).sum(axis=1) / often
    growth = np.zeros(len(there)) if kind == "ring" else grown
    turn = np.angle(np.where(twice, ratio, 0.0).sum(axis=1))
    similar = np.exp(growth + 1j * turn)
    powers = similar[:, None] ** index
    arms = np.where(ahead, step / (powers[:, :-1] * (similar - 1)[:, None]), 0.0)
    arm = arms.sum(axis=1) / ahead.sum(axis=1)
    middle = np.where(there, places - arm[:, None] * powers, 0.0).sum(axis=1) / there.sum(axis=1)
    size = np.abs(arm)
    radial = {"ring": [size], "log": [size, growth], "archimedes": [size, size * growth]}[kind]
    first = np.stack([middle.real, middle.imag, np.angle(arm), turn, *radial])
    still = np.abs(similar - 1) < STILL / WIDER
    return _nearest(kind, first, places, there), still


def _nearest(kind: Kind, first: Floats, places: Complexes, there: Mask) -> Floats:
    """(k, s) numbers that come nearest to members (s, 7), from where they are."""
    best, i = first, np.arange(there.shape[1], dtype=np.float64)
    left = np.full(len(there), np.inf)
    waiting = np.flatnonzero(np.isfinite(first).all(axis=0))
    tried = first[:, waiting]
    for _ in range(ROUNDS + 1):
        turned = turning(Model(kind, tried[:, :, None]), i)
        apart = np.where(there[waiting], places[waiting] - turned.places, 0.0)
        rest = (np.abs(apart) ** 2).sum(axis=1)
        less = rest < left[waiting]
        best[:, waiting[less]] = tried[:, less]
        more = less & (rest <= ENOUGH * left[waiting])
        left[waiting[less]] = rest[less]
        waiting = waiting[more]
        slope = slopes(turned, i)[more] * there[waiting][:, :, None]
        both = np.concatenate([slope.real, slope.imag], axis=1)
        wanted = np.concatenate([apart[more].real, apart[more].imag], axis=1)
        if not len(waiting):
            break
        tried = tried[:, more] + _solved(both, wanted[:, :, None])[:, :, 0].T
    return best


def _solved(basis: Floats, wanted: Floats) -> Floats:
    """(s, k, w) least squares of s systems (s, m, k) and (s, m, w), columns made equally large."""
    size = np.sqrt((basis**2).sum(axis=1, keepdims=True))
    size[size == 0] = 1.0
    scaled = basis / size
    lost = ~np.isfinite(scaled).all(axis=(1, 2))
    scaled[lost] = 0.0
    left, value, right = np.linalg.svd(scaled, full_matrices=False)
    with np.errstate(divide="ignore"):
        back = np.where(value > NOTHING * value[:, :1], 1 / value, 0.0)
    found = right.swapaxes(1, 2) @ (back[:, :, None] * (left.swapaxes(1, 2) @ wanted))
    found[lost] = np.nan
    return np.asarray(found / size.swapaxes(1, 2))
