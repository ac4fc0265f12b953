"""Which of its images a motif keeps, where the motions between its occurrences are a symmetry.

Takes a motif that the quarters of a tower, or two mirrored halves, are; gives the same motif with
each part taken from the same side. Growing chooses freely among the images of a part, so that one
row of windows may end up on all four sides. Nothing here looks anything up or counts tokens.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.search.fields import Field
from ipmlang.inverse.split.search.growth import Grown
from ipmlang.inverse.split.snapping import label_rows, snap_columns

MOST = 24  # occurrences
FEW = 32  # parts of a half, which are as plain on either side unless they share coordinates
LEAST, LEAST_HALF = 3, 8  # parts of a side; few parts of a half are as plain on either side
SAME = 1e-5  # share of what the motif spans
TILT = (3e-3, -1e-3, 1e-5)  # no two images lie equally far along a direction
LEADS = (
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, 1),
    (1, 1, 0),
    (1, -1, 0),
    (1, 0, 1),
    (0, 1, 1),
    (1, 1, 1),
)  # directions whose side is tried


def coherent(field: Field, grown: Grown) -> Grown:
    """The motif with each part on one side, if its motions are a group and that is plainer."""
    count, size = grown.rows.shape
    if size < (LEAST_HALF if count == 2 else LEAST) or not 2 <= count <= MOST:
        return grown
    centers = field.points[grown.rows, 0]
    after = _products(grown.motion, SAME * (float(np.abs(centers).max()) + 1e-12))
    if after is None:
        return grown
    symbol = field.draft.symbol[grown.rows[0]]
    gap = SAME * (float(np.ptp(centers.reshape(-1, 3), axis=0).max()) + 1e-12)
    best, least = np.zeros(size, np.int64), _effort(centers[0], symbol, gap)
    column = np.arange(size)
    little = count == 2 and size < FEW
    for side in _sides(centers):
        effort = _effort(centers[side, column], symbol, gap)
        if effort[0] < least[0] or (effort < least and not little):
            best, least = side, effort
    return Grown(grown.rows[after[:, best], column[None]], grown.motion)


def _products(motion: Floats, small: float) -> Integers | None:
    """(k, k) which motion each is after each, None where some product is not among them."""
    turn, move = motion[:, :, :3], motion[:, :, 3]
    turned = np.einsum("iab,jbc->ijac", turn, turn)
    moved = np.einsum("iab,jb->ija", turn, move) + move[:, None]
    off = np.abs(turned[:, :, None] - turn).max(axis=(3, 4))
    far = np.abs(moved[:, :, None] - move).max(axis=3)
    same = (off < SAME) & (far < small)
    return np.asarray(same.argmax(axis=2)) if same.any(axis=2).all() else None


def _sides(centers: Floats) -> list[Integers]:
    """For each direction, which image (m,) of each part lies farthest along it; (k, m, 3)."""
    away = centers - centers.mean(axis=0)
    directions = np.array(LEADS) + TILT
    far = np.einsum("kmi,di->dkm", away, directions)
    return list(far.argmax(axis=1))


def _effort(centers: Floats, symbol: Integers, gap: float) -> tuple[int, float]:
    """How many different coordinates the copies of all symbols have, and how far they reach."""
    labels = snap_columns(centers, gap)
    different = sum(
        len(label_rows(np.stack([symbol, labels[:, axis]], axis=1))[1]) for axis in range(3)
    )
    return different, round(float(np.ptp(centers, axis=0).sum()) / gap) * gap
