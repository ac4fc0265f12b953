"""The maps that lay one part on another: turns and mirrors about the parts' centres.

Takes a model part and parts that may equal it; gives for each the map that makes it so, proved
point by point and face by face. What maps the model onto itself is found the same way. Rare corners
are the anchors, so that few maps are tried.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.copies import Copies, Model, Truths, in_same_order, matched
from ipmlang.inverse.parts.invariants import mixed

_TRIES = 256  # maps that are tried for one part
_BATCH = 1_000_000  # points compared at a time
_MOST_WORK = 20_000_000  # corners compared to find all maps of a part onto itself


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """found (k,): which parts are the model; linear (k, 3, 3): model to part about their centres;
    places (k, v): the part's vertex for each of the model's. Rows not found are undefined.
    """

    found: Truths
    linear: Floats
    places: Integers


def aligned(model: Model, copies: Copies) -> Alignment:
    """The plainest way to look first: shifted copies, then turned ones, then any."""
    count, size = copies.points.shape[:2]
    result = Alignment(
        np.zeros(count, np.bool_),
        np.tile(np.eye(3), (count, 1, 1)),
        np.tile(np.arange(size), (count, 1)),
    )
    found = in_same_order(model, copies, result.linear)
    result.found[found] = True
    rest = np.flatnonzero(~result.found)
    turned = turns(np.broadcast_to(model.copies.points, copies.points[rest].shape), copies.points[rest])
    _keep(result, rest, in_same_order(model, copies[rest], turned), turned)
    rest = np.flatnonzero(~result.found)
    _match(model, copies, result, rest, np.tile(np.eye(3), (len(rest), 1, 1)), 0.0)
    rest = np.flatnonzero(~result.found)
    if len(rest):
        _anchored(model, copies, result, rest)
    return result


def _keep(result: Alignment, rows: Integers, found: Truths, linear: Floats) -> None:
    result.found[rows[found]] = True
    result.linear[rows[found]] = linear[found]


def _match(
    model: Model, copies: Copies, result: Alignment, rows: Integers, linear: Floats, slack: float
) -> None:
    """Note which rows are the model under these maps, after the best map for what was matched."""
    step = max(1, _BATCH // copies.points.shape[1])
    for begin in range(0, len(rows), step):
        part = rows[begin : begin + step]
        maps = linear[begin : begin + step]
        found, places = matched(model, copies[part], maps, slack)
        maps, good = refined(model, copies[part[found]], maps[found], places)
        kept = part[found][good]
        result.found[kept] = True
        result.linear[kept] = maps[good]
        result.places[kept] = places[good]


def refined(
    model: Model, copies: Copies, linear: Floats, places: Integers
) -> tuple[Floats, Truths]:
    """The best maps for known places, and whether they are within the tolerance."""
    points = np.take_along_axis(copies.points, places[..., None], 1)
    own = np.broadcast_to(model.copies.points, points.shape)
    best = turns(own, points, np.sign(np.linalg.det(linear)) if len(linear) else None)
    best = np.where((_misfit(own, points, linear) <= 0)[:, None, None], linear, best)
    return best, _misfit(own, points, best) <= model.tolerance


def _misfit(own: Floats, points: Floats, linear: Floats) -> Floats:
    off = points @ linear - own
    return np.asarray(np.sqrt(np.einsum("kvi,kvi->kv", off, off).max(axis=1, initial=0.0)))


def turns(points: Floats, onto: Floats, sign: Floats | None = None) -> Floats:
    """The turns (k, 3, 3) that bring points (k, v, 3) nearest to others, in the sense of least
    squares; mirrored ones where the sign is -1.
    """
    count = len(points)
    if not count:
        return np.zeros((0, 3, 3))
    moment = onto.transpose(0, 2, 1) @ points
    left, _, right = np.linalg.svd(moment)
    wanted = np.ones(count) if sign is None else sign
    left[:, :, 2] *= (np.sign(np.linalg.det(left @ right)) * wanted)[:, None]
    return np.asarray(left @ right)


def _anchored(model: Model, copies: Copies, result: Alignment, rows: Integers) -> None:
    anchor = Anchor.of(model)
    if anchor is None:
        return
    row, corner, forward = anchor.candidates(copies[rows])
    rank = _ranks(row)
    for turn in range(min(int(rank.max(initial=-1)) + 1, _TRIES)):
        now = (rank == turn) & ~result.found[rows[row]]
        if not now.any():
            if result.found[rows].all():
                return
            continue
        linear = anchor.maps(copies[rows], row[now], corner[now], forward[now])
        _match(model, copies, result, rows[row[now]], linear, anchor.slack)


def _ranks(row: Integers) -> Integers:
    """How many equal numbers stand before each, in sorted numbers."""
    starts = np.searchsorted(row, row)
    return np.asarray(np.arange(len(row)) - starts)


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A rare corner of the model: what it is known by (5,), its hash, the axes (3, 3) that it and
    its neighbour give (columns), and how far off maps made from it may be.
    """

    lengths: Floats
    look: np.uint64
    axes: Floats
    slack: float
    tolerance: float

    @classmethod
    def of(cls, model: Model) -> Anchor | None:
        """None where all corners lie in one line through the centre."""
        copies = model.copies
        lengths = _lengths(copies)[0]
        points = copies.points[0][copies.corners[0]]
        ahead = points[copies.after[0]]
        lever = _lever(points, ahead)
        reach = float(lengths[:, 0].max())
        if lever.max() <= max(1e-9 * reach, model.tolerance) * reach:
            return None
        fit = np.flatnonzero(lever >= 0.3 * lever.max())
        unit = max(64 * model.tolerance, 1e-6 * reach)
        often = _how_often(np.rint(lengths / unit), copies.look[0])[fit]
        wide = np.round(lever[fit] / lever.max(), 3)
        best = int(fit[np.lexsort([-wide, often])[0]])
        far = max(np.linalg.norm(points[best]), np.linalg.norm(ahead[best]))
        slack = 4 * model.tolerance * reach * far / lever[best]
        axes = _axes(points[best][None], ahead[best][None], np.ones(1))[0]
        return cls(lengths[best], copies.look[0][best], axes, float(slack), model.tolerance)

    def candidates(self, copies: Copies) -> tuple[Integers, Integers, Truths]:
        """Row and corner of all that may be the anchor, and whether faces run as the model's do;
        by rows, those that do first.
        """
        lengths = _lengths(copies)
        close = 4 * self.tolerance
        plain = (np.abs(lengths - self.lengths) <= close).all(axis=2)
        mirror = (np.abs(lengths[:, :, [0, 2, 1, 4, 3]] - self.lengths) <= close).all(axis=2)
        seen = copies.look == self.look
        rows, corners = zip(*(np.nonzero(each & seen) for each in (plain, mirror)), strict=True)
        row, corner = np.concatenate(rows), np.concatenate(corners)
        forward = np.arange(len(row)) < len(rows[0])
        order = np.lexsort([corner, ~forward, row])
        return row[order], corner[order], forward[order]

    def maps(self, copies: Copies, row: Integers, corner: Integers, forward: Truths) -> Floats:
        """The maps (q, 3, 3) that bring the anchor to corners of rows."""
        next_one = np.where(forward, copies.after[row, corner], copies.before[row, corner])
        points = copies.points[row, copies.corners[row, corner]]
        ahead = copies.points[row, copies.corners[row, next_one]]
        return _axes(points, ahead, np.where(forward, 1.0, -1.0)) @ self.axes.T


