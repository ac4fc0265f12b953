"""Meshes and copies become the columns that are drawn: where, which way, in what colour."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from studio.scenes import boxes, cube

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, chosen_faces, triangulated
from ipmlang.formats.textures import Texture
from ipmlang.studio import surfaces
from ipmlang.studio.corners import closed_faces, corner_normals, face_normals, sharp_edges
from ipmlang.studio.surfaces import Surface, model_of


def in_triangles(mesh: Mesh) -> Mesh:
    corners, _ = triangulated(mesh)
    count = len(corners)
    flat = mesh.corners[corners].reshape(-1)
    zero = np.zeros(count, np.int64)
    return Mesh(mesh.vertices, flat, np.arange(count + 1) * 3, zero - 1, zero, groups=((),))


def placed(surface: Surface) -> np.ndarray:
    """Triangles of all copies (k, t, 3 corners, 3)."""
    points = surface.position[surface.triangles].astype(np.float64)
    linear = surface.matrix[:, :, :3].astype(np.float64)
    return np.einsum("kij,tcj->ktci", linear, points) + surface.matrix[:, None, None, :, 3]


def test_copies_lie_where_they_did_drawn_one_by_one_or_baked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    random = np.random.default_rng(3)
    scene = boxes(random.normal(size=(40, 3)) * 5)
    scene = replace(scene, matrix=scene.matrix + random.normal(size=scene.matrix.shape))
    (baked,) = model_of(scene).surfaces
    monkeypatch.setattr(surfaces, "_WORTH", 0)
    (repeated,) = model_of(scene).surfaces
    assert len(baked.matrix) == 1
    assert len(repeated.matrix) == 40
    assert placed(repeated).reshape(-1, 3) == pytest.approx(placed(baked).reshape(-1, 3), abs=1e-6)


@pytest.mark.parametrize(("unit", "place"), [(1e-3, 0.0), (1e6, 0.0), (1.0, 5e6)])
def test_units_and_distance_leave_the_model_as_it_is(unit: float, place: float) -> None:
    scene = boxes([[0, 0, 0], [3, 1, 0]])
    (near,) = model_of(scene).surfaces
    matrix = scene.matrix * unit
    matrix[:, :, 3] += place
    (far,) = model_of(replace(scene, matrix=matrix)).surfaces
    assert far.position == pytest.approx(near.position, abs=1e-6)


def test_what_a_copy_is_painted_with_counts_before_its_faces() -> None:
    faces = replace(cube(), material=np.array([0, 0, 0, -1, -1, -1]),
                    materials=(Material("blue", (0.0, 0.0, 1.0, 1.0)),))  # fmt: skip
    red = Material("red", (1.0, 0.0, 0.0, 1.0))
    scene = replace(
        boxes([[0, 0, 0], [2, 0, 0]], mesh=faces, materials=[red]), material=np.array([-1, 0])
    )
    (surface,) = model_of(scene).surfaces
    colors = surface.color.reshape(2, 6, 4, 4)[:, :, 0, :3].tolist()
    assert colors[0][:3] == [[0, 0, 255]] * 3
    assert colors[0][5] == [222, 219, 214]  # clay, where nothing says a colour
    assert colors[1] == [[255, 0, 0]] * 6


def test_faces_are_drawn_image_by_image() -> None:
    image = Texture("stone", ".png", b"")
    stone = Material("stone", None, image)
    faces = replace(cube(), material=np.array([-1, 0, -1, 0, -1, -1]), materials=(stone,))
    (surface,) = model_of(boxes([[0, 0, 0]], mesh=faces)).surfaces
    assert surface.parts == ((0, 8, -1), (8, 4, 0))
    assert (surface.color[4:8] == 255).all()  # an image shows as it is


def test_what_is_nowhere_or_clear_as_air_is_left_out() -> None:
    air = Material("air", (1.0, 1.0, 1.0, 0.0))
    scene = boxes([[0, 0, 0], [1, 1, 1], [9, 9, 9]], materials=[air, air, air])
    scene = replace(scene, material=np.array([-1, -1, 0]))
    scene.matrix[1, 0, 3] = np.nan
    (surface,) = model_of(scene).surfaces
    assert len(surface.triangles) == 12


@pytest.mark.parametrize("scale", [(0.0, 0.0, 0.0), (np.inf, 1.0, 1.0)])
def test_nothing_to_see_is_an_error(scale: tuple[float, float, float]) -> None:
    with pytest.raises(IpmError) as caught:
        model_of(boxes([[1, 2, 3]], scale=scale))
    assert caught.value.diagnostics[0].code == "nothing-drawn"


@pytest.mark.parametrize("mesh", [cube(), in_triangles(cube())], ids=["quads", "triangles"])
def test_a_cube_has_twelve_sharp_edges_and_flat_faces(mesh: Mesh) -> None:
    edges, _ = sharp_edges(mesh)
    lengths = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    assert lengths.tolist() == [1.0] * 12
    normals = corner_normals(mesh)
    assert (np.count_nonzero(normals.round(9), axis=1) == 1).all()
    assert closed_faces(mesh).all()


def test_an_open_mesh_is_known_by_its_border() -> None:
    lid_off = chosen_faces(cube(), np.array([True, False, True, True, True, True]))
    assert closed_faces(lid_off).tolist() == [True, False, False, False, False]
    assert len(sharp_edges(lid_off)[0]) == 12


def test_a_rounded_surface_shades_smoothly() -> None:
    sides, angle = 40, np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    near = np.arange(sides)
    after = (near + 1) % sides
    quads = np.stack([near, after, after + sides, near + sides], axis=1).reshape(-1)
    vertices = np.concatenate([ring, ring + np.array([0, 0, 1])])
    zero = np.zeros(sides, np.int64)
    pipe = Mesh(vertices, quads, np.arange(sides + 1) * 4, zero - 1, zero, groups=((),))
    normals = corner_normals(pipe)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert normals == pytest.approx(vertices[quads] * [1, 1, 0], abs=1e-9)


def test_normals_of_faces_have_twice_their_area() -> None:
    assert np.linalg.norm(face_normals(cube()), axis=1) == pytest.approx(np.full(6, 2.0))


def test_a_hundred_meshes_of_one_copy_are_few_surfaces() -> None:
    count = 100
    places = np.arange(count)[:, None] * [2.0, 0, 0]
    scene = boxes(places.tolist())
    scene = MeshScene((cube(),) * count, np.arange(count), scene.matrix, scene.name,
                      scene.material, scene.names)  # fmt: skip
    model = model_of(scene)
    assert len(model.surfaces) == 1
    assert model.triangles == 12 * count
