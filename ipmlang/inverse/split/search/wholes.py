"""Wholes that are the same on both sides: mirrored halves, and cells about an axis.

Takes a field; gives, for a body that a motion maps largely onto itself, the part of it that is
placed again by that motion: half of a mirrored building, a quarter of a fourfold tower. What the
motion leaves where it is stays outside. Nothing here counts tokens.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers, compose, inverse, matrices
from ipmlang.inverse.split.search.fields import Field, look_up
from ipmlang.inverse.split.search.growth import Grown
from ipmlang.inverse.split.snapping import label_rows, members, snap_columns

SYMBOL = 24  # placements of one symbol that vote
FOLLOWED = 8  # motions of one body that are followed
MOST = 16  # copies about an axis


def wholes(field: Field, error: float) -> list[Grown]:
    """Groups that a motion of their body maps onto others, one for each motion that many rows
    vote for.
    """
    found = []
    for rows in members(field.draft.body, field.draft.bodies):
        if len(rows) < 4:
            continue
        for motion in _voted(field, rows, error):
            found += _cells(field, rows, motion, error)
    return found


def _voted(field: Field, rows: Integers, error: float) -> list[Floats]:
    """Motions (3, 4) that map most rows of a body, by votes of pairs of equal symbols."""
    votes = []
    draft = field.draft
    for symbol in np.unique(draft.symbol[rows]).tolist():
        own = rows[draft.symbol[rows] == symbol]
        if 2 <= len(own) <= SYMBOL:
            votes.append(_pairs(draft.frames[own], draft.figures[symbol].symmetry))
    if not votes:
        return []
    motion = np.concatenate(votes)
    reach = float(np.abs(field.points[rows]).max()) + 1e-9
    scaled = motion.reshape(-1, 12) / np.tile([1, 1, 1, reach], 3)
    label, count = label_rows(snap_columns(scaled, 1e-5))
    _, start = np.unique(label, return_index=True)
    order = np.lexsort((start, -count))
    return [motion[start[kind]] for kind in order[count[order] > 1][:FOLLOWED].tolist()]


def _pairs(frames: Frames, symmetry: Frames) -> Floats:
    one, two = np.nonzero(~np.eye(len(frames), dtype=np.bool_))
    many = min(len(symmetry), 16)
    own = symmetry[np.tile(np.arange(many), len(one))]
    one, two = np.repeat(one, many), np.repeat(two, many)
    return matrices(compose(compose(frames[two], own), inverse(frames[one])))


def _cells(field: Field, rows: Integers, motion: Floats, error: float) -> list[Grown]:
    """The group that the motion repeats, if each of its rows comes round to itself."""
    order = _order(motion)
    if order < 2:
        return []
    orbit = [rows]
    points = field.points[rows]
    symbol, body = field.draft.symbol[rows], field.draft.body[rows]
    for _ in range(order - 1):
        points = points @ motion[:, :3].T + motion[:, 3]
        orbit.append(look_up(field, points, symbol, body, error))
    every = np.stack(orbit, axis=1)
    whole = (every >= 0).all(axis=1)
    whole &= np.array([len(set(row)) == order for row in every.tolist()])
    every = every[whole]
    if len(every) < 2:
        return []
    chosen = _sector(field, every, motion, order)
    motions = [np.concatenate([np.eye(3), np.zeros((3, 1))], axis=1)]
    for _ in range(order - 1):
        motions.append(_after(motion, motions[-1]))
    return [Grown(chosen.T, np.stack(motions))]


def _order(motion: Floats) -> int:
    """How often the motion is done until everything is where it was; 0: never, or too often."""
    at = motion
    for count in range(1, MOST + 1):
        if np.abs(at - np.eye(3, 4)).max() < 1e-5 * max(1.0, float(np.abs(motion).max())):
            return count
        at = _after(motion, at)
    return 0


def _after(second: Floats, first: Floats) -> Floats:
    turn = second[:, :3] @ first[:, :3]
    moved = second[:, :3] @ first[:, 3] + second[:, 3]
    return np.concatenate([turn, moved[:, None]], axis=1)


def _sector(field: Field, every: Integers, motion: Floats, order: int) -> Integers:
    """(m, k) orbits, each begun in the same sector about the axis, or on the same side."""
    center = field.points[every, 0]
    turn = motion[:, :3]
    if order == 2:
        away = center[:, 0] - center[:, 1]
        lead = away[np.argmax(np.linalg.norm(away, axis=1))]
        side = np.argmax(np.einsum("mki,i->mk", center, lead), axis=1)
    else:
        axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        axis = axis / (np.linalg.norm(axis) + 1e-12)
        flat = center - center.mean(axis=1, keepdims=True)
        lead = flat[0, 0] - axis * float(flat[0, 0] @ axis)
        other = np.cross(axis, lead)
        angle = np.degrees(np.arctan2(flat @ other, flat @ lead)) % 360.0
        step = 360.0 / order
        start = _largest_gap(np.sort((angle % step).ravel()), step)
        side = np.argmin(np.round((angle - start) % 360.0, 6), axis=1)
    index = (side[:, None] + np.arange(order)[None]) % order
    chosen = np.take_along_axis(every, index, axis=1)
    _, once = np.unique(chosen[:, 0], return_index=True)
    return np.asarray(chosen[np.sort(once)])


def _largest_gap(angle: Floats, step: float) -> float:
    """Where, between angles below `step`, the most room is."""
    gaps = np.diff(np.concatenate([angle, [angle[0] + step]]))
    at = int(np.argmax(np.round(gaps, 6)))
    return float(angle[at] + gaps[at] / 2)
