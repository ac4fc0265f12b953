"""Pairs of oriented boxes: does one lie in the other, do they overlap, touch, how far apart.

In go boxes row by row, out come truth values and distances; no loop goes over pairs. A box may have
no extent along some axes: rectangles, segments and points are boxes, too, and what two of them have
in common counts by their own dimension. Separating axes: Gottschalk, Lin and Manocha, "OBBTree"
(1996), section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats

Flags = NDArray[np.bool_]
NEAR = 1e-9  # of the size of a pair: what is so near is at one place
PARALLEL = 1e-9  # the sine of the angle between axes that count as parallel
BLOCK = 1 << 14  # pairs worked on at once
_SIGNS = np.array([[(k >> a & 1) * 2 - 1 for a in range(3)] for k in range(8)], np.float64)
_EDGES = np.array([(k, k | 1 << a) for a in range(3) for k in range(8) if not k >> a & 1])


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """n boxes: the middle (n, 3), the axes as rows (n, 3, 3) of unit vectors, and half of the
    extents (n, 3).
    """

    middle: Floats
    axes: Floats
    half: Floats

    def __len__(self) -> int:
        return len(self.middle)

    def take(self, rows: NDArray[np.int64] | slice) -> Boxes:
        """Some of the boxes."""
        return Boxes(self.middle[rows], self.axes[rows], self.half[rows])

    def bounds(self) -> tuple[Floats, Floats]:
        """The corners (n, 3) of the boxes along the world's axes around them."""
        reach: Floats = np.einsum("nk,nkc->nc", self.half, np.abs(self.axes))
        low: Floats = self.middle - reach
        high: Floats = self.middle + reach
        return low, high

    def corners(self) -> Floats:
        """The eight corners of each (n, 8, 3)."""
        steps: Floats = np.einsum("sk,nk,nkc->nsc", _SIGNS, self.half, self.axes)
        steps = np.einsum("sk,nk,nkc->nsc", _SIGNS, self.half, self.axes)
        corners: Floats = self.middle[:, None] + steps
        return corners


def tolerances(a: Boxes, b: Boxes) -> Floats:
    """The distance (n,) below which things of a pair are at one place."""
    size = 2 * np.maximum(a.half.max(axis=1), b.half.max(axis=1))
    far = np.maximum(np.abs(a.middle).max(axis=1), np.abs(b.middle).max(axis=1))
    near: Floats = NEAR * size + 1e-13 * far
    return near


def lies_within(a: Boxes, b: Boxes) -> Flags:
    """Whether each box of `a` lies in its partner (n,), whose boundary belongs to it."""
    found = np.empty(len(a), np.bool_)
    for start in range(0, len(a), BLOCK):
        rows = slice(start, start + BLOCK)
        one, other = a.take(rows), b.take(rows)
        local = np.einsum("nsc,nkc->nsk", one.corners() - other.middle[:, None], other.axes)
        room = other.half + tolerances(one, other)[:, None]
        found[rows] = (np.abs(local) <= room[:, None]).all(axis=(1, 2))
    return found


def meetings(a: Boxes, b: Boxes) -> tuple[Flags, Flags]:
    """Whether the insides of each pair overlap (n,), and whether nothing separates them (n,)."""
    overlap, meet = np.empty(len(a), np.bool_), np.empty(len(a), np.bool_)
    for start in range(0, len(a), BLOCK):
        rows = slice(start, start + BLOCK)
        overlap[rows], meet[rows] = _meet(a.take(rows), b.take(rows))
    return overlap, meet


