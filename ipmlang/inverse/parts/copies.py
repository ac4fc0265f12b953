"""Parts that may be equal, stacked so that all are compared with one at once.

Takes pieces of equal counts; gives arrays with one row a part, and tests whether a row under a map
is the model part: the same points, faces, materials and texture coordinates. Maps are about the
parts' centres. Nothing is searched here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.invariants import UV_TOLERANCE, mixed
from ipmlang.inverse.parts.pieces import Pieces

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Truths: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """k parts with v vertices, c corners, f faces each. points (k, v, 3) from their centres;
    corners (k, c) vertex of each corner; after, before (k, c) corners next to it; begin (k, f)
    first corner of each face; look (k, c) a hash of the face's material and size; uv (k, c, 2)
    where images are laid.
    """

    points: Floats
    corners: Integers
    after: Integers
    before: Integers
    begin: Integers
    look: NDArray[np.uint64]
    uv: Floats | None

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, rows: Integers | Truths | slice) -> Copies:
        return Copies(
            self.points[rows],
            self.corners[rows],
            self.after[rows],
            self.before[rows],
            self.begin[rows],
            self.look[rows],
            None if self.uv is None else self.uv[rows],
        )


def stacked(pieces: Pieces, center: Floats, rows: Integers) -> Copies:
    """Parts of equal counts as a stack."""

    def block(starts: Integers) -> Integers:
        count = starts[rows[0] + 1] - starts[rows[0]]
        return np.asarray(starts[rows][:, None] + np.arange(count))

    corner, face, vertex = (
        block(starts) for starts in (pieces.corner_start, pieces.face_start, pieces.vertex_start)
    )
    first = corner[:, :1]
    size = pieces.offsets[face + 1] - pieces.offsets[face]
    look = mixed(mixed(size.astype(np.uint64)) ^ pieces.material[face].astype(np.uint64))
    return Copies(
        pieces.vertices[vertex] - center[rows][:, None],
        pieces.corners[corner] - vertex[:, :1],
        pieces.after[corner] - first,
        pieces.before[corner] - first,
        pieces.offsets[face] - first,
        np.repeat(look.reshape(-1), size.reshape(-1)).reshape(corner.shape),
        None if pieces.laid is None else pieces.laid[corner],
    )


class Model:
    """The part that others are compared with, or one for each of them: a stack of one row or of as
    many, how far apart points may be, and what is asked again and again, made when first asked for.
    """

    def __init__(self, copies: Copies, tolerance: float) -> None:
        self.copies = copies
        self.tolerance = tolerance

    def at(self, rows: Integers) -> Model:
        """The models of these rows; the one there is stands for all."""
        return self if len(self.copies) == 1 else Model(self.copies[rows], self.tolerance)

    @cached_property
    def sorted_corners(self) -> tuple[NDArray[np.uint64], Integers]:
        """The hashes (m, c) of the corners, in order, and which corner is where in that order."""
        forward = np.ones(len(self.copies), np.bool_)
        return _corner_keys(self.copies, self.copies.corners, forward)

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.copies.points[0])

    def nearest(self, points: Floats, reach: Floats) -> tuple[Truths, Integers]:
        """Rows (k,) of points (k, p, 3) that all have a vertex within reach (k,), and which."""
        if not points.size:
            return np.zeros(len(points), np.bool_), np.zeros(points.shape[:2], np.int64)
        if len(self.copies) == 1:
            apart, index = self._tree.query(
                points, distance_upper_bound=reach.max() * (1 + 1e-9) + 1e-300
            )
        else:  # many small ones
            off = points[:, :, None] - self.copies.points[:, None]
            square = np.einsum("kpvi,kpvi->kpv", off, off)
            index = np.argmin(square, axis=2)
            apart = np.sqrt(np.take_along_axis(square, index[..., None], 2)[..., 0])
        close = np.asarray((apart <= reach[:, None]).all(axis=1), np.bool_)
        return close, np.asarray(index, np.int64)


def in_same_order(model: Model, copies: Copies, linear: Floats) -> Truths:
    """Which rows are the model under maps (k, 3, 3) that do not mirror, with all in its order."""
    one = model.copies
    kept: Truths = (copies.corners == one.corners).all(axis=1)
    kept &= (copies.look == one.look).all(axis=1)
    kept &= (copies.begin == one.begin).all(1)
    rows = np.flatnonzero(kept)
    off = copies.points[rows] @ linear[rows] - one.points
    kept[rows] = np.einsum("kvi,kvi->kv", off, off).max(axis=1) <= model.tolerance**2
    rows = np.flatnonzero(kept)
    every = np.tile(np.arange(one.corners.shape[1]), (len(rows), 1))
    kept[rows] = _dressed_alike(model, copies[rows], every, every)
    return kept


def matched(model: Model, copies: Copies, linear: Floats, slack: Floats) -> tuple[Truths, Integers]:
    """Which rows are the model under maps (k, 3, 3), and for these rows (r, v) the vertex that
    stands where the model's vertex is. slack (k,): how far off the maps may be themselves.
    """
    points = copies.points @ linear  # the inverse of a turn from the right
    near, vertex = _nearest(model, points, model.tolerance + slack)
    rows = np.flatnonzero(near)
    places = np.empty_like(vertex[rows])
    np.put_along_axis(places, vertex[rows], np.arange(vertex.shape[1])[None], axis=1)
    mirrored = np.linalg.det(linear[rows]) < 0
    chosen = copies[rows]
    corner = np.take_along_axis(vertex[rows], chosen.corners, axis=1)
    keys, order = _corner_keys(chosen, corner, ~mirrored)
    own = model.at(rows)
    own_keys, mine = own.sorted_corners
    same = (keys == own_keys).all(axis=1)
    mine = np.broadcast_to(mine, order.shape)
    kept = np.flatnonzero(same)
    same[kept] = _dressed_alike(own.at(kept), chosen[kept], mine[kept], order[kept])
    found = np.zeros(len(copies), np.bool_)
    found[rows[same]] = True
    return found, places[same]


def _nearest(model: Model, points: Floats, reach: Floats) -> tuple[Truths, Integers]:
    """Rows whose points are the model's one by one, and the model's vertex for each point."""
    count, size = points.shape[:2]
    probe = np.linspace(0, size - 1, min(size, 24)).astype(np.int64)
    near: Truths = np.ones(count, np.bool_)
    vertex = np.zeros((count, size), np.int64)
    if size > 2 * len(probe):
        near, _ = model.nearest(points[:, probe], reach)
    rows = np.flatnonzero(near)
    close, found = model.at(rows).nearest(points[rows], reach[rows])
    whole = (np.sort(found, axis=1) == np.arange(size)).all(axis=1)
    near[rows] = close & whole
    vertex[rows] = found
    return near, vertex


def _corner_keys(
    copies: Copies, vertex: Integers, forward: Truths
) -> tuple[NDArray[np.uint64], Integers]:
    """For each row the hashes of its corners in order, and which corner is where: hashes of the
    vertex with those of its face, read backwards where not `forward`.
    """
    count, size = vertex.shape
    ahead = np.take_along_axis(vertex, copies.after, axis=1)
    behind = np.take_along_axis(vertex, copies.before, axis=1)
    flip = ~forward[:, None]
    ahead, behind = np.where(flip, behind, ahead), np.where(flip, ahead, behind)
    own = mixed(vertex.astype(np.uint64))
    edge = mixed(own + mixed(ahead.astype(np.uint64)) * np.uint64(3) ^ copies.look)
    edge += mixed(behind.astype(np.uint64) * np.uint64(5) + own)
    starts = (copies.begin + size * np.arange(count)[:, None]).reshape(-1)
    face = np.add.reduceat(edge.reshape(-1), starts)
    sizes = np.diff(np.append(starts, count * size))
    keys = mixed(np.repeat(face, sizes).reshape(count, size) ^ own)
    order = np.argsort(keys, axis=1, kind="stable")
    return np.take_along_axis(keys, order, axis=1), order


def _dressed_alike(model: Model, copies: Copies, mine: Integers, theirs: Integers) -> Truths:
    """Whether texture coordinates of corners `theirs` are those of `mine` (k, c)."""
    own = model.copies.uv
    if copies.uv is None or own is None:
        return np.ones(len(copies), np.bool_)
    row = np.arange(len(own))[:, None]  # one model, or one for each
    off = np.take_along_axis(copies.uv, theirs[..., None], 1) - own[row, mine]
    return np.asarray(np.abs(off).max(axis=(1, 2)) <= UV_TOLERANCE)
