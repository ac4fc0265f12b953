"""Outlines for tests, and the points that curves have at equal parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import (
    ARC,
    CUBIC,
    LINE,
    QUADRATIC,
    Drawing,
    DrawnElement,
    Outline,
    Style,
)


def outline(kinds: Sequence[int], rows: Sequence[Sequence[float]], closed: bool = False) -> Outline:
    """One subpath; a row has the numbers of `coords` of one segment, padded with zeros."""
    coords = np.zeros((len(kinds), 4, 2))
    for place, row in zip(coords, rows, strict=True):
        place.reshape(-1)[: len(row)] = row
    starts = np.array([0, len(kinds)], np.int32)
    return Outline(np.array(kinds, np.uint8), coords, starts, np.array([closed]))


def drawing(
    *outlines: Outline, box: tuple[float, float, float, float] = (0, 0, 100, 100)
) -> Drawing:
    """A drawing of outlines in the plainest style."""
    return Drawing(tuple(DrawnElement(each, Style()) for each in outlines), box)


def points(one: Outline, count: int = 17) -> NDArray[np.float64]:
    """(count, n, 2) points of each segment at equal parameters."""
    t = np.linspace(0, 1, count)[:, None]
    out = np.zeros((count, len(one.kind), 2))
    for index, (kind, row) in enumerate(zip(one.kind.tolist(), one.coords, strict=True)):
        p, q, r, s = row
        match kind:
            case k if k == LINE:
                out[:, index] = p * (1 - t) + q * t
            case k if k == QUADRATIC:
                out[:, index] = p * (1 - t) ** 2 + 2 * q * t * (1 - t) + r * t**2
            case k if k == CUBIC:
                u = 1 - t
                out[:, index] = p * u**3 + 3 * q * t * u**2 + 3 * r * t**2 * u + s * t**3
            case k if k == ARC:
                angle = s[0] + s[1] * t
                out[:, index] = p + q * np.cos(angle) + r * np.sin(angle)
    return out
