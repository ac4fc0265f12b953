"""Grids as a person would write them: which of all bases of a lattice, plain or staggered.

Takes nodes numbered in any basis; gives the basis whose box has fewest holes, the plain one before
the staggered one, with upright steps to the right and up. Nothing here looks points up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lattices.cloud import Integers
from ipmlang.inverse.lsystem.frames import Complexes, Floats

Fit: TypeAlias = tuple[complex, complex, complex]  # origin and both steps
_STEPS = [(1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2)]
_PAIRS = np.array([(*one, *two) for one in _STEPS for two in _STEPS], np.int64)
# (k, 4) both steps of a basis in those of another
BASES = _PAIRS[np.abs(_PAIRS[:, 0] * _PAIRS[:, 3] - _PAIRS[:, 1] * _PAIRS[:, 2]) == 1]


@dataclass(frozen=True, slots=True, eq=False)
class Net:
    """A grid. origin, u, v: x + iy of node (0, 0) and of both steps; stagger: how far nodes of odd
    j are moved along u, in steps, 0 or 0.5; index: (m, 2) i and j from 0, rows: (m,) points; reach:
    units, the largest residual.
    """

    origin: complex
    u: complex
    v: complex
    stagger: float
    index: Integers
    rows: Integers
    reach: float

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def shape(self) -> tuple[int, int]:
        """Columns and rows."""
        return int(self.index[:, 0].max()) + 1, int(self.index[:, 1].max()) + 1

    @property
    def nodes(self) -> int:
        """Members and holes."""
        return self.shape[0] * self.shape[1]


def net_at(net: Net, index: Integers) -> Complexes:
    """(m,) places of nodes (m, 2)."""
    i = index[:, 0] + net.stagger * (index[:, 1] % 2)
    return np.asarray(net.origin + i * net.u + index[:, 1] * net.v)


def presented(fitted: Fit, index: Integers, rows: Integers, reach: float) -> Net:
    """The grid of members with nodes (m, 2) of a fitted lattice, as it reads best."""
    origin, u, v = fitted
    p, q, r, s = BASES.T
    one, two = p * u + q * v, r * u + s * v
    right, up = _sign(one.real, one.imag), _sign(two.imag, two.real)
    sign = p * s - q * r
    i, j = index.T
    a = (right * sign)[:, None] * (s[:, None] * i - r[:, None] * j)
    b = (up * sign)[:, None] * (p[:, None] * j - q[:, None] * i)
    one, two = right * one, up * two
    plain = _rank(a, b, one, two, 0.0)
    staggered = _rank(a + (b - b.min(axis=1, keepdims=True)) // 2, b, one, two - one / 2, 0.5)
    best = int(np.lexsort(np.concatenate([plain, staggered], axis=1)[::-1])[0])
    way, stagger = best % len(BASES), 0.5 * (best >= len(BASES))
    steps = complex(one[way]), complex(two[way])
    return _based(Net(origin, *steps, stagger, index, rows, reach), a[way], b[way])


def _sign(first: Floats, second: Floats) -> Integers:
    """Of the first numbers, of the second where the first are nothing."""
    deciding = np.where(np.abs(first) > 1e-9 * np.abs(second), first, second)
    return np.where(deciding < 0, -1, 1)


def _rank(a: Integers, b: Integers, u: Complexes, v: Complexes, stagger: float) -> Floats:
    """(5, k) what reads better is less: few nodes, not staggered, upright, flat, low."""
    high = np.ptp(b, axis=1) + 1.0
    slant = np.abs((u.conj() * v).real) / np.maximum(np.abs(u) * np.abs(v), 1e-300)
    flat = np.abs(u.real) / np.maximum(np.abs(u), 1e-300)
    nodes = (np.ptp(a, axis=1) + 1) * high
    return np.stack([nodes, np.full(len(u), stagger), slant.round(3), -flat.round(3), high])


def _based(net: Net, a: Integers, b: Integers) -> Net:
    """Numbered from 0 by a and b along u and v. Staggered: every second line goes half a step
    back, so that lines stay upright.
    """
    low = int(b.min())
    b = b - low
    origin, v = net.origin + low * net.v, net.v
    if net.stagger:
        a = a + b // 2
        v = v - net.u / 2
    first = int(a.min())
    index = np.stack([a - first, b], axis=1)
    return Net(origin + first * net.u, net.u, v, net.stagger, index, net.rows, net.reach)


def unstaggered(net: Net) -> Integers:
    """(m, 2) nodes along u and along v, which leads to the next line's node half a step on."""
    i, j = net.index.T
    return np.stack([i - j // 2, j], axis=1) if net.stagger else net.index


def turned(net: Net, back: bool, down: bool) -> Net:
    """The same nodes numbered from the other end of u (back), of v (down) or both."""
    a, b = unstaggered(net).T
    along, up = (-1 if back else 1), (-1 if down else 1)
    u, v = along * net.u, up * net.v
    if net.stagger:
        v += u / 2
        carried = b if along != up else 0 * b
        return _based(
            Net(net.origin, u, v, net.stagger, net.index, net.rows, net.reach),
            along * a + (carried if along > 0 else -carried),
            up * b,
        )
    return _based(Net(net.origin, u, v, 0.0, net.index, net.rows, net.reach), along * a, up * b)
