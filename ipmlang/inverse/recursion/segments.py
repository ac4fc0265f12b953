"""Segments of the straight outlines of a drawing, in paint order, y up.

In come outlines as readers give them; out come the segments of all elements one after the other,
with the element that each belongs to. A polyline counts as its segments. Nothing here looks at
styles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.formats.drawing import LINE, Outline
from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.recursion.strokes import Integers


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """start, end: (n,) x + iy, y up; element: (n,) index of the outline each is part of."""

    start: Complexes
    end: Complexes
    element: Integers


def segments(outlines: Sequence[Outline], flip: float) -> Segments | None:
    """The segments of outlines that have straight lines only, None if one has others or nothing.
    flip: y up is flip - y.
    """
    if not outlines or any(not len(each.kind) or np.any(each.kind != LINE) for each in outlines):
        return None
    coords = np.concatenate([each.coords[:, :2] for each in outlines])
    points = coords[..., 0] + 1j * (flip - coords[..., 1])
    counts = [len(each.kind) for each in outlines]
    element = np.repeat(np.arange(len(outlines)), counts).astype(np.int64)
    return Segments(points[:, 0].copy(), points[:, 1].copy(), element)
