"""Made models: shapes in given and in random places, and whether parts give a model back.

Everything is made from a seed. `lost` is an independent check: it knows frames and faces, nothing
of how parts are found.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from ipmlang.formats.mesh_types import Material, Mesh, merged, moved
from ipmlang.inverse.frames import matrices
from ipmlang.inverse.parts import Parts
from ipmlang.inverse.parts.soup import Soup

Floats = NDArray[np.float64]


def polygons(points: Sequence[Sequence[float]], faces: Sequence[Sequence[int]]) -> Mesh:
    """A mesh of polygons without materials."""
    corners = np.array([corner for face in faces for corner in face], np.int64)
    offsets = np.cumsum([0, *(len(face) for face in faces)]).astype(np.int64)
    zero = np.zeros(len(faces), np.int64)
    return Mesh(np.array(points, np.float64), corners, offsets, zero - 1, zero, (), ((),))


def box(x: float, y: float, z: float) -> Mesh:
    """A closed box of quads from the origin."""
    points = [[i * x, j * y, k * z] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return polygons(points, faces)


def prism(outline: Sequence[tuple[float, float]], height: float) -> Mesh:
    """An upright prism over an outline that runs to the left."""
    count = len(outline)
    points = [[x, y, z] for z in (0.0, height) for x, y in outline]
    sides = [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    lids = [list(range(count))[::-1], list(range(count, 2 * count))]
    return polygons(points, sides + lids)


def regular(sides: int, height: float = 1.0) -> Mesh:
    """A prism over a regular polygon."""
    angle = 2 * np.pi * np.arange(sides) / sides
    return prism([(float(np.cos(a)), float(np.sin(a))) for a in angle], height)


ELL = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]


def ell() -> Mesh:
    """A prism that no turn about its height maps onto itself, with a mirror plane across it."""
    return prism(ELL, 0.7)


def chiral() -> Mesh:
    """A shape that differs from its mirror image and has no symmetry."""
    made = prism(ELL, 0.7)
    lifted = made.vertices.copy()
    lifted[7, 2] = 1.3
    return Mesh(
        lifted, made.corners, made.offsets, made.material, made.group, made.materials, made.groups
    )


def placement(random: np.random.Generator, mirror: bool = False) -> Floats:
    """A random rigid motion (3, 4), far enough to touch nothing."""
    turn = Rotation.random(random_state=int(random.integers(1 << 30))).as_matrix()
    if mirror:
        turn = turn @ np.diag([-1.0, 1, 1])
    return np.concatenate([turn, random.uniform(-200, 200, (3, 1))], axis=1)


def shuffled(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """The mesh with vertices and faces in another order and faces begun at other corners."""
    place = random.permutation(len(mesh.vertices))
    vertices = np.empty_like(mesh.vertices)
    vertices[place] = mesh.vertices
    faces, materials, order = [], [], random.permutation(len(mesh.material))
    for face in order.tolist():
        corners = place[mesh.corners[mesh.offsets[face] : mesh.offsets[face + 1]]]
        faces.append(np.roll(corners, int(random.integers(len(corners)))).tolist())
        materials.append(mesh.material[face])
    made = polygons(vertices.tolist(), faces)
    return Mesh(
        made.vertices, made.corners, made.offsets, np.array(materials), made.group, mesh.materials,
        ((),),
    )  # fmt: skip


def colored(mesh: Mesh, name: str) -> Mesh:
    """The mesh in one material."""
    own = (Material(name, (1.0, 0.0, 0.0, 1.0)),)
    zero = np.zeros(len(mesh.material), np.int64)
    return Mesh(mesh.vertices, mesh.corners, mesh.offsets, zero, mesh.group, own, mesh.groups)


def soup_of(meshes: Sequence[Mesh], places: Sequence[Floats] | None = None) -> Soup:
    """Meshes in their places as one model."""
    if places is not None:
        meshes = [moved(mesh, place) for mesh, place in zip(meshes, places, strict=True)]
    whole = merged(list(meshes))
    zero = np.zeros(len(whole.material), np.int64)
    return Soup(whole, zero, np.zeros(1, np.bool_), whole.groups)


def rebuilt(parts: Parts) -> Mesh:
    """The model that the parts say there was."""
    maps = matrices(parts.frames)
    made = [
        moved(parts.classes[number].mesh, place)
        for number, place in zip(parts.shape.tolist(), maps, strict=True)
    ]
    return merged(made)


def lost(parts: Parts, mesh: Mesh) -> float:
    """How far the faces of the rebuilt model are from those of a mesh, as a share of the diagonal;
    infinite where one of either has no like. Faces are known by their middle, by how they face and
    how large they are, and by their material.
    """
    ours, theirs = _known_by(rebuilt(parts)), _known_by(mesh)
    reach = 1e-3 * parts.diagonal
    furthest = 0.0
    for some, others in ((ours, theirs), (theirs, ours)):
        apart, index = cKDTree(others).query(some, distance_upper_bound=reach)
        if not np.isfinite(apart).all():
            return float("inf")
        furthest = max(furthest, float(np.linalg.norm((some - others[index])[:, :3], axis=1).max()))
    return furthest / parts.diagonal


def _known_by(mesh: Mesh) -> Floats:
    sizes = np.diff(mesh.offsets)
    points = mesh.vertices[mesh.corners]
    middle = np.add.reduceat(points, mesh.offsets[:-1]) / sizes[:, None]
    arm = points - np.repeat(middle, sizes, axis=0)
    after = np.arange(1, len(points) + 1)
    after[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    vector = np.add.reduceat(np.cross(arm, arm[after]), mesh.offsets[:-1]) / 2
    size = np.sqrt(np.linalg.norm(vector, axis=1, keepdims=True))
    names = sorted({each.name for each in mesh.materials})
    known = np.array([*(names.index(each.name) + 1.0 for each in mesh.materials), 0.0])
    facing = vector / np.maximum(size, 1e-300)
    return np.concatenate([middle, facing, known[mesh.material][:, None]], axis=1)


def obj_text(mesh: Mesh, digits: int = 6) -> str:
    """The mesh as the text of an OBJ file."""
    lines = ["v " + " ".join(f"{each:.{digits}f}" for each in row) for row in mesh.vertices]
    for begin, end in zip(mesh.offsets[:-1], mesh.offsets[1:], strict=True):
        lines.append("f " + " ".join(str(each + 1) for each in mesh.corners[begin:end]))
    return "\n".join(lines) + "\n"


def written(path: Path, text: str) -> Path:
    """A file of that text."""
    path.write_text(text)
    return path
