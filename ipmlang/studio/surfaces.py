"""Meshes and their copies as the columns that OpenGL draws, in a world of size one.

Takes a `MeshScene`; gives a `Model`: for each mesh with many copies one `Surface` and its matrices,
and two more for all the rest, made real. Positions are centred in f64 before they become f32, so
that a model far from the origin, or very small, is drawn as well as any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats.mesh_types import Floats, Indices, Material, MeshScene
from ipmlang.studio.library import Library, library_of
from ipmlang.studio.outline import hull, hull_of_copies

Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_DRAWS = 256  # meshes at most that are drawn copy by copy
_NOTHING = np.zeros((0, 3))
_WORTH = 20_000  # corners that must be saved by it


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Corners and their copies. position (c, 3) f32; normal (c, 4) f16, the last a number that
    tells baked copies apart; color (c, 4) u8; uv (c, 2) f32; triangles (t, 3) u32 corners; parts:
    first triangle, how many, the index of the image on them or -1; edges (e, 2, 3) f32. matrix
    (k, 3, 4) f32 and paint (k, 4) u8 are the copies'; where the paint's opacity is 0, the corners
    keep their colours. closed: whether the faces bound volumes, so that half of them cast the whole
    shadow.
    """

    position: Singles
    normal: NDArray[np.float16]
    color: Bytes
    uv: Singles
    triangles: NDArray[np.uint32]
    parts: tuple[tuple[int, int, int], ...]
    edges: Singles
    matrix: Singles
    paint: Bytes
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """All that is drawn. outline (k, 3): points with its hull, around the origin, none farther than
    1; triangles: how many, with all copies; clear: whether one can look through anything; middle
    (3,) and size: what in the scene became the origin, and how long 1 is.
    """

    surfaces: tuple[Surface, ...]
    images: tuple[Material, ...]
    outline: Floats
    triangles: int
    clear: bool
    middle: Floats
    size: float


@dataclass(frozen=True, slots=True, eq=False)
class _Copies:
    """Copies that are drawn alike: their mesh (k,), matrix (k, 3, 4), paint (k, 4), and the image
    (k,) that is on them: -2 where the mesh keeps its own, -1 for none.
    """

    mesh: Indices
    matrix: Floats
    paint: Bytes
    image: Indices

    def rows(self, rows: Indices) -> _Copies:
        return _Copies(self.mesh[rows], self.matrix[rows], self.paint[rows], self.image[rows])


def model_of(scene: MeshScene, *, lines: bool = False, beside: Floats = _NOTHING) -> Model:
    """The model of a scene; an `IpmError` if there is nothing that could be seen. `beside`: points
    (n, 3) of what else there is.
    """
    library = library_of(scene, lines=lines)
    copies = _seen(scene, library)
    many, rest = _grouped(copies, library)
    closed = library.closed[rest.mesh]
    baked = [_baked(library, rest.rows(np.flatnonzero(closed == which))) for which in (True, False)]
    parts = [hull_of_copies(_positions(library, group), group.matrix) for group in many]
    outline = hull(np.concatenate([*(each.position for each in baked), *parts, beside]))
    middle, size = middle_and_size(outline)
    surfaces = [_repeated(library, group, middle, size) for group in many]
    for which, real in zip((True, False), baked, strict=True):
        if len(real.position):
            surfaces.append(_as_surface(real, middle, size, closed=which))
    return Model(
        tuple(surfaces),
        library.images,
        (outline - middle) / size,
        sum(len(each.triangles) * len(each.matrix) for each in surfaces),
        any(_is_clear(each, library) for each in surfaces),
        middle,
        size,
    )


def middle_and_size(outline: Floats) -> tuple[Floats, float]:
    """The middle (3,) of points (n, 3) and how far they are from it at most; an `IpmError` if they
    have no extent.
    """
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2
    size = float(np.linalg.norm(outline - middle, axis=1).max())
    if not 0 < size < np.inf:
        raise fail("nothing-drawn", "there is nothing to see: the model has no extent")
    return middle, size


