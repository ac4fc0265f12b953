"""How far apart two drawn curves are, for many pairs at once.

In come pairs of elements as stacked curves, out go largest distances in units. Segments that
correspond are compared at equal parameters, also when the curve starts elsewhere or runs backwards;
full ellipses by centre and axes; the rest by the distance of dense points of each curve from the
other, refined on the curve itself, so that no flattening error enters. Nothing here looks at
styles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC
from ipmlang.inverse.lsystem.alignment import Freedom, closest_start
from ipmlang.inverse.lsystem.curves import Booleans, Curves, Integers, evaluate
from ipmlang.inverse.lsystem.ellipses import find_ellipses
from ipmlang.inverse.lsystem.frames import Complexes, Floats

FINE = 1e-7  # of the diagonal: distances that are as good as none
QUARTERS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
ALONG = 32  # points of a segment whose distance from the other curve is measured
REFINED_AT_MOST = 500  # pairs that correspond but differ, for which a lower distance is sought,
SEGMENTS_AT_MOST = 50_000  # or more of them while they have no more segments than this


def pair_distances(a: Curves, b: Curves, fixed: Booleans, unit: float, near: float = 0.0) -> Floats:
    """(n,) largest distance between element i of a and element i of b.

    fixed: (n,) start and direction are visible, so they must agree; unit: the drawing's diagonal;
    distances that are no more of it than `FINE` are not worked on further; near: units by which
    pairs may lie apart and still be looked at closely. Infinite where only one of a pair is empty.
    """
    count = len(a.counts)
    result = np.full(count, np.inf)
    result[(a.counts == 0) & (b.counts == 0)] = 0.0
    alike = (a.counts == b.counts) & (a.counts > 0)
    alike[alike] = _same_kinds(a, b, np.flatnonzero(alike))
    rows = np.flatnonzero(alike)
    result[rows] = _at_equal_parameters(a, b, rows)
    fine = FINE * unit
    _improve_ellipses(result, a, b, fixed, unit)
    rows = np.flatnonzero(alike & (result > fine) & ~fixed & (a.subpaths == 1) & (b.subpaths == 1))
    _improve_restarted(result, a, b, rows)
    _improve_dense(result, a, b, fixed, alike, unit, near)
    return result


def rows_of(offsets: Integers, elements: Integers) -> Integers:
    """Segment numbers of the elements, one after the other."""
    counts = offsets[elements + 1] - offsets[elements]
    ends = np.cumsum(counts)
    shift = np.repeat(offsets[elements] - (ends - counts), counts)
    return np.asarray(np.arange(len(shift)) + shift)


def _same_kinds(a: Curves, b: Curves, rows: Integers) -> Booleans:
    differ = a.kind[rows_of(a.offsets, rows)] != b.kind[rows_of(b.offsets, rows)]
    return np.asarray(_largest(differ.astype(np.float64), a.counts[rows]) == 0)


def _largest(values: Floats, counts: Integers) -> Floats:
    """(n,) maxima of consecutive stretches of so many values each, none of them empty."""
    if not len(counts):
        return np.zeros(0)
    return np.asarray(np.maximum.reduceat(values, np.cumsum(counts) - counts))


def _at_equal_parameters(a: Curves, b: Curves, rows: Integers) -> Floats:
    here, there = rows_of(a.offsets, rows), rows_of(b.offsets, rows)
    off = evaluate(a.kind[here], a.points[here], QUARTERS)
    off -= evaluate(b.kind[there], b.points[there], QUARTERS)
    return _largest(np.abs(off).max(axis=1), a.counts[rows])


def _improve_ellipses(result: Floats, a: Curves, b: Curves, fixed: Booleans, unit: float) -> None:
    """Full ellipses, however they are cut into arcs; what they lack of full ones is added."""
    unsure = ~fixed & (result > FINE * unit)
    if not unsure.any():
        return
    left, right = find_ellipses(a, 1e-7 * unit), find_ellipses(b, 1e-7 * unit)
    rows = np.flatnonzero(left.full & right.full & unsure)
    tilt = np.deg2rad(left.angle[rows] - right.angle[rows])
    flat = np.minimum(left.major - left.minor, right.major - right.minor)[rows]
    off = np.abs(left.centre - right.centre)[rows]
    off += np.maximum(np.abs(left.major - right.major), np.abs(left.minor - right.minor))[rows]
    off += np.abs(np.sin(tilt)) * flat + left.gap[rows] + right.gap[rows]
    result[rows] = np.minimum(result[rows], off)


def _improve_restarted(result: Floats, a: Curves, b: Curves, rows: Integers) -> None:
    """Single subpaths of equally many segments that start elsewhere or run backwards."""
    keys = np.stack([a.counts, a.closed & b.closed], axis=1)[rows]
    unique, which = np.unique(keys, axis=0, return_inverse=True)
    for number, (length, closed) in enumerate(unique.tolist()):
        part = rows[which.ravel() == number]
        left, right = (_sampled(each, part, length, bool(closed)) for each in (a, b))
        off = closest_start(left, right, Freedom(4 if closed else 0, True))
        result[part] = np.minimum(result[part], off)


def _sampled(curves: Curves, rows: Integers, length: int, closed: bool) -> Complexes:
    index = curves.offsets[rows][:, None] + np.arange(length)
    points = evaluate(
        curves.kind[index].ravel(), curves.points[index].reshape(-1, 4), QUARTERS
    ).reshape(len(rows), length, 5)
    along = points[:, :, :4].reshape(len(rows), -1)
    return along if closed else np.concatenate([along, points[:, -1, 4:]], axis=1)


def _improve_dense(
    result: Floats,
    a: Curves,
    b: Curves,
    fixed: Booleans,
    alike: Booleans,
    unit: float,
    near: float,
) -> None:
    """Curves whose segments do not correspond, and some of those that do but lie apart."""
    drawn = (a.counts > 0) & (b.counts > 0)
    rows = np.flatnonzero(drawn & (result > 5e-7 * unit))
    rows = rows[_overlapping(a, b, rows, near)]
    apart, strange = rows[alike[rows]], rows[~alike[rows]]
    small = int(np.searchsorted(np.cumsum(a.counts[apart]), SEGMENTS_AT_MOST))
    for row in np.concatenate([strange, apart[: max(REFINED_AT_MOST, small)]]).tolist():
        left, right = _segments(a, row), _segments(b, row)
        off = max(_one_way(left, right), _one_way(right, left))
        if fixed[row]:
            off = max(off, _ends_apart(left, right))
        result[row] = min(result[row], off)


def _overlapping(a: Curves, b: Curves, rows: Integers, near: float) -> Booleans:
    """Whether pairs lie about where each other is, so that it is worth looking at them closely."""
    boxes = [bounding_boxes(each, rows) for each in (a, b)]
    size = np.maximum(*(np.abs(box[:, 2:] - box[:, :2]).max(axis=1) for box in boxes))
    return np.asarray(np.abs(boxes[0] - boxes[1]).max(axis=1) <= 0.25 * size + near)


def bounding_boxes(curves: Curves, rows: Integers) -> Floats:
    """(k, 4) least x and y, largest x and y of points along elements that are not empty; curves may
    reach a little further.
    """
    index, counts = rows_of(curves.offsets, rows), curves.counts[rows]
    along = evaluate(curves.kind[index], curves.points[index], np.linspace(0.0, 1.0, 17))
    sides = [-along.real, -along.imag, along.real, along.imag]
    box = np.stack([_largest(side.max(axis=1), counts) for side in sides], axis=1)
    box[:, :2] *= -1
    return box


Segments = tuple[NDArray[np.uint8], Complexes]


def _segments(curves: Curves, row: int) -> Segments:
    part = slice(int(curves.offsets[row]), int(curves.offsets[row + 1]))
    return curves.kind[part], curves.points[part]


def _ends_apart(left: Segments, right: Segments) -> float:
    at = np.array([0.0, 1.0])
    a, b = evaluate(*left, at), evaluate(*right, at)
    return float(max(abs(a[0, 0] - b[0, 0]), abs(a[-1, 1] - b[-1, 1])))


def _one_way(left: Segments, right: Segments) -> float:
    """Largest distance of points along `left` from the curve `right`."""
    points = evaluate(*left, np.linspace(0.0, 1.0, ALONG + 1)).ravel()
    return float(np.abs(Locus(right).closest(points)[0] - points).max())


class Locus:
    """A curve to which points are near or far."""

    def __init__(self, curve: Segments) -> None:
        from scipy.spatial import cKDTree

        self.kind, self.points = curve
        self.at = np.linspace(0.0, 1.0, ALONG + 1)
        self.along = evaluate(self.kind, self.points, self.at).ravel()
        self.tree = cKDTree(np.stack([self.along.real, self.along.imag], axis=1))

    def closest(
        self, targets: Complexes, near: int = 6, steps: int = 8
    ) -> tuple[Complexes, Complexes]:
        """(K,) the point of the curve nearest to each of K targets, and the derivative there; found
        from so many points near each target in so many steps.
        """
        near = min(near, self.along.size)
        _, number = self.tree.query(np.stack([targets.real, targets.imag], axis=1), k=near)
        # Distances that overflow come without a neighbour, as the number past the end.
        index = np.minimum(np.asarray(number), self.along.size - 1).ravel()
        segment, step = np.divmod(index, len(self.at))
        kind, points, wanted = self.kind[segment], self.points[segment], np.repeat(targets, near)
        place = _refined(kind, points, self.at[step], wanted, steps)
        found, start = evaluate(kind, points, place[:, None])[:, 0], self.along[index]
        # A step of refinement may lead away from where the search began.
        worse = np.abs(start - wanted) < np.abs(found - wanted)
        place, found = np.where(worse, self.at[step], place), np.where(worse, start, found)
        best = np.argmin(np.abs(found - wanted).reshape(-1, near), axis=1)
        best = np.arange(len(targets)) * near + best
        return found[best], derivative(kind[best], points[best], place[best])


def _refined(
    kind: NDArray[np.uint8], points: Complexes, start: Floats, target: Complexes, steps: int
) -> Floats:
    """(K,) parameters of the points of segments nearest to targets, by Gauss-Newton."""
    t = start
    for _ in range(steps):
        here = evaluate(kind, points, t[:, None])[:, 0]
        slope = derivative(kind, points, t)
        length = np.abs(slope) ** 2
        step = ((here - target) * np.conj(slope)).real / np.maximum(length, 1e-300)
        t = np.clip(t - np.where(length > 0, step, 0.0), 0.0, 1.0)
    return t


def derivative(kind: NDArray[np.uint8], points: Complexes, at: Floats) -> Complexes:
    """(K,) derivatives of K segments by their parameter, each at its own.

    >>> line = np.array([[0, 4, 0, 0]], complex)
    >>> derivative(np.array([LINE], np.uint8), line, np.array([0.5])).tolist()
    [(4+0j)]
    """
    p0, p1, p2, p3 = points.T
    s = 1 - at
    result = np.zeros(len(kind), np.complex128)
    for code, value in (
        (LINE, p1 - p0),
        (QUADRATIC, 2 * (s * (p1 - p0) + at * (p2 - p1))),
        (CUBIC, 3 * (s**2 * (p1 - p0) + 2 * s * at * (p2 - p1) + at**2 * (p3 - p2))),
    ):
        result = np.where(kind == code, value, result)
    arc = kind == ARC
    angle = p3[arc].real + p3[arc].imag * at[arc]
    result[arc] = p3[arc].imag * (p2[arc] * np.cos(angle) - p1[arc] * np.sin(angle))
    return result
