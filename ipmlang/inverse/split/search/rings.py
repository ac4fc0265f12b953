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
from ipmlang.inverse.split.expansion import ring_frames
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
    chains = [_chain(*each) for each in zip(first.tolist(), ahead, steps, strict=True)]
    long = [number for number, chain in enumerate(chains) if len(chain) >= 3]
    if not long:
        return
    members = [_members(points, chains[number]) for number in long]
    turns = _turns(motion[long], members, error)
    found = [
        _ring(symbol, frames[own.rows[:1]], chains[number], turn)
        for number, own, turn in zip(long, members, turns, strict=True)
    ]
    rows = np.concatenate([own.rows for own in members])
    off = misses(shape, probed(shape, ring_frames(found)), frames[rows])[0]
    begins = np.cumsum([0, *(len(own.rows) for own in members[:-1])])
    for own, ring, worst in zip(members, found, np.maximum.reduceat(off, begins), strict=True):
        if worst <= error:
            yield own.rows, ring


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


@dataclass(frozen=True, slots=True, eq=False)
class _Members:
    """rows (k,) of a chain that are there, at steps index (k,), and their centers (k, 3)."""

    rows: Integers
    index: Integers
    centers: Floats


def _members(points: Floats, chain: Integers) -> _Members:
    index = np.nonzero(chain >= 0)[0]
    return _Members(chain[index], index, points[chain[index], 0])


def _ring(symbol: int, first: Frames, chain: Integers, turn: Turn) -> Ring:
    holes = frozenset(np.nonzero(chain < 0)[0].tolist())
    return Ring(
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


def _turns(motion: Floats, members: list[_Members], error: float) -> list[Turn]:
    """Axis, angle and rise of each motion (m, 3, 4), fitted to where the members' centers stand."""
    growth = np.cbrt(np.linalg.det(motion[:, :, :3]))
    growth[np.abs(growth - 1) < 1e-6] = 1.0
    turned = quaternions(motion[:, :, :3] / growth[:, None, None])
    sine = np.sqrt((turned[:, 1:] ** 2).sum(axis=1))
    angle = np.degrees(2 * np.arctan2(sine, turned[:, 0]))
    axis = turned[:, 1:] / sine[:, None]
    row, lead = np.arange(len(axis)), np.argmax(np.abs(axis), axis=1)
    straight = np.count_nonzero(np.abs(axis) >= 1e-5, axis=1) == 1
    axis[straight] = np.eye(3)[lead[straight]] * np.sign(axis[row, lead])[straight, None]
    sign = np.where(axis[row, lead] < 0, -1.0, 1.0)
    axis, angle = axis * sign[:, None] + 0.0, angle * sign
    whole = [_whole(each, own, error) for each, own in zip(angle.tolist(), members, strict=True)]
    return _axes(members, axis, np.array(whole), growth, error)


def _whole(angle: float, members: _Members, error: float) -> float:
    """The angle, as a share of the full turn or with few decimals where that is as good."""
    share = 360.0 / abs(angle)
    if abs(share - round(share)) < 1e-4:
        return float(np.sign(angle) * 360.0 / round(share))
    reach = float(np.ptp(members.centers, axis=0).max()) + error
    return shortest(angle, np.degrees(error / reach) / (4 * int(members.index[-1]) + 1))


def _axes(
    members: list[_Members], axis: Floats, angle: Floats, growth: Floats, error: float
) -> list[Turn]:
    """Where each axis stands and how much a step rises, by least squares: linear in the center, the
    rise and the place of the first member.
    """
    of = np.repeat(np.arange(len(members)), [len(own.index) for own in members])
    index = np.concatenate([own.index for own in members])
    turned = turns(about(axis[of], angle[of] * index))
    turned *= (growth[of] ** index)[:, None, None]
    rises = index[:, None] * axis[of]
    known = np.concatenate([turned, np.eye(3) - turned, rises[:, :, None]], axis=2)
    found = []
    begin = 0
    for number, own in enumerate(members):
        end = begin + len(own.index)
        equations = known[begin:end].reshape(-1, 7)
        solved = np.linalg.lstsq(equations, own.centers.ravel(), rcond=1e-9)[0]
        place = float(angle[number]), axis[number], float(growth[number])
        found.append(_settled(solved, *place, int(own.index[-1]), error))
        begin = end
    return found


def _settled(
    solved: Floats, angle: float, axis: Floats, growth: float, last: int, error: float
) -> Turn:
    """The turn with a center and a rise of few decimals."""
    center, rise = solved[3:6], float(solved[6])
    if growth == 1.0:
        center = center - axis * float(center @ axis)
    rounded = [shortest(each, error / 16) for each in center.tolist()]
    rise = shortest(rise, error / (8 * last + 1))
    rise = 0.0 if abs(rise) * last < error / 4 else rise
    return Turn(np.array(rounded), axis, angle, rise, growth)
