"""Faces sorted by the part that they belong to, with tables of what each part holds.

Takes all faces and the part of each; gives columns in which a part's faces, corners and vertices
lie together, so that thousands of parts are measured and compared at once. Nothing is rounded:
vertices are those of the file.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import by_first, distinct_numbers
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.soup import corners_of

Number = TypeVar("Number", np.float64, np.int64, np.uint64)


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """n parts. vertices (v, 3), corners (c,) into them, offsets (f + 1,) of faces, material and
    group (f,), uv (c, 2), normals (c, 3) as in a mesh, all sorted by part; laid (c, 2): the uv
    that tell parts apart, 0 where no image is laid; face_start,
    corner_start, vertex_start (n + 1,) where each part begins; after, before (c,): the corners
    next to one in its face; face (f): the row of each in the soup.
    """

    vertices: Floats
    corners: Integers
    offsets: Integers
    material: Integers
    group: Integers
    uv: Floats | None
    normals: Floats | None
    laid: Floats | None
    face_start: Integers
    corner_start: Integers
    vertex_start: Integers
    after: Integers
    before: Integers
    face: Integers

    def __len__(self) -> int:
        return len(self.face_start) - 1


def sorted_pieces(mesh: Mesh, same: Integers, part: Integers, keep_uv: bool) -> Pieces:
    """The faces of a mesh by part (f,). same (v,): vertices of equal label in a part are one;
    keep_uv: texture coordinates count even where no image is laid.
    """
    order = np.argsort(part, kind="stable")
    sizes = np.diff(mesh.offsets)[order]
    corner = corners_of(mesh.offsets, order)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    face_start = np.searchsorted(part[order], np.arange(int(part.max()) + 2))
    corner_start = offsets[face_start]
    used = mesh.corners[corner]
    owner = np.repeat(part[order], sizes)
    # Vertices are numbered by first use, so that equal files of faces number them alike.
    key = owner * (int(same.max()) + 1) + same[used]
    first, kind = by_first(*distinct_numbers(key))
    after, before = neighbours(offsets)
    return Pieces(
        mesh.vertices[used[first]],
        kind,
        offsets,
        mesh.material[order],
        mesh.group[order],
        None if mesh.uv is None else mesh.uv[corner],
        None if mesh.normals is None else mesh.normals[corner],
        _laid(mesh, order, corner, keep_uv),
        face_start,
        corner_start,
        np.searchsorted(first, corner_start),
        after,
        before,
        order,
    )


def with_diagonals(pieces: Pieces) -> Pieces:
    """The pieces told apart also by the triangles that a fan cuts their faces into: of faces of
    four the diagonal counts, of larger ones the first corner.
    """
    size = np.diff(pieces.offsets)
    step = np.arange(len(pieces.corners)) - np.repeat(pieces.offsets[:-1], size)
    around = np.repeat(size, size)
    joined = np.where(around == 4, step % 2 == 0, (step == 0) & (around > 4))
    columns = [joined[:, None].astype(np.float64)]
    if pieces.laid is not None:
        columns.append(pieces.laid)
    return replace(pieces, laid=np.concatenate(columns, axis=1))


def chosen(pieces: Pieces, rows: Integers) -> Pieces:
    """Some of the parts, in this order."""
    corner, face, vertex = (
        corners_of(start, rows)
        for start in (pieces.corner_start, pieces.face_start, pieces.vertex_start)
    )
    offsets = _ends(np.diff(pieces.offsets)[face])
    vertex_start = _ends(np.diff(pieces.vertex_start)[rows])
    moved = vertex_start[:-1] - pieces.vertex_start[rows]
    after, before = neighbours(offsets)
    return Pieces(
        pieces.vertices[vertex],
        pieces.corners[corner] + np.repeat(moved, np.diff(pieces.corner_start)[rows]),
        offsets,
        pieces.material[face],
        pieces.group[face],
        None if pieces.uv is None else pieces.uv[corner],
        None if pieces.normals is None else pieces.normals[corner],
        None if pieces.laid is None else pieces.laid[corner],
        _ends(np.diff(pieces.face_start)[rows]),
        _ends(np.diff(pieces.corner_start)[rows]),
        vertex_start,
        after,
        before,
        pieces.face[face],
    )


def _ends(sizes: Integers) -> Integers:
    """Where each of several things of these sizes begins, and where the last ends."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _laid(mesh: Mesh, faces: Integers, corner: Integers, keep_uv: bool) -> Floats | None:
    textured = np.array([*(each.texture is not None for each in mesh.materials), False]) | keep_uv
    if mesh.uv is None or not textured.any():
        return None
    shown = np.repeat(textured[mesh.material[faces]], np.diff(mesh.offsets)[faces])
    return np.where(shown[:, None], mesh.uv[corner], 0.0)


def neighbours(offsets: Integers) -> tuple[Integers, Integers]:
    """The corner after and before each corner, round its face."""
    count = int(offsets[-1])
    after, before = np.arange(1, count + 1), np.arange(-1, count - 1)
    after[offsets[1:] - 1] = offsets[:-1]
    before[offsets[:-1]] = offsets[1:] - 1
    return after, before


def sums(values: NDArray[Number], starts: Integers) -> NDArray[Number]:
    """Sums of rows between starts (n + 1,), none of them empty."""
    if values.ndim == 1:
        return np.add.reduceat(values, starts[:-1])
    # Column by column is several times quicker than rows of three.
    return np.stack([np.add.reduceat(each, starts[:-1]) for each in values.T.copy()], axis=1)


def piece_mesh(pieces: Pieces, part: int, like: Mesh) -> Mesh:
    """One part as a mesh with the materials and groups that it uses, in the order of use."""
    faces = slice(pieces.face_start[part], pieces.face_start[part + 1])
    corners = slice(pieces.corner_start[part], pieces.corner_start[part + 1])
    points = slice(pieces.vertex_start[part], pieces.vertex_start[part + 1])
    begin = pieces.face_start[part]
    offsets = pieces.offsets[begin : pieces.face_start[part + 1] + 1]
    used = [int(each) for each in dict.fromkeys(pieces.material[faces].tolist()) if each >= 0]
    number = np.full(len(like.materials) + 1, -1)
    number[used] = np.arange(len(used))
    return Mesh(
        pieces.vertices[points],
        pieces.corners[corners] - points.start,
        offsets - offsets[0],
        number[pieces.material[faces]],
        np.zeros(faces.stop - faces.start, np.int64),
        tuple(like.materials[each] for each in used),
        ((),),
        None if pieces.uv is None else pieces.uv[corners],
        None if pieces.normals is None else pieces.normals[corners],
    )
