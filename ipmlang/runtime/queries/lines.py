"""The lines that splits snap to: planes across an axis of the shapes that made them.

In go columns of a batch, out come, for cuts along other axes, the lines beside them. Which lines
there are depends neither on the order in which they were made nor on how shapes are batched. No
loop goes over lines or cuts: lines are sorted by what may see them and by where they look, and
found by bisection.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
GRID = 1e6  # lines and axes whose directions differ by less than about a millionth are parallel
_BITS = 21  # of each of three numbers that make one


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """Lines of one derivation: the number of the name, the row of marks that each stands in, the
    phase (n,); a point on the plane and its unit normal (n, 3).
    """

    name: Numbers
    mark: Numbers
    phase: Floats
    point: Floats
    normal: Floats

    def take(self, rows: Numbers | NDArray[np.bool_]) -> Made:
        """Some of them."""
        return Made(
            self.name[rows], self.mark[rows], self.phase[rows], self.point[rows], self.normal[rows]
        )


def joined(parts: Sequence[Made]) -> Made:
    """Several batches as one."""
    none, blank = np.zeros(0, np.int64), np.zeros((0, 3))
    return Made(
        np.concatenate([none, *(each.name for each in parts)]),
        np.concatenate([none, *(each.mark for each in parts)]),
        np.concatenate([none * 0.0, *(each.phase for each in parts)]),
        np.concatenate([blank, *(each.point for each in parts)]),
        np.concatenate([blank, *(each.normal for each in parts)]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Axes:
    """Along what cuts are made: the family of lines that each sees (n,), where it begins and its
    unit direction (n, 3).
    """

    family: Numbers
    origin: Floats
    along: Floats


class Standing:
    """Lines by family: those of a name, perhaps of one shape alone. `family` (n,), 0 or more."""

    def __init__(self, lines: Made, family: Numbers) -> None:
        both = np.concatenate([lines.normal, -lines.normal])  # a line has no direction of its own
        points, families = np.concatenate([lines.point] * 2), np.concatenate([family] * 2)
        offset = _dot(points, both)
        cell = _cells(np.rint(both * GRID))
        order = np.lexsort((*points.T, offset, cell, families))
        self._points, self._offset = points[order], offset[order]
        self._families, in_family = _places(families[order])
        self._cells, in_cell = _places(cell[order])
        self._groups, group = _places(in_family * len(self._cells) + in_cell)
        self._begins = np.searchsorted(group, np.arange(len(self._groups)))
        self._ends = np.append(self._begins[1:], len(order))

    def beside(self, axes: Axes, owner: Numbers, at: Floats) -> tuple[Floats, Floats]:
        """The nearest lines at or below, and at or above, the places `at` (c,) along the axes
        `owner` (c,); -inf and inf where there is none.
        """
        below, above = np.full(len(at), -np.inf), np.full(len(at), np.inf)
        target = _dot(axes.origin, axes.along)[owner] + at
        for group in self._seen(axes):
            rows = np.flatnonzero(group[owner] >= 0)
            if not len(rows):
                continue
            own = group[owner[rows]]
            begin, end = self._begins[own], self._ends[own]
            place = _bisected(self._offset, begin, end, target[rows])
            for chosen, there in ((place - 1, place > begin), (place, place < end)):
                kept = rows[there]
                axis = owner[kept]
                apart = self._points[chosen[there]] - axes.origin[axis]
                found = _dot(apart, axes.along[axis])
                lower = found <= at[kept]
                below[kept] = np.where(lower, np.maximum(below[kept], found), below[kept])
                above[kept] = np.where(lower, above[kept], np.minimum(above[kept], found))
        return below, above

    def _seen(self, axes: Axes) -> list[Numbers]:
        """The groups of lines (n,) that are across each axis, -1 for none: more than one where the
        axis looks between cells.
        """
        scaled = axes.along * GRID
        corners = np.stack([np.floor(scaled), np.ceil(scaled)])
        family = np.searchsorted(self._families, axes.family)
        family[self._families[np.minimum(family, len(self._families) - 1)] != axes.family] = -1
        found: list[Numbers] = []
        for choice in itertools.product((0, 1), repeat=3):
            cell = _cells(np.stack([corners[side, :, k] for k, side in enumerate(choice)], axis=1))
            place = np.minimum(np.searchsorted(self._cells, cell), len(self._cells) - 1)
            wanted = family * len(self._cells) + place
            group = np.minimum(np.searchsorted(self._groups, wanted), len(self._groups) - 1)
            known = (family >= 0) & (self._cells[place] == cell) & (self._groups[group] == wanted)
            own = np.where(known, group, -1)
            for before in found:
                own[own == before] = -1
            if (own >= 0).any():
                found.append(own)
        return found


def _dot(a: Floats, b: Floats) -> Floats:
    """Sums of products, with the same bits in every batch."""
    found: Floats = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    return found


def _cells(whole: Floats) -> Numbers:
    """One number for each row of three whole ones between -GRID and GRID."""
    x, y, z = (whole + GRID).astype(np.int64).T
    found: Numbers = (x << 2 * _BITS) | (y << _BITS) | z
    return found


def _places(values: Numbers) -> tuple[Numbers, Numbers]:
    """The different values, ascending, and the place of each among them."""
    found, place = np.unique(values, return_inverse=True)
    return found, place.reshape(-1).astype(np.int64)


def _bisected(values: Floats, begin: Numbers, end: Numbers, target: Floats) -> Numbers:
    """The first place of each span of ascending values at which one is above the target."""
    low, high = begin.copy(), end.copy()
    while (low < high).any():
        middle = (low + high) // 2
        after = (low < high) & (values[np.minimum(middle, len(values) - 1)] <= target)
        high = np.where(after, high, np.minimum(high, middle))
        low = np.where(after, middle + 1, low)
    return low