def _meet(a: Boxes, b: Boxes) -> tuple[Flags, Flags]:
    across = np.cross(a.axes[:, :, None], b.axes[:, None]).reshape(len(a), 9, 3)
    length = np.linalg.norm(across, axis=2, keepdims=True)
    known = np.concatenate([np.ones((len(a), 6), np.bool_), length[:, :, 0] > PARALLEL], axis=1)
    across = across / np.where(length > PARALLEL, length, 1.0)
    axes = np.concatenate([a.axes, b.axes, across], axis=1)
    apart = np.abs(np.einsum("nxc,nc->nx", axes, b.middle - a.middle))
    reach = [
        np.einsum("nk,nxk->nx", box.half, np.abs(np.einsum("nxc,nkc->nxk", axes, box.axes)))
        for box in (a, b)
    ]
    near = tolerances(a, b)[:, None]
    deep = reach[0] + reach[1] - apart
    flat = (reach[0] <= near) & (reach[1] <= near) & (apart <= near)  # both in one plane
    overlap = (flat | (deep > near) | ~known).all(axis=1)
    return overlap, ((deep >= -near) | ~known).all(axis=1)


def distances(a: Boxes, b: Boxes) -> Floats:
    """The distance of each pair (n,), 0 where they meet."""
    found = np.zeros(len(a))
    turn = np.abs(np.einsum("nkc,nlc->nkl", a.axes, b.axes))
    aligned = (np.minimum(turn, np.abs(1 - turn)) <= PARALLEL).all(axis=(1, 2))
    rows = np.flatnonzero(aligned)
    found[rows] = _aligned(a.take(rows), b.take(rows), turn[rows])
    rows = np.flatnonzero(~aligned)
    for start in range(0, len(rows), BLOCK // 8):
        some = rows[start : start + BLOCK // 8]
        found[some] = _turned(a.take(some), b.take(some))
    return found


def _aligned(a: Boxes, b: Boxes, turn: Floats) -> Floats:
    """Where the axes of both are parallel, the distance is that of intervals on each."""
    apart = np.abs(np.einsum("nkc,nc->nk", a.axes, b.middle - a.middle))
    reach = a.half + np.einsum("nkl,nl->nk", np.round(turn), b.half)
    found: Floats = np.linalg.norm(np.maximum(apart - reach, 0.0), axis=1)
    return found


def _turned(a: Boxes, b: Boxes) -> Floats:
    """The least distance of corners from boxes and of edges from edges."""
    meet = _meet(a, b)[1]
    best = np.minimum(_to_box(a, b), _to_box(b, a))
    rows = np.flatnonzero(~meet)
    one, other = a.take(rows).corners()[:, _EDGES], b.take(rows).corners()[:, _EDGES]
    edges = segment_distances(one[:, :, None], other[:, None])
    best[rows] = np.minimum(best[rows], edges.min(axis=(1, 2)))
    return np.where(meet, 0.0, best)


def _to_box(a: Boxes, b: Boxes) -> Floats:
    """The least distance of the corners of `a` from `b`."""
    local = np.einsum("nsc,nkc->nsk", a.corners() - b.middle[:, None], b.axes)
    out = np.maximum(np.abs(local) - b.half[:, None], 0.0)
    found: Floats = np.linalg.norm(out, axis=2).min(axis=1)
    return found


def segment_distances(a: Floats, b: Floats) -> Floats:
    """The distances of segments (…, 2, 3) of each pair (Ericson, "Real-Time Collision Detection",
    5.1.9): the nearest points are clamped to one segment, then to the other.
    """
    along, across = a[..., 1, :] - a[..., 0, :], b[..., 1, :] - b[..., 0, :]
    apart = a[..., 0, :] - b[..., 0, :]
    aa, bb, ab = _dot(along, along), _dot(across, across), _dot(along, across)
    ac, bc = _dot(along, apart), _dot(across, apart)
    both = aa * bb - ab * ab
    first = np.clip(_over(ab * bc - ac * bb, both), 0.0, 1.0)
    second = _over(ab * first + bc, bb)
    held = np.clip(second, 0.0, 1.0)
    again = np.clip(_over(ab * held - ac, aa), 0.0, 1.0)
    first = np.where(second == held, first, again)
    gap = apart + first[..., None] * along - held[..., None] * across
    return np.sqrt(_dot(gap, gap))


def _dot(a: Floats, b: Floats) -> Floats:
    found: Floats = np.einsum("...c,...c->...", a, b)
    return found


def _over(a: Floats, b: Floats) -> Floats:
    large = b > 1e-12 * np.max(b, initial=1e-300)
    return np.divide(a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape)), where=large)
