"""Faces that are wrong in themselves: without area, there twice, or turned against their like.

Takes a mesh whose equal points have equal labels; gives the mesh without such faces, and notes
that count what was mended. Faces that look inward all together are left: rooms are seen from
inside.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_numbers, stable_order
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, chosen_faces
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.invariants import mixed
from ipmlang.inverse.parts.pieces import neighbours, sums
from ipmlang.inverse.parts.welding import linked

_FLAT = 1e-9  # of the diagonal: faces that are less high show nothing


def sound(
    mesh: Mesh, same: Integers, owner: Integers, diagonal: float
) -> tuple[Mesh, Integers, tuple[Note, ...]]:
    """The mesh with only sound faces that agree with their neighbours, their numbers, notes."""
    notes = []
    kept = np.arange(len(owner))
    flat = _without_area(mesh, same, diagonal)
    twice = _twice(mesh, same, owner) & ~flat
    for lost, code, what in (
        (flat, "degenerate-face", "faces without area were left out"),
        (twice, "duplicate-face", "faces that are there twice were left out once"),
    ):
        if lost.any():
            notes.append(Note(code, what, int(lost.sum())))
    if notes:
        kept = np.flatnonzero(~(flat | twice))
        mesh = _kept(mesh, ~(flat | twice))
    turned = _against(mesh, same, owner[kept]) if len(kept) else np.zeros(0, np.bool_)
    if turned.any():
        what = "faces were turned to look the same way as their neighbours"
        notes.append(Note("flipped-face", what, int(turned.sum())))
        mesh = _turned(mesh, turned)
    return mesh, kept, tuple(notes)


def _kept(mesh: Mesh, keep: NDArray[np.bool_]) -> Mesh:
    """Some of the faces, with all vertices in their places."""
    return replace(chosen_faces(mesh, keep), vertices=mesh.vertices, corners=mesh.corners[
        np.repeat(keep, np.diff(mesh.offsets))])  # fmt: skip


def area_vectors(mesh: Mesh) -> Floats:
    """The area (f, 3) of each face along its normal."""
    if len(mesh.corners) == 3 * (len(mesh.offsets) - 1) and (np.diff(mesh.offsets) == 3).all():
        return _triangle_areas(mesh)
    points = mesh.vertices[mesh.corners]
    arm = points - np.repeat(points[mesh.offsets[:-1]], np.diff(mesh.offsets), axis=0)
    after, _ = neighbours(mesh.offsets)
    x, y, z = arm.T.copy()
    u, v, w = x[after], y[after], z[after]
    crossed = np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
    return sums(crossed, mesh.offsets) / 2


def _triangle_areas(mesh: Mesh) -> Floats:
    """The same where all faces are triangles, several times quicker."""
    one, two, three = mesh.corners.reshape(-1, 3).T.copy()
    columns = mesh.vertices.T.copy()
    x, y, z = (column[two] - column[one] for column in columns)
    u, v, w = (column[three] - column[one] for column in columns)
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1) / 2 + 0.0


def _without_area(mesh: Mesh, same: Integers, diagonal: float) -> NDArray[np.bool_]:
    """Faces that are a line or a point."""
    after, _ = neighbours(mesh.offsets)
    points = mesh.vertices[mesh.corners]
    ahead = points[after] - points
    longest = np.sqrt(np.maximum.reduceat(np.einsum("ci,ci->c", ahead, ahead), mesh.offsets[:-1]))
    area = np.linalg.norm(area_vectors(mesh), axis=1)
    point = same[mesh.corners]
    apart = np.add.reduceat((point != point[after]).astype(np.int64), mesh.offsets[:-1])
    found: NDArray[np.bool_] = (area <= _FLAT * diagonal * longest) | (apart < 3)
    return found


def _twice(mesh: Mesh, same: Integers, owner: Integers) -> NDArray[np.bool_]:
    """Faces that another before them has equalled: the same corners in the same sense."""
    after, _ = neighbours(mesh.offsets)
    point = same[mesh.corners].astype(np.uint64)
    edge = mixed(mixed(point) + np.uint64(3) * mixed(point[after] + np.uint64(1)))
    around = np.add.reduceat(edge, mesh.offsets[:-1])
    dress = mixed(mesh.material.astype(np.uint64)) + mixed(owner.astype(np.uint64) + np.uint64(7))
    first, _ = distinct_numbers(around + dress)
    again = np.ones(len(owner), np.bool_)
    again[first] = False
    return again


def _against(mesh: Mesh, same: Integers, owner: Integers) -> NDArray[np.bool_]:
    """Faces to turn so that all across edges of two faces look the same way: of the two ways the
    one that encloses space, else the one that takes less turning.
    """
    pairs, agree = _across(mesh, same, owner)
    count = len(owner)
    none = np.zeros(count, np.bool_)
    if agree.all():
        return none
    one, other = pairs.T
    swap = np.where(agree, 0, count)
    sheets = np.concatenate(
        [np.stack([one, other + swap], 1), np.stack([one + count, other + count - swap], 1)]
    )
    label = linked(2 * count, sheets)
    front, back = label[:count], label[count:]
    wrong = np.zeros(int(label.max()) + 1, np.bool_)
    disputed = one[~agree]
    wrong[front[disputed]] = wrong[back[disputed]] = True
    wrong[front[front == back]] = False  # a band with one side has no way to look
    rows = np.flatnonzero(wrong[front])
    vector = area_vectors(mesh)
    size = np.linalg.norm(vector, axis=1)
    # The lower label of the two stands for the sheet; faces of the other are turned against it.
    side = np.where(front < back, 1.0, -1.0)[rows]
    sheet = np.minimum(front, back)[rows]
    middle = mesh.vertices[mesh.corners[mesh.offsets[:-1]]][rows]
    total = len(wrong)
    facing = np.bincount(sheet, side * size[rows], total)
    inside = np.einsum("ij,ij->i", middle - middle[0], vector[rows]) * side
    volume = np.bincount(sheet, inside, total)
    closed = np.linalg.norm(
        np.stack([np.bincount(sheet, vector[rows, k] * side, total) for k in range(3)]), axis=0
    ) < 1e-6 * np.bincount(sheet, size[rows], total)
    wanted = np.where(closed & (volume != 0), np.sign(volume), np.sign(facing) + (facing == 0))
    none[rows] = side != wanted[sheet]
    return none


def _across(mesh: Mesh, same: Integers, owner: Integers) -> tuple[Integers, NDArray[np.bool_]]:
    """Pairs of faces (p, 2) that alone share an edge, and whether they run along it oppositely."""
    after, _ = neighbours(mesh.offsets)
    face = np.repeat(np.arange(len(owner)), np.diff(mesh.offsets))
    here = same[mesh.corners] + owner[face] * (int(same.max()) + 1)
    there = here[after]
    low, high = np.minimum(here, there), np.maximum(here, there)
    edge = mixed(mixed(low.astype(np.uint64)) ^ high.astype(np.uint64))
    order = stable_order(edge)
    edge = edge[order]
    starts = np.flatnonzero(np.concatenate([[True], edge[1:] != edge[:-1]]))
    two = starts[np.diff(np.append(starts, len(order))) == 2]
    first, second = order[two], order[two + 1]
    return np.stack([face[first], face[second]], axis=1), here[first] != here[second]


def _turned(mesh: Mesh, turned: NDArray[np.bool_]) -> Mesh:
    counts = np.diff(mesh.offsets)
    face = np.repeat(np.arange(len(counts)), counts)
    here = np.arange(len(face))
    order = np.where(turned[face], mesh.offsets[face] + mesh.offsets[face + 1] - 1 - here, here)
    normals = mesh.normals
    if normals is not None:
        normals = normals[order] * np.where(turned[face], -1.0, 1.0)[:, None]
    uv = None if mesh.uv is None else mesh.uv[order]
    return replace(mesh, corners=mesh.corners[order], uv=uv, normals=normals)
