"""What faces share: vertices at one place, edges between neighbours.

Solids come in, arrays of vertex and corner numbers go out; nothing is moved or merged here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.solid import Floats, Indices, Solid


def first_at_place(vertices: Floats, near: float = 0.0) -> Indices:
    """For each vertex (v,) the number of the first at its place.

    near: coordinates of different vertices that follow each other this closely are the same.
    """
    cells = vertices if near == 0 else np.stack([_steps(each, near) for each in vertices.T], axis=1)
    order = np.lexsort(cells.T)
    first = np.ones(len(order), bool)
    first[1:] = (cells[order[1:]] != cells[order[:-1]]).any(axis=1)
    numbers = np.empty(len(order), np.int64)
    numbers[order] = order[first][np.cumsum(first) - 1]
    return numbers


def _steps(values: Floats, near: float) -> Indices:
    """Numbers (v,) that are the same for values with no gap between them."""
    order = np.argsort(values)
    steps = np.empty(len(values), np.int64)
    steps[order] = np.cumsum(np.diff(values[order], prepend=values[order[:1]]) > near)
    return steps


def following(solid: Solid) -> Indices:
    """The corner after each corner (c,) in its ring."""
    after = np.arange(1, len(solid.corners) + 1)
    after[solid.rings[1:] - 1] = solid.rings[:-1]
    return after


def neighbours(solid: Solid) -> tuple[Indices, Indices]:
    """Corners (e,), (e,) where the two uses of an edge begin, which run opposite ways.

    Edges that more or fewer than two faces share are left out.
    """
    ahead = solid.corners[following(solid)]
    low, high = np.minimum(solid.corners, ahead), np.maximum(solid.corners, ahead)
    order = np.lexsort([solid.corners > ahead, high, low])
    key = low[order] * (len(solid.vertices) + 1) + high[order]
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    pairs = starts[np.diff(starts, append=len(key)) == 2]
    one, other = order[pairs], order[pairs + 1]
    opposite = solid.corners[one] != solid.corners[other]
    return one[opposite], other[opposite]
