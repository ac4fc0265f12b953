"""Paths grouped by shape: same curve under turning, scaling, moving and mirroring.

In come stacked curves, out go groups with the frames of their members and the symmetry of their
model. Elements with the same layout of segments are compared in one batch: invariants sort them
into lumps that no equal pair crosses, and inside a lump each group is proven by aligning its
members with its model. Nothing is merged on the strength of a hash.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.formats.drawing import LINE
from ipmlang.inverse.lsystem.alignment import Freedom, align, find_symmetries
from ipmlang.inverse.lsystem.curves import Booleans, Curves, Integers, evaluate
from ipmlang.inverse.lsystem.frames import Complexes, Floats, Frames, frames
from ipmlang.inverse.lsystem.symmetry import Symmetry, simplest, trivial

# Invariants move at most this many times as far as the points of a shape of unit radius do.
SENSITIVITY = 8.0
# A shape used once has nothing to match, so the symmetry of long ones is not worth its time.
SINGLE_LIMIT = 64


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Elements of one shape. members: (k,) element numbers, ascending; model: the member that
    stands for all, whose frame is unturned and of scale 1, and its centre, the origin of the
    shape; frames: (k,); error: (k,) units.
    """

    members: Integers
    model: int
    centre: complex
    frames: Frames
    error: Floats
    symmetry: Symmetry
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Elements that may correspond point by point. rows: (k,) element numbers; points: (k, M)."""

    rows: Integers
    points: Complexes
    freedom: Freedom


def group_paths(
    curves: Curves, rows: Integers, layout: Integers, fixed: Booleans, tolerance: float
) -> list[Group]:
    """Groups of the elements `rows`, each of radius above the tolerance.

    layout: (n,) equal numbers for elements whose subpaths have equal lengths and closings; fixed:
    (n,) whether start and direction are part of the shape.
    """
    groups: list[Group] = []
    if not len(rows):
        return groups
    for batch in _batches(curves, rows, layout, fixed):
        groups += _grouped(batch, tolerance)
    return groups


def _batches(curves: Curves, rows: Integers, layout: Integers, fixed: Booleans) -> Iterator[Batch]:
    straight = np.ones(len(curves.counts), np.bool_)
    bent = np.repeat(np.arange(len(curves.counts)), curves.counts)[curves.kind != LINE]
    straight[bent] = False
    keys = np.stack([layout, curves.counts, straight, fixed, curves.closed], axis=1)[rows]
    unique, which = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(which.ravel(), minlength=len(unique)))
    for part, key in zip(np.split(order, ends[:-1]), unique, strict=True):
        members = rows[part]
        whole = bool(curves.subpaths[members[0]] == 1)
        yield _sampled(curves, members, int(key[1]), bool(key[2]), whole, not key[3])


def _sampled(
    curves: Curves, rows: Integers, length: int, straight: bool, whole: bool, free: bool
) -> Batch:
    """Points along the segments: corners of polygons, else quarters too, which fix a cubic."""
    index = curves.offsets[rows][:, None] + np.arange(length)
    kind, points = curves.kind[index].ravel(), curves.points[index].reshape(-1, 4)
    parameters = np.array([0.0]) if straight else np.array([0.0, 0.25, 0.5, 0.75])
    closed = whole and bool(curves.closed[rows[0]])
    if not whole:
        parameters = np.append(parameters, 1.0)
    along = evaluate(kind, points, parameters).reshape(len(rows), -1)
    if whole and not closed:
        end = evaluate(kind, points, np.array([1.0])).reshape(len(rows), -1)[:, -1:]
        along = np.concatenate([along, end], axis=1)
    step = len(parameters) if closed and free else 0
    return Batch(rows, along, Freedom(step, free and whole))


@dataclass(frozen=True, slots=True, eq=False)
class _Cluster:
    """Rows of a batch with one shape: members ascending, the row that models it, its size relative
    to which frames are given, the frames and errors.
    """

    members: Integers
    model: int
    frames: Frames
    error: Floats


def _grouped(batch: Batch, tolerance: float) -> list[Group]:
    centre = batch.points.mean(axis=1)
    given = batch.points - centre[:, None]
    radius = np.sqrt(np.mean(np.abs(given) ** 2, axis=1))
    reach = SENSITIVITY * tolerance / radius
    features = _invariants(given / radius[:, None], batch.freedom)
    alone, clusters = frames(centre), []
    for lump in lumps(features, reach):
        if len(lump) == 1:
            clusters.append(_Cluster(lump, int(lump[0]), alone[lump], np.zeros(1)))
        else:
            clusters += _split(batch, lump, features, reach, radius, tolerance)
    return _finished(batch, centre, given, clusters, tolerance)


def _finished(
    batch: Batch,
    centre: Complexes,
    given: Complexes,
    clusters: list[_Cluster],
    tolerance: float,
) -> list[Group]:
    """Clusters with their symmetries, by which their frames become as simple as possible."""
    symmetries = [trivial()] * len(clusters)
    worth = [
        number
        for number, cluster in enumerate(clusters)
        if len(cluster.members) > 1 or given.shape[1] <= SINGLE_LIMIT
    ]
    models = given[[clusters[number].model for number in worth]]
    rooms = np.array([0.25 * tolerance / clusters[number].frames.scale.max() for number in worth])
    for number, symmetry in zip(worth, find_symmetries(models, batch.freedom, rooms), strict=True):
        symmetries[number] = symmetry
    radii = np.abs(given[[cluster.model for cluster in clusters]]).max(axis=1)
    return [
        Group(
            batch.rows[cluster.members],
            int(batch.rows[cluster.model]),
            complex(centre[cluster.model]),
            simplest(cluster.frames, symmetry),
            cluster.error,
            symmetry,
            float(radius),
        )
        for cluster, symmetry, radius in zip(clusters, symmetries, radii, strict=True)
    ]


def _invariants(points: Complexes, freedom: Freedom) -> Floats:
    """(k, 5) numbers that no similarity, mirroring, start or direction changes; points of unit
    root-mean-square radius about 0. None of them jumps when points move a little.
    """
    distance = np.abs(points)
    if freedom.step:
        near, far = np.roll(points, -1, axis=1), np.roll(points, -2, axis=1)
        steps, leaps = np.abs(near - points), np.abs(far - points)
    else:
        near = points[:, 1:]
        steps, leaps = np.abs(near - points[:, :-1]), np.abs(points[:, 2:] - points[:, :-2])
        points = points[:, :-1]
    area = np.abs(np.mean((np.conj(points) * near).imag, axis=1))
    spread = leaps.mean(axis=1) if leaps.shape[1] else np.zeros(len(points))
    columns = [distance.mean(axis=1), distance.max(axis=1), steps.mean(axis=1), spread, area]
    return np.stack(columns, axis=1)


def lumps(features: Floats, reach: Floats) -> list[Integers]:
    """Rows in parts such that rows of different parts differ by more than their reach somewhere."""
    label = np.zeros(len(reach), np.int64)
    for column in range(features.shape[1]):
        label = _cut(label, features[:, column] - reach, features[:, column] + reach)
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1)


def _cut(label: Integers, low: Floats, high: Floats) -> Integers:
    """Labels refined: intervals of one label that no chain of overlaps joins get labels of their
    own. Ranks stand for the numbers, so that labels can be ranked in front of them exactly.
    """
    count = len(label)
    rank = np.empty(2 * count, np.int64)
    rank[np.argsort(np.concatenate([low, high]), kind="stable")] = np.arange(2 * count)
    lower, upper = label * 2 * count + rank[:count], label * 2 * count + rank[count:]
    order = np.argsort(lower, kind="stable")
    furthest = np.maximum.accumulate(upper[order])
    fresh = np.concatenate([[False], lower[order][1:] > furthest[:-1]])
    result = np.empty(count, np.int64)
    result[order] = np.cumsum(fresh)
    return result


def _split(
    batch: Batch,
    lump: Integers,
    features: Floats,
    reach: Floats,
    radius: Floats,
    tolerance: float,
) -> list[_Cluster]:
    """A lump as clusters. The largest element leads, since its shape is the best known."""
    column = int(np.argmax(np.ptp(features[lump], axis=0)))
    lump = lump[np.argsort(features[lump, column], kind="stable")]
    value, widest = features[lump, column], float(reach[lump].max())
    free = np.ones(len(lump), np.bool_)
    clusters: list[_Cluster] = []
    for place in np.lexsort((lump, -np.round(np.log(radius[lump]), 9))).tolist():
        if not free[place]:
            continue
        room = widest + reach[lump[place]]
        low = int(np.searchsorted(value, value[place] - room))
        high = int(np.searchsorted(value, value[place] + room, "right"))
        window = low + np.flatnonzero(free[low:high])
        apart = np.abs(features[lump[window]] - features[lump[place]]).max(axis=1)
        window = window[apart <= reach[lump[window]] + reach[lump[place]]]
        fits, cluster = _proven(batch, int(lump[place]), lump[window], tolerance)
        clusters.append(cluster)
        free[window[fits]] = False
    return clusters


def _proven(
    batch: Batch, lead: int, candidates: Integers, tolerance: float
) -> tuple[Booleans, _Cluster]:
    """The cluster led by row `lead`, and which candidates belong to it."""
    # A quarter of the tolerance is left for the symmetries by which frames are simplified.
    limit = 0.75 * tolerance
    if len(candidates) == 1:
        alone = frames(batch.points[candidates].mean(axis=1))
        return np.ones(1, np.bool_), _Cluster(candidates, lead, alone, np.zeros(1))
    model = batch.points[lead] - batch.points[lead].mean()
    placed, error = align(model, batch.points[candidates], batch.freedom, limit)
    fits = (error <= limit) | (candidates == lead)
    order = np.flatnonzero(fits)[np.argsort(candidates[fits])]
    members = candidates[order]
    usual = _most_usual(members, placed.scale[order], lead)
    if usual != lead:
        model = batch.points[usual] - batch.points[usual].mean()
        again = align(model, batch.points[members], batch.freedom, limit)
        if (again[1] <= limit).all():
            return fits, _Cluster(members, usual, *again)
    return fits, _Cluster(members, lead, placed[order], error[order])


def _most_usual(members: Integers, scale: Floats, lead: int) -> int:
    """The lead if its scale is as frequent as any, else the first member of the most frequent."""
    _, which, often = np.unique(np.round(np.log(scale), 6), return_inverse=True, return_counts=True)
    frequency = often[which.ravel()]
    if frequency[np.searchsorted(members, lead)] == frequency.max():
        return lead
    return int(members[np.argmax(frequency)])
