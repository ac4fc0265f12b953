"""Full ellipses and circles among curves, however they are cut into arcs.

In come stacked curves, out go centres, half axes and tilts of the elements that are one whole
ellipse, with a bound on how far each is from an ideal one. Cubic approximations of circles are not
taken for circles. Nothing here groups or compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.formats.drawing import ARC, LINE
from ipmlang.inverse.lsystem.curves import Booleans, Curves
from ipmlang.inverse.lsystem.frames import Complexes, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Ellipses:
    """Columns over n elements. full: (n,) whether it is a whole ellipse; the others hold for those:
    centre; major and minor half axes; angle of the major one, degrees, 0 for circles; gap: how far
    the drawn curve may be from the ideal one, units.
    """

    full: Booleans
    centre: Complexes
    major: Floats
    minor: Floats
    angle: Floats
    gap: Floats


def find_ellipses(curves: Curves, tolerance: float) -> Ellipses:
    """Elements of one subpath whose arcs run once around one ellipse, within the tolerance (units).

    A circle drawn as one arc that ends just before its start, as SVG demands, is a full one.
    """
    count = len(curves.counts)
    blank = np.zeros((4, count))
    result = Ellipses(np.zeros(count, np.bool_), np.zeros(count, np.complex128), *blank)
    rows = np.flatnonzero((curves.subpaths == 1) & _arcs_only(curves, tolerance))
    if not len(rows):
        return result
    first = curves.offsets[rows]
    major, minor, tilt = _axes(curves)
    travelled, off = _traced(curves, major, minor, tilt)
    open_end = np.abs(2 * np.pi - travelled[rows]) * major[first]
    # A closed curve is off by the sagitta of its closing chord, an open one by what is not drawn.
    sagitta = open_end**2 / (8 * np.maximum(major[first], 1e-300))
    gap = off[rows] + np.where(curves.closed[rows], sagitta, open_end)
    good = (gap <= tolerance) & (major[first] > tolerance)
    rows, first = rows[good], first[good]
    result.full[rows] = True
    result.centre[rows] = curves.points[first, 0]
    result.major[rows], result.minor[rows] = major[first], minor[first]
    circle = major[first] - minor[first] <= tolerance
    result.angle[rows] = np.where(circle, 0.0, tilt[first])
    result.gap[rows] = gap[good]
    return result


def _arcs_only(curves: Curves, tolerance: float) -> Booleans:
    """(n,) whether all segments are arcs, negligible lines and the last line of a closed subpath
    (how much that one matters is measured later) aside.
    """
    arc = curves.kind == ARC
    line = curves.kind == LINE
    spare = line & (np.abs(curves.points[:, 1] - curves.points[:, 0]) <= tolerance / 8)
    some = np.flatnonzero((curves.counts > 1) & curves.closed)
    last = curves.offsets[some + 1] - 1
    spare[last] |= line[last]
    first = np.zeros(len(curves.counts), np.bool_)
    drawn = curves.counts > 0
    first[drawn] = arc[curves.offsets[:-1][drawn]]
    return np.asarray((_sums((~arc & ~spare).astype(np.float64), curves) == 0) & first)


def _axes(curves: Curves) -> tuple[Floats, Floats, Floats]:
    """(N,) half axes and tilt (degrees) of the ellipse under each segment, 0 for other kinds.

    An arc is centre + p exp(ia) + m exp(-ia); |p|, |m| and p m do not depend on where a starts.
    """
    arc = curves.kind == ARC
    plus, minus = _turning(curves)
    major, minor = np.abs(plus) + np.abs(minus), np.abs(np.abs(plus) - np.abs(minus))
    return major, minor, np.where(arc, np.angle(plus * minus, deg=True) / 2, 0.0)


def _turning(curves: Curves) -> tuple[Complexes, Complexes]:
    arc = curves.kind == ARC
    plus = np.where(arc, (curves.points[:, 1] - 1j * curves.points[:, 2]) / 2, 0)
    minus = np.where(arc, (curves.points[:, 1] + 1j * curves.points[:, 2]) / 2, 0)
    return plus, minus


def _traced(curves: Curves, major: Floats, minor: Floats, tilt: Floats) -> tuple[Floats, Floats]:
    """(n,) the angle travelled by each element's arcs, and how far they are from the ellipse of its
    first one; infinite if they do not all run in one direction.
    """
    arc = curves.kind == ARC
    plus, minus = _turning(curves)
    sweep = np.where(arc, curves.points[:, 3].imag * np.sign(np.abs(plus) - np.abs(minus)), 0.0)
    head = np.repeat(curves.offsets[:-1], curves.counts)  # first segment of a segment's element
    # Axes, as vectors of doubled angle, agree whatever the tilt of a circle is.
    axes = (major - minor) * np.exp(2j * np.deg2rad(tilt))
    away = np.abs(curves.points[:, 0] - curves.points[head, 0]) + np.abs(major - major[head])
    away = np.where(arc, away + np.abs(axes - axes[head]), 0.0)
    travelled = _sums(np.abs(sweep), curves)
    off = np.zeros(len(curves.counts))
    drawn = np.flatnonzero(curves.counts)
    off[drawn] = np.maximum.reduceat(away, curves.offsets[drawn])
    off[np.abs(np.abs(_sums(sweep, curves)) - travelled) > 1e-9] = np.inf
    return travelled, off


def _sums(values: Floats, curves: Curves) -> Floats:
    """(n,) sums over the segments of each element."""
    running = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(running[curves.offsets[1:]] - running[curves.offsets[:-1]])
