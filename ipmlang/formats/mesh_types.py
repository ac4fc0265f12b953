"""What a mesh and a scene of meshes are, free of any file format, and what follows from them alone.

Readers make these, writers take them. z points up; faces are counter-clockwise seen from outside.
Nothing here reads, writes or derives.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import Note
from ipmlang.formats.textures import Texture
from ipmlang.formats.triangles import cut_faces

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Color: TypeAlias = tuple[float, float, float, float]
Alpha: TypeAlias = Literal["", "MASK", "BLEND"]

UNCOLORED: Color = (0.8, 0.8, 0.8, 1.0)
"""What is shown where nothing says a colour."""
FARTHEST = 1e100  # of a coordinate; products of three of them are still numbers
_TOGETHER = 100_000  # corners of small meshes that are triangulated at a time

Z_TO_Y = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""Turns a z-up model to y-up: (x, y, z) to (x, z, -y). Its transpose turns back."""


@dataclass(frozen=True, slots=True)
class Material:
    """A name and a colour: red, green, blue and opacity, 0 to 1, as shown on a screen (sRGB).

    `texture`: an image that the colour is multiplied with, laid by the corners' texture
    coordinates and repeated. `alpha`: what the image's own opacity does: nothing, cut out, or
    let through.
    """

    name: str
    color: Color | None = None
    texture: Texture | None = None
    alpha: Alpha = ""


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Faces over shared vertices.

    vertices (v, 3) f64; corners (c,) the faces' vertices one after the other; offsets (f + 1,)
    where each face's corners begin; material (f,) index into materials, -1 for none; group (f,)
    index into groups, each the names that a face goes by (its object, then its groups); uv (c, 2)
    and normals (c, 3) belong to corners, None if the file had none. uv: u right and v up, an
    image fills 0 to 1; 0 for corners without any in a mesh where others have some.
    """

    vertices: Floats
    corners: Indices
    offsets: Indices
    material: Indices
    group: Indices
    materials: tuple[Material, ...] = ()
    groups: tuple[tuple[str, ...], ...] = ()
    uv: Floats | None = None
    normals: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class MeshScene:
    """Meshes and their copies, in columns of equal length n, so that a million of them are cheap.

    mesh (n,) index into meshes; matrix (n, 3, 4) from the mesh's space to the world; name (n,)
    index into names; material (n,) index into materials, -1 where the mesh keeps its own; rule
    (n,) index into rules and key (n,) u64, both empty if nothing is known of rules.
    """

    meshes: tuple[Mesh, ...]
    mesh: Indices
    matrix: Floats
    name: Indices
    material: Indices
    names: tuple[str, ...]
    materials: tuple[Material, ...] = ()
    rule: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    key: NDArray[np.uint64] = field(default_factory=lambda: np.zeros(0, np.uint64))
    rules: tuple[str, ...] = ()
    extras: Mapping[str, str | int] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()


def triangle_mesh(vertices: Floats, triangles: NDArray[np.integer], name: str = "") -> Mesh:
    """A mesh of triangles (t, 3) without materials."""
    count = len(triangles)
    return Mesh(
        np.asarray(vertices, np.float64),
        np.asarray(triangles, np.int64).reshape(-1),
        np.arange(count + 1, dtype=np.int64) * 3,
        np.full(count, -1, np.int64),
        np.zeros(count, np.int64),
        groups=((name,),) if name else ((),),
    )


def single(mesh: Mesh, name: str, notes: tuple[Note, ...] = ()) -> MeshScene:
    """A scene of one mesh where it stands."""
    zero = np.zeros(1, np.int64)
    return MeshScene((mesh,), zero, np.eye(3, 4)[None], zero, zero - 1, (name,), notes=notes)


def triangulated(mesh: Mesh) -> tuple[Indices, Indices]:
    """Corner numbers (t, 3) of triangles that cover the faces, and the face of each (t,)."""
    return cut_faces(mesh.vertices, mesh.corners, mesh.offsets)


def all_triangulated(meshes: Sequence[Mesh]) -> Iterator[tuple[Indices, Indices]]:
    """What `triangulated` gives for each of the meshes, small ones many at a time."""
    ends = np.cumsum([len(mesh.corners) for mesh in meshes])
    begin = 0
    while begin < len(meshes):
        done = ends[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + _TOGETHER, side="right")))
        yield from _triangulated_together(meshes[begin:end])
        begin = end


def _triangulated_together(meshes: Sequence[Mesh]) -> Iterator[tuple[Indices, Indices]]:
    points = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    corners = np.cumsum([0, *(len(mesh.corners) for mesh in meshes)])
    faces = np.cumsum([0, *(len(mesh.offsets) - 1 for mesh in meshes)])
    begins = [mesh.offsets[:-1] + shift for mesh, shift in zip(meshes, corners, strict=False)]
    cut, face = cut_faces(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([m.corners + shift for m, shift in zip(meshes, points, strict=False)]),
        np.concatenate([*begins, corners[-1:]]),
    )
    parts = np.searchsorted(face, faces)
    for number in range(len(meshes)):
        part = slice(parts[number], parts[number + 1])
        yield cut[part] - corners[number], face[part] - faces[number]


def face_normals(mesh: Mesh) -> Floats:
    """(f, 3) the direction that each face looks in, as long as twice its area."""
    counts = np.diff(mesh.offsets)
    found = np.zeros((len(counts), 3))
    full = counts > 0
    begin = mesh.offsets[:-1][full]
    if not len(begin):
        return found
    points = mesh.vertices[mesh.corners]
    points = points - np.repeat(points[begin], counts[full], axis=0)  # small numbers cancel less
    after = np.arange(1, len(points) + 1)
    after[mesh.offsets[1:][full] - 1] = begin
    found[full] = np.add.reduceat(np.cross(points, points[after]), begin, axis=0)
    return found


def chosen_faces(mesh: Mesh, keep: NDArray[np.bool_]) -> Mesh:
    """The faces that are kept (f,), with only the vertices they use."""
    counts = np.diff(mesh.offsets)
    used = np.repeat(keep, counts)
    corners = mesh.corners[used]
    vertices, corners = np.unique(corners, return_inverse=True)
    return replace(
        mesh,
        vertices=mesh.vertices[vertices],
        corners=corners.reshape(-1).astype(np.int64),
        offsets=np.concatenate([[0], np.cumsum(counts[keep])]).astype(np.int64),
        material=mesh.material[keep],
        group=mesh.group[keep],
        uv=None if mesh.uv is None else mesh.uv[used],
        normals=None if mesh.normals is None else mesh.normals[used],
    )


def without_bad_faces(mesh: Mesh) -> tuple[Mesh, tuple[Note, ...]]:
    """The mesh without faces that touch a vertex without a value or that have under three
    corners apart, and notes that count them.
    """
    counts = np.diff(mesh.offsets)
    finite = np.asarray((np.abs(mesh.vertices) <= FARTHEST).all(axis=1))
    bad = np.concatenate([[0], np.cumsum(~finite[mesh.corners])])
    lost = bad[mesh.offsets[1:]] > bad[mesh.offsets[:-1]]
    folded = np.zeros(len(counts), np.bool_)
    three = np.flatnonzero(counts == 3)
    a, b, c = (mesh.corners[mesh.offsets[three] + k] for k in range(3))
    folded[three] = (a == b) | (b == c) | (a == c)
    flat = (folded | (counts < 3)) & ~lost
    notes = []
    if lost.any():
        message = "faces with a vertex without a value (not a number, or too large) were left out"
        notes.append(Note("bad-vertex", message, int(lost.sum())))
    if flat.any():
        message = "faces with fewer than three different corners were left out"
        notes.append(Note("degenerate-face", message, int(flat.sum())))
    return (chosen_faces(mesh, ~(lost | flat)) if notes else mesh), tuple(notes)


def mapped(points: Floats, matrix: Floats) -> Floats:
    """Points (n, 3) under a map (3, 4). Not a product of matrices: for very many points those keep
    all processors busy for longer than they take.
    """
    return np.asarray(np.einsum("nj,ij->ni", points, matrix[:, :3]) + matrix[:, 3])


def moved(mesh: Mesh, matrix: Floats) -> Mesh:
    """The mesh under a map (3, 4); a mirroring one turns the faces' order too."""
    linear = matrix[:, :3]
    stays = bool((matrix == np.eye(3, 4)).all())
    vertices = mesh.vertices + 0.0 if stays else mapped(mesh.vertices, matrix)  # no -0 either way
    normals = mesh.normals
    if normals is not None:
        normals = normals + 0.0 if stays else normals @ _inverse(linear)
        normals = _unit(normals)
    result = replace(mesh, vertices=vertices, normals=normals)
    return reversed_faces(result) if not stays and np.linalg.det(linear) < 0 else result


