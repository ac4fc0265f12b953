"""Outlines as chords: the points of polylines that stay within a tolerance of the curves.

In goes an outline of a drawing, out come the points of each subpath, in its own coordinates. All
segments of an outline are evaluated together; nothing is closed, mended or flipped here.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Floats, Outline

MOST = 4096  # chords that one segment becomes, however fine the tolerance


def chords(outline: Outline, tolerance: float) -> list[Floats]:
    """The points (n, 2) of each subpath, from its first to its last, that end included.

    No curve lies farther than `tolerance`, in the outline's units, from its chords.

    >>> kind = np.array([LINE, QUADRATIC], np.uint8)
    >>> coords = np.zeros((2, 4, 2))
    >>> coords[0, 1] = coords[1, 0] = (4, 0)
    >>> coords[1, 1], coords[1, 2] = (4, 2), (2, 2)
    >>> corner = Outline(kind, coords, np.array([0, 2], np.int32), np.array([False]))
    >>> [len(points) for points in chords(corner, 0.1)]
    [5]
    """
    if (outline.kind == LINE).all():
        spans = pairwise(outline.starts.tolist())
        return [np.concatenate([outline.coords[a:b, 0], outline.coords[b - 1 : b, 1]])
                for a, b in spans]  # fmt: skip
    counts = _counts(outline, tolerance)
    segment = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    ends = _points(outline.kind[segment], outline.coords[segment], step / counts[segment])
    begins = np.concatenate([[0], np.cumsum(counts)])
    firsts = outline.starts[:-1]
    origin = _points(outline.kind[firsts], outline.coords[firsts], np.zeros(len(firsts)))
    reaches = zip(begins[firsts], begins[outline.starts[1:]], strict=True)
    return [
        np.concatenate([origin[number : number + 1], ends[begin:end]])
        for number, (begin, end) in enumerate(reaches)
    ]


def _counts(outline: Outline, tolerance: float) -> NDArray[np.int64]:
    """Into how many chords each segment is cut."""
    kind, coords = outline.kind, outline.coords
    found = np.ones(len(kind))
    second = coords[:, 0] - 2 * coords[:, 1] + coords[:, 2]
    third = coords[:, 1] - 2 * coords[:, 2] + coords[:, 3]
    bend, other = np.hypot(*second.T), np.hypot(*third.T)
    # a chord over 1/n of the parameter is off by at most |second derivative| / (8 n n)
    most = np.select([kind == QUADRATIC, kind == CUBIC], [2 * bend, 6 * np.maximum(bend, other)])
    curved = most > 0
    found[curved] = np.ceil(np.sqrt(most[curved] / (8 * tolerance)))
    arcs = kind == ARC
    radius = _radius(coords[arcs, 1], coords[arcs, 2])
    # of a circle of radius r, a chord over the angle a is off by r (1 - cos(a / 2))
    angle = 2 * np.arccos(np.clip(1 - tolerance / np.maximum(radius, tolerance), 0, 1))
    found[arcs] = np.ceil(np.abs(coords[arcs, 3, 1]) / np.maximum(angle, 1e-6))
    return np.clip(found, 1, MOST).astype(np.int64)


def _radius(u: Floats, v: Floats) -> Floats:
    """The greater half axis of ellipses with conjugate radii u and v, (n,)."""
    squares = (u * u + v * v).sum(axis=1)
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    apart = np.sqrt(np.maximum(squares * squares - 4 * area * area, 0))
    found: Floats = np.sqrt((squares + apart) / 2)
    return found


def _points(kind: NDArray[np.uint8], coords: Floats, at: Floats) -> Floats:
    """Where segments are at a parameter from 0 to 1, (n, 2)."""
    t = at[:, None]
    s = 1 - t
    p, q, r, last = (coords[:, k] for k in range(4))
    angle = (coords[:, 3, 0] + coords[:, 3, 1] * at)[:, None]
    return np.select(
        [(kind == each)[:, None] for each in (LINE, QUADRATIC, CUBIC, ARC)],
        [
            s * p + t * q,
            s * s * p + 2 * s * t * q + t * t * r,
            s * s * s * p + 3 * s * s * t * q + 3 * s * t * t * r + t * t * t * last,
            p + np.cos(angle) * q + np.sin(angle) * r,
        ],
    )
