"""Points in the plane that are looked up by place, and how likely they line up by chance.

Takes positions; gives nearest neighbours, the point near a predicted place, the local density and
the expected number of accidental lattices (an a-contrario test as in Desolneux, Moisan and Morel).
Nothing here knows frames or kinds of lattices, and nothing compares all pairs of many points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import lgamma, log, log10, pi

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Complexes, Floats

Integers = NDArray[np.int64]

NEIGHBOURS = 12
EVERY = 60  # points up to which all pairs are neighbours
COARSE, FINE = 0.05, 0.001  # of the distance of neighbours, in the plane and on a line: coarser
# rounding looks like design, not like chance
SELDOM = -2.0  # log10 of the accidental lattices that one may expect where one is found


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Distinct points.

    at: (n,) x + iy; near: (n, k) nearest others, nearest first; density: (n,) points around each
    per unit of area (of length if `straight`: all on one line); grain: units between the places
    that the coordinates can have, 0 if they are not rounded; exact: units within which a place is
    hit; loose: share of the local step that noise may be; find: for places of any shape and reaches
    the nearest point within reach, -1 for none.
    """

    at: Complexes
    near: Integers
    density: Floats
    straight: bool
    grain: float
    exact: float
    loose: float
    find: Callable[[Complexes, Floats | float], Integers]

    @property
    def shares(self) -> tuple[float, ...]:
        """Shares of the step that what is looked for may be off, exact places first."""
        return (0.0, self.loose) if self.loose else (0.0,)

    def __len__(self) -> int:
        return len(self.at)


def cloud(at: Complexes, exact: float, loose: float, straight: bool = False) -> Cloud:
    """The cloud of distinct points (n,), n at least 2; straight: known to be on one line."""
    from scipy.spatial import cKDTree

    count = len(at)
    straight = straight or _on_a_line(at)
    tree = cKDTree(np.stack([at.real, at.imag], axis=1))
    often = count - 1 if count <= EVERY else min(NEIGHBOURS, count - 1)
    nearest = tree.query(np.stack([at.real, at.imag], axis=1), k=often + 1)
    apart, near = np.asarray(nearest[0], np.float64), np.asarray(nearest[1], np.int64)
    few = min(often, NEIGHBOURS)
    room = np.maximum(apart[:, few], exact)
    density = few / (2 * room if straight else pi * room**2)

    def find(places: Complexes, reach: Floats | float) -> Integers:
        wanted = np.ascontiguousarray(places).reshape(-1, 1).view(np.float64)
        if not np.isfinite(wanted).all():
            wanted = np.where(np.isfinite(wanted).all(axis=1, keepdims=True), wanted, 1e300)
        reaches = np.broadcast_to(np.asarray(reach, np.float64), places.shape).ravel()
        bound = float(reaches.max(initial=0.0)) * (1 + 1e-9) + 1e-300
        away, row = tree.query(wanted, k=1, distance_upper_bound=bound)
        return np.where(away <= reaches, row, -1).astype(np.int64).reshape(places.shape)

    others = near[:, 1:].copy()
    coarse = (FINE if straight else COARSE) * float(np.median(apart[:, 1]))
    grain = min(_grain(at, exact), coarse)
    return Cloud(at, others, density, straight, grain, exact, loose, find)


def _on_a_line(at: Complexes) -> bool:
    """Whether the points are on one line, give or take a hundredth of what they span."""
    from_middle = at - at.mean()
    along = np.sqrt((from_middle**2).mean())  # its direction is that of the longest spread
    if along == 0:
        return False
    turned = from_middle * np.abs(along) / along
    return bool(np.ptp(turned.imag) <= 0.01 * np.ptp(turned.real))


def _grain(at: Complexes, exact: float) -> float:
    """The coarsest power of ten that nearly all differences of coordinates are multiples of."""
    apart = at - at[0]
    both = np.concatenate([apart.real, apart.imag])
    for digits in range(-2, 7):
        unit = 10.0**-digits
        if unit <= 8 * exact:
            return 0.0
        if np.mean(np.abs(both - unit * np.round(both / unit)) <= 2 * exact) >= 0.9:
            return unit
    return 0.0


def likely(
    known: Cloud, tests: float, rows: Integers, nodes: int, fixed: float, reach: float
) -> float:
    """log10 of how many lattices this good chance makes among so many tests.

    rows: (m,) members; nodes: members and holes; fixed: how many members the parameters took;
    reach: units, the largest residual.
    """
    reach = max(reach, known.exact, 0.57 * known.grain)
    density = float(np.median(known.density[rows]))
    hit = density * (2 * reach if known.straight else pi * reach**2)
    ways = (lgamma(nodes + 1) - lgamma(len(rows) + 1) - lgamma(nodes - len(rows) + 1)) / log(10)
    return log10(max(tests, 1.0)) + ways + (len(rows) - fixed) * log10(min(max(hit, 1e-30), 0.5))