def lone_surfaces(library: Library, meshes: Sequence[int]) -> tuple[Surface, ...]:
    """Each of these meshes about its own middle, the longest side of its box 1, one copy of it."""
    return tuple(_repeated(library, _lone(number), np.zeros(3), 1.0) for number in meshes)


def _lone(number: int) -> _Copies:
    """A mesh once, where it is and as it is."""
    one, keeps_its_own = np.zeros(1, np.int64), -2
    return _Copies(
        one + number, np.eye(3, 4)[None], np.zeros((1, 4), np.uint8), one + keeps_its_own
    )


def _seen(scene: MeshScene, library: Library) -> _Copies:
    """The copies that have faces, are at a finite place, and are not wholly transparent."""
    paint = np.concatenate([library.copy_color[:-1], np.zeros((1, 4), np.uint8)])[scene.material]
    image = np.append(library.copy_image[:-1], -2)[scene.material]
    faces = np.diff(library.faces)[scene.mesh] > 0
    there = np.isfinite(scene.matrix).all(axis=(1, 2))
    hidden = (scene.material >= 0) & (paint[:, 3] == 0)
    rows = np.flatnonzero(faces & there & ~hidden)
    if not len(rows):
        raise fail("nothing-drawn", "there is nothing to see: no faces at a finite place")
    return _Copies(scene.mesh, scene.matrix, paint, image).rows(rows)


def _grouped(copies: _Copies, library: Library) -> tuple[list[_Copies], _Copies]:
    """The copies of each mesh that saves most by being drawn copy by copy, and all the others."""
    key = copies.mesh * (len(library.images) + 2) + copies.image + 2
    kinds, first, group, count = np.unique(
        key, return_index=True, return_inverse=True, return_counts=True
    )
    group = group.reshape(-1)
    saved = (count - 1) * np.diff(library.corners)[copies.mesh[first]]
    best = np.argsort(-saved, kind="stable")[:_DRAWS]
    best = np.sort(best[saved[best] > _WORTH])
    place = np.full(len(kinds), -1)
    place[best] = np.arange(len(best))
    order = np.argsort(place[group], kind="stable")
    ends = np.searchsorted(place[group][order], np.arange(len(best) + 1))
    many = [copies.rows(order[a:b]) for a, b in pairwise(ends.tolist())]
    return many, copies.rows(order[: ends[0]])


@dataclass(frozen=True, slots=True, eq=False)
class _Baked:
    """Corners, triangles and edges of copies made real, in the world and in f64; copy (c,) says
    whose each corner is.
    """

    position: Floats
    normal: Floats
    color: Bytes
    uv: Floats
    triangles: Indices
    image: Indices
    edges: Floats
    copy: Indices


def _baked(library: Library, copies: _Copies) -> _Baked:
    corner, row = _runs(library.corners, copies.mesh)
    triangle, triangle_row = _runs(library.faces, copies.mesh)
    edge, edge_row = _runs(library.lines, copies.mesh)
    counts = np.diff(library.corners)[copies.mesh]
    moved = np.cumsum(counts) - counts - library.corners[copies.mesh]  # where its corners went
    linear = copies.matrix[:, :, :3]
    painted = copies.paint[row]
    own = copies.image[triangle_row]
    return _Baked(
        _moved(copies.matrix, row, library.position[corner]),
        np.einsum("cij,cj->ci", _cofactors(linear)[row], library.normal[corner]),
        np.where(painted[:, 3:] > 0, painted, library.color[corner]),
        library.uv[corner],
        library.triangles[triangle] + moved[triangle_row][:, None],
        np.where(own == -2, library.image[triangle], own),
        np.stack(
            [_moved(copies.matrix, edge_row, library.edges[edge, end]) for end in (0, 1)], axis=1
        ),
        row,
    )


def _runs(starts: Indices, chosen: Indices) -> tuple[Indices, Indices]:
    """The members of the chosen runs one after the other, and which choice each belongs to."""
    count = np.diff(starts)[chosen]
    owner = np.repeat(np.arange(len(chosen)), count)
    begin = np.cumsum(count) - count
    return np.arange(len(owner)) + (starts[chosen] - begin)[owner], owner


