"""Numbers whose largest deviation from what was measured is the smallest: Chebyshev's fit.

Takes columns and a target; gives the factors of the columns, by linear programs over the points
that are furthest off, to which others are added as long as one lies further off than those. What
was rounded is fitted so, since no point of it is off by more than the others may be. Nothing here
rounds.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.lsystem.frames import Floats

FIRST = 256  # points that the first linear program holds, and that each further one adds
EXCHANGES = 16  # of points that it moved too far
NEAR = 1e-7  # of the largest deviation, by which another point may be further off


def least_largest(columns: Floats, target: Floats) -> Floats | None:
    """(k,) factors of the columns (n, k) that come nearest to a target (n,); None where no program
    is solved. After EXCHANGES the last ones are taken.

    >>> np.round(least_largest(np.ones((3, 1)), np.array([0.0, 1.0, 4.0])), 9).tolist()
    [2.0]
    """
    size = np.abs(columns).max(axis=0)
    size[size == 0] = 1.0
    scaled = columns / size
    found = np.linalg.lstsq(scaled, target, rcond=1e-12)[0]
    chosen, largest = np.zeros(0, np.int64), -1.0
    for _ in range(EXCHANGES):
        off = np.abs(target - scaled @ found)
        worst = np.argsort(-off, kind="stable")[:FIRST]
        if off[worst[0]] <= largest * (1 + NEAR) or np.isin(worst, chosen).all():
            break
        chosen = np.union1d(chosen, worst)
        solved = least_largest_of_few(scaled[chosen], target[chosen])
        if solved is None:
            return None
        found, largest = solved
    return np.asarray(found / size, np.float64)


def least_largest_of_few(columns: Floats, target: Floats) -> tuple[Floats, float] | None:
    """(k,) factors of the columns (n, k) by one linear program over all of a target (n,), and the
    largest deviation; None where it is not solved. Time grows faster than n.
    """
    from scipy.optimize import linprog

    width = columns.shape[1]
    slack = -np.ones((len(columns), 1))
    free: list[tuple[float | None, float | None]] = [(None, None)] * width + [(0, None)]
    solved = linprog(
        [0] * width + [1],
        np.block([[columns, slack], [-columns, slack]]),
        np.concatenate([target, -target]),
        bounds=free,
    )
    if solved.status != 0 or solved.x is None:
        return None
    return np.asarray(solved.x[:width], np.float64), float(solved.x[width])
