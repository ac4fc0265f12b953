"""Rings, spiral stairs, spirals: symbols that one turn about an axis takes from each to the next.

Takes placements of one symbol; gives rings with their members, fitted. A symbol's symmetry is used:
what is round itself may stand in any ring. Nothing here counts tokens.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    about,
    compose,
    inverse,
    matrices,
    quaternions,
    turns,
)
from ipmlang.inverse.numbers import shortest
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Ring
from ipmlang.inverse.split.search.figures import Figure, misses, probed
from ipmlang.inverse.split.snapping import Flags, label_rows, snap_columns

EVERY = 16  # placements of which all pairs are looked at; of more, the nearest
NEAREST = 4
FRAMES = 16  # frames of a symmetry that are tried
MOTIONS = 12  # motions that are followed
LEAST = 2.0  # degrees of a step
SAME = 4  # rows that may share a center
MISSING = 2  # members in a row that may be missing


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """center, axis (3,), angle in degrees a step, rise along the axis, growth."""

    center: Floats
    axis: Floats
    angle: float
    rise: float
    growth: float


def rings(
    shape: Figure, frames: Frames, symbol: int, error: float
) -> Iterator[tuple[Integers, Ring]]:
    """Rows of frames (n,) with the rings that they are, those of three and more."""
    if len(frames) < 3:
        return
    if len(shape.symmetry) == 1 and not (frames.rotation != frames.rotation[0]).any():
        return  # nothing turns
    points = probed(shape, frames)
    first, motion = _motions(shape, frames, points, error)
    if len(first) == 0:
        return
    ahead, steps = _ahead(shape, frames, points, motion, 8 * error)
    for index in range(len(first)):
        chain = _chain(int(first[index]), ahead[index], steps[index])
        if len(chain) >= 3:
            found = _fitted(shape, frames, points, chain, motion[index], symbol, error)
            if found is not None:
                yield found


def _motions(
    shape: Figure, frames: Frames, points: Floats, error: float
) -> tuple[Integers, Floats]:
    """Turns (m, 3, 4) that take several placements to the next, with one (m,) of these each."""
    one, two = _pairs(points[:, 0])
    many = min(len(shape.symmetry), FRAMES)
    own = shape.symmetry[np.tile(np.arange(many), len(one))]
    one, two = np.repeat(one, many), np.repeat(two, many)
    motion = compose(compose(frames[two], own), inverse(frames[one]))
    turned = 2 * np.degrees(np.arccos(np.clip(np.abs(motion.rotation[:, 0]), 0, 1)))
    good = (motion.hand > 0) & (turned > LEAST)
    one, matrix, turned = one[good], matrices(motion[good]), turned[good]
    reach = max(float(np.abs(points).max()), 1e-9)
    onward = ~_swaps(matrix, 1e-6 * reach)
    one, matrix, turned = one[onward], matrix[onward], turned[onward]
    if len(one) == 0:
        return one, matrix
    scaled = matrix.reshape(-1, 12) / np.tile([1, 1, 1, reach], 3)
    label, count = label_rows(snap_columns(scaled, max(1e-6, 8 * error / shape.reach)))
    _, start = np.unique(label, return_index=True)
    angle = turned[start]
    order = np.lexsort((start, np.round(angle, 4), -count))
    kept = start[order[count[order] > 1][:MOTIONS]]
    return one[kept], matrix[kept]


def _swaps(motion: Floats, small: float) -> Flags:
    """Which motions (m, 3, 4), done twice, leave everything where it was: no three stand so."""
    turn, move = motion[:, :, :3], motion[:, :, 3]
    back = np.abs(turn @ turn - np.eye(3)).max(axis=(1, 2)) < 1e-6
    there = np.abs(np.einsum("mij,mj->mi", turn, move) + move).max(axis=1) < small
    return np.asarray(back & there)


def _pairs(center: Floats) -> tuple[Integers, Integers]:
    count = len(center)
    if count <= EVERY:
        one, two = np.nonzero(~np.eye(count, dtype=np.bool_))
        return one.astype(np.int64), two.astype(np.int64)
    from scipy.spatial import cKDTree

    near = np.asarray(cKDTree(center).query(center, k=NEAREST + 1)[1])
    one = np.repeat(np.arange(count), NEAREST + 1)
    two = near.ravel().astype(np.int64)
    return one[one != two], two[one != two]


def _ahead(
    shape: Figure, frames: Frames, points: Floats, motion: Floats, near: float
) -> tuple[Integers, Integers]:
    """(m, n) rows that motions (m, 3, 4) lead to from each, after how many steps; -1: to none."""
    from scipy.spatial import cKDTree

    many, count = len(motion), len(points)
    tree = cKDTree(points[:, 0])
    ahead, steps = np.full((many, count), -1, np.int64), np.zeros((many, count), np.int64)
    at = np.broadcast_to(points.reshape(1, -1, 3), (many, 4 * count, 3))
    for step in range(1, MISSING + 2):
        at = at @ motion[:, :, :3].transpose(0, 2, 1) + motion[:, None, :, 3]
        way, row = np.nonzero(ahead < 0)
        wanted = at.reshape(many, count, 4, 3)[way, row]
        told = tree.query(wanted[:, 0], k=SAME, distance_upper_bound=near)[1]
        ask, rank = np.nonzero(np.asarray(told) < count)
        hit = np.asarray(told)[ask, rank]
        good = misses(shape, wanted[ask], frames[hit])[0] <= near
        ask, hit = ask[good], hit[good]
        last = np.lexsort([-hit, ask])  # of several the first counts
        ask, hit = ask[last], hit[last]
        ahead[way[ask], row[ask]], steps[way[ask], row[ask]] = hit, step
    return ahead, steps


def _chain(first: int, ahead: Integers, steps: Integers) -> Integers:
    """(k,) rows that a motion leads to from `first`, backwards and onwards; -1: missing."""
    known = list(zip(ahead.tolist(), steps.tolist(), strict=True))
    onwards = _walk(first, {row: at for row, at in enumerate(known) if at[0] >= 0})
    if len(onwards) > 2 and first in onwards[1:]:
        return np.array(onwards[: onwards.index(first, 1)], np.int64)
    behind = {row: (before, step) for before, (row, step) in enumerate(known) if row >= 0}
    return np.array(_walk(first, behind)[:0:-1] + onwards, np.int64)


def _walk(first: int, following: dict[int, tuple[int, int]]) -> list[int]:
    """Rows from `first` on, -1 for what is missing between, until it comes back or ends."""
    chain, seen = [first], {first}
    while chain[-1] in following:
        row, step = following[chain[-1]]
        if row in seen and row != first:
            break
        chain += [-1] * (step - 1) + [row]
        if row in seen:
            break
        seen.add(row)
    return chain


def _fitted(
    shape: Figure,
    frames: Frames,
    points: Floats,
    chain: Integers,
    motion: Floats,
    symbol: int,
    error: float,
) -> tuple[Integers, Ring] | None:
    """The ring that a chain is; None if it is off."""
    index = np.nonzero(chain >= 0)[0]
    rows = chain[index]
    turn = _turn(motion, points[rows, 0], index, error)
    if turn is None:
        return None
    first = frames[rows[:1]]
    holes = frozenset(np.nonzero(chain < 0)[0].tolist())
    ring = Ring(
        symbol,
        first,
        len(chain),
        turn.center,
        turn.axis,
        turn.angle,
        turn.rise,
        turn.growth,
        holes,
    )
    made = placements(ring)[0][1]
    off = misses(shape, probed(shape, made), frames[rows])[0]
    return (rows, ring) if off.max() <= error else None


def _turn(motion: Floats, centers: Floats, index: Integers, error: float) -> Turn | None:
    """Axis, angle and rise, fitted to where the members' centers stand."""
    growth = float(np.cbrt(np.linalg.det(motion[:, :3])))
    growth = 1.0 if abs(growth - 1) < 1e-6 else growth
    turned = quaternions(motion[None, :, :3] / growth)[0]
    sine = float(np.linalg.norm(turned[1:]))
    angle = float(np.degrees(2 * np.arctan2(sine, turned[0])))
    axis = turned[1:] / sine
    lead = int(np.argmax(np.abs(axis)))
    if np.abs(np.delete(axis, lead)).max() < 1e-5:
        axis = np.eye(3)[lead] * np.sign(axis[lead])
    if axis[lead] < 0:
        axis, angle = -axis, -angle
    angle = _whole(angle, centers, index, error)
    return _axis(centers, index, axis + 0.0, angle, growth, error)


