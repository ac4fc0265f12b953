"""Texture coordinates of copies: on the faces of their scopes, or as a projection lays them.

In go meshes and where their copies stand, out come meshes with coordinates: copies whose
coordinates agree, but for whole tiles, share one. A mesh that has coordinates keeps them where no
projection is applied. No image is read, and nothing is written here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.mesh_types import Mesh
from ipmlang.runtime.export.placing import rotation_matrices
from ipmlang.runtime.export.sides import in_tiles, on_sides
from ipmlang.runtime.scene import TextureMaps

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_NEAR = 1e6  # texture coordinates that differ by less than a millionth are the same
_WHOLE = np.eye(2, 3)


@dataclass(slots=True, eq=False)
class Copies:
    """Copies of meshes: mesh (n,) index into meshes; matrix (n, 3, 4) to the world; way (n,) index
    into texture maps, -1 for none; textured (n,) whether an image is laid on them at all.
    """

    mesh: Indices
    matrix: Floats
    way: Indices
    textured: NDArray[np.bool_]


def laid(
    meshes: list[Mesh], copies: Copies, maps: TextureMaps | None
) -> tuple[list[Mesh], Indices]:
    """The meshes and the number of each copy's, those with an image with texture coordinates."""
    number = copies.mesh.copy()
    made = list(meshes)
    order = np.argsort(copies.mesh, kind="stable")
    order = order[copies.textured[order]]
    used, begins = np.unique(copies.mesh[order], return_index=True)
    for mesh, rows in zip(used.tolist(), np.split(order, begins[1:]), strict=True):
        way = copies.way[rows]
        projected = np.zeros(len(rows), np.bool_)
        if maps is not None:
            projected = (way >= 0) & maps.projected[way]
        for part, lay in ((rows[~projected], _fitted), (rows[projected], _projected)):
            if len(part):
                variants, which = lay(meshes[mesh], copies.matrix[part], copies.way[part], maps)
                number[part] = which + len(made)
                made += variants
    return _kept(made, number)


def _kept(meshes: list[Mesh], number: Indices) -> tuple[list[Mesh], Indices]:
    """The meshes that some copy shows, in their order."""
    used, place = np.unique(number, return_inverse=True)
    return [meshes[each] for each in used.tolist()], place.reshape(-1).astype(np.int64)


Variants = tuple[list[Mesh], Indices]


def _projected(mesh: Mesh, matrix: Floats, way: Indices, maps: TextureMaps | None) -> Variants:
    """Coordinates by a plane in space: a map (2, 4) of the mesh's own space for each copy."""
    assert maps is not None
    linear = rotation_matrices(maps.rotation[way]).transpose(0, 2, 1)
    linear[:, 0] *= maps.hand[way][:, None]  # a mirrored frame's x runs the other way
    rows = np.take_along_axis(linear, maps.plane[way][:, :, None], axis=1)
    rows = rows / maps.tile[way][:, :, None]
    shifted = matrix[:, :, 3] - maps.position[way]
    plain = np.concatenate([rows @ matrix[:, :, :3], rows @ shifted[:, :, None]], axis=2)
    change = maps.map[way]
    total = change[:, :, :2] @ plain
    total[:, :, 3] += change[:, :, 2]
    total[:, :, 3] -= np.floor(total[:, :, 3] + 0.5 / _NEAR)
    extent = np.ptp(mesh.vertices, axis=0) if len(mesh.vertices) else np.zeros(3)
    size = np.append(np.maximum(extent, np.abs(mesh.vertices).max(axis=0, initial=0.0)), 1.0)
    key = np.rint(total.reshape(len(way), -1) * np.tile(size, 2) * _NEAR)
    first, which = distinct_rows(key)
    points = mesh.vertices[mesh.corners]
    found = [points @ each[:, :3].T + each[:, 3] for each in total[first]]
    return [replace(mesh, uv=each) for each in found], which


def _fitted(mesh: Mesh, matrix: Floats, way: Indices, maps: TextureMaps | None) -> Variants:
    """Coordinates that the mesh has, or those on the sides of its box; 0 to 1, or in tiles."""
    tile, change = np.full((len(way), 2), np.nan), np.tile(_WHOLE, (len(way), 1, 1))
    if maps is not None:
        there = way >= 0
        tile[there], change[there] = maps.tile[way[there]], maps.map[way[there]]
    has_own = mesh.uv is not None and mesh.uv.any()
    lengths = np.linalg.norm(matrix[:, :, :3], axis=1) * (
        np.ptp(mesh.vertices[mesh.corners], axis=0) if len(mesh.corners) else np.zeros(3)
    )
    tiled = ~np.isnan(tile[:, 0]) & (not has_own)
    lengths[~tiled], tile[~tiled] = 0.0, 0.0  # which then make no difference
    key = np.concatenate([lengths, tile, change.reshape(-1, 6)], axis=1)
    first, which = distinct_rows(np.rint(key * _NEAR))
    made = []
    for row in first.tolist():
        if has_own or not tiled[row]:
            base = mesh.uv if has_own else on_sides(mesh)
        else:
            base = in_tiles(mesh, lengths[row]) / tile[row]
        assert base is not None
        uv = base @ change[row][:, :2].T + change[row][:, 2]
        made.append(replace(mesh, uv=uv))
    return made, which