def _lever(points: Floats, ahead: Floats) -> Floats:
    """The lengths (c,) of cross products: what a corner and the next one span with the centre."""
    product = np.einsum("ci,ci->c", points, ahead)
    square = np.einsum("ci,ci->c", points, points) * np.einsum("ci,ci->c", ahead, ahead)
    return np.asarray(np.sqrt(np.maximum(square - product**2, 0.0)))


def _lengths(copies: Copies) -> Floats:
    """What corners (k, c, 5) are known by: how far from the centre they and their neighbours are,
    and from these.
    """
    row = np.arange(len(copies))[:, None]
    points = copies.points[row, copies.corners]
    ahead = points[row, copies.after] - points
    far = np.sqrt(np.einsum("kci,kci->kc", points, points))
    edge = np.sqrt(np.einsum("kci,kci->kc", ahead, ahead))
    after, before = copies.after, copies.before
    columns = (far, edge, edge[row, before], far[row, after], far[row, before])
    return np.stack(columns, axis=2)


def _how_often(lengths: Floats, look: NDArray[np.uint64]) -> Integers:
    """How many corners are like each, its mirror images among them."""
    columns = lengths.astype(np.int64).view(np.uint64)
    far, ahead, behind, next_far, last_far = columns.T
    # What stands before and after a corner counts alike.
    sides = mixed(mixed(ahead) ^ next_far) + mixed(mixed(behind) ^ last_far)
    _, kind, count = np.unique(
        mixed(far) + mixed(sides) ^ look, return_inverse=True, return_counts=True
    )
    return np.asarray(count[kind])


