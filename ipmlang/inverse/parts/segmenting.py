"""What hangs together cut into what repeats, where that says the model in less.

Takes faces with the part of each; gives finer parts. A cut is tried on one of each kind of part and
kept for all of them where its pieces repeat so much that they cost far less to say. Solids that
touch in points alone come apart, convex ones stay whole, and so do most parts of real models.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.formats.distinct import by_first, distinct_numbers, distinct_rows
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.cutting import (
    Cut,
    Sheet,
    Truths,
    bounded,
    by_creases,
    by_edges,
    by_own_vertices,
    by_planes,
    by_ridges,
    by_solids,
    by_valleys,
    sheet_of,
)
from ipmlang.inverse.parts.invariants import alike, centers
from ipmlang.inverse.parts.pieces import Pieces, sorted_pieces
from ipmlang.inverse.parts.soup import corners_of

_LEAST, _MOST = 8, 60_000  # faces of parts that are tried, of one and of all in a round
_ROUNDS = 3
_PLACE = 8.0  # numbers that a place costs


@dataclass(frozen=True, slots=True)
class _Trial:
    """A cut, what a piece's place costs in numbers, and the share of what the whole costs that the
    pieces may cost: more where the file itself shows that things merely touch. often: how many
    pieces there must be of a kind, on average, for a cut that saves less than half.
    """

    cut: Cut
    place: float
    share: float
    often: float = 0.0


_TRIALS = (
    _Trial(by_own_vertices, 4.0, 0.7),
    _Trial(by_solids, 4.0, 0.7),
    _Trial(by_edges, 4.0, 0.7),
    _Trial(by_planes, 8.0, 0.45),
    _Trial(by_valleys, 8.0, 0.8, 8.0),
    _Trial(by_ridges, 8.0, 0.8, 8.0),
    _Trial(by_creases, 8.0, 0.45),
)
_OWN, _EDGES = ([trial.cut for trial in _TRIALS].index(cut) for cut in (by_own_vertices, by_edges))


def segmented(
    mesh: Mesh, same: Integers, part: Integers, diagonal: float, tolerance: float
) -> tuple[Integers, tuple[Note, ...]]:
    """The part of each face after all cuts that pay, and a note that counts the parts cut."""
    given = part
    fresh = np.ones(int(part.max()) + 1, np.bool_)
    for _ in range(_ROUNDS):
        faces = np.bincount(part)
        fit = fresh & (faces >= _LEAST) & (faces <= _MOST)
        worth, cost = _worth(mesh, same, part, fit, tolerance)
        if not worth:
            break
        first = np.array([group[0] for group in worth], np.int64)
        times = np.array([len(group) for group in worth], np.int64)
        choice = _choices(mesh, same, part, (first, times, cost), diagonal, tolerance)
        finer = part.copy()
        for number, trial in enumerate(_TRIALS):
            rows = [group for group, chosen in zip(worth, choice, strict=True) if chosen == number]
            if rows:
                among = np.isin(part, np.concatenate(rows))
                finer = _cut(mesh, same, finer, among, trial.cut, diagonal)
        if (choice < 0).all():
            break
        fresh = np.zeros(int(finer.max()) + 1, np.bool_)
        fresh[finer[np.bincount(finer, minlength=len(fresh))[finer] < faces[part]]] = True
        part = finer
    first, _ = distinct_numbers(part)
    count = int((np.bincount(given[first]) > 1).sum())
    if not count:
        return given, ()
    return part, (Note("segmented", "parts were cut where their pieces repeat", count),)


def _worth(
    mesh: Mesh, same: Integers, part: Integers, fit: Truths, tolerance: float
) -> tuple[list[Integers], Floats]:
    """The largest kinds of parts of which the first is fit to be tried: the parts of each, and the
    numbers that such a shape takes.
    """
    faces = np.bincount(part)
    like = np.isin(faces, faces[fit])  # what is like a part has as many faces
    if not fit.any():
        return [], np.zeros(0)
    number = np.cumsum(like) - 1
    rows = np.flatnonzero(like[part])
    pieces = sorted_pieces(_some(mesh, rows, True), same, number[part[rows]], False)
    groups = [np.flatnonzero(like)[each] for each in alike(pieces, centers(pieces), tolerance)]
    worth = _largest([group for group in groups if fit[group[0]]], faces)
    first = number[[group[0] for group in worth]]
    return worth, _numbers(pieces)[first]


def _numbers(pieces: Pieces) -> Floats:
    """(n,) numbers that say each piece: its points and the corners of its faces."""
    return np.asarray(3.0 * np.diff(pieces.vertex_start) + np.diff(pieces.corner_start))


def _largest(groups: list[Integers], faces: Integers) -> list[Integers]:
    """Those with the largest parts whose faces, one part of each taken, are few enough to try."""
    size = np.array([faces[rows[0]] for rows in groups], np.int64)
    order = np.argsort(-size, kind="stable")
    within = np.cumsum(size[order]) <= _MOST
    return [groups[each] for each in sorted(order[within].tolist())]


def _cut(
    mesh: Mesh, same: Integers, part: Integers, among: np.ndarray, cut: Cut, diagonal: float
) -> Integers:
    faces = np.flatnonzero(among)
    sheet = _sheet(mesh, same, part, faces, diagonal)
    label = cut(sheet)
    finer = part.copy()
    finer[faces] = int(part.max()) + 1 + label
    return by_first(*distinct_numbers(finer))[1]


def _sheet(mesh: Mesh, same: Integers, part: Integers, faces: Integers, diagonal: float) -> Sheet:
    """Some faces as a sheet, with all vertices in their places."""
    return sheet_of(_some(mesh, faces), same, part[faces], diagonal)


def _some(mesh: Mesh, faces: Integers, keep_uv: bool = False) -> Mesh:
    if len(faces) == len(mesh.material):
        return mesh if keep_uv else replace(mesh, uv=None, normals=None)
    sizes = np.diff(mesh.offsets)[faces]
    corner = corners_of(mesh.offsets, faces)
    return replace(
        mesh,
        corners=mesh.corners[corner],
        offsets=np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        material=mesh.material[faces],
        group=mesh.group[faces],
        uv=mesh.uv[corner] if keep_uv and mesh.uv is not None else None,
        normals=None,
    )


def _choices(
    mesh: Mesh,
    same: Integers,
    part: Integers,
    kinds: tuple[Integers, Integers, Floats],
    diagonal: float,
    tolerance: float,
) -> Integers:
    """For each kind of part, given by the row of one of them, how many there are and the numbers
    that its shape takes, the number of the cut that pays most, -1 for none.
    """
    rows, times, numbers = kinds
    choice = np.full(len(rows), -1)
    sheet = _sheet(mesh, same, part, np.flatnonzero(np.isin(part, rows)), diagonal)
    order = np.argsort(rows)
    parent = order[np.searchsorted(rows[order], sheet.part)]
    least = np.ones(len(rows))
    labels = [distinct_numbers(trial.cut(sheet)) for trial in _TRIALS]
    convex, several = bounded(sheet, parent, len(rows), labels[_EDGES][0])
    choice[several] = _EDGES
    whole = numbers + _PLACE * times
    for number, (trial, (first, label)) in enumerate(zip(_TRIALS, labels, strict=True)):
        many = np.bincount(parent[first], minlength=len(rows))
        places = trial.place * many * times
        hopeful = (many > 2) & ~convex & ~several
        if hopeful.any():
            bound = places + _least_costs(sheet, parent, label)
            hopeful &= bound < np.minimum(trial.share, least) * whole
        if not hopeful.any():
            continue
        faces = np.flatnonzero(hopeful[parent])
        some = replace(sheet, mesh=_some(sheet.mesh, faces))
        cost, kinds_in = np.full(len(rows), np.inf), np.zeros(len(rows))
        costs, counts = _shapes(some, same, parent[faces], label[faces], tolerance)
        cost[: len(costs)], kinds_in[: len(counts)] = costs, counts
        share = np.where(hopeful, cost + places, np.inf) / whole
        better = (share <= trial.share) & (share < least * 0.9)
        better &= (share <= 0.45) | (many >= trial.often * kinds_in)
        choice[better], least[better] = number, share[better]
    left = ~convex & ~several & (choice < 0)
    if left.any():
        own = labels[_OWN][1]
        choice[_shared(sheet, same, parent, own, left, whole, times, tolerance)] = _OWN
    return choice


def _shared(
    sheet: Sheet,
    same: Integers,
    parent: Integers,
    label: Integers,
    fit: Truths,
    whole: Floats,
    times: Integers,
    tolerance: float,
) -> Truths:
    """Of the parents that fit, those that fall by the file's own vertices into pieces, which the
    label tells apart, that others have, too: books on shelves, of which no two rows are alike.
    """
    trial = _TRIALS[_OWN]
    first, _ = distinct_numbers(label)
    many = np.bincount(parent[first], minlength=len(whole))
    fit = fit & (many > 1)
    if not fit.any():
        return fit
    above, of, kinds, own = _kinds(sheet, same, parent, label, tolerance)
    while True:  # what one of them saves hangs on the others
        holders = np.bincount(kinds[(fit | (many == 1))[of]], minlength=len(above))
        shared = own / np.maximum(holders[kinds], 1)
        cost = np.bincount(of, shared, len(whole)) + trial.place * many * times
        better = fit & (cost <= trial.share * whole)
        if (better == fit).all():
            return fit
        fit = better


def _least_costs(sheet: Sheet, parent: Integers, label: Integers) -> Floats:
    """Less than what the kinds of pieces of each parent cost, quickly: by their counts alone."""
    sizes = np.diff(sheet.mesh.offsets)
    faces = np.bincount(label)
    corners = np.bincount(label, sizes)
    above = np.zeros(len(faces), np.int64)
    above[label] = parent
    key = np.stack([above, faces, corners], axis=1)
    first, _ = distinct_rows(key.astype(np.float64))
    least = np.bincount(above[first], 1.4 * corners[first], int(parent.max()) + 1)
    return least.astype(np.float64)


def _shapes(
    sheet: Sheet, same: Integers, parent: Integers, label: Integers, tolerance: float
) -> tuple[Floats, Integers]:
    """What the shapes of each parent cost to say, the numbers of each kind of piece in it; and how
    many kinds there are.
    """
    _, of, _, own = _kinds(sheet, same, parent, label, tolerance)
    count = int(parent.max()) + 1
    return np.bincount(of, own, count).astype(np.float64), np.bincount(of, minlength=count)


def _kinds(
    sheet: Sheet, same: Integers, parent: Integers, label: Integers, tolerance: float
) -> tuple[Integers, Integers, Integers, Floats]:
    """The parent of each piece that a label makes; then for each kind of piece in a parent, once:
    the parent, the kind's number, and what the shape costs to say.
    """
    pieces = sorted_pieces(sheet.mesh, same, distinct_numbers(label)[1], False)
    above = parent[pieces.face[pieces.face_start[:-1]]]
    kind = np.zeros(len(pieces), np.int64)
    for number, rows in enumerate(alike(pieces, centers(pieces), tolerance)):
        kind[rows] = number
    own = _numbers(pieces)
    first, _ = distinct_numbers(above * len(pieces) + kind)
    return above, above[first], kind[first], own[first]
