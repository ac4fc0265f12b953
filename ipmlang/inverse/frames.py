"""Placements in space as columns: position, turn, handedness and scale, one row a copy.

A frame maps a symbol's own coordinates to those around it as the language does: local x is
mirrored where the hand is -1, then everything is scaled, turned and moved. Nothing here knows what
is placed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]

_HIGH = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], np.bool_)


def _products() -> Floats:
    """(16, 9) how often each product of two components counts in each entry of a turn's matrix."""
    table = np.zeros((4, 4, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[j + 1, j + 1, i, i] = table[k + 1, k + 1, i, i] = -2.0
        table[i + 1, j + 1, i, j] = table[i + 1, j + 1, j, i] = 2.0
        table[0, k + 1, i, j], table[0, k + 1, j, i] = -2.0, 2.0
    return table.reshape(16, 9)


def _terms() -> Floats:
    """(9, 16) how often each entry of a turn's matrix counts in four times each product of two
    components; what is squared has 1 to be added.
    """
    table = np.zeros((3, 3, 4, 4))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        table[i, i, 0, 0] = table[i, i, i + 1, i + 1] = 1.0
        table[i, i, j + 1, j + 1] = table[i, i, k + 1, k + 1] = -1.0
        table[k, j, 0, i + 1] = table[k, j, i + 1, 0] = 1.0
        table[j, k, 0, i + 1] = table[j, k, i + 1, 0] = -1.0
        table[i, j, i + 1, j + 1] = table[i, j, j + 1, i + 1] = 1.0
        table[j, i, i + 1, j + 1] = table[j, i, j + 1, i + 1] = 1.0
    return table.reshape(9, 16)


_PRODUCTS, _TERMS = _products(), _terms()
_STILL = np.eye(3).ravel()
_BLOCK = 1024  # rows of a product of matrices for which no more processors are woken up
_BENT = np.where(np.eye(3) > 0, 1e-5, 1e-12)  # how far a square may be off that of a turn
_BACK = np.array([1.0, -1.0, -1.0, -1.0])
_OTHER = np.array([[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]])
"""For each component of a product of quaternions the second's components, by the first's order."""
_SIGN = np.array([[1.0, -1, -1, -1], [1, 1, 1, -1], [1, -1, 1, 1], [1, 1, -1, 1]])


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """n placements: around = position + scale * R(rotation) * diag(hand, 1, 1) * own.

    position (n, 3); rotation (n, 4) unit quaternions w, x, y, z, w >= 0; hand (n,) 1.0 or -1.0;
    scale (n,) > 0.
    """

    position: Floats
    rotation: Floats
    hand: Floats
    scale: Floats

    def __len__(self) -> int:
        return len(self.hand)

    def __getitem__(self, rows: Integers | NDArray[np.bool_] | slice) -> Frames:
        return Frames(self.position[rows], self.rotation[rows], self.hand[rows], self.scale[rows])


def identity(count: int = 1) -> Frames:
    """Everything where it is."""
    turn = np.zeros((count, 4))
    turn[:, 0] = 1.0
    return Frames(np.zeros((count, 3)), turn, np.ones(count), np.ones(count))


def moved_to(position: Floats) -> Frames:
    """Plain translations to (n, 3)."""
    position = np.asarray(position, np.float64).reshape(-1, 3)
    return Frames(position, *_rest(identity(len(position))))


def _rest(frames: Frames) -> tuple[Floats, Floats, Floats]:
    return frames.rotation, frames.hand, frames.scale


def join(parts: Sequence[Frames]) -> Frames:
    """The rows of all, one after the other."""
    if not parts:
        return identity(0)
    return Frames(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.rotation for part in parts]),
        np.concatenate([part.hand for part in parts]),
        np.concatenate([part.scale for part in parts]),
    )


def chosen(which: NDArray[np.bool_], one: Frames, other: Frames) -> Frames:
    """Row by row (n,) one or the other."""
    return Frames(
        np.where(which[:, None], one.position, other.position),
        np.where(which[:, None], one.rotation, other.rotation),
        np.where(which, one.hand, other.hand),
        np.where(which, one.scale, other.scale),
    )


def linear(frames: Frames) -> Floats:
    """(n, 3, 3) what frames do to directions."""
    turned = turns(frames.rotation)
    turned *= frames.scale[:, None, None]
    turned[:, :, 0] *= frames.hand[:, None]
    return turned


def turns(rotation: Floats) -> Floats:
    """(n, 3, 3) matrices of unit quaternions (n, 4)."""
    products = (rotation[:, :, None] * rotation[:, None]).reshape(-1, 16)
    if len(products) <= _BLOCK:
        entries = products @ _PRODUCTS
    else:
        blocks = [products[k : k + _BLOCK] @ _PRODUCTS for k in range(0, len(products), _BLOCK)]
        entries = np.concatenate(blocks)
    entries += _STILL
    return np.asarray(entries.reshape(-1, 3, 3))


def matrices(frames: Frames) -> Floats:
    """(n, 3, 4) the same maps as matrices."""
    return np.concatenate([linear(frames), frames.position[:, :, None]], axis=2)


