"""Rings about one centre as one lattice, and spirals of the sunflower kind from the middle out.

Takes rings found one by one and joins those whose radius grows evenly; takes patches of points and
numbers them by their distance from the middle, where neighbours are no neighbours in the sequence.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.inverse.lattices.chains import HOLES, Chain, Mask, believable, grow
from ipmlang.inverse.lattices.cloud import Cloud, Integers
from ipmlang.inverse.lattices.models import TURN, Model, at, centre, fit
from ipmlang.inverse.lsystem.frames import Complexes, Floats

LEAST = 3  # rings that make a lattice
INNER = 12  # members of a sunflower that it begins with
PATCH = 12  # points that can be a sunflower
COHERENT = 0.9  # how alike the steps of its angle are
SHELLS = (1.0, 0.5, 0.25, 0.12)  # shares of a patch whose middle may be the centre
PATCHES = 20
WIDE = 1.7  # times the usual distance of neighbours that joins two points in a patch


@dataclass(frozen=True, slots=True, eq=False)
class Rings:
    """Node (i, j) is centre + (radius + growth j) exp(i (phase + step i + twist j)), radians.

    closed: members all around; index: (m, 2) from 0; rows: (m,) points; reach: units, the largest
    residual.
    """

    centre: complex
    radius: float
    growth: float
    phase: float
    step: float
    twist: float
    closed: int
    index: Integers
    rows: Integers
    reach: float

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def nodes(self) -> int:
        """Members and holes."""
        around = self.closed or int(self.index[:, 0].max()) + 1
        return around * (int(self.index[:, 1].max()) + 1)


def rings_at(rings: Rings, index: Integers) -> Complexes:
    """(m,) places of nodes (m, 2)."""
    i, j = index.T
    turn = rings.phase + rings.step * i + rings.twist * j
    return np.asarray(rings.centre + (rings.radius + rings.growth * j) * np.exp(1j * turn))


def join_rings(known: Cloud, chains: list[Chain]) -> list[Rings]:
    """Sets of full rings about one centre, as many around each, with evenly growing radius."""
    full = [each for each in chains if each.model.closed]
    made: list[Rings] = []
    taken: set[int] = set()
    for first, chain in enumerate(full):
        if first in taken:
            continue
        slack = max(known.exact, known.loose * float(_chord(chain)))
        same = [
            k
            for k, each in enumerate(full)
            if k not in taken
            and each.model.closed == chain.model.closed
            and abs(centre(each.model) - centre(chain.model)) <= slack
        ]
        rings = _joined(known, [full[k] for k in same]) if len(same) >= LEAST else None
        if rings is not None:
            taken |= set(same)
            made.append(rings)
    return made


def _chord(chain: Chain) -> float:
    return float(abs(2 * float(chain.model.numbers[4]) * np.sin(chain.model.numbers[TURN] / 2)))


def _joined(known: Cloud, chains: list[Chain]) -> Rings | None:
    """One lattice of rings, if radius and phase go evenly."""
    chains = sorted(chains, key=lambda each: float(each.model.numbers[4]))
    radius = np.array([float(each.model.numbers[4]) for each in chains])
    step = 2 * np.pi / chains[0].model.closed
    number = _numbered(radius, known)
    if number is None:
        return None
    phase = np.array([float(each.model.numbers[2]) for each in chains])
    turns = phase / step
    twist = _usual(np.diff(turns) / np.diff(number))
    shift = np.round(turns - turns[0] - twist * number)
    index, rows = [], []
    for chain, ring, by in zip(chains, number.tolist(), shift.tolist(), strict=True):
        forward = 1 if chain.model.numbers[TURN] > 0 else -1
        around = (forward * chain.index + int(by)) % chain.model.closed
        index.append(np.stack([around, np.full(len(chain), ring)], axis=1))
        rows.append(chain.rows)
    growth = (radius[-1] - radius[0]) / number[-1]
    middle = complex(np.mean([centre(each.model) for each in chains]))
    every = np.concatenate(index)
    guess = Rings(
        middle,
        radius[0],
        growth,
        phase[0],
        step,
        twist * step,
        chains[0].model.closed,
        every,
        np.concatenate(rows),
        0.0,
    )
    return _fitted(known, guess)


def _numbered(radius: Floats, known: Cloud) -> Integers | None:
    """Numbers of rising radii that go evenly, few left out; None if they do not."""
    step = float(np.median(np.diff(radius)))
    number: Integers = np.round((radius - radius[0]) / step).astype(np.int64)
    if (np.diff(number) < 1).any() or len(number) < (1 - HOLES) * (number[-1] + 1):
        return None
    line = np.polynomial.Polynomial.fit(number, radius, 1)
    if np.abs(radius - line(number)).max() > max(known.exact, known.loose * step):
        return None
    return number


def _usual(turns: Floats) -> float:
    """The middle of numbers known up to whole ones."""
    mean = float(np.angle(np.exp(2j * np.pi * turns).sum()) / (2 * np.pi))
    rest = turns - mean
    return mean + float(np.median(rest - np.round(rest)))


def _fitted(known: Cloud, guess: Rings) -> Rings | None:
    """Least squares of everything but the step, which divides the full turn."""
    i, j = guess.index.T.astype(np.float64)
    places = known.at[guess.rows]
    for _ in range(6):
        off = places - rings_at(guess, guess.index)
        ahead = np.exp(1j * (guess.phase + guess.step * i + guess.twist * j))
        radius = guess.radius + guess.growth * j
        ones = np.ones(len(i))
        aside = 1j * radius * ahead
        slopes = np.stack([ones, 1j * ones, ahead, ahead * j, aside, aside * j], axis=1)
        change = np.linalg.lstsq(
            np.concatenate([slopes.real, slopes.imag]),
            np.concatenate([off.real, off.imag]),
            rcond=None,
        )[0]
        guess = replace(
            guess,
            centre=guess.centre + complex(change[0], change[1]),
            radius=guess.radius + float(change[2]),
            growth=guess.growth + float(change[3]),
            phase=guess.phase + float(change[4]),
            twist=guess.twist + float(change[5]),
        )
    off = np.abs(places - rings_at(guess, guess.index))
    chord = 2 * (guess.radius + guess.growth * j) * abs(np.sin(guess.step / 2))
    if (off > np.maximum(known.exact, 1.3 * known.loose * chord)).any():
        return None
    return replace(guess, reach=float(off.max()))


# ------------------------------------------------------------------------ sunflowers


def find_sunflowers(known: Cloud, used: Mask) -> list[Chain]:
    """Spirals with radius k sqrt(i + i0) and a constant turn, of points not `used` (n,)."""
    found: list[Chain] = []
    for patch in _patches(known, used):
        sure = []
        for first, index, rows in _middles(known, patch):
            for share in known.shares:
                chain = grow(known, first, index, rows, used, share)
                if chain is not None and believable(known, chain, 100.0):
                    sure.append(chain)
        if sure:
            best = max(sure, key=len)
            used[best.rows] = True
            found.append(best)
    return found


def _patches(known: Cloud, used: Mask) -> list[Integers]:
    """Points not used that neighbours join, largest patches first."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count, often = len(known), min(6, known.near.shape[1])
    apart = np.abs(known.at[known.near[:, :often]] - known.at[:, None])
    free = ~used
    if free.sum() < PATCH:
        return []
    room = WIDE * np.median(apart[free, 0])
    here = np.repeat(np.arange(count), often)
    there = known.near[:, :often].ravel()
    joined = (apart.ravel() <= room) & free[here] & free[there]
    ends = (here[joined], there[joined])
    graph = coo_array((np.ones(int(joined.sum())), ends), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    size = np.bincount(label[free], minlength=int(label.max()) + 1)
    largest = np.argsort(-size, kind="stable")[:PATCHES]
    return [np.flatnonzero((label == k) & free) for k in largest.tolist() if size[k] >= PATCH]


def _middles(known: Cloud, patch: Integers) -> Iterator[tuple[Model, Integers, Integers]]:
    """First guesses with the members they come from."""
    places = known.at[patch]
    middle = complex(places.mean())
    for share in SHELLS:
        order = np.argsort(np.abs(places - middle), kind="stable")
        inner = order[: max(PATCH, round(share * len(order)))]
        middle = complex(places[inner].mean())
        for skip in (0, 1):
            nearest = np.argsort(np.abs(places - middle), kind="stable")[skip : skip + INNER]
            model = _sunflower(places[nearest], middle)
            if model is not None:
                yield model, np.arange(len(nearest)), patch[nearest]


def _sunflower(places: Complexes, middle: complex) -> Model | None:
    """The spiral through places that go outwards in this order about a rough centre."""
    arms = places - middle
    turns = arms[1:] * arms[:-1].conj()
    turns = turns / np.maximum(np.abs(turns), 1e-300)
    usual = complex(turns[1:].mean())
    if abs(usual) < COHERENT:
        return None
    index = np.arange(len(places))
    slope, offset = np.polynomial.Polynomial.fit(index, np.abs(arms) ** 2, 1).convert().coef[::-1]
    if slope <= 0:
        return None
    step = float(np.angle(usual))
    phase = float(np.angle((arms * np.exp(-1j * step * index)).sum()))
    numbers = [middle.real, middle.imag, phase, step, np.sqrt(slope), max(offset / slope, 0.0)]
    model = fit(Model("vogel", np.array(numbers)), index, places)
    off = np.abs(places - at(model, index)).max()
    return model if off <= 0.2 * abs(model.numbers[4]) and model.numbers[5] > -0.5 else None


def ring_order(rank: Integers, index: Integers, around: int) -> tuple[int, bool]:
    """With which index a full ring begins if painted in order, and whether it goes back."""
    first = int(index[int(np.argmin(rank))])
    back = (first - index) % around
    ahead = (index - first) % around
    return first, _falls(rank, ahead) > _falls(rank, back)


def wound(rings: Rings, rank: Integers, inwards: bool) -> Rings:
    """The same nodes so numbered that each ring begins with its first member painted, if that
    shifts evenly from ring to ring; inwards: from the outermost ring.
    """
    i, j = rings.index.T
    last = int(j.max())
    if inwards:
        j = last - j
        rings = replace(
            rings,
            radius=rings.radius + last * rings.growth,
            growth=-rings.growth,
            phase=rings.phase + last * rings.twist,
            twist=-rings.twist,
        )
    first, shift = _first_painted(rank, i, j, rings.closed)
    i = (i - first - shift * j) % rings.closed
    ring = j == 0
    back = -i % rings.closed
    turns_back = _falls(rank[ring], i[ring]) > _falls(rank[ring], back[ring])
    return replace(
        rings,
        phase=rings.phase + first * rings.step,
        twist=rings.twist + shift * rings.step,
        step=-rings.step if turns_back else rings.step,
        index=np.stack([back if turns_back else i, j], axis=1),
    )


def _first_painted(rank: Integers, i: Integers, j: Integers, around: int) -> tuple[int, int]:
    """Where the first ring begins, and by how much the next ring's begin is shifted."""
    begins = []
    for ring in np.unique(j)[:2].tolist():
        rows = np.flatnonzero(j == ring)
        begins.append((ring, int(i[rows[int(np.argmin(rank[rows]))]])))
    (one, first), (two, second) = begins
    shift = (second - first + around // 2) % around - around // 2
    return first, shift if two - one == 1 else 0


def _falls(rank: Integers, index: Integers) -> int:
    return int((np.diff(rank[np.argsort(index)]) < 0).sum())