def _unit(directions: Floats) -> Floats:
    """Directions (n, 3) of length 1."""
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return np.asarray(directions / np.maximum(lengths, 1e-300))


def _inverse(linear: Floats) -> Floats:
    """The inverse (3, 3) of a map of directions, or what is nearest to one."""
    own = linear.diagonal()
    if np.count_nonzero(linear) == 3 and (own > 0).all():  # it stretches along the axes
        return np.diag(1.0 / own)
    return np.asarray(np.linalg.pinv(linear))


def reversed_faces(mesh: Mesh) -> Mesh:
    """The mesh with each face's corners in opposite order."""
    order = reversal(mesh.offsets)
    return replace(
        mesh,
        corners=mesh.corners[order],
        uv=None if mesh.uv is None else mesh.uv[order],
        normals=None if mesh.normals is None else mesh.normals[order],
    )


def reversal(offsets: Indices) -> Indices:
    """The corner numbers (c,) that read every face backwards from its first corner, so that a fan
    from there has the same diagonals.
    """
    counts = np.diff(offsets)
    face = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(face)) - offsets[face]
    return offsets[face] + -step % counts[face]


def merged(meshes: list[Mesh]) -> Mesh:
    """All faces in one mesh; materials and groups with equal names become one."""
    if len(meshes) == 1:
        return meshes[0]
    materials: dict[Material, int] = {}
    groups: dict[tuple[str, ...], int] = {}
    material, group, corners, offsets = [], [], [], [np.zeros(1, np.int64)]
    vertices = face_corners = 0
    for mesh in meshes:
        into = [materials.setdefault(each, len(materials)) for each in mesh.materials]
        names = [groups.setdefault(each, len(groups)) for each in mesh.groups]
        material.append(np.array([*into, -1], np.int64)[mesh.material])
        group.append(np.array([*names, 0], np.int64)[mesh.group])
        corners.append(mesh.corners + vertices)
        offsets.append(mesh.offsets[1:] + face_corners)
        vertices += len(mesh.vertices)
        face_corners += len(mesh.corners)
    empty = np.zeros((0, 3))
    return Mesh(
        np.concatenate([empty, *(mesh.vertices for mesh in meshes)]),
        np.concatenate([np.zeros(0, np.int64), *corners]),
        np.concatenate(offsets),
        np.concatenate([np.zeros(0, np.int64), *material]),
        np.concatenate([np.zeros(0, np.int64), *group]),
        tuple(materials),
        tuple(groups) or ((),),
        _joined_uv(meshes),
        _joined([mesh.normals for mesh in meshes]),
    )