def _moved(matrix: Floats, row: Indices, points: Floats) -> Floats:
    """Points (n, 3), each under the matrix of its row."""
    result = matrix[row, :, 3]
    for axis in range(3):
        result += matrix[row, :, axis] * points[:, axis : axis + 1]
    return result


def _cofactors(linear: Floats) -> Floats:
    """(n, 3, 3) what turns normals along, also where a map flattens; signs do not matter here."""
    x, y, z = linear[:, 0], linear[:, 1], linear[:, 2]
    return np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)], axis=1)


def _as_surface(baked: _Baked, middle: Floats, size: float, *, closed: bool) -> Surface:
    """The baked corners in the world of size one, sorted by image, as a single copy."""
    order = np.argsort(baked.image, kind="stable")
    return Surface(
        ((baked.position - middle) / size).astype(np.float32),
        _unit_normals(baked.normal, _numbers(baked.copy)),
        baked.color,
        baked.uv.astype(np.float32),
        baked.triangles[order].astype(np.uint32),
        _parts(baked.image[order]),
        ((baked.edges - middle) / size).astype(np.float32),
        np.eye(3, 4, dtype=np.float32)[None],
        np.zeros((1, 4), np.uint8),
        closed,
    )


def _repeated(library: Library, copies: _Copies, middle: Floats, size: float) -> Surface:
    """One mesh about its own middle, and its copies."""
    number = int(copies.mesh[0])
    corners = slice(library.corners[number], library.corners[number + 1])
    faces = slice(library.faces[number], library.faces[number + 1])
    lines = slice(library.lines[number], library.lines[number + 1])
    position = library.position[corners]
    center = (position.min(axis=0) + position.max(axis=0)) / 2
    extent = float(np.ptp(position, axis=0).max()) or 1.0
    image = library.image[faces] if copies.image[0] == -2 else np.full(1, copies.image[0])
    image = np.broadcast_to(image, faces.stop - faces.start)
    order = np.argsort(image, kind="stable")
    linear = copies.matrix[:, :, :3] * (extent / size)
    place = copies.matrix[:, :, :3] @ center + copies.matrix[:, :, 3] - middle
    return Surface(
        ((position - center) / extent).astype(np.float32),
        _unit_normals(library.normal[corners]),
        library.color[corners],
        library.uv[corners].astype(np.float32),
        (library.triangles[faces][order] - corners.start).astype(np.uint32),
        _parts(image[order]),
        ((library.edges[lines] - center) / extent).astype(np.float32),
        np.concatenate([linear, (place / size)[:, :, None]], axis=2).astype(np.float32),
        copies.paint,
        bool(library.closed[number]),
    )


def _positions(library: Library, copies: _Copies) -> Floats:
    number = int(copies.mesh[0])
    return library.position[library.corners[number] : library.corners[number + 1]]


def _parts(image: Indices) -> tuple[tuple[int, int, int], ...]:
    """Runs of equal images: the first triangle, how many, the image."""
    kinds, first, count = np.unique(image, return_index=True, return_counts=True)
    return tuple(zip(first.tolist(), count.tolist(), kinds.tolist(), strict=True))


def _unit_normals(normals: Floats, chance: Floats | float = 0.0) -> NDArray[np.float16]:
    """(c, 4) normals of length 1, or 0, and the numbers."""
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    table = np.empty((len(normals), 4), np.float16)
    table[:, :3] = np.nan_to_num(normals / np.where(length > 0, length, 1.0))
    table[:, 3] = chance
    return table


def _numbers(copies: Indices) -> Floats:
    """A number 0 to 1 for each copy, far from those of its neighbours: the golden ratio's."""
    numbers: Floats = np.modf(copies * 0.6180339887498949)[0]
    return numbers


def _is_clear(surface: Surface, library: Library) -> bool:
    images = {library.images[image].alpha for *_, image in surface.parts if image >= 0}
    paint = surface.paint[:, 3]
    return bool(
        images - {""} or (surface.color[:, 3] < 255).any() or ((paint > 0) & (paint < 255)).any()
    )