def from_matrices(matrix: Floats) -> Frames:
    """The frames of similarity maps (n, 3, 4); of any other map the nearest turn."""
    matrix = np.asarray(matrix, np.float64).reshape(-1, 3, 4)
    own = matrix[:, :, :3].copy()
    volume = np.linalg.det(own)
    hand = np.where(volume < 0, -1.0, 1.0)
    own[:, :, 0] *= hand[:, None]
    return Frames(matrix[:, :, 3].copy(), quaternions(own), hand, np.cbrt(np.abs(volume)))


def quaternions(turn: Floats) -> Floats:
    """(n, 4) unit quaternions, the first component that is not 0 positive, of matrices (n, 3, 3)
    that do not mirror; of those that do more than turn, of the nearest turn.
    """
    square = turn @ turn.transpose(0, 2, 1)
    bent = (np.abs(square - np.eye(3)) > _BENT).any(axis=(1, 2))
    if bent.any():
        left, _, right = np.linalg.svd(turn[bent])
        turn = turn.copy()
        turn[bent] = left @ right
    terms = turn.reshape(-1, 9) @ _TERMS
    terms[:, ::5] += 1.0
    ways = terms.reshape(-1, 4, 4)  # each row the quaternion, the longer the better it is known
    row = np.arange(len(ways))
    best = ways[row, np.argmax(terms[:, ::5], axis=1)]
    best = best / np.sqrt((best * best).sum(axis=1))[:, None]
    sign = np.where(best[row, np.argmax(best != 0, axis=1)] < 0, -1.0, 1.0)
    return np.asarray(best * sign[:, None] + 0.0)


def about(axis: Floats, degrees: Floats) -> Floats:
    """(n, 4) quaternions of turns by angles (n,) about a unit axis (3,)."""
    half = np.radians(degrees) / 2
    return np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)


def apply(frames: Frames, points: Floats) -> Floats:
    """Points (n, 3), one for each frame, in the coordinates around."""
    return np.asarray(np.einsum("nij,nj->ni", linear(frames), points) + frames.position)


def spread(frames: Frames, points: Floats) -> Floats:
    """Points (k, 3) under every frame: (n, k, 3)."""
    return np.asarray(np.einsum("nij,kj->nki", linear(frames), points) + frames.position[:, None])


def corners(frames: Frames, low: Floats, high: Floats) -> Floats:
    """(n, 8, 3) the corners of boxes, (n, 3) or one (3,) for all, in the coordinates around."""
    own = np.where(_HIGH, high[..., None, :], low[..., None, :])
    return np.asarray(
        np.einsum("nij,nkj->nki", linear(frames), np.broadcast_to(own, (len(frames), 8, 3)))
        + frames.position[:, None]
    )


def around(frames: Frames, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """(n, 3) low and high of the boxes, along the axes around, that hold such boxes."""
    placed = corners(frames, low, high)
    return placed.min(axis=1), placed.max(axis=1)


def compose(outer: Frames, inner: Frames) -> Frames:
    """Row by row, what `inner` places placed by `outer`; one row stands for as many as needed."""
    if len(outer) in (1, len(inner)) and _moves_only(outer):
        position = inner.position + outer.position + 0.0
        return Frames(position, canonical(inner.rotation), inner.hand, inner.scale)
    only_moves = _moves_only(inner)
    outer, inner = _matched(outer, inner)
    return Frames(
        apply(outer, inner.position),
        canonical(outer.rotation) if only_moves else _turned(outer, inner),
        outer.hand * inner.hand,
        outer.scale * inner.scale,
    )


def _moves_only(frames: Frames) -> bool:
    """Whether frames neither turn nor mirror nor scale."""
    turned = frames.rotation[:, 1:].any() or (frames.hand < 0).any()
    return not (turned or (frames.scale != 1.0).any())


def _turned(outer: Frames, inner: Frames) -> Floats:
    """The turns of what `inner` turns turned by `outer`."""
    turned = inner.rotation
    if (outer.hand < 0).any():
        turned = turned.copy()
        turned[:, 2:] *= outer.hand[:, None]  # turns about y and z go the other way in a mirror
    return canonical(multiply(outer.rotation, turned))


def _matched(a: Frames, b: Frames) -> tuple[Frames, Frames]:
    if len(a) == len(b):
        return a, b
    one = np.zeros(max(len(a), len(b)), np.int64)
    return (a[one], b) if len(a) == 1 else (a, b[one])


def inverse(frames: Frames) -> Frames:
    """The frames that undo these."""
    back = frames.rotation * _BACK
    back[:, 2:] *= frames.hand[:, None]
    undone = Frames(frames.position, canonical(back), frames.hand, 1 / frames.scale)
    moved = np.einsum("nij,nj->ni", linear(undone), -frames.position) + 0.0
    return Frames(moved, undone.rotation, undone.hand, undone.scale)


def multiply(a: Floats, b: Floats) -> Floats:
    """Products (n, 4) of quaternions."""
    terms = a[:, None] * (b[:, _OTHER] * _SIGN)
    return np.asarray(terms[:, :, 0] + terms[:, :, 1] + terms[:, :, 2] + terms[:, :, 3])


def canonical(rotation: Floats) -> Floats:
    """The one of q and -q whose first component that is not 0 is positive."""
    if (rotation[:, 0] > 1e-9).all():
        return rotation + 0.0
    near = np.where(np.abs(rotation) > 1e-9, rotation, 0.0)
    first = np.argmax(near != 0, axis=1)
    sign = np.where(near[np.arange(len(near)), first] < 0, -1.0, 1.0)
    return rotation * sign[:, None] + 0.0
