"""Pattern discovery (Demir and Aliaga 2016, section 3.3): copies of a rule in rows, grids, blocks.

In go the places of copies that stand alike, out come lattices of up to three translations, along
the axes or not, that hold all or some of them. What a copy is does not matter here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.split.distinct import numbered
from ipmlang.inverse.split.snapping import label_rows, members

FEWEST = 3  # members of a row that is a pattern though it does not hold all copies


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """rows (n,): the copies, the first has all digits 0; counts (k,) and steps (k, 3): members and
    translation of each group, k <= 3, every place taken.
    """

    rows: Integers
    counts: tuple[int, ...]
    steps: Floats


def lattices(places: Floats, small: float) -> tuple[list[Lattice], Integers]:
    """Lattices of places (n, 3), none in two, and the rows that are in none.

    The smallest distance along an axis that divides all others is the step. Where copies are not
    one lattice together, those that share a plane or a line are tried.

    >>> places = np.array([[x * 5.0, 0, z * 3.0] for z in range(2) for x in range(3)])
    >>> found, rest = lattices(places, 1e-9)
    >>> found[0].counts, np.round(found[0].steps, 9).tolist(), len(rest)
    ((3, 2), [[5.0, 0.0, 0.0], [0.0, 0.0, 3.0]], 0)
    """
    found: list[Lattice] = []
    rest = np.arange(len(places))
    for groups in (_whole, _planes, _lines):
        left = []
        fewest = 2 if groups is _whole else FEWEST
        for rows in groups(places, rest, small):
            lattice = _lattice(places, rows, small) if len(rows) >= fewest else None
            if lattice is None:
                left.append(rows)
            else:
                found.append(lattice)
        rest = np.sort(np.concatenate([np.zeros(0, np.int64), *left]))
    return found, rest


def _whole(places: Floats, rows: Integers, small: float) -> Iterator[Integers]:
    yield rows


def _planes(places: Floats, rows: Integers, small: float) -> Iterator[Integers]:
    """Rows that share a coordinate: the one that most share."""
    if not len(rows):
        return
    kinds = [numbered(places[rows, axis], small) for axis in range(3)]
    fewest = min(range(3), key=lambda axis: (len(set(kinds[axis].tolist())), axis))
    yield from _grouped(rows, kinds[fewest][:, None])


def _lines(places: Floats, rows: Integers, small: float) -> Iterator[Integers]:
    """Runs along the axis in whose lines most stand, cut where the step changes."""
    if not len(rows):
        return
    kinds = np.stack([numbered(places[rows, axis], small) for axis in range(3)], axis=1)
    others = [[1, 2], [0, 2], [0, 1]]
    lines = [list(_grouped(rows, kinds[:, pair])) for pair in others]
    axis = min(range(3), key=lambda each: (len(lines[each]), each))
    for line in lines[axis]:
        yield from _runs(line, places[line, axis], small)


def _runs(rows: Integers, along: Floats, small: float) -> Iterator[Integers]:
    """The longest stretches of equal steps, from the left."""
    order = np.argsort(along, kind="stable")
    rows, along = rows[order], along[order]
    start = 0
    while start < len(rows):
        end = start + 1
        while end < len(rows) and _even(along[start : end + 1], small):
            end += 1
        yield rows[start:end]
        start = end


def _even(along: Floats, small: float) -> bool:
    step = (along[-1] - along[0]) / (len(along) - 1)
    return bool(np.abs(along - along[0] - step * np.arange(len(along))).max() <= small)


def _lattice(places: Floats, rows: Integers, small: float) -> Lattice | None:
    """All of these rows as one lattice."""
    points = places[rows]
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    if np.abs(points.mean(axis=0) - middle).max() > 4 * small:
        return None  # a lattice that is filled is the same from both ends
    steps = _axis_steps(points, small)
    found = None if steps is None else _filled(points, rows, steps, small)
    if found is None:
        skewed = _skewed_steps(points, small)
        found = None if skewed is None else _filled(points, rows, skewed, small)
    return found


def _axis_steps(points: Floats, small: float) -> Floats | None:
    """The smallest distance along each axis that divides all others; None where one does not."""
    steps = []
    for axis in range(3):
        levels = _levels(points[:, axis], small)
        if len(levels) == 1:
            continue
        step = float(np.diff(levels).min())
        digits = np.round((levels - levels[0]) / step)
        step = float((levels[-1] - levels[0]) / digits[-1])
        if np.abs(levels - levels[0] - digits * step).max() > small:
            return None
        steps.append(np.eye(3)[axis] * step)
    return np.array(steps).reshape(-1, 3)


def _skewed_steps(points: Floats, small: float) -> Floats | None:
    """Up to three translations from a corner to the nearest points that are not in one line or
    plane with those before.
    """
    corner = points[np.lexsort((points[:, 0], points[:, 1], points[:, 2]))[0]]
    away = points - corner
    length = np.linalg.norm(away, axis=1)
    order = np.argsort(length, kind="stable")
    order = order[length[order] > small]
    away, length = away[order], length[order]
    steps = away[:1]
    while 0 < len(steps) < 3:
        held = np.repeat(steps[None], len(away), axis=0)
        held = np.concatenate([held, away[:, None]], axis=1) / length[:, None, None]
        beyond = np.flatnonzero(np.linalg.matrix_rank(held, tol=1e-3) > len(steps))
        if not len(beyond):
            break
        steps = np.concatenate([steps, away[beyond[:1]]])
    return steps if len(steps) else None


def _filled(points: Floats, rows: Integers, steps: Floats, small: float) -> Lattice | None:
    """The lattice of these steps, where its places are the points, no more and no fewer."""
    if not len(steps):
        return None
    digits = np.round(np.linalg.lstsq(steps.T, (points - points[0]).T, rcond=None)[0].T)
    digits = (digits - digits.min(axis=0)).astype(np.int64)
    order = np.lexsort(digits.T)
    digits, rows, points = digits[order], rows[order], points[order]
    counts = digits.max(axis=0) + 1
    if np.prod(counts) != len(rows) or not (digits[1:] != digits[:-1]).any(axis=1).all():
        return None
    known = np.concatenate([np.ones((len(rows), 1)), digits], axis=1)
    fitted = np.linalg.lstsq(known, points, rcond=None)[0]
    if np.abs(known @ fitted - points).max() > small:
        return None
    clean = np.where(np.abs(fitted[1:]) * counts[:, None] <= small, 0.0, fitted[1:])
    kept = counts > 1
    return Lattice(rows, tuple(counts[kept].tolist()), clean[kept])


def _levels(values: Floats, small: float) -> Floats:
    """The distinct values, each the middle of those that are the same."""
    number = numbered(values, small)
    return np.asarray(np.bincount(number, values) / np.bincount(number))


def _grouped(rows: Integers, kinds: Integers) -> Iterator[Integers]:
    """Rows whose kinds (n, k) are the same."""
    number, count = label_rows(kinds)
    yield from (rows[own] for own in members(number, len(count)))
