"""Where lines across x or y cut a polygon into pieces of given areas.

How much area lies before a line is a quadratic of the line's place between two corners, so the
lines are found by solving it, not by searching.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.geometry.planar import opened
from ipmlang.geometry.solid import Floats, Solid

AXES = {"x": 0, "y": 1}


def area_cuts(polygon: Solid, axis: str, areas: Sequence[float]) -> Floats:
    """Where along x or y pieces of these areas, one after the other, begin and end (n + 1,).

    Areas below 0 are none. What is left beyond the last one makes no piece, a last one that is not
    all there makes a smaller piece. Raises `GeometryError` for what is no level polygon.

    >>> from ipmlang.geometry import solid
    >>> area_cuts(solid.unit_square(), "x", [0.25, 1]).tolist()
    [0.0, 0.25, 1.0]
    """
    rings, _ = opened(polygon, "split")
    along = AXES[axis]
    upto = np.cumsum([0.0, *(max(0.0, each) for each in areas)])
    turned = rings if along == 0 else [ring[:, ::-1] for ring in rings]
    sign = 1.0 if along == 0 else -1.0
    start = np.concatenate(turned)
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in turned])
    stops = np.unique(start[:, 0])
    whole = sign * float(_before(start, end, stops[-1:])[0])
    upto = np.where(upto >= whole * (1 - 1e-14), whole, upto)
    return _places(start, end, sign, stops, np.clip(upto, 0.0, whole))


def _before(start: Floats, end: Floats, lines: Floats) -> Floats:
    """The area to the left of lines x = … (m,): the sum over edges of min(x, line) dy.

    (Green's theorem, for the field that is min(x, line) along x.)
    """
    origin = start[:, 0].min()
    x0, x1 = start[:, 0] - origin, end[:, 0] - origin
    height = end[:, 1] - start[:, 1]
    line = (lines - origin)[:, None]
    low, high = np.minimum(x0, x1), np.maximum(x0, x1)
    span = np.where(high > low, high - low, 1.0)
    share = np.clip((line - low) / span, 0.0, 1.0)  # of the edge, to the left of the line
    mean = share * (low + (np.clip(line, low, high) - low) / 2) + (1 - share) * line
    mean = np.where(line >= high, (low + high) / 2, np.where(line <= low, line, mean))
    found: Floats = (mean * height).sum(axis=1)
    return found


def _places(start: Floats, end: Floats, sign: float, stops: Floats, areas: Floats) -> Floats:
    """Where so much area (k,) lies before each line: between the two stops that have it between
    them, which are found by halving, by the quadratic that the area is there.
    """
    low = np.zeros(len(areas), np.int64)
    high = np.full(len(areas), len(stops) - 1)
    first = np.zeros(len(areas))
    last = np.repeat(sign * _before(start, end, stops[-1:]), len(areas))
    while (high - low > 1).any():
        middle = (low + high) // 2
        here = sign * _before(start, end, stops[middle])
        enough = here >= areas
        high, last = np.where(enough, middle, high), np.where(enough, here, last)
        low, first = np.where(enough, low, middle), np.where(enough, first, here)
    begin, until = stops[low], stops[high]
    half = sign * _before(start, end, (begin + until) / 2)
    want = areas - first
    # first + b t + c t², with t from 0 to 1 between the stops
    c = 2 * (last - 2 * half + first)
    b = last - first - c
    root = np.sqrt(np.maximum(b * b + 4 * c * want, 0.0))
    share = np.divide(2 * want, b + root, out=np.ones(len(areas)), where=b + root > 0)
    place = begin + (until - begin) * np.clip(share, 0.0, 1.0)
    found: Floats = np.where(areas <= 0.0, stops[0], np.where(areas == last, until, place))
    return found
