"""Grids in a cloud: two independent steps, skewed or staggered, with holes and noise.

Seeds are parallelograms of neighbours: first of the steps that occur most often in the whole cloud,
then of each point with its own neighbours. The one that most of the sixteen nodes around agree with
is grown over its bounding box and fitted again until nothing more is found. Lines at the border
that are nearly empty are cut off. Nothing here knows frames.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.lattices.chains import EARLY, LATE, Mask, tolerable
from ipmlang.inverse.lattices.cloud import EVERY, SELDOM, Cloud, Integers, likely
from ipmlang.inverse.lattices.nets import Fit, Net, presented, unstaggered
from ipmlang.inverse.lsystem.frames import Complexes, Floats

ATTEMPTS = 200
BARREN = 40  # attempts in a row without a grid: seeds come best first, so the rest is hopeless
SLACK = 4.0  # times the noise that a prediction from a seed may be off
CELL = 0.04  # relative size of the cells in which steps are counted
COMMON = 0.1  # of all points: steps so frequent are tried first
SAMPLED = 400  # points at which a frequent pair of steps is tried
SEEDS = 240_000  # parallelograms looked at
WITHIN = 16  # neighbours of a point, two of which span a parallelogram
FILLED = 0.6  # of the nodes of a grid's box
LINE, FEW = 0.4, 3  # nodes of a line at the border of a noisy grid: this share or so many
SLANT = 0.2  # sine of the least angle between the steps
LENGTHS = 6.0  # most that one step is longer than the other
BETTER = 1.3  # times as many members make a noisy grid better than an exact one
# nodes in a finer basis: the same one, the middles of cells, of the one and of the other side
FINER = np.array([(1, 0, 0, 1), (1, -1, 0, 2), (2, 0, 0, 1), (1, 0, 0, 2)], np.int64)
AROUND = np.array([(i, j) for i in range(-1, 3) for j in range(-1, 3)], np.int64)
CORNERS = np.flatnonzero((AROUND >= 0).all(axis=1) & (AROUND <= 1).all(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class _Seed:
    """index: (k, 2) nodes, rows: (k,) points on them."""

    index: Integers
    rows: Integers


def find_nets(known: Cloud, used: Mask, share: float) -> list[Net]:
    """Grids of points not `used` (n,), which mark what they take; share 0 asks for exact places."""
    found: list[Net] = []
    for seeds, tests in _seedings(known, used, share):
        left, patience = ATTEMPTS, BARREN
        for seed in seeds:
            if left == 0 or patience == 0:
                break
            if used[seed.rows].any():
                continue
            left, patience = left - 1, patience - 1
            net = _grown(known, seed, used, share)
            if net is None or not _believable(known, net, tests):
                continue
            patience = BARREN
            for finer in FINER[0 if share == 0 else 1 :]:
                net = _noisier(known, net, used, tests, finer)
            used[net.rows] = True
            found.append(net)
    return found


def _noisier(known: Cloud, net: Net, used: Mask, tests: float, finer: Integers) -> Net:
    """The same grid with noise allowed, or with the steps (4,) of a finer basis, where that makes
    it much larger.
    """
    least = max(BETTER * len(net), len(net) + 3)
    if np.count_nonzero(~used) < least:
        return net
    p, q, r, s = finer
    i, j = unstaggered(net).T
    index = np.stack([p * i + q * j, r * i + s * j], axis=1)
    tried = _grown(known, _Seed(index, net.rows), used, known.loose, least)
    if tried is None or len(tried) < least:
        return net
    return tried if _believable(known, tried, tests) else net


def _believable(known: Cloud, net: Net, tests: float) -> bool:
    """Two by three if exact, else three by three, and unlikely by chance."""
    short, long = sorted(net.shape)
    exact = net.reach <= known.exact
    if short < 2 or long < 3 or (not exact and (short < 3 or len(net) < 7)):
        return False
    return likely(known, tests, net.rows, net.nodes, 3, net.reach) <= SELDOM


# ------------------------------------------------------------------------ seeds


def _seedings(known: Cloud, used: Mask, share: float) -> Iterator[tuple[Iterator[_Seed], float]]:
    """Seeds from the steps common in the cloud, then from each point; and how many were looked at.

    A generator, so that the second sees what grids of the first have taken.
    """
    steps = _common_steps(known, used) if len(known) > EVERY else np.zeros(0, np.complex128)
    if len(steps) >= 2:
        points = np.flatnonzero(~used)
        points = points[:: max(1, len(points) // SAMPLED)]
        one, two = np.triu_indices(len(steps), 1)
        p = np.repeat(points, len(one))
        u, v = np.tile(steps[one], len(points)), np.tile(steps[two], len(points))
        yield _supported(known, used, share, p, u, v)
    if (~used).sum() >= 6:
        yield _supported(known, used, share, *_own_steps(known, used))


def _common_steps(known: Cloud, used: Mask) -> Complexes:
    """Up to six steps to neighbours that occur most often, of either sign."""
    free = np.flatnonzero(~used)
    near = known.near[free, : min(12, known.near.shape[1])]
    steps = (known.at[near] - known.at[free][:, None])[~used[near]]
    steps = np.where((steps.real < -1e-9 * np.abs(steps)), -steps, steps)
    upright = np.abs(steps.real) <= 1e-9 * np.abs(steps)
    steps = np.where(upright & (steps.imag < 0), -steps, steps)
    if len(steps) < 12:
        return np.zeros(0, np.complex128)
    cell = np.log(steps + 0j) / CELL
    key = np.round(cell.real).astype(np.int64) * 4096 + np.round(cell.imag).astype(np.int64)
    _, of, often = np.unique(key, return_inverse=True, return_counts=True)
    best = np.argsort(-often, kind="stable")[:6]
    best = best[often[best] >= max(6, COMMON * len(free))]
    alike = [steps[of == k] for k in best]
    return np.array([np.median(each.real) + 1j * np.median(each.imag) for each in alike])


def _own_steps(known: Cloud, used: Mask) -> tuple[Integers, Complexes, Complexes]:
    """Each point not used with pairs of its neighbours, within `SEEDS` in all."""
    free = np.flatnonzero(~used)
    often = min(WITHIN, known.near.shape[1])
    while often > 4 and len(free) * often * (often - 1) / 2 > SEEDS:
        often -= 1
    one, two = np.triu_indices(often, 1)
    p = np.repeat(free, len(one))
    a, b = known.near[free][:, one].ravel(), known.near[free][:, two].ravel()
    keep = ~used[a] & ~used[b]
    p, a, b = p[keep], a[keep], b[keep]
    return p, known.at[a] - known.at[p], known.at[b] - known.at[p]


def _supported(
    known: Cloud, used: Mask, share: float, p: Integers, u: Complexes, v: Complexes
) -> tuple[Iterator[_Seed], float]:
    """The parallelograms at p with sides u and v that nodes around agree with, best first."""
    tests = float(len(p))
    area = np.abs((u.conj() * v).imag)
    long, short = np.maximum(np.abs(u), np.abs(v)), np.minimum(np.abs(u), np.abs(v))
    good = (area > SLANT * long * short) & (long <= LENGTHS * short)
    p, u, v, area, short = p[good], u[good], v[good], area[good], short[good]
    reach = np.maximum(4 * known.exact, SLACK * share * short)
    across = known.find(known.at[p] + u + v, reach)
    good = (across >= 0) & ~used[across]
    p, u, v, area, reach = p[good], u[good], v[good], area[good], reach[good]
    order = np.argsort(area, kind="stable")[: SEEDS // 16]
    p, u, v, area, reach = p[order], u[order], v[order], area[order], reach[order]
    rows = _nodes(known, used, p, u, v, AROUND, reach)
    count = np.where((rows[:, CORNERS] >= 0).all(axis=1), (rows >= 0).sum(axis=1), 0)
    order = np.lexsort((p, (area / max(known.exact, 1e-300)).round(), -count))
    order = order[count[order] >= (6 if share == 0 else 7)][: 40 * ATTEMPTS]
    return (_Seed(AROUND[each >= 0], each[each >= 0]) for each in rows[order]), tests


def _nodes(
    known: Cloud,
    used: Mask,
    p: Integers,
    u: Complexes,
    v: Complexes,
    index: Integers,
    reach: Floats,
) -> Integers:
    """(s, k) the points on nodes of s grids with corner p, -1 for none."""
    places = known.at[p][:, None] + u[:, None] * index[:, 0] + v[:, None] * index[:, 1]
    hit = known.find(places, np.repeat(reach[:, None], len(index), axis=1))
    hit[(hit >= 0) & used[hit]] = -1
    return hit


# ------------------------------------------------------------------------ growing


def _grown(known: Cloud, seed: _Seed, used: Mask, share: float, least: float = 0) -> Net | None:
    """The largest grid about a seed, in the basis in which its box is best filled; None for one of
    less than the `least` members.
    """
    index, rows = seed.index, seed.rows
    index, rows = _distinct(index, rows)
    for _ in range(24):
        fitted = _fit(known, index, rows)
        if fitted is None:
            return None
        slack = EARLY if len(rows) < 16 else LATE
        box = _box(index, len(known))
        hit = known.find(_places(fitted, box), slack * _allowance(known, fitted, share))
        hit[(hit >= 0) & used[hit]] = -1
        found = _connected(box, hit >= 0, index[0])
        new_index, new_rows = _distinct(box[found], hit[found])
        if len(new_rows) < 4:
            return None
        same = len(new_rows) == len(rows) and set(new_rows.tolist()) == set(rows.tolist())
        index, rows = new_index, new_rows
        if same:
            break
    return _finished(known, index, rows, share) if len(rows) >= least else None


def _fit(known: Cloud, index: Integers, rows: Integers) -> Fit | None:
    """Origin and steps by least squares; None if the nodes lie on a line."""
    columns = np.stack([np.ones(len(index)), index[:, 0], index[:, 1]], axis=1)
    places = known.at[rows]
    solved, _, rank, _ = np.linalg.lstsq(columns, np.stack([places.real, places.imag], axis=1))
    if rank < 3:
        return None
    origin, u, v = solved[:, 0] + 1j * solved[:, 1]
    return complex(origin), complex(u), complex(v)


def _places(fitted: Fit, index: Integers) -> Complexes:
    return np.asarray(fitted[0] + fitted[1] * index[:, 0] + fitted[2] * index[:, 1])


def _allowance(known: Cloud, fitted: Fit, share: float) -> float:
    """Units that a member may be off."""
    return max(known.exact, share * min(abs(fitted[1]), abs(fitted[2])))


def _box(index: Integers, count: int) -> Integers:
    """All nodes of the bounding box and half its size around, as far as points can fill it."""
    low, high = index.min(axis=0), index.max(axis=0)
    size = high - low + 1
    wide = np.maximum(2, size // 2)
    if np.prod(size + 2 * wide) > 64 + 8 * count:
        wide = np.array([2, 2])
    first, sizes = low - wide, (size + 2 * wide).tolist()
    box = np.empty((*sizes, 2), np.int64)
    box[..., 0] = (first[0] + np.arange(sizes[0]))[:, None]
    box[..., 1] = first[1] + np.arange(sizes[1])
    return box.reshape(-1, 2)


def _connected(box: Integers, there: Mask, start: Integers) -> Mask:
    """Which nodes (k, 2) of a box, line by line, are members that steps of at most two nodes join
    to the start.
    """
    low, size = box[0], box[-1] - box[0] + 1
    full = np.zeros(size + 2, np.bool_)
    inside = full[1:-1, 1:-1]
    inside[...] = there.reshape(inside.shape)
    thick = full.copy()
    thick[1:] |= full[:-1]
    thick[:, 1:] |= thick[:, :-1].copy()
    piece = _pieces(thick)
    own, number = int(piece[tuple(start - low + 1)]), piece[1:-1, 1:-1].ravel()
    if own == piece.size:
        own = int(np.bincount(number[there], minlength=1).argmax())
    return np.asarray(there & (number == own))


def _pieces(there: Mask) -> Integers:
    """(h, w) for each of these cells the number of the first that is joined to it, by sides or
    corners; h * w for all others.
    """
    none = there.size
    number = np.where(there, np.arange(none).reshape(there.shape), none)
    cells = number[there]
    while True:
        least = number.copy()
        np.minimum(least[1:], number[:-1], out=least[1:])
        np.minimum(least[:-1], number[1:], out=least[:-1])
        wide = least.copy()
        np.minimum(wide[:, 1:], least[:, :-1], out=wide[:, 1:])
        np.minimum(wide[:, :-1], least[:, 1:], out=wide[:, :-1])
        near = wide[there]
        joined = wide.ravel()[near]  # what that cell has come to meanwhile
        if (joined == cells).all():
            return number
        cells = number[there] = joined


def _distinct(index: Integers, rows: Integers) -> tuple[Integers, Integers]:
    """Each point on one node only."""
    _, first = np.unique(rows, return_index=True)
    first.sort()
    return index[first], rows[first]


def _finished(known: Cloud, index: Integers, rows: Integers, share: float) -> Net | None:
    """Trimmed to the noise allowed and to a box that is filled well."""
    for _ in range(6):
        fitted = _fit(known, index, rows) if len(rows) >= 4 else None
        if fitted is None:
            return None
        off = np.abs(known.at[rows] - _places(fitted, index))
        keep = tolerable(off, np.full(len(off), _allowance(known, fitted, share)), known.exact)
        if keep.all():
            break
        index, rows = index[keep], rows[keep]
    else:
        return None
    net = presented(fitted, index, rows, float(off.max()))
    keep = _filled(net.index, share)
    if keep.all():
        return net
    if keep.sum() < 4:
        return None
    index, rows = index[keep], rows[keep]
    fitted = _fit(known, index, rows)
    if fitted is None:
        return None
    off = np.abs(known.at[rows] - _places(fitted, index))
    return presented(fitted, index, rows, float(off.max()))


def _filled(index: Integers, share: float) -> Mask:
    """(m,) which members stay so that the box is filled: the emptiest lines at its border go."""
    keep = np.ones(len(index), np.bool_)
    while keep.sum() >= 4:
        there = index[keep]
        low, high = there.min(axis=0), there.max(axis=0)
        size = high - low + 1
        share_all = len(there) / float(np.prod(size))
        if share_all >= FILLED and share == 0:
            break
        ends = [(axis, int(value[axis])) for axis in (0, 1) for value in (low, high)]
        counts = [int((there[:, axis] == value).sum()) for axis, value in ends]
        parts = [count / size[1 - axis] for count, (axis, _) in zip(counts, ends, strict=True)]
        least = int(np.argmin(parts))
        stray = share > 0 and parts[least] < LINE and counts[least] < FEW
        if share_all >= FILLED and not stray:
            break
        worst = ends[least]
        keep &= index[:, worst[0]] != worst[1]
    return keep