def _axes(first: Floats, second: Floats, sign: Floats) -> Floats:
    """Unit axes (q, 3, 3), as columns: along the first, toward the second, and across."""
    x = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    y = second - np.einsum("qi,qi->q", x, second)[:, None] * x
    y = y / np.maximum(np.linalg.norm(y, axis=1, keepdims=True), 1e-300)
    return np.stack([x, y, np.cross(x, y) * sign[:, None]], axis=2)


@dataclass(frozen=True, slots=True, eq=False)
class SelfMaps:
    """What maps a model onto itself: linear (s, 3, 3), the identity first, and places (s, v): the
    vertex that each vertex comes to. whole: False if only those along the axes were looked for.
    """

    linear: Floats
    places: Integers
    whole: bool


def self_maps(model: Model, most: int) -> SelfMaps:
    """All maps of the model onto itself; only those along the axes where there may be more than
    `most` or where the model is very large.
    """
    size = model.copies.points.shape[1]
    alone = SelfMaps(np.eye(3)[None], np.arange(size)[None], True)
    anchor = Anchor.of(model)
    if anchor is None:
        return alone
    _, corner, forward = anchor.candidates(model.copies)
    if len(corner) <= 1:
        return alone
    zero = np.zeros(len(corner), np.int64)
    linear = anchor.maps(model.copies, zero, corner, forward)
    linear = linear[np.abs(linear - np.eye(3)).max(axis=(1, 2)) > 1e-6]
    corners = model.copies.corners.shape[1]
    whole = len(corner) <= most and len(corner) * corners <= _MOST_WORK
    if not whole:
        linear = linear[_along_axes(linear)]
    step = max(1, _BATCH // corners)
    found = [_proved(model, linear[k : k + step], anchor.slack) for k in range(0, len(linear), step)]
    return SelfMaps(
        np.concatenate([alone.linear, *(maps for maps, _ in found)]),
        np.concatenate([alone.places, *(places for _, places in found)]),
        whole,
    )


def _proved(model: Model, linear: Floats, slack: float) -> tuple[Floats, Integers]:
    """Those of the maps that bring the model onto itself, at their best."""
    copies = model.copies[np.zeros(len(linear), np.int64)]
    found, places = matched(model, copies, linear, slack)
    best, good = refined(model, copies[found], linear[found], places)
    return best[good], places[good]


def _along_axes(linear: Floats) -> Truths:
    """Which maps take axes to axes."""
    return np.abs(linear - np.rint(linear)).max(axis=(1, 2)) < 1e-5
