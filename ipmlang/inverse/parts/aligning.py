"""The maps that lay one part on another: turns and mirrors about the parts' centres.

Takes a model part and parts that may equal it; gives for each the map that makes it so, proved
point by point and face by face. Plain ways are tried before rare corners are laid on each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.anchors import Anchors, corner_lengths
from ipmlang.inverse.parts.copies import Copies, Model, Truths, in_same_order, matched

_TRIES = 256  # maps that are tried for one part
_BATCH = 1_000_000  # points compared at a time


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
    there = copies.points[rest]
    turned = turns(np.broadcast_to(model.copies.points, there.shape), there)
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
        found, places = matched(model, copies[part], maps, np.full(len(part), slack))
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
    anchor = Anchors.of(model.copies, corner_lengths(model.copies), model.tolerance)
    others = copies[rows]
    row, corner, forward = anchor.candidates(others, corner_lengths(others))
    rank = _ranks(row)
    for turn in range(min(int(rank.max(initial=-1)) + 1, _TRIES)):
        now = (rank == turn) & ~result.found[rows[row]]
        if not now.any():
            if result.found[rows].all():
                return
            continue
        linear = anchor.maps(others, row[now], corner[now], forward[now])
        _match(model, copies, result, rows[row[now]], linear, float(anchor.slack[0]))


def _ranks(row: Integers) -> Integers:
    """How many equal numbers stand before each, in sorted numbers."""
    starts = np.searchsorted(row, row)
    return np.asarray(np.arange(len(row)) - starts)