def _whole(angle: float, centers: Floats, index: Integers, error: float) -> float:
    """The angle, as a share of the full turn or with few decimals where that is as good."""
    share = 360.0 / abs(angle)
    if abs(share - round(share)) < 1e-4:
        return float(np.sign(angle) * 360.0 / round(share))
    reach = float(np.ptp(centers, axis=0).max()) + error
    return shortest(angle, np.degrees(error / reach) / (4 * int(index[-1]) + 1))


def _axis(
    centers: Floats, index: Integers, axis: Floats, angle: float, growth: float, error: float
) -> Turn | None:
    """Where the axis stands and how much a step rises, by least squares: linear in the center, the
    rise and the place of the first member.
    """
    turned = (
        turns(about(axis, np.asarray(angle * index, np.float64)))
        * (growth ** index.astype(np.float64))[:, None, None]
    )
    still = np.eye(3) - turned
    rises = index[:, None] * axis
    known = np.concatenate([turned, still, rises[:, :, None]], axis=2).reshape(-1, 7)
    solved = np.linalg.lstsq(known, centers.ravel(), rcond=1e-9)[0]
    center, rise = solved[3:6], float(solved[6])
    if growth == 1.0:
        center = center - axis * float(center @ axis)
    rounded = [shortest(float(v), error / 16) for v in center]
    rise = shortest(rise, error / (8 * int(index[-1]) + 1))
    rise = 0.0 if abs(rise) * int(index[-1]) < error / 4 else rise
    return Turn(np.array(rounded), axis, angle, rise, growth)
