"""Which point of a symbol lies on a lattice where its copies turn: not always its middle.

Takes frames in paint order; gives the point about which copies were turned before they were moved
by even steps. Three of them in a row say where it is, and many that agree are believed. A symbol
that turns into itself has its centre, and copies that do not turn show nothing. Nothing here looks
for lattices.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.lattices.chains import Mask
from ipmlang.inverse.lattices.cloud import Integers
from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames

MOST = 500  # copies that are compared with each other
LEAST, SHARE = 4, 0.25  # copies and share of them that must agree
TURNED = 0.005  # by how much the turn from one to the next must change, as a factor
NOISE = 4.0  # times the noise of one place is that of a second difference
WITHIN = 1.5  # times the symbol's extent: further off is the centre of a ring
NEARLY = 0.5  # of the extent that a place may be off and still be told


def turned_about(
    placed: Frames, order: Integers, radius: float, exact: float, loose: float
) -> complex | None:
    """The point, in units of the symbol, that goes by even steps where copies (n,) turn, None if
    there is none; order: (n,) paint ranks; radius: the symbol's extent; exact: units within which a
    place is exact; loose: share of the step that it may be off.

    >>> from ipmlang.inverse.lsystem.frames import compose, frames
    >>> row = frames(9.0 * np.arange(8), 20.0 * np.arange(8))
    >>> off = compose(row, frames(np.array([-1j])))
    >>> abs(turned_about(off, np.arange(8), 2.0, 1e-6, 0.01) - 1j) < 1e-9
    True
    """
    if not LEAST < len(placed) <= MOST or np.ptp(placed.handedness) or not np.ptp(placed.angle):
        return None
    rank = np.argsort(order)
    at, factor = placed.position[rank], placed.factor[rank]
    bend = np.diff(factor, 2)
    told = np.abs(bend) > TURNED * np.abs(factor[1:-1])
    where, bent = -np.diff(at, 2)[told] / bend[told], np.abs(bend[told])
    step = np.abs(np.diff(at))[1:][told]
    for share in (0.0, loose):
        near = NOISE * np.maximum(exact, share * step) / bent
        agree = _agreeing(where, near, radius)
        if np.count_nonzero(agree) >= max(LEAST, SHARE * len(placed)):
            point = complex(np.median(where[agree].real), np.median(where[agree].imag))
            # The points of mirrored copies are mirrored before they are turned.
            return point if placed.handedness[0] > 0 else -point.conjugate()
    return None


def _agreeing(where: Complexes, near: Floats, radius: float) -> Mask:
    """(m,) those about the point that most agree with; near: (m,) how far each may be off."""
    good = (np.abs(where) <= WITHIN * radius) & (near <= NEARLY * radius)
    if not good.any():
        return good
    alike = (np.abs(where[:, None] - where) <= np.maximum(near, near[:, None])) & good
    best = int(np.argmax(np.where(good, alike.sum(axis=1), 0)))
    return np.asarray(alike[best], np.bool_)
