"""Which parts are one shape, and where each stands.

Takes pieces; gives classes of equal parts with a representative each and the map to every member,
as plain as the class's symmetry allows. Every placement is proved; parts that only look alike are
told apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.formats.distinct import distinct_rows
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.aligning import aligned
from ipmlang.inverse.parts.averaging import Placed, averaged, decimals_of
from ipmlang.inverse.parts.copies import Model, stacked
from ipmlang.inverse.parts.invariants import alike, centers
from ipmlang.inverse.parts.pieces import Pieces
from ipmlang.inverse.parts.plainest import plainest, snapped
from ipmlang.inverse.parts.symmetry import SelfMaps, self_maps

MOST_SYMMETRY = 192
_SMALL = 32  # vertices of parts that are looked at many at a time
_TOGETHER = 500


@dataclass(frozen=True, slots=True, eq=False)
class ShapeClass:
    """Equal parts. rows (k,): which; model: the row that stands for all; linear (k, 3, 3): from the
    shape to each, about their centres; symmetry (s, 3, 3): of the shape about its centre; whole:
    whether that is all of it; misfit (k,); shape (v, 3): the corners that stand for all, from the
    model's centre and in its order, None for its own; shift (k, 3): what members are moved by
    beside their centres.
    """

    rows: Integers
    model: int
    linear: Floats
    symmetry: Floats
    whole: bool
    misfit: Floats
    shape: Floats | None
    shift: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Classes:
    """shape (n,) into classes; center (n, 3) of each part."""

    shape: Integers
    center: Floats
    classes: tuple[ShapeClass, ...]


def classified(pieces: Pieces, tolerance: float) -> Classes:
    """The classes of all parts, in the order of their first members. tolerance: how far apart
    vertices of equal parts may be, a length.
    """
    center = centers(pieces)
    groups = alike(pieces, center, tolerance)
    lone = np.array([group[0] for group in groups if len(group) == 1], np.int64)
    found = _lone_classes(pieces, center, lone, tolerance)
    for group in groups:
        rest = group if len(group) > 1 else group[:0]
        while len(rest):
            one, rest = _first_class(pieces, center, rest, tolerance)
            found.append(one)
    found.sort(key=lambda each: int(each.rows[0]))
    shape = np.zeros(len(pieces), np.int64)
    for number, each in enumerate(found):
        shape[each.rows] = number
    return Classes(shape, center, tuple(found))


def _lone_classes(
    pieces: Pieces, center: Floats, rows: Integers, tolerance: float
) -> list[ShapeClass]:
    """Classes of parts that nothing is like, small ones of equal counts together."""
    if not len(rows):
        return []
    starts = (pieces.vertex_start, pieces.corner_start, pieces.face_start)
    counts = np.stack([start[rows + 1] - start[rows] for start in starts], axis=1)
    apart = np.where(counts[:, :1] > _SMALL, rows[:, None], -1)
    _, kind = distinct_rows(np.concatenate([counts, apart], axis=1).astype(np.float64))
    order = np.argsort(kind, kind="stable")
    found = []
    for group in np.split(rows[order], np.flatnonzero(np.diff(kind[order])) + 1):
        for begin in range(0, len(group), _TOGETHER):
            some = group[begin : begin + _TOGETHER]
            models = Model(stacked(pieces, center, some), tolerance)
            own = self_maps(models, MOST_SYMMETRY)
            found += [_lone_class(row, maps) for row, maps in zip(some, own, strict=True)]
    return found


def _lone_class(row: int, own: SelfMaps) -> ShapeClass:
    alone, still = np.array([row], np.int64), np.eye(3)[None]
    return ShapeClass(
        alone, int(row), still, own.linear, own.whole, np.zeros(1), None, np.zeros((1, 3))
    )


def _first_class(
    pieces: Pieces, center: Floats, rows: Integers, tolerance: float
) -> tuple[ShapeClass, Integers]:
    """The class of the first of the rows, and the rows that are not of it."""
    copies = stacked(pieces, center, rows)
    model = Model(copies[:1], tolerance)
    own = self_maps(model, MOST_SYMMETRY)[0]
    alignment = aligned(model, copies)
    members = np.flatnonzero(alignment.found)
    order = alignment.places[members]
    points = np.take_along_axis(copies.points[members], order[..., None], 1)
    fitted = _Fitted(points, order, alignment.linear[members])
    return _settled(pieces, center, model, own, fitted, rows[members]), rows[~alignment.found]


@dataclass(frozen=True, slots=True, eq=False)
class _Fitted:
    """Members on the model: points (k, v, 3), those of each that stand for the model's; order
    (k, v): which these are; linear (k, 3, 3), what brings the model's there.
    """

    points: Floats
    order: Integers
    linear: Floats


def _settled(
    pieces: Pieces, center: Floats, model: Model, own: SelfMaps, members: _Fitted, rows: Integers
) -> ShapeClass:
    """The class with the member that stands best for all, made the mean of all, and the plainest
    maps from it.
    """
    near = model.tolerance / max(float(np.abs(model.copies.points).max()), 1e-300)
    first = _plainest(members, own.linear, own.places, near)
    chosen = _representative(first, model.tolerance)
    outward = first.linear[chosen]
    symmetry = snapped(outward @ own.linear @ outward.T, near)
    from_chosen = _Fitted(first.points, first.order, first.linear @ outward.T)
    last = _plainest(from_chosen, symmetry, own.places, near)
    row = int(rows[chosen])
    corners = slice(pieces.vertex_start[row], pieces.vertex_start[row + 1])
    decimals = decimals_of(pieces.vertices[corners])
    placed = Placed(center[rows], last.points, last.linear, symmetry, own.places)
    fit = averaged(placed, chosen, decimals, model.tolerance)
    shape = None
    if not np.array_equal(fit.shape, last.points[chosen]):
        shape = np.empty_like(fit.shape)
        shape[last.order[chosen]] = fit.shape
    return ShapeClass(rows, row, fit.linear, symmetry, own.whole, fit.misfit, shape, fit.shift)


def _plainest(members: _Fitted, symmetry: Floats, places: Integers, near: float) -> _Fitted:
    linear, which = plainest(members.linear, symmetry, near)
    chosen = places[which]
    points = np.take_along_axis(members.points, chosen[..., None], 1)
    return _Fitted(points, np.take_along_axis(members.order, chosen, 1), linear)


def _representative(members: _Fitted, tolerance: float) -> int:
    """The member turned as most are, of equally many the tightest in its box; of these the one in
    the middle, of equal ones the first.
    """
    turned = np.rint(members.linear.reshape(-1, 9) * 1e3)
    _, kind = distinct_rows(turned)
    often = np.bincount(kind)[kind]
    box = np.ptp(members.points, axis=1).sum(axis=1)
    box = np.round(box / max(box.max(), 1e-300), 4)
    laid = members.points @ members.linear
    apart = np.linalg.norm(laid - laid.mean(axis=0), axis=2).max(axis=1)
    apart = np.rint(apart / (tolerance / 4))
    return int(np.lexsort([np.arange(len(box)), apart, box, -often])[0])
