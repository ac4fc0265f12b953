"""Numbers of a part that no rigid motion, mirror or order of faces changes.

Takes pieces; gives groups of parts that may be equal. Parts that are equal within the tolerance are
always in one group; that those of a group are equal is for others to prove.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_numbers, distinct_rows
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.pieces import Pieces, sums

UV_TOLERANCE = 1e-5  # of the image


def centers(pieces: Pieces) -> Floats:
    """The mean (n, 3) of each part's corners."""
    points = pieces.vertices[pieces.corners]
    # Far from the origin sums lose digits: they are taken from each part's first corner.
    first = points[pieces.corner_start[:-1]]
    counts = np.diff(pieces.corner_start)
    moved = points - np.repeat(first, counts, axis=0)
    return np.asarray(first + sums(moved, pieces.corner_start) / counts[:, None])


def alike(pieces: Pieces, center: Floats, tolerance: float) -> list[Integers]:
    """Rows of parts that may be equal, in groups by their first; in a group all have the same
    numbers of faces, corners and vertices.
    """
    counts = np.stack(
        [
            np.diff(pieces.face_start),
            np.diff(pieces.corner_start),
            np.diff(pieces.vertex_start),
            sums(face_kinds(pieces), pieces.face_start).view(np.int64),
        ],
        axis=1,
    )
    label = np.zeros(len(pieces), np.int64)
    for count in counts.T:
        label = distinct_numbers(label * len(pieces) + distinct_numbers(count)[1])[1]
    images = _images(pieces) * (tolerance / UV_TOLERANCE)
    columns = np.concatenate([_lengths(pieces, center), images], axis=1) / (4 * tolerance)
    for column in columns.T:
        label = _parted(label, column)
    label = _without_lone(label, columns)
    for column in columns.T:
        label = _parted(label, column)
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return sorted(groups, key=lambda group: int(group[0]))


def face_kinds(pieces: Pieces) -> NDArray[np.uint64]:
    """A hash of each face's material and number of corners."""
    sizes = np.diff(pieces.offsets).astype(np.uint64)
    return mixed(mixed(sizes) ^ pieces.material.astype(np.uint64))


def _lengths(pieces: Pieces, center: Floats) -> Floats:
    """Columns (n, 7) that change by at most four times what any vertex is moved by: extents along
    the principal axes, and distances from the centre.
    """
    counts = np.diff(pieces.corner_start)
    arm = (pieces.vertices[pieces.corners] - np.repeat(center, counts, axis=0)).T.copy()
    square = (arm**2).sum(axis=0)
    spread = np.empty((len(pieces), 3, 3))
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        spread[:, i, j] = spread[:, j, i] = sums(arm[i] * arm[j], pieces.corner_start) / counts
    axes = np.sqrt(np.maximum(np.linalg.eigvalsh(spread), 0.0))
    largest = np.maximum.reduceat(square, pieces.corner_start[:-1])
    smallest = np.minimum.reduceat(square, pieces.corner_start[:-1])
    scale = np.where(largest > 0, largest, 1.0)
    relative = square / np.repeat(scale, counts)
    fourth = sums(relative**2, pieces.corner_start) / counts
    distances = np.stack([np.sqrt(largest), np.sqrt(smallest), np.sqrt(scale) * fourth**0.25], 1)
    return np.concatenate([axes, distances, _edges(pieces, counts)[:, None]], axis=1)


def _edges(pieces: Pieces, counts: Integers) -> Floats:
    """The root of the mean square of each part's edges."""
    ahead = pieces.vertices[pieces.corners[pieces.after]] - pieces.vertices[pieces.corners]
    square = np.einsum("ij,ij->i", ahead, ahead)
    return np.asarray(np.sqrt(sums(square, pieces.corner_start) / counts) / 2)


def _images(pieces: Pieces) -> Floats:
    """Columns of where parts lie on their images: the middle, and how far from it."""
    if pieces.laid is None:
        return np.zeros((len(pieces), 0))
    counts = np.diff(pieces.corner_start)[:, None]
    middle = sums(pieces.laid, pieces.corner_start) / counts
    off = pieces.laid - np.repeat(middle, counts[:, 0], axis=0)
    return np.concatenate([middle, np.sqrt(sums(off**2, pieces.corner_start) / counts)], axis=1)


def _parted(label: Integers, value: Floats) -> Integers:
    """Labels that also differ where values of one label, in order, jump by more than 1."""
    order = np.lexsort([value, label])
    new = (np.diff(label[order]) != 0) | (np.diff(value[order]) > 1)
    parted = np.empty(len(label), np.int64)
    parted[order] = np.concatenate([[0], np.cumsum(new)])
    return parted


def _without_lone(label: Integers, columns: Floats) -> Integers:
    """Labels of their own for rows with no like: among very many parts of all sizes each column
    has values everywhere, and only all columns together tell which are near each other.
    """
    from scipy.spatial import cKDTree

    table = np.concatenate([label[:, None] * 4.0, columns], axis=1)
    shared = np.bincount(label)[label] > 1
    rows = np.flatnonzero(shared)
    if len(rows) < 2:
        return label
    first, kind = distinct_rows(np.rint(table[rows] * 64))
    alone = first[np.bincount(kind) == 1]  # in its cell; others have a like beyond doubt
    leaders = table[rows[first]]
    near, _ = cKDTree(leaders).query(table[rows[alone]], k=2, p=np.inf, distance_upper_bound=1.1)
    lone = rows[alone[~np.isfinite(np.asarray(near)[:, 1])]]
    label = label.copy()
    label[lone] = int(label.max()) + 1 + np.arange(len(lone))
    return label


def mixed(value: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The bits of whole numbers, mixed so that sums of them tell sets apart."""
    value = value * np.uint64(0x9E3779B97F4A7C15) + np.uint64(0x165667B19E3779F9)
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))
