"""Faces cut into triangles, and copies made real, many at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.formats.atomic import write_files
from ipmlang.formats.mesh import mesh_contents, read_mesh
from ipmlang.formats.mesh_types import Mesh, MeshScene, all_triangulated, merged, triangulated
from ipmlang.formats.triangles import ears
from ipmlang.runtime.export.models import unit_cube


def star(angles: list[float], radii: list[float], axis: int) -> np.ndarray:  # type: ignore[type-arg]
    """A polygon (n, 3) around the origin, square to an axis."""
    around, distance = np.array(sorted(angles)), np.array(radii[: len(angles)])
    points = np.insert(
        np.stack([np.cos(around), np.sin(around)], axis=1) * distance[:, None], axis, 3.0, axis=1
    )
    return points


def face_mesh(*polygons: np.ndarray) -> Mesh:  # type: ignore[type-arg]
    """A mesh of one face a polygon."""
    sizes = [len(each) for each in polygons]
    none = np.zeros(len(sizes), np.int64)
    offsets = np.cumsum([0, *sizes])
    return Mesh(np.concatenate(polygons), np.arange(sum(sizes)), offsets, none - 1, none, (), ((),))


def vectors(mesh: Mesh, corners: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Normals times area (t, 3) of triangles of corner numbers."""
    points = mesh.vertices[mesh.corners[corners]]
    return np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]) / 2


def newell(points: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Normal times area of a polygon, by the sum over its edges."""
    return np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) / 2


ANGLES = st.lists(st.integers(0, 89), min_size=4, max_size=12, unique=True)
RADII = st.lists(st.floats(0.2, 3), min_size=12, max_size=12)


@given(ANGLES, RADII, st.integers(0, 2), st.booleans())
def test_triangles_cover_any_star(
    angles: list[int], radii: list[float], axis: int, backward: bool
) -> None:
    """No more and no less: areas add up with sign, and all face as the polygon does."""
    points = star([np.radians(4 * each) for each in angles], radii, axis)
    turns = np.diff([*sorted(angles), min(angles) + 90])
    if turns.max() >= 45:  # the origin lies outside: the outline may cross itself
        return
    points = points[::-1] if backward else points
    mesh = face_mesh(points)
    found = vectors(mesh, triangulated(mesh)[0])
    whole = newell(points)
    assert found.sum(axis=0) == pytest.approx(whole, abs=1e-9)
    assert (found @ whole > -1e-9).all()
    assert np.linalg.norm(found, axis=1).sum() == pytest.approx(np.linalg.norm(whole))


def test_a_quad_that_turns_inward_is_no_fan() -> None:
    """Whichever corner comes first."""
    dart = np.array([[0.0, 0, 0], [2, -1, 0], [0.5, 0, 0], [2, 1, 0]])
    for shift in range(4):
        mesh = face_mesh(np.roll(dart, shift, axis=0))
        assert np.linalg.norm(vectors(mesh, triangulated(mesh)[0]), axis=1).sum() == 0.5


def test_corners_on_an_edge_keep_their_place() -> None:
    """A convex face with a corner amid an edge stays whole: every corner is used."""
    mesh = face_mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]))
    assert set(triangulated(mesh)[0].reshape(-1).tolist()) == set(range(5))


def test_holes_and_faces_without_area() -> None:
    """Ends of rings are given; nothing that is flat raises."""
    ring = np.array([[0.0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0]])
    hole = np.array([[1.0, 1, 0], [1, 2, 0], [2, 2, 0], [2, 1, 0]])
    mesh = face_mesh(np.concatenate([ring, hole]))
    found = vectors(mesh, ears(mesh.vertices, np.array([4, 8])))
    assert found.sum(axis=0) == pytest.approx([0, 0, 8])
    assert len(ears(np.zeros((5, 3)))) == 3


def test_many_meshes_are_cut_as_each_alone() -> None:
    """In order, with corners and faces numbered in their own mesh."""
    ell = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]])
    empty = replace(face_mesh(ell), corners=np.zeros(0, np.int64), offsets=np.zeros(1, np.int64))
    meshes = [unit_cube(), face_mesh(ell, ell[:3]), empty, face_mesh(ell[::-1]), unit_cube()]
    for mesh, (cut, face) in zip(meshes, all_triangulated(meshes), strict=True):
        alone = triangulated(mesh)
        assert (cut.tolist(), face.tolist()) == (alone[0].tolist(), alone[1].tolist())
    assert list(all_triangulated([])) == []


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
def test_small_meshes_are_written_together(suffix: str, tmp_path: Path) -> None:
    """Alternating names, mirrored copies: nothing is lost, and each name is one group."""
    meshes = tuple(replace(unit_cube(), vertices=unit_cube().vertices * k) for k in (1, 2, 3, 4))
    matrix = np.tile(np.eye(3, 4), (4, 1, 1))
    matrix[:, 0, 3] = [0, 10, 20, 30]
    matrix[2, 0, 0] = -1
    scene = MeshScene(
        meshes, np.arange(4), matrix, np.array([0, 1, 0, 1]), np.full(4, -1), ("a", "b")
    )
    path = tmp_path / f"x{suffix}"
    write_files(mesh_contents(scene, path))
    corners = read_mesh(path)
    mesh = merged([corners])
    cut = triangulated(mesh)[0]
    points = mesh.vertices[mesh.corners[cut]]
    volume = np.einsum("ti,ti->", points[:, 0], np.cross(points[:, 1], points[:, 2])) / 6
    assert volume == pytest.approx(1 + 8 + 27 + 64)
    if suffix == ".obj":
        assert path.read_text().count("\ng ") == 2
        counts = np.bincount(mesh.group).tolist()
        assert [count for count in counts if count] == [12, 12]
