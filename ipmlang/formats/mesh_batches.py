"""Copies of meshes made real, many at once, for formats that know no copies.

Takes a scene of meshes; gives batches of equal meshes with all their vertices in the world. A
mirrored copy has its faces turned, so that they still face outward. Nothing is written here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.mesh_types import (
    UNCOLORED,
    Z_TO_Y,
    Floats,
    Indices,
    Mesh,
    MeshScene,
    merged,
    reversed_faces,
    triangulated,
)

Colors: TypeAlias = NDArray[np.uint8]

_BATCH = 300_000  # vertices made at a time
_SMALL = 1_000  # vertices of a batch that is made together with others of its name and material


@dataclass(slots=True)
class Batch:
    """k copies of one mesh: `vertices` (k, v, 3) in the world; `mesh` has its faces in the order
    that faces outward; `name` and `material` are indices into the scene's, material -1 for the
    mesh's own; `normals` (k, c, 3) of unit length in the world, where the mesh has any.
    """

    mesh: Mesh
    vertices: Floats
    name: int
    material: int
    normals: Floats | None = None


def batches(scene: MeshScene, up: Literal["y-up", "z-up"] = "z-up") -> Iterator[Batch]:
    """All copies, those of a name and material together, names and materials by first use."""
    waiting: list[Batch] = []
    vertices = 0
    for batch in _batches_of_meshes(scene, up):
        size = batch.vertices.shape[0] * batch.vertices.shape[1]
        fits = size <= _SMALL and vertices + size <= _BATCH
        if waiting and not (fits and _look(waiting[0]) == _look(batch)):
            yield _joined(waiting)
            waiting, vertices = [], 0
        if size <= _SMALL:
            waiting.append(batch)
            vertices += size
        else:
            yield batch
    if waiting:
        yield _joined(waiting)


def _look(batch: Batch) -> tuple[int, int, bool]:
    return batch.name, batch.material, batch.normals is None


def _joined(parts: list[Batch]) -> Batch:
    """One batch of one mesh, all of whose copies are faces of it."""
    if len(parts) == 1:
        return parts[0]
    whole = merged([each for part in parts for each in _placed(part)])
    normals = None if whole.normals is None else whole.normals[None]
    return Batch(whole, whole.vertices[None], parts[0].name, parts[0].material, normals)


def _placed(part: Batch) -> Iterator[Mesh]:
    """Each copy as a mesh of its own."""
    for copy, vertices in enumerate(part.vertices):
        normals = None if part.normals is None else part.normals[copy]
        yield replace(part.mesh, vertices=vertices, normals=normals)


def _batches_of_meshes(scene: MeshScene, up: Literal["y-up", "z-up"]) -> Iterator[Batch]:
    mirrored = np.linalg.det(scene.matrix[:, :, :3]) < 0
    key = np.stack([scene.name, scene.material, scene.mesh, mirrored.astype(np.int64)], axis=1)
    first, kind = distinct_rows(key.astype(np.float64))
    distinct = key[first]
    rows_by_group = np.argsort(kind, kind="stable")
    ends = np.cumsum(np.bincount(kind, minlength=len(distinct)))
    turn = Z_TO_Y if up == "y-up" else np.eye(3)
    for group in _in_order(distinct).tolist():
        name, material, number, is_mirrored = distinct[group].tolist()
        mesh = scene.meshes[number]
        if not len(mesh.corners):
            continue
        mesh = reversed_faces(mesh) if is_mirrored else mesh
        rows = rows_by_group[ends[group - 1] if group else 0 : ends[group]]
        step = max(1, _BATCH // len(mesh.vertices))
        for begin in range(0, len(rows), step):
            matrices = turn @ scene.matrix[rows[begin : begin + step]]
            vertices = mesh.vertices @ matrices[:, :, :3].transpose(0, 2, 1)
            normals = _turned(mesh.normals, matrices[:, :, :3])
            yield Batch(mesh, vertices + matrices[:, None, :, 3], name, material, normals)


def _turned(normals: Floats | None, linear: Floats) -> Floats | None:
    """Normals (c, 3) under maps (k, 3, 3), of unit length: what is crossed with surfaces is turned
    by the cofactors of a map.
    """
    if normals is None:
        return None
    x, y, z = linear[:, 0], linear[:, 1], linear[:, 2]
    cofactors = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=1)
    hand = np.sign(np.einsum("ki,ki->k", x, cofactors[:, 0]))
    turned = normals @ (cofactors * hand[:, None, None]).transpose(0, 2, 1)
    length = np.linalg.norm(turned, axis=2, keepdims=True)
    return np.asarray(turned / np.where(length > 0, length, 1.0))


def _in_order(groups: Indices) -> Indices:
    """Groups of a name and material together, in the order of the first; `groups` are in theirs."""
    _, look = distinct_rows(groups[:, :2].astype(np.float64))
    return np.argsort(look, kind="stable")


def world_triangles(
    scene: MeshScene, up: Literal["y-up", "z-up"] = "z-up"
) -> tuple[Floats, Indices, Colors | None]:
    """All copies as vertices (v, 3), triangles (t, 3) and their colours (t, 4), 0 to 255 each; None
    instead of these where nothing has a colour.
    """
    vertices: list[NDArray[np.float64]] = [np.zeros((0, 3))]
    triangles: list[Indices] = [np.zeros((0, 3), np.int64)]
    colors: list[Colors] = [np.zeros((0, 4), np.uint8)]
    count = 0
    for batch in batches(scene, up):
        copies, size = batch.vertices.shape[:2]
        corners, face = triangulated(batch.mesh)
        one = batch.mesh.corners[corners]
        shifts = count + size * np.arange(copies)
        triangles.append((one[None] + shifts[:, None, None]).reshape(-1, 3))
        vertices.append(batch.vertices.reshape(-1, 3))
        colors.append(np.tile(_face_colors(scene, batch)[face], (copies, 1)))
        count += copies * size
    known = (*scene.materials, *(each for mesh in scene.meshes for each in mesh.materials))
    colored = any(each.color is not None for each in known)
    return (
        np.concatenate(vertices),
        np.concatenate(triangles),
        np.concatenate(colors) if colored else None,
    )


def _face_colors(scene: MeshScene, batch: Batch) -> Colors:
    """The colour (f, 4) of each face of a batch's mesh; one that has none is light grey."""
    mesh = batch.mesh
    if batch.material >= 0:
        table = [scene.materials[batch.material].color]
        chosen = np.zeros(len(mesh.material), np.int64)
    else:
        table = [*(each.color for each in mesh.materials), None]
        chosen = mesh.material  # -1, for none, is the last entry
    shares = np.array([UNCOLORED if color is None else color for color in table])
    rounded: Colors = np.rint(shares * 255).astype(np.uint8)
    return rounded[chosen]
