"""All meshes of a scene end to end, with what each of their corners looks like.

Takes a `MeshScene`; gives a `Library`, from which any run of meshes is a slice of a few columns, so
that a hundred thousand meshes cost no more than their corners. Nothing here knows OpenGL.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, merged, triangulated
from ipmlang.studio.corners import closed_faces, corner_normals, sharp_edges

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Bytes = NDArray[np.uint8]

CLAY = (0.87, 0.86, 0.84, 1.0)
"""The colour (sRGB) of what has none: unglazed, nearly white."""
_WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """Corners of all meshes: position (c, 3) in the mesh's space, normal (c, 3) of any length,
    color (c, 4) sRGB, uv (c, 2). triangles (t, 3) corners; image (t,) index into `images`, -1 for
    none; edges (e, 2, 3) positions. corners, faces and lines (m + 1,) say where those of each mesh
    begin, in corners, triangles and edges. closed (m,): whether a mesh bounds a volume. images: the
    materials with one. copy_image and copy_color (n + 1,) are those of the scene's own materials,
    the last for none.
    """

    position: Floats
    normal: Floats
    color: Bytes
    uv: Floats
    triangles: Indices
    image: Indices
    edges: Floats
    corners: Indices
    faces: Indices
    lines: Indices
    closed: NDArray[np.bool_]
    images: tuple[Material, ...]
    copy_image: Indices
    copy_color: Bytes


def library_of(scene: MeshScene, *, lines: bool) -> Library:
    """The library of a scene's meshes."""
    mesh = merged(list(scene.meshes))
    known = (*mesh.materials, *scene.materials)
    images = tuple(dict.fromkeys(each for each in known if each.texture is not None))
    number = {each: index for index, each in enumerate(images)}
    image_of = np.array([*(number.get(each, -1) for each in known), -1], np.int64)
    color_of = np.array([color_bytes(each) for each in (*known, None)], np.uint8)
    corners, triangle_face = triangulated(mesh)
    face = np.repeat(np.arange(len(mesh.material)), np.diff(mesh.offsets))
    first_face = _starts([len(each.material) for each in scene.meshes])
    edges, edge_face = sharp_edges(mesh) if lines else (np.zeros((0, 2), np.int64), face[:0])
    order = np.argsort(edge_face, kind="stable")
    own = len(mesh.materials)
    return Library(
        mesh.vertices[mesh.corners],
        _normals(mesh, scene.meshes),
        color_of[mesh.material][face],
        np.zeros((len(face), 2)) if mesh.uv is None else mesh.uv,
        corners,
        image_of[mesh.material][triangle_face],
        mesh.vertices[edges[order]],
        _starts([len(each.corners) for each in scene.meshes]),
        np.searchsorted(triangle_face, first_face),
        np.searchsorted(edge_face[order], first_face),
        np.diff(np.append(0, np.cumsum(~closed_faces(mesh)))[first_face]) == 0,
        images,
        image_of[own:],
        color_of[own:],
    )


def color_bytes(material: Material | None) -> tuple[int, ...]:
    """What is shown of a material, 0 to 255 each; an image shows as it is."""
    color = None if material is None else material.color
    if color is None:
        color = CLAY if material is None or material.texture is None else _WHITE
    return tuple(round(min(max(part, 0.0), 1.0) * 255) for part in color)


def _normals(mesh: Mesh, parts: Sequence[Mesh]) -> Floats:
    """Those that the files give, and those of the faces elsewhere."""
    if mesh.normals is not None:
        return mesh.normals
    normals, begin = corner_normals(mesh), 0
    for part in parts:
        if part.normals is not None:
            normals[begin : begin + len(part.corners)] = part.normals
        begin += len(part.corners)
    return normals


def _starts(counts: Sequence[int]) -> Indices:
    return np.concatenate([[0], np.cumsum(np.array(counts, np.int64))]).astype(np.int64)
