"""Exact boxes of outlines and the affine map of many outlines at once.

Boxes are (x0, y0, x1, y1) of the curves themselves, not of their control points. Batched over all
segments; nothing here loops over them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Floats, Outline

_POINTS = np.array(
    [[0, 0, 0, 0], [1, 1, 0, 0], [1, 1, 1, 0], [1, 1, 1, 1], [1, 0, 0, 0]], dtype=np.float64
)
"""Which rows of a segment are points that a map moves, by kind."""
_MAPPED = np.array(
    [[0, 0, 0, 0], [1, 1, 0, 0], [1, 1, 1, 0], [1, 1, 1, 1], [1, 1, 1, 0]], dtype=np.bool_
)
"""Which rows the linear part acts on, by kind."""


def transform_segments(kind: NDArray[np.uint8], coords: Floats, matrices: Floats) -> Floats:
    """`coords` (n, 4, 2) mapped by `matrices`: (6,) for all or (n, 6), one for each segment."""
    m = np.broadcast_to(matrices, (len(kind), 6))
    x, y = coords[..., 0], coords[..., 1]
    shift = _POINTS[kind]
    mapped = np.empty_like(coords)
    mapped[..., 0] = m[:, 0:1] * x + m[:, 2:3] * y + m[:, 4:5] * shift
    mapped[..., 1] = m[:, 1:2] * x + m[:, 3:4] * y + m[:, 5:6] * shift
    return np.where(_MAPPED[kind][..., None], mapped, coords)


def segment_ends(kind: NDArray[np.uint8], coords: Floats) -> tuple[Floats, Floats]:
    """First and last points of the segments, (n, 2) each."""
    first = coords[:, 0].copy()
    last = coords[np.arange(len(kind)), np.minimum(kind, CUBIC)].copy()
    arcs = kind == ARC
    if arcs.any():
        start, sweep = coords[arcs, 3, 0], coords[arcs, 3, 1]
        first[arcs] = _on_ellipse(coords[arcs], start)
        last[arcs] = _on_ellipse(coords[arcs], start + sweep)
    return first, last


def _on_ellipse(coords: Floats, angle: Floats) -> Floats:
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return coords[:, 0] + cosine * coords[:, 1] + sine * coords[:, 2]


def segment_tangents(kind: NDArray[np.uint8], coords: Floats) -> tuple[Floats, Floats]:
    """Unit directions in which segments leave and arrive, (n, 2) each; zero for a mere point."""
    first, last = segment_ends(kind, coords)
    leave, arrive = np.zeros_like(first), np.zeros_like(first)
    for row in (1, 2, 3):
        used = (kind >= row) & (kind != ARC)
        # The nearest control point that is not the end itself gives the direction.
        out = np.where(used[:, None], coords[:, row] - first, 0.0)
        leave = np.where((leave == 0).all(axis=1, keepdims=True), out, leave)
        back = np.clip(kind.astype(np.intp) - row, 0, 3)
        into = np.where(used[:, None], last - coords[np.arange(len(kind)), back], 0.0)
        arrive = np.where((arrive == 0).all(axis=1, keepdims=True), into, arrive)
    arcs = kind == ARC
    if arcs.any():
        rows = coords[arcs]
        start, sweep = rows[:, 3, 0], rows[:, 3, 1]
        leave[arcs] = _along_ellipse(rows, start, sweep)
        arrive[arcs] = _along_ellipse(rows, start + sweep, sweep)
    return _unit(leave), _unit(arrive)


def _along_ellipse(coords: Floats, angle: Floats, sweep: Floats) -> Floats:
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.sign(sweep)[:, None] * (cosine * coords[:, 2] - sine * coords[:, 1])


def _unit(ways: Floats) -> Floats:
    lengths = np.hypot(ways[:, 0], ways[:, 1])[:, None]
    return np.divide(ways, lengths, out=np.zeros_like(ways), where=lengths > 0)


def segment_boxes(kind: NDArray[np.uint8], coords: Floats) -> Floats:
    """(n, 4): the exact box of each segment."""
    first, last = segment_ends(kind, coords)
    low, high = np.minimum(first, last), np.maximum(first, last)
    for which, extremes in (
        (kind == QUADRATIC, _quadratic_extremes),
        (kind == CUBIC, _cubic_extremes),
        (kind == ARC, _arc_extremes),
    ):
        if which.any():
            points = extremes(coords[which])
            low[which] = np.fmin(low[which], np.fmin.reduce(points, axis=0))
            high[which] = np.fmax(high[which], np.fmax.reduce(points, axis=0))
    return np.concatenate([low, high], axis=1)


def _quadratic_extremes(coords: Floats) -> Floats:
    """(1, n, 2) values at the turning points, NaN where there is none inside."""
    a, b, c = coords[:, 0], coords[:, 1], coords[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (a - b) / (a - 2 * b + c)
        t = np.where((t > 0) & (t < 1), t, np.nan)
        return ((1 - t) ** 2 * a + 2 * t * (1 - t) * b + t * t * c)[None]


def _cubic_extremes(coords: Floats) -> Floats:
    """(2, n, 2) values at the turning points, NaN where there is none inside."""
    a, b, c, d = (coords[:, i] for i in range(4))
    p, q, r = d - a + 3 * (b - c), 2 * (a - 2 * b + c), b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(q * q - 4 * p * r)
        far = -0.5 * (q + np.copysign(root, q))
        t = np.stack([far / p, r / far])
        t = np.where((t > 0) & (t < 1), t, np.nan)
        s = 1 - t
        return s**3 * a + 3 * s * s * t * b + 3 * s * t * t * c + t**3 * d


def _arc_extremes(coords: Floats) -> Floats:
    """(2, n, 2) values at the two angles where each axis turns, NaN outside the sweep."""
    centre, u, v = coords[:, 0], coords[:, 1], coords[:, 2]
    start, sweep = coords[:, 3, 0:1], coords[:, 3, 1:2]
    angle = np.arctan2(v, u)
    points = []
    for turn in (0.0, math.pi):
        along = np.mod((angle + turn - start) * np.sign(sweep), math.tau)
        reach = np.hypot(u, v) * (1.0 if turn == 0.0 else -1.0)
        points.append(np.where(along <= np.abs(sweep), centre + reach, np.nan))
    return np.stack(points)


def outline_box(outline: Outline) -> tuple[float, float, float, float]:
    """(x, y, width, height) of an outline, as SVG's bounding box."""
    boxes = segment_boxes(outline.kind, outline.coords)
    x0, y0 = boxes[:, :2].min(axis=0)
    x1, y1 = boxes[:, 2:].max(axis=0)
    return float(x0), float(y0), float(x1 - x0), float(y1 - y0)


def place(outline: Outline, matrix: tuple[float, ...]) -> Outline:
    """The outline mapped by (a, b, c, d, e, f)."""
    coords = transform_segments(outline.kind, outline.coords, np.array(matrix))
    return Outline(outline.kind, coords, outline.starts, outline.closed)


assert LINE == 1  # The tables above are indexed by kind.
