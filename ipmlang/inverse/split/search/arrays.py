"""Rows, grids and blocks among points: which stand in an array, with holes and uneven steps.

Takes points of symbols that are turned alike; gives lattices with their rows and digits, directions
fitted to them, the ones that save most first. Directions need not follow the axes nor be square to
each other. Nothing here knows symbols.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import hypot, prod
from operator import mul
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.cost import fewest_tokens
from ipmlang.inverse.split.expansion import offsets
from ipmlang.inverse.split.scheme import Direction
from ipmlang.inverse.split.snapping import Flags, label_rows, members, snap, snap_columns

EVERY = 40  # points of which all pairs are looked at; of more, the nearest
NEAREST = 8
DIRECTIONS = 6  # directions that are followed
LINES = 6  # longest lines, or fullest planes, that are tried along each
FLAT = 0.2  # sine of the angle under which two directions do not span a plane
SQUARE = 1e-6  # a direction this near to an axis is the axis
FEWEST = (3, 4, 4)  # points of a row, a grid or a block
DENSE = 16  # cells for each point, above which a lattice is not looked at

_Axis: TypeAlias = tuple[Integers, Floats, bool]


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """rows (k,) of the points that stand at digits (k, d); first (3,): where all digits are 0;
    directions: d of them; holes: digits of members that are missing.
    """

    rows: Integers
    digits: Integers
    first: Floats
    directions: tuple[Direction, ...]
    holes: frozenset[tuple[int, ...]]


def lattices(
    points: Floats, error: float, alone: Integers, least: float = -np.inf
) -> Iterator[Lattice]:
    """Arrays among points (n, 3), exact to `error`; alone (n,): tokens that each takes by itself;
    least: tokens that an array has to save.
    """
    if len(points) < 3:
        return
    along = directions(points, error)
    for size in (1, 2, 3):
        if len(points) < (3, 4, 8)[size - 1]:
            break
        for basis in combinations(range(len(along) if size < 3 else min(len(along), 4)), size):
            full = _completed(along[list(basis)])
            if full is not None:
                yield from _lattices(points, full, size, error, alone, least)


def directions(points: Floats, error: float) -> Floats:
    """(d, 3) unit directions that many pairs of points share, the most frequent first."""
    first, second = _pairs(points)
    away = points[second] - points[first]
    length = np.linalg.norm(away, axis=1)
    away, length = away[length > 4 * error], length[length > 4 * error]
    if len(away) == 0:
        return np.zeros((0, 3))
    unit = away / length[:, None]
    unit[np.abs(unit) < SQUARE] = 0.0
    lead = unit[np.arange(len(unit)), np.argmax(unit != 0, axis=1)]
    unit = unit * np.sign(lead)[:, None] + 0.0
    near = max(SQUARE, 4 * error / float(np.median(length)))
    label, count = label_rows(snap_columns(unit, near))
    # the longest pair of a kind says best where it points
    order = np.lexsort((-length, label))
    best = unit[order[np.searchsorted(label[order], np.arange(len(count)))]]
    straight = np.abs(best).max(axis=1) > 1 - SQUARE
    best[straight] = np.round(best[straight])
    rank = np.lexsort((*best.T, ~straight, -count))
    rank = rank[(count[rank] > 1) | straight[rank]]
    return np.asarray(best[rank[:DIRECTIONS]])


def _pairs(points: Floats) -> tuple[Integers, Integers]:
    if len(points) <= EVERY:
        one, two = np.triu_indices(len(points), 1)
        return one.astype(np.int64), two.astype(np.int64)
    from scipy.spatial import cKDTree

    near = np.asarray(cKDTree(points).query(points, k=NEAREST + 1)[1])
    first = np.repeat(np.arange(len(points)), NEAREST)
    return first, near[:, 1:].ravel().astype(np.int64)


def _completed(along: Floats) -> Floats | None:
    """(3, 3) columns: the directions and what is square to them; None if they are too flat."""
    columns: list[list[float]] = along.tolist()
    if len(columns) == 1:
        least = min(range(3), key=lambda axis: abs(columns[0][axis]))
        second = _across(columns[0], [float(axis == least) for axis in range(3)])
        columns.append([each / hypot(*second) for each in second])
    if len(columns) == 2:
        third = _across(columns[0], columns[1])
        sine = hypot(*third)
        if sine < FLAT:
            return None
        columns.append([each / sine for each in third])
    volume = sum(map(mul, columns[0], _across(columns[1], columns[2])))
    return np.array(columns).T if abs(volume) > FLAT else None


def _across(one: Sequence[float], two: Sequence[float]) -> list[float]:
    """What is square to both."""
    return [
        one[1] * two[2] - one[2] * two[1],
        one[2] * two[0] - one[0] * two[2],
        one[0] * two[1] - one[1] * two[0],
    ]


def _lattices(
    points: Floats, basis: Floats, size: int, error: float, alone: Integers, least: float
) -> Iterator[Lattice]:
    """Those along the first `size` columns of a basis."""
    each = float(alone.mean())
    place = np.asarray(np.linalg.solve(basis, points.T).T, np.float64)
    place -= place.min(axis=0)
    label = snap_columns(place, 2 * error)
    group, count = label_rows(label[:, size:])
    groups = members(group, len(count))
    groups = [own for own in groups if len(own) >= FEWEST[size - 1]]
    groups.sort(key=lambda own: (-len(own), int(own[0])))
    for own in groups[:LINES]:
        for rows in _choices(place[own, :size], label[own, :size], error, each):
            chosen = own[rows]
            axes = [_axis(place[chosen, a], label[chosen, a], error) for a in range(size)]
            if int(alone[chosen].sum()) - _fewest_tokens(axes, len(chosen)) >= least:
                found = _fit(points, chosen, axes, basis, error)
                if found is not None:
                    yield found


def _choices(place: Floats, label: Integers, error: float, each: float) -> Iterator[Integers]:
    """Rows of points with places (n, d) along directions that may be an array."""
    if place.shape[1] == 1:
        yield np.sort(np.unique(label[:, 0], return_index=True)[1])
        yield from _even(place[:, 0], error)
        return
    filled = _filled(label)
    if filled is None:
        return
    before = -1
    for hole in (float(place.shape[1]), 2 * each):  # with holes where they pay, and without
        rows = filled.rows[filled.inside(_peeled(filled.dense, each, hole))]
        if len(rows) not in (before, 0, 1, 2) and (np.ptp(label[rows], axis=0) > 0).all():
            before = len(rows)
            yield rows


def _even(along: Floats, error: float) -> Iterator[Integers]:
    """Rows of points on a line that stand in equal steps, a few missing."""
    order = np.argsort(along, kind="stable")
    gaps = np.diff(along[order])
    gaps = gaps[gaps > 4 * error]
    if len(gaps) < 2:
        return
    label, count = label_rows(snap(gaps, 4 * error)[:, None])
    for kind in np.lexsort((np.arange(len(count)), -count))[:3].tolist():
        step = float(np.mean(gaps[label == kind]))
        digit = np.round((along[order] - along[order[0]]) / step)
        rest = (along[order] - along[order[0]]) - digit * step
        bins, sizes = label_rows(snap(rest, max(4 * error, 0.02 * step))[:, None])
        for own in members(bins, len(sizes)):
            runs = np.split(own, np.nonzero(np.diff(digit[own]) > 2)[0] + 1)
            best = max(runs, key=len)
            best = best[np.unique(digit[best], return_index=True)[1]]
            if len(best) >= 3:
                yield order[best]


@dataclass(frozen=True, slots=True, eq=False)
class _Filled:
    """Rows of points (k,), the slices (k, d) that they are in, and which cells of these are not
    empty.
    """

    rows: Integers
    index: Integers
    dense: Flags

    def inside(self, kept: list[Flags]) -> Flags:
        """Which points are in these slices along each axis."""
        alive = [own[self.index[:, axis]] for axis, own in enumerate(kept)]
        return np.asarray(np.logical_and.reduce(alive))


def _filled(label: Integers) -> _Filled | None:
    """The points of a lattice in all slices that have several; None where there are too few."""
    rows = _first_of_each(label)
    while True:  # a slice with a single point in it never pays
        slim = np.zeros(len(rows), np.bool_)
        for column in label[rows].T:
            amount = np.bincount(column)
            slim |= amount[column] < 2
        if not slim.any():
            break
        rows = rows[~slim]
        if len(rows) < 4:
            return None
    columns = label[rows].T
    ranks = [np.cumsum(np.bincount(column) > 0) - 1 for column in columns]
    index = np.stack([rank[column] for rank, column in zip(ranks, columns, strict=True)], axis=1)
    shape = tuple((index.max(axis=0) + 1).tolist())
    if np.prod(shape) > DENSE * len(rows):
        return None
    dense = np.zeros(shape, np.bool_)
    dense[tuple(index.T)] = True
    return _Filled(rows, index, dense)


def _first_of_each(label: Integers) -> Integers:
    """The first row of each kind, in order."""
    kind, count = label_rows(label)
    first = np.empty(len(count), np.int64)
    first[kind[::-1]] = np.arange(len(kind))[::-1]
    return np.sort(first)


def _peeled(dense: Flags, each: float, hole: float) -> list[Flags]:
    """Which slices along each axis are in the box that saves most tokens."""
    sizes, axes = dense.shape, dense.ndim
    alive = [np.ones(size, np.bool_) for size in sizes]
    filled = dense.astype(np.float64)
    amounts = [
        filled.sum(axis=tuple(other for other in range(axes) if other != axis))
        for axis in range(axes)
    ]
    left, there = list(sizes), float(filled.sum())
    best, least = [own.copy() for own in alive], -np.inf
    while True:
        whole = float(np.prod(left))
        gain = each * there - hole * (whole - there) - 2.0 * sum(left)
        if gain > least:
            best, least = [own.copy() for own in alive], gain
        worst: tuple[float, int, int] | None = None
        for axis in range(axes):
            if left[axis] <= 2:
                continue
            index = int(np.argmin(amounts[axis]))
            amount = float(amounts[axis][index])
            value = each * amount - hole * (whole / left[axis] - amount)
            if worst is None or value < worst[0]:
                worst = (value, axis, index)
        if worst is None or (gain < least and worst[0] > each):
            return best
        _, axis, index = worst
        there -= float(amounts[axis][index])
        left[axis] -= 1
        alive[axis][index] = False
        _take_out(filled, amounts, axis, index)


def _take_out(filled: Floats, amounts: list[Floats], axis: int, index: int) -> None:
    """Empty a slice, which is not to be found again, and count its cells out of the others."""
    cut = (slice(None),) * axis + (index,)
    slab = filled[cut]
    crossed = [other for other in range(filled.ndim) if other != axis]
    for place, other in enumerate(crossed):
        amounts[other] -= slab.sum(axis=tuple(k for k in range(len(crossed)) if k != place))
    filled[cut] = 0.0
    amounts[axis][index] = np.inf


def _fewest_tokens(axes: list[_Axis], members: int) -> int:
    """Tokens that an array takes at least."""
    cells = prod(len(values) for _, values, _ in axes)
    return fewest_tokens([(len(values), even) for _, values, even in axes], cells - members)


def _fit(
    points: Floats, rows: Integers, axes: list[_Axis], basis: Floats, error: float
) -> Lattice | None:
    """The array that points stand in, its numbers fitted and made short; None if it is off."""
    size = len(axes)
    digits = np.stack([digit for digit, _, _ in axes], axis=1)
    offset = np.stack([values[digit] for digit, values, _ in axes], axis=1)
    known = np.concatenate([np.ones((len(rows), 1)), offset], axis=1)
    solved = np.linalg.lstsq(known, points[rows], rcond=None)[0]
    first, along = solved[0], solved[1:]
    made = [_direction(axes[a][1], along[a], basis[:, a], error / (2 * size)) for a in range(size)]
    where = np.zeros((len(rows), 3))
    for a, direction in enumerate(made):
        where += offsets(direction)[digits[:, a]]
    first = np.array([shortest(v, error / 8) for v in (points[rows] - where).mean(axis=0)])
    if np.linalg.norm(first + where - points[rows], axis=1).max() > error:
        return None
    holes = _holes(digits, [direction.count for direction in made])
    return Lattice(rows, digits, first, tuple(made), holes)


def _axis(place: Floats, label: Integers, error: float) -> _Axis:
    """(k,) digits along an axis and (c,) where each digit stands, the first at 0; and whether their
    steps are one.
    """
    digit = np.unique(label, return_inverse=True)[1].reshape(-1).astype(np.int64)
    total = np.bincount(digit, weights=place)
    values: Floats = np.asarray(total / np.bincount(digit))
    values = values - values[0]
    gaps = np.diff(values)
    step = float(gaps.min())
    whole = np.round(values / step)
    fine = float(whole @ values / (whole @ whole))
    if np.abs(whole * fine - values).max() < 2 * error and whole[-1] < 1.5 * len(values):
        even = np.asarray(np.arange(int(whole[-1]) + 1) * fine, np.float64)
        return whole.astype(np.int64)[digit], even, True
    return digit, np.asarray(values, np.float64), _steps_alike(values)


def _direction(values: Floats, along: Floats, wanted: Floats, error: float) -> Direction:
    """A direction through offsets, `along` for each unit of them; `wanted`: what it should be."""
    count = len(values)
    if _steps_alike(values):
        step = along * values[1]
        return Direction(count, np.array([shortest(v, error / count) for v in step]))
    length = float(np.linalg.norm(along))
    unit = along / length
    if np.abs(unit - wanted).max() * values[-1] < error:
        unit = wanted
    steps = [shortest(float(gap), error / count) for gap in np.diff(values) * length]
    return Direction(count, unit, tuple(steps))


def _steps_alike(values: Floats) -> bool:
    return bool(np.abs(np.diff(values, 2)).max(initial=0.0) <= 1e-12 * (1 + values[-1]))


def _holes(digits: Integers, counts: list[int]) -> frozenset[tuple[int, ...]]:
    there = np.zeros(counts, np.bool_)
    there[tuple(digits.T)] = True
    return frozenset(zip(*(axis.tolist() for axis in np.nonzero(~there)), strict=True))
