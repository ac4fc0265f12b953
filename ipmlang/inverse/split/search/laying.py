"""Laying motifs: from rows that seem to be equal groups to a rule's body and exact placements.

The motion to every occurrence is fitted to all its rows at once and made plain where the error
allows; an occurrence that is not exact then is left out. Also where a body looks the same when it
is moved onto itself. Nothing here counts tokens but to choose how a body is turned.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    chosen,
    compose,
    from_matrices,
    inverse,
    linear,
    matrices,
    moved_to,
)
from ipmlang.inverse.parts.plainest import snapped, turned_plainly
from ipmlang.inverse.parts.uprighting import by_hand
from ipmlang.inverse.split.cost import placement_tokens
from ipmlang.inverse.split.search.drafts import Draft, Limits, Motif, motif_box
from ipmlang.inverse.split.search.fields import Field, field_of, look_up_moved, standing
from ipmlang.inverse.split.search.figures import MOST_FRAMES
from ipmlang.inverse.split.search.growth import Grown
from ipmlang.inverse.split.snapping import Flags
from ipmlang.inverse.split.turning import tidy

TOGETHER = 512  # lookups at a time
NEARLY = 1e-4  # how far turns may be from plain ones that are tried in their place
PLAINER = 0.5  # of the error that there may be, where a turn is plain
ASKEW = 10.0  # tokens that it may take more to draw a body upright that stands in no order
TRIED = 6  # occurrences whose own way of standing the body may take


def laid(field: Field, grown: Grown, limits: Limits) -> Motif | None:
    """The motif with exact places; None if fewer than two occurrences are exact.

    The body is the first occurrence, or another one that more of them are equal to.
    """
    draft, rows = field.draft, grown.rows
    target = _targets(field, grown)
    points = target.reshape(len(rows), -1, 3)
    best: tuple[Integers, Frames] | None = None
    for index in range(min(TRIED, len(rows))):
        near = grown.motion if index == 0 else _from(grown.motion, index)
        places, off = _places(field, target[index], points, rows, near, limits)
        exact = np.nonzero(off <= limits.error)[0]
        if best is None or len(exact) > len(best[0]):
            best = exact, compose(places[exact], inverse(places[exact[:1]]))
        if len(exact) == len(rows):
            break
    if best is None or len(best[0]) < 2:
        return None
    return _turned(draft, rows[best[0]], best[1], limits)


def _places(
    field: Field, body: Floats, target: Floats, rows: Integers, near: Floats, limits: Limits
) -> tuple[Frames, Floats]:
    """Frames (k,) that lay probes (m, 4, 3) on (k, 4 m, 3), turned plainly where there is room for
    it, and how far they are off.
    """
    source = body.reshape(-1, 3)
    motion = plain(fitted(source, target, near))
    places = _rounded(from_matrices(motion), limits)
    off = _errors(field, body, rows, places)
    turned = _turned_plainly(source, target, motion)
    if np.array_equal(turned, motion):
        return places, off
    plainer = _rounded(from_matrices(turned), limits)
    off_plainly = _errors(field, body, rows, plainer)
    better = off_plainly <= np.maximum(PLAINER * limits.error, off)
    return chosen(better, plainer, places), np.where(better, off_plainly, off)


def _from(motion: Floats, index: int) -> Floats:
    """The motions (k, 3, 4) from occurrence `index` instead of the first."""
    frames = from_matrices(motion)
    return matrices(compose(frames, inverse(frames[index : index + 1])))


def fitted(source: Floats, target: Floats, near: Floats) -> Floats:
    """(k, 3, 4) least-squares motions of points (p, 3) to (k, p, 3), with the handedness of those
    nearby, and scaled where these are.
    """
    scale = np.cbrt(np.abs(np.linalg.det(near[:, :, :3])))
    hand = np.sign(np.linalg.det(near[:, :, :3]))
    middle, middles = source.mean(axis=0), target.mean(axis=1)
    spread = np.einsum("pi,kpj->kij", source - middle, target - middles[:, None])
    left, _, right = np.linalg.svd(spread)
    flip = np.ones((len(target), 3))
    flip[:, 2] = hand * np.sign(np.linalg.det(left @ right))
    turn = np.einsum("kji,kj,klj->kil", right, flip, left)
    if np.abs(scale - 1).max(initial=0.0) > 1e-9:
        own = np.einsum("kil,pl,kpi->k", turn, source - middle, target - middles[:, None])
        scale = np.where(np.abs(scale - 1) > 1e-9, own / ((source - middle) ** 2).sum(), scale)
    turn = turn * scale[:, None, None]
    return np.concatenate([turn, (middles - turn @ middle)[:, :, None]], axis=2)


def plain(motion: Floats, near: float = 1e-6) -> Floats:
    """The same motions, with turns that are all but exact quarter turns made exact."""
    whole = np.round(motion[:, :, :3])
    close = np.abs(motion[:, :, :3] - whole).max(axis=(1, 2)) < near
    result = motion.copy()
    result[close, :, :3] = whole[close]
    return result


def _turned_plainly(source: Floats, target: Floats, motion: Floats) -> Floats:
    """The motions with turns that a person would write, about the middles of points (p, 3) and
    (k, p, 3).
    """
    scale = np.cbrt(np.abs(np.linalg.det(motion[:, :, :3])))[:, None, None]
    turn = scale * snapped(turned_plainly(motion[:, :, :3] / scale, NEARLY), NEARLY)
    moved = target.mean(axis=1) - turn @ source.mean(axis=0)
    return np.concatenate([turn, moved[:, :, None]], axis=2)


def _rounded(places: Frames, limits: Limits) -> Frames:
    """Places with coordinates of no more decimals than the error calls for."""
    decimals = int(np.ceil(-np.log10(max(limits.error, 1e-15) / 4)))
    position = np.round(places.position, decimals) + 0.0
    return Frames(position, places.rotation, places.hand, places.scale)


def _targets(field: Field, grown: Grown) -> Floats:
    """(k, m, 4, 3) where the probes of the first occurrence go in each, under the symmetries that
    the motions call for.
    """
    wanted = _moved(grown.motion, field.points[grown.rows[0]])
    there = standing(field, grown.rows.ravel(), wanted.reshape(-1, 4, 3))[1]
    return there.reshape(wanted.shape)


def _errors(field: Field, body: Floats, rows: Integers, places: Frames) -> Floats:
    """(k,) the largest distance of a probe of the body (m, 4, 3) from where the places put it."""
    wanted = _moved(matrices(places), body)
    off = standing(field, rows.ravel(), wanted.reshape(-1, 4, 3))[0]
    return np.asarray(off.reshape(rows.shape).max(axis=1))


def _moved(motion: Floats, points: Floats) -> Floats:
    """(k, m, 4, 3) points (m, 4, 3) under motions (k, 3, 4)."""
    turned = points.reshape(-1, 3) @ motion[:, :, :3].transpose(0, 2, 1)
    return np.asarray((turned + motion[:, None, :, 3]).reshape(len(motion), *points.shape))


def _turned(draft: Draft, rows: Integers, places: Frames, limits: Limits) -> Motif:
    """The motif whose body is turned as the occurrence that makes all of it shortest, or as one of
    its own parts: what stands askew everywhere is drawn upright.
    """
    ways = []
    for index in range(min(TRIED, len(rows))):
        outside = compose(places, inverse(places[index : index + 1]))
        ways.append(Motif(rows, outside, draft.frames[rows[index]]))
    home = _at_home(draft, rows)
    best = _shortest(ways, home, limits)
    turned = [
        Motif(rows, compose(best.places, turn), tidy(compose(inverse(turn), best.inside)))
        for turn in _askew(best.inside)
    ]
    more = ASKEW if turned and by_hand(best.places) else 0.0
    return _cornered(draft, _shortest([best, *turned], home, limits, more), limits)


def _at_home(draft: Draft, rows: Integers) -> Flags:
    """(m,) which parts of a body stand nowhere else: their shapes are drawn where they stand."""
    symbol = draft.symbol[rows[0]]
    amount = np.bincount(draft.symbol, minlength=len(draft.figures))[symbol]
    return np.asarray((symbol < draft.classes) & (amount == len(rows)))


def _shortest(ways: list[Motif], home: Flags, limits: Limits, more: float = 0.0) -> Motif:
    """The shortest of some ways; the others may be longer than the first by so many tokens."""
    best, least = ways[0], np.inf
    for number, each in enumerate(ways):
        inside = placement_tokens(each.inside, limits.small)
        effort = float(inside[~home].sum() + placement_tokens(each.places, limits.small).sum())
        effort -= more * (number > 0)
        if effort < least - 0.5:
            best, least = each, effort
    return best


def _askew(inside: Frames) -> list[Frames]:
    """Turns, one row each, that parts of a body stand in and that are no quarter turns."""
    turn = np.round(linear(inside), 9) + 0.0
    whole = np.abs(turn - np.round(turn)).max(axis=(1, 2)) < NEARLY
    rows = np.flatnonzero(~whole & (inside.hand > 0) & (np.abs(inside.scale - 1) < NEARLY))
    _, first = np.unique(turn[rows].reshape(len(rows), 9), axis=0, return_index=True)
    still = np.zeros((1, 3))
    return [replace(inside[row : row + 1], position=still) for row in rows[first[:TRIED]].tolist()]


def _cornered(draft: Draft, motif: Motif, limits: Limits) -> Motif:
    """The motif whose body begins at the low corner of its box."""
    low, _ = motif_box(draft, motif)
    inside = compose(moved_to(-low[None]), motif.inside)
    places = _rounded(compose(motif.places, moved_to(low[None])), limits)
    return Motif(motif.rows, places, inside)


def symmetry_of(draft: Draft, motif: Motif, limits: Limits) -> Frames:
    """(s,) motions of a motif's body onto itself, the identity first."""
    symbol = draft.symbol[motif.rows[0]]
    count = len(symbol)
    own = Draft(draft.figures, draft.classes, np.zeros(count, np.int64), symbol, motif.inside)
    amount = np.bincount(symbol, minlength=len(draft.figures))
    many = np.array([len(shape.symmetry) for shape in draft.figures])
    rarest = int(np.argmin(np.where(amount > 0, amount * many, amount.max() * many.max() + 1)))
    ways = _ways(own, rarest, np.nonzero(symbol == rarest)[0])
    if len(ways) > 1:
        field = field_of(own, neighbours=False)
        motion, row = matrices(ways), 0
        while row < count and len(ways) > 1:
            some = np.arange(row, min(row + max(1, TOGETHER // len(ways)), count))
            row += len(some)
            body = np.zeros(len(ways), np.int64)
            hit = look_up_moved(field, some, motion, body, limits.error)
            kept = np.asarray((hit >= 0).all(axis=0))
            ways, motion = ways[kept], motion[kept]
    exact = _rounded(from_matrices(plain(matrices(ways))), limits)
    return exact[:MOST_FRAMES]


def _ways(own: Draft, symbol: int, anchor: Integers) -> Frames:
    """Motions that take the first row of a symbol to any, the identity first."""
    shape = own.figures[symbol]
    many = len(shape.symmetry)
    rows = np.repeat(anchor, many)
    turned = shape.symmetry[np.tile(np.arange(many), len(anchor))]
    ways = compose(compose(own.frames[rows], turned), inverse(own.frames[anchor[:1]]))
    return ways
