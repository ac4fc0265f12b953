"""The curves of many elements stacked into flat complex columns, so that numpy sees them at once.

In come outlines of `formats.drawing`, out go columns, points along the curves and
moved outlines. A point (x, y) is the number x + iy. An arc keeps its four numbers: centre, u, v and
start + i sweep, so only the first three move with the curve. Nothing here compares or groups.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Outline
from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames, mirrored

# Which of the four points of each kind of segment are places, which stay when a curve is moved.
PLACES = np.zeros((5, 4))
for _code, _used in ((LINE, 2), (QUADRATIC, 3), (CUBIC, 4), (ARC, 1)):
    PLACES[_code, :_used] = 1.0

Integers = NDArray[np.int64]
Booleans = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """n elements with N segments in all.

    kind: (N,) uint8; points: (N, 4) complex; offsets: (n + 1,) first segment of each element;
    subpaths: (n,) how many subpaths an element has; closed: (n,) whether all of them are closed.
    """

    kind: NDArray[np.uint8]
    points: Complexes
    offsets: Integers
    subpaths: Integers
    closed: Booleans

    @property
    def counts(self) -> Integers:
        """(n,) segments of each element."""
        return np.diff(self.offsets)


def stack(outlines: Sequence[Outline], flip: float | None = None) -> Curves:
    """Columns of the outlines; with `flip` every y becomes flip - y."""
    counts = [len(outline.kind) for outline in outlines]
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    if offsets[-1]:
        kind = np.concatenate([outline.kind for outline in outlines])
        coords = np.concatenate([outline.coords for outline in outlines])
    else:
        kind, coords = np.zeros(0, np.uint8), np.zeros((0, 4, 2))
    points = coords[..., 0] + 1j * coords[..., 1]
    if flip is not None:
        points = flipped(kind, points, flip)
    subpaths = np.array([len(outline.closed) for outline in outlines], np.int64)
    closed = np.array([bool(outline.closed.all()) for outline in outlines], np.bool_)
    return Curves(kind, points, offsets, subpaths, closed & (subpaths > 0))


def flipped(kind: NDArray[np.uint8], points: Complexes, height: float) -> Complexes:
    """Points with y replaced by height - y (arc vectors by -y, arc angles kept)."""
    arc = kind == ARC
    result = np.conj(points) + 1j * height
    result[arc, 1:3] = np.conj(points[arc, 1:3])
    result[arc, 3] = points[arc, 3]
    # What a kind does not use stays zero, as the format promises.
    result[kind == LINE, 2:] = 0
    result[kind == QUADRATIC, 3] = 0
    return result


def evaluate(kind: NDArray[np.uint8], points: Complexes, at: Floats) -> Complexes:
    """(N, T) points of N segments at parameters 0..1, the same (T,) for all or (N, T) of their own.

    >>> line = np.array([[0, 4, 0, 0]], complex)
    >>> evaluate(np.array([LINE], np.uint8), line, np.array([0.25])).tolist()
    [[(1+0j)]]
    """
    t = np.broadcast_to(at, (len(kind), np.shape(at)[-1]))
    result = np.zeros(t.shape, np.complex128)
    for code, basis in ((LINE, _line), (QUADRATIC, _quadratic), (CUBIC, _cubic), (ARC, _arc)):
        rows = kind == code
        if rows.any():
            result[rows] = basis(points[rows], t[rows])
    return result


def _line(p: Complexes, t: Floats) -> Complexes:
    # Both ends come out exactly, which `start + t * step` does not promise.
    return p[:, :1] * (1 - t) + p[:, 1:2] * t


def _quadratic(p: Complexes, t: Floats) -> Complexes:
    s = 1 - t
    return p[:, :1] * s**2 + p[:, 1:2] * (2 * s * t) + p[:, 2:3] * t**2


def _cubic(p: Complexes, t: Floats) -> Complexes:
    s = 1 - t
    outer = p[:, :1] * s**3 + p[:, 3:4] * t**3
    return np.asarray(outer + p[:, 1:2] * (3 * s**2 * t) + p[:, 2:3] * (3 * s * t**2))


def _arc(p: Complexes, t: Floats) -> Complexes:
    angle = p[:, 3:4].real + p[:, 3:4].imag * t
    return p[:, :1] + p[:, 1:2] * np.cos(angle) + p[:, 2:3] * np.sin(angle)


def diagonal_of(box: tuple[float, float, float, float] | None, curves: Curves) -> float:
    """The unit of tolerances: the diagonal of the viewBox, else of what is drawn, else 1."""
    if box is not None and 0 < np.hypot(box[2], box[3]) < np.inf:
        return float(np.hypot(box[2], box[3]))
    along = evaluate(curves.kind, curves.points, np.linspace(0.0, 1.0, 5)).ravel()
    along = along[np.isfinite(along)]
    if not len(along):
        return 1.0
    return float(np.hypot(np.ptp(along.real), np.ptp(along.imag))) or 1.0


def moved(outline: Outline, frame: Frames) -> Outline:
    """The outline under one frame (arrays of shape (1,) or ()), handedness included."""
    position, factor = frame.position.reshape(()), frame.factor.reshape(())
    hand = frame.handedness.reshape(())
    points = outline.coords[..., 0] + 1j * outline.coords[..., 1]
    local = factor * mirrored(points, hand)
    result = local + position
    arc = outline.kind == ARC
    result[arc, 1:3], result[arc, 3] = local[arc, 1:3], points[arc, 3]
    result[outline.kind == LINE, 2:] = 0
    result[outline.kind == QUADRATIC, 3] = 0
    return Outline(outline.kind, _pairs(result), outline.starts, outline.closed)


def outline_at(curves: Curves, element: int, like: Outline, origin: complex) -> Outline:
    """One element as an outline about an origin, with the subpaths of `like`, its source."""
    rows = slice(int(curves.offsets[element]), int(curves.offsets[element + 1]))
    points = curves.points[rows] - origin * PLACES[like.kind]
    return Outline(like.kind, _pairs(points), like.starts, like.closed)


def segment_line(length: float) -> Outline:
    """The segment from the origin to (length, 0)."""
    coords = np.zeros((1, 4, 2))
    coords[0, 1, 0] = length
    return _single(LINE, coords, False)


def full_ellipse(major: float, minor: float) -> Outline:
    """The ellipse about the origin with its long axis along x."""
    coords = np.array([[[0.0, 0.0], [major, 0.0], [0.0, minor], [0.0, 2 * np.pi]]])
    return _single(ARC, coords, True)


def _single(kind: int, coords: Floats, closed: bool) -> Outline:
    starts = np.array([0, 1], np.int32)
    return Outline(np.array([kind], np.uint8), coords, starts, np.array([closed]))


def _pairs(points: Complexes) -> Floats:
    return np.ascontiguousarray(points).view(np.float64).reshape(*points.shape, 2)