def _joined_uv(meshes: list[Mesh]) -> Floats | None:
    """The texture coordinates of all corners, 0 where a mesh has none; None if none has any."""
    if all(mesh.uv is None for mesh in meshes):
        return None
    columns = (np.zeros((len(mesh.corners), 2)) if mesh.uv is None else mesh.uv for mesh in meshes)
    return np.concatenate(list(columns))


def _joined(columns: list[Floats | None]) -> Floats | None:
    """The columns one after the other, None unless every mesh has one."""
    known = [column for column in columns if column is not None]
    return np.concatenate(known) if known and len(known) == len(columns) else None


def stretched(mesh: Mesh, factors: Sequence[float]) -> Mesh:
    """A mesh so many times as large along x, y and z, from its origin, each above 0; as it is for
    (). What `moved` makes of it, without products of matrices that hold so many zeros.
    """
    if not factors:
        return mesh
    along = np.array(factors, np.float64)
    normals = mesh.normals
    if normals is not None:
        normals = _unit(normals * (1.0 / along) + 0.0)
    return replace(mesh, vertices=mesh.vertices * along + 0.0, normals=normals)


def baked(scene: MeshScene) -> Mesh:
    """All copies of a scene as one mesh in the world; meant for scenes of few copies."""
    parts = []
    for row in range(len(scene.mesh)):
        mesh = moved(scene.meshes[scene.mesh[row]], scene.matrix[row])
        if scene.material[row] >= 0:
            count = len(mesh.material)
            own = scene.materials[scene.material[row]]
            mesh = replace(mesh, material=np.zeros(count, np.int64), materials=(own,))
        parts.append(mesh)
    return merged(parts)
