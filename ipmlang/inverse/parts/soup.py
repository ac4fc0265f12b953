"""All faces of a model in the world, z up, before anything is known of parts.

Takes a scene of meshes and copies; gives one mesh, whose faces know which copy they came from and
which names they stood under. Files with y up are turned. Nothing here welds or compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.formats.mesh_types import Z_TO_Y, Material, Mesh, MeshScene, reversed_faces
from ipmlang.inverse.frames import Floats, Integers


@dataclass(frozen=True, slots=True, eq=False)
class Soup:
    """mesh: all faces in the world, z up; owner (f,): the copy of the scene that a face is of;
    shared (o,): whether a copy's mesh is used more than once; group of the mesh: index into
    paths, the names that faces stood under, outermost first.
    """

    mesh: Mesh
    owner: Integers
    shared: np.ndarray[tuple[int], np.dtype[np.bool_]]
    paths: tuple[tuple[str, ...], ...]


def gathered(scene: MeshScene, turned: bool, unit: float) -> Soup:
    """The faces of all copies. turned: y is up in the scene; unit: what its lengths are times."""
    materials: dict[Material, int] = {}
    paths: dict[tuple[str, ...], int] = {}
    around = (Z_TO_Y.T if turned else np.eye(3)) * unit
    blocks = []
    for row in _rows_by_mesh(scene):
        mesh = scene.meshes[scene.mesh[row[0]]]
        if len(mesh.corners):
            blocks.append(_block(scene, mesh, row, around, (materials, paths)))
    order = np.argsort(np.concatenate([block.owner for block in blocks]), kind="stable")
    whole = _joined(blocks, tuple(materials), tuple(paths))
    uses = np.bincount(scene.mesh, minlength=len(scene.meshes))
    mesh, owner = _reordered(whole, order), np.concatenate([block.owner for block in blocks])[order]
    return Soup(mesh, owner, uses[scene.mesh] > 1, tuple(paths))


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """All copies of one mesh, one after the other; indices into materials and paths of all."""

    mesh: Mesh
    owner: Integers


def _rows_by_mesh(scene: MeshScene) -> list[Integers]:
    """Copies of one mesh and of one handedness together, in the order of their first."""
    mirrored = np.linalg.det(scene.matrix[:, :, :3]) < 0
    key = scene.mesh * 2 + mirrored
    order = np.argsort(key, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(key[order])) + 1)
    return sorted((group for group in groups if len(group)), key=lambda group: int(group[0]))


def _block(
    scene: MeshScene,
    mesh: Mesh,
    rows: Integers,
    around: Floats,
    tables: tuple[dict[Material, int], dict[tuple[str, ...], int]],
) -> _Block:
    materials, paths = tables
    matrix = around @ scene.matrix[rows]
    if np.linalg.det(matrix[0, :, :3]) < 0:
        mesh = reversed_faces(mesh)
    count, points, faces = len(rows), len(mesh.vertices), len(mesh.material)
    linear = matrix[:, :, :3].transpose(0, 2, 1)
    vertices = (mesh.vertices @ linear + matrix[:, None, :, 3]).reshape(-1, 3)
    corners = mesh.corners[None] + points * np.arange(count)[:, None]
    sizes = np.tile(np.diff(mesh.offsets), count)
    known = np.array([*(materials.setdefault(m, len(materials)) for m in mesh.materials), -1])
    material = np.tile(known[mesh.material], count)
    own = scene.material[rows]
    if (own >= 0).any():
        given = [
            materials.setdefault(scene.materials[each], len(materials)) if each >= 0 else -1
            for each in own.tolist()
        ]
        instead = np.repeat(np.array(given), faces)
        material = np.where(np.repeat(own, faces) >= 0, instead, material)
    group = [_paths(scene, mesh, row, paths)[mesh.group] for row in rows.tolist()]
    return _Block(
        Mesh(
            vertices,
            corners.reshape(-1),
            np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
            material,
            np.concatenate(group),
            uv=None if mesh.uv is None else np.tile(mesh.uv, (count, 1)),
            normals=_turned_normals(mesh.normals, matrix[:, :, :3]),
        ),
        np.repeat(rows, faces),
    )


def _paths(scene: MeshScene, mesh: Mesh, row: int, paths: dict[tuple[str, ...], int]) -> Integers:
    """The index of each group's path in a copy: the copy's own name before the group's."""
    name = scene.names[scene.name[row]] if len(scene.mesh) > 1 else ""
    found = []
    for group in mesh.groups or ((),):
        above = (name,) if name and name not in group else ()
        found.append(paths.setdefault((*above, *group), len(paths)))
    return np.array(found, np.int64)


def _turned_normals(normals: Floats | None, linear: Floats) -> Floats | None:
    if normals is None:
        return None
    if (np.abs(linear - np.eye(3)) < 1e-12).all():
        return np.tile(normals, (len(linear), 1))
    turned = (normals @ np.linalg.pinv(linear)).reshape(-1, 3)
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(turned / np.maximum(length, 1e-300))


def _joined(
    blocks: list[_Block], materials: tuple[Material, ...], paths: tuple[tuple[str, ...], ...]
) -> Mesh:
    meshes = [block.mesh for block in blocks]
    points = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    corners = np.cumsum([0, *(len(mesh.corners) for mesh in meshes)])
    some_uv = any(mesh.uv is not None for mesh in meshes)
    uv = [np.zeros((len(m.corners), 2)) if m.uv is None else m.uv for m in meshes]
    normals = [mesh.normals for mesh in meshes if mesh.normals is not None]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([m.corners + start for m, start in zip(meshes, points, strict=False)]),
        np.concatenate(
            [
                *(m.offsets[:-1] + start for m, start in zip(meshes, corners, strict=False)),
                corners[-1:],
            ]
        ),
        np.concatenate([mesh.material for mesh in meshes]),
        np.concatenate([mesh.group for mesh in meshes]),
        materials,
        paths,
        np.concatenate(uv) if some_uv else None,
        np.concatenate(normals) if len(normals) == len(meshes) else None,
    )


def _reordered(mesh: Mesh, order: Integers) -> Mesh:
    """The mesh with its faces in another order."""
    if (np.diff(order) == 1).all():
        return mesh
    sizes = np.diff(mesh.offsets)[order]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    corner = corners_of(mesh.offsets, order)
    return Mesh(
        mesh.vertices,
        mesh.corners[corner],
        offsets,
        mesh.material[order],
        mesh.group[order],
        mesh.materials,
        mesh.groups,
        None if mesh.uv is None else mesh.uv[corner],
        None if mesh.normals is None else mesh.normals[corner],
    )


def corners_of(offsets: Integers, faces: Integers) -> Integers:
    """The numbers of the corners of faces, in the order of the faces."""
    sizes = np.diff(offsets)[faces]
    ends = np.cumsum(sizes)
    return np.repeat(offsets[faces] - (ends - sizes), sizes) + np.arange(sizes.sum())
