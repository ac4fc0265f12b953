"""The scopes of many pieces of geometry at once: their boxes along their own axes.

In go solids in the coordinates of the scope they were made in, out come corners, turns, extents and
numbers in the pool, as columns. Rectangles, which are most of what houses fall into, are found all
together; only what is none goes to the pool by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import Floats, reshaped
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.pool import SNAP, Pool

OWN = np.eye(3)
_FOUR = np.arange(4)


@dataclass(frozen=True, slots=True, eq=False)
class Framed:
    """The scopes of p pieces: corner (p, 3) and turn (p, 4) in the scope they were made in, size
    (p, 3), and the numbers of their geometries (p,).
    """

    corner: Floats
    turn: Floats
    size: Floats
    geometry: Floats


NONE = Framed(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0))


def joined(parts: Sequence[Framed]) -> Framed:
    """The scopes of several lots of pieces, one after the other."""
    if not parts:
        return NONE
    columns = (
        [getattr(part, name) for part in parts] for name in ("corner", "turn", "size", "geometry")
    )
    corner, turn, size, geometry = map(np.concatenate, columns)
    return Framed(corner, turn, size, geometry)


def framed(pool: Pool, pieces: Sequence[Piece]) -> Framed:
    """The scopes of pieces."""
    count = len(pieces)
    if not count:
        return NONE
    axes = np.array([OWN if piece.axes is None else piece.axes for piece in pieces])
    many = np.array([len(piece.solid.vertices) for piece in pieces])
    starts = np.cumsum(many) - many
    vertices = np.concatenate([piece.solid.vertices for piece in pieces])
    turned = np.einsum("vj,vij->vi", vertices, axes[np.repeat(np.arange(count), many)])
    low = np.minimum.reduceat(turned, starts, axis=0)
    size = np.maximum.reduceat(turned, starts, axis=0) - low
    size[size <= SNAP * size.max(axis=1, keepdims=True)] = 0.0
    geometry = _rectangles(pool, pieces, turned, starts, low, size)
    others = np.flatnonzero(np.isnan(geometry))
    ends = starts + many
    solids = [
        reshaped(pieces[place].solid, turned[starts[place] : ends[place]])
        for place in others.tolist()
    ]
    geometry[others] = pool.all_within(solids, low[others], size[others])
    corner = np.einsum("pi,pij->pj", low, axes)
    return Framed(corner, boxes.quaternion(axes), size, geometry)


def _rectangles(
    pool: Pool,
    pieces: Sequence[Piece],
    turned: Floats,
    starts: NDArray[np.int64],
    low: Floats,
    size: Floats,
) -> Floats:
    """The numbers of the pieces that are rectangles across their z; NaN for the others."""
    found = np.full(len(pieces), np.nan)
    four = np.array([place for place, piece in enumerate(pieces) if _has_four(piece)], np.int64)
    if len(four):
        four = four[(size[four, 2] == 0) & (size[four, :2] > 0).all(axis=1)]
    if not len(four):
        return found
    order = np.array([pieces[place].solid.corners for place in four.tolist()])
    points = turned[starts[four][:, None] + order][:, :, :2]
    unit = (points - low[four, None, :2]) / size[four, None, :2]
    near = np.round(unit)
    whole = (np.abs(unit - near) <= SNAP).all(axis=(1, 2))
    code = near[:, :, 0] + 2 * near[:, :, 1]
    whole &= (np.sort(code, axis=1) == _FOUR).all(axis=1)
    side, after = near[:, 1] - near[:, 0], near[:, 2] - near[:, 1]
    whole &= side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0] > 0.5
    numbers: dict[frozenset[str], float] = {}
    for place in four[whole].tolist():
        tags = pieces[place].solid.tags[0]
        if tags not in numbers:
            numbers[tags] = float(pool.box((tags,)))
        found[place] = numbers[tags]
    return found


def _has_four(piece: Piece) -> bool:
    solid = piece.solid
    return len(solid.corners) == 4 == len(solid.vertices) and len(solid) == 1 and solid.uv is None
