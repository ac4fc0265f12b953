"""Whether two models are the same: every face of one where the other has one, nothing twice.

Takes meshes in the world; gives how many faces are lost or new and how far points are apart. Faces
are matched by their corners, whatever the order of the file; which way they wind does not count.
Nothing is derived here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_numbers, distinct_rows
from ipmlang.formats.mesh_types import Mesh, triangulated
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.welding import linked

BEYOND = 4.0  # times the limit up to which it is found out how far off a corner is


@dataclass(frozen=True, slots=True)
class Difference:
    """lost: faces of the first model that the second has not; new: the other way round; error: how
    far a corner is from where it was, in units, infinite where that is far beyond the limit.
    """

    lost: int
    new: int
    error: float

    @property
    def none(self) -> bool:
        """Whether nothing is lost and nothing new."""
        return self.lost == 0 and self.new == 0


def compare_models(source: Mesh, derived: Mesh, limit: float) -> Difference:
    """How `derived` differs from `source`; limit: units that a corner may be off. Faces without
    area count on neither side; where one model has polygons and the other not, triangles are
    compared.

    >>> from ipmlang.formats.mesh_types import triangle_mesh
    >>> one = triangle_mesh(np.eye(3), np.array([[0, 1, 2]]))
    >>> two = triangle_mesh(np.eye(3) + 1e-7, np.array([[1, 2, 0], [0, 2, 1]]))
    >>> found = compare_models(one, two, 1e-6)
    >>> found.lost, found.new
    (0, 1)
    """
    if _sizes(source) != _sizes(derived):
        source, derived = _cut(source), _cut(derived)
    places, own = _places(source)
    points, other = _places(derived)
    cluster, near, error = _nearest(places, points, limit)
    if near is None:
        return Difference(_count(source), _count(derived), error)
    names = _material_numbers(source, derived)
    first = _keys(source, cluster[own], names)
    second = _keys(derived, cluster[near][other], names)
    lost, new = _unmatched(first, second)
    return Difference(lost, new, error)


def _count(mesh: Mesh) -> int:
    return len(mesh.offsets) - 1


def _places(mesh: Mesh) -> tuple[Floats, Integers]:
    """The places (p, 3) where corners are, and which of them each corner (c,) is at."""
    used, at = distinct_numbers(mesh.corners)
    points = mesh.vertices[mesh.corners[used]]
    first, kind = distinct_rows(points)
    return points[first], kind[at]


def _sizes(mesh: Mesh) -> tuple[int, ...]:
    return tuple(np.bincount(np.diff(mesh.offsets)).tolist())


def _cut(mesh: Mesh) -> Mesh:
    """The mesh as triangles."""
    corners, face = triangulated(mesh)
    count = len(face)
    return Mesh(
        mesh.vertices,
        mesh.corners[corners].reshape(-1),
        np.arange(count + 1) * 3,
        mesh.material[face],
        mesh.group[face],
        mesh.materials,
        mesh.groups,
    )


def _nearest(
    places: Floats, points: Floats, limit: float
) -> tuple[Integers, Integers | None, float]:
    """The cluster of each place, shared by those within `limit` of each other; the place that each
    point stands at, None where one stands at none; and how far the farthest is from its place, up
    to some limits.
    """
    from scipy.spatial import cKDTree

    none = np.zeros(0, np.int64)
    if not len(places) or not len(points):
        return none, none if len(points) == len(places) else None, 0.0
    tree = cKDTree(places)
    told = tree.query(points, distance_upper_bound=BEYOND * limit)
    farthest = float(np.max(told[0]))
    if farthest > limit * (1 + 1e-9):
        return none, None, farthest
    pairs = tree.query_pairs(limit, output_type="ndarray")
    return linked(len(places), pairs), np.asarray(told[1], np.int64), farthest


def _material_numbers(*meshes: Mesh) -> dict[str, int]:
    """A number for every material by its name, 0 for none."""
    names = dict.fromkeys(each.name for mesh in meshes for each in mesh.materials)
    return {name: number + 1 for number, name in enumerate(names)}


def _keys(mesh: Mesh, label: Integers, names: dict[str, int]) -> list[NDArray[np.int64]]:
    """For every number of corners the faces (f, k + 1) with it: their corners in order from the
    least, in the direction of the lesser neighbour, and their material. Those without area are
    left out.
    """
    number = np.array([*(names[each.name] for each in mesh.materials), 0], np.int64)[mesh.material]
    counts = np.diff(mesh.offsets)
    found = []
    for size in range(3, int(counts.max(initial=0)) + 1):
        faces = np.flatnonzero(counts == size)
        corners = label[mesh.offsets[faces][:, None] + np.arange(size)]
        corners = _canonical(corners)
        apart = (np.diff(np.sort(corners, axis=1), axis=1) != 0).sum(axis=1) >= 2
        found.append(np.concatenate([corners, number[faces][:, None]], axis=1)[apart])
    return found


def _canonical(corners: Integers) -> Integers:
    """Rows turned and perhaps reversed so that equal rings of numbers are equal rows."""
    size = corners.shape[1]
    begin = np.argmin(corners, axis=1)[:, None]
    forth = np.take_along_axis(corners, (begin + np.arange(size)) % size, axis=1)
    back = np.take_along_axis(corners, (begin - np.arange(size)) % size, axis=1)
    return np.where((forth[:, 1] <= back[:, 1])[:, None], forth, back)


def _unmatched(first: list[Integers], second: list[Integers]) -> tuple[int, int]:
    """How many rows of the first have no partner in the second, and the other way round."""
    lost = new = 0
    for k in range(max(len(first), len(second))):
        one = first[k] if k < len(first) else np.zeros((0, k + 4), np.int64)
        two = second[k] if k < len(second) else np.zeros((0, k + 4), np.int64)
        _, kind = distinct_rows(np.concatenate([one, two]).astype(np.float64))
        total = int(kind.max(initial=-1)) + 1
        surplus = np.bincount(kind[: len(one)], minlength=total)
        surplus = surplus - np.bincount(kind[len(one) :], minlength=total)
        lost += int(surplus[surplus > 0].sum())
        new -= int(surplus[surplus < 0].sum())
    return lost, new
