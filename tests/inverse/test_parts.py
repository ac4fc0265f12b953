"""Parts and their classes: what is one shape is found to be one, what is not is kept apart."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inverse import solids
from inverse.solids import box, chiral, colored, ell, lost, placement, regular, shuffled, soup_of

from ipmlang.formats.mesh_types import Mesh, moved
from ipmlang.inverse.frames import Frames, compose, identity, inverse, linear, matrices, spread
from ipmlang.inverse.parts import Parts, observe, parts_of

EXACT = 1e-6
SHAPES = {
    "box": box(1, 2, 3),
    "cube": box(1, 1, 1),
    "slab": box(2, 2, 0.3),
    "ell": ell(),
    "chiral": chiral(),
    "column": regular(12),
    "panel": solids.polygons([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]),
    "fan": solids.polygons([[0, 0, 0], [2, 0, 0], [0, 3, 0]], [[0, 1, 2]]),
}
ORDERS = {"box": 8, "cube": 48, "slab": 16, "ell": 2, "chiral": 1, "column": 48, "panel": 4,
          "fan": 1}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("mirror", [False, True])
def test_copies_in_any_place_are_one_class(name: str, mirror: bool) -> None:
    """However turned, mirrored and re-ordered."""
    random = np.random.default_rng(len(name))
    meshes = [SHAPES[name], *(shuffled(SHAPES[name], random) for _ in range(9))]
    places = [placement(random, mirror and k % 2 == 1) for k in range(10)]
    soup = soup_of(meshes, places)
    parts = parts_of(soup, EXACT)
    assert len(parts.shape) == 10 and len(parts.classes) == 1
    assert lost(parts, soup.mesh) < EXACT and parts.misfit.max() < EXACT * parts.diagonal


@pytest.mark.parametrize("name", SHAPES)
def test_symmetries_are_a_group(name: str) -> None:
    """Of the known order, closed, and each maps the shape onto itself."""
    parts = parts_of(soup_of([SHAPES[name]]), EXACT)
    own = parts.classes[0]
    group = own.symmetry
    assert len(group) == ORDERS[name]
    assert np.allclose(matrices(group[:1]), matrices(identity()), atol=1e-9)
    for frame in (group[k : k + 1] for k in range(len(group))):
        assert all(_among(product, group) for product in _rows(compose(frame, group)))
        there = spread(frame, own.mesh.vertices)[0]
        apart = np.linalg.norm(there[:, None] - own.mesh.vertices[None], axis=2).min(axis=1)
        assert apart.max() < 1e-9
    assert all(_among(back, group) for back in _rows(inverse(group)))


def _at(x: float) -> solids.Floats:
    return np.concatenate([np.eye(3), [[x], [0], [0]]], axis=1)


def _rows(frames: Frames) -> list[Frames]:
    return [frames[k : k + 1] for k in range(len(frames))]


def _among(one: Frames, group: Frames) -> bool:
    return bool(np.abs(matrices(group) - matrices(one)).max(axis=(1, 2)).min() < 1e-7)


def test_mirror_images_of_a_chiral_shape_are_marked() -> None:
    """One class, of which some members have the other hand."""
    mirrored = np.diag([1.0, -1, 1]) @ _at(-10)
    parts = parts_of(soup_of([chiral()] * 3, [_at(0), _at(10), mirrored]), EXACT)
    assert len(parts.classes) == 1
    assert sorted(parts.frames.hand.tolist()) == [-1, 1, 1]


def test_a_flipped_shape_is_another() -> None:
    """Faces that look inward are not those that look outward."""
    inward = moved(box(1, 2, 3), np.concatenate([np.diag([-1.0, 1, 1]), [[9], [0], [0]]], axis=1))
    order = inward.corners.reshape(-1, 4)[:, ::-1].reshape(-1)
    turned_in = Mesh(
        inward.vertices, order, inward.offsets, inward.material, inward.group, (), ((),)
    )
    assert len(parts_of(soup_of([box(1, 2, 3), turned_in]), EXACT).classes) == 2


def test_near_shapes_are_told_apart() -> None:
    """Equal counts, boxes and areas do not make parts equal."""
    wide = box(1, 2, 3)
    wider = box(1, 2, 3 + 1e-3)
    parts = parts_of(soup_of([wide, wider, wide], [_at(0), _at(5), _at(10)]), EXACT)
    assert [each.members.tolist() for each in parts.classes] == [[0, 2], [1]]


def test_materials_tell_shapes_apart() -> None:
    """Two colours are two shapes."""
    meshes = [colored(ell(), "red"), colored(ell(), "blue"), colored(ell(), "red")]
    parts = parts_of(soup_of(meshes, [_at(0), _at(5), _at(10)]), EXACT)
    assert [len(each.members) for each in parts.classes] == [2, 1]
    assert [each.mesh.materials[0].name for each in parts.classes] == ["red", "blue"]


def test_frames_are_plain_where_a_symmetry_allows() -> None:
    """Boxes turned by quarters stand as they are where that is the same box."""
    half = np.diag([-1.0, -1, 1]) @ np.eye(3, 4)
    half[:, 3] = [9, 0, 0]
    quarter = np.array([[0.0, -1, 0, 0], [1, 0, 0, 9], [0, 0, 1, 0]])
    parts = parts_of(soup_of([box(1, 2, 3)] * 3, [np.eye(3, 4), half, quarter]), EXACT)
    turns = linear(parts.frames)
    assert np.array_equal(turns[:2], np.tile(np.eye(3), (2, 1, 1)))
    assert np.allclose(turns[2], quarter[:, :3]) and parts.frames.hand.min() == 1


def test_the_representative_stands_as_most_do() -> None:
    """One turned copy first does not turn the shape of the others."""
    random = np.random.default_rng(3)
    soup = soup_of([chiral()] * 6, [placement(random), *(_at(5.0 * k) for k in range(5))])
    parts = parts_of(soup, EXACT)
    assert np.allclose(parts.frames.rotation[1:], [1, 0, 0, 0])
    assert np.allclose(parts.classes[0].size, [3, 2, 1.3])
    assert np.allclose(parts.classes[0].mesh.vertices.min(axis=0), 0)


@pytest.mark.parametrize("noise", [1e-5, 1e-4, 1e-3])
def test_noisy_copies_within_a_tolerance(noise: float) -> None:
    """At most one in a hundred is split off, and the misfit says how far each is."""
    random = np.random.default_rng(7)
    meshes, places = [], []
    for k in range(400):
        shape = [chiral(), ell(), regular(7, 2.0), box(1, 2, 3)][k % 4]
        off = random.uniform(-1, 1, shape.vertices.shape) * noise
        moved_by = Mesh(
            shape.vertices + off, shape.corners, shape.offsets, shape.material, shape.group
        )
        meshes.append(shuffled(moved_by, random))
        place = placement(random, k % 3 == 0)
        place[:, 3] = [8.0 * (k % 20), 8.0 * (k // 20), 0]
        places.append(place)
    soup = soup_of(meshes, places)
    diagonal = parts_of(soup, EXACT).diagonal
    parts = parts_of(soup, 6 * noise / diagonal)
    assert len(parts.shape) == 400
    largest = sum(sorted((len(each.members) for each in parts.classes), reverse=True)[:4])
    assert largest >= 0.99 * 400
    assert noise / 10 < parts.misfit.max() <= 6 * noise


def test_the_shape_of_rounded_copies_is_their_mean() -> None:
    """Copies in a ring, written with four decimals: each is nearer to the shape than two of them
    are to each other, turns are plain, and what is level stays level.
    """
    made = []
    for k in range(12):
        angle = np.radians(30.0 * k)
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
        points = (chiral().vertices * 1.23457 + [10, 0, 0]) @ turn.T
        made.append(replace(chiral(), vertices=np.round(points, 4)))
    soup = soup_of(made)
    parts = parts_of(soup, 3e-4 / parts_of(soup, EXACT).diagonal)
    assert len(parts.classes) == 1
    assert parts.misfit.max() < 6e-5
    heights = parts.classes[0].mesh.vertices[:, 2]
    assert len(np.unique(heights)) == len(np.unique(chiral().vertices[:, 2]))
    w, x, y, z = parts.frames.rotation.T
    turned = np.degrees(2 * np.arctan2(z, w))
    assert np.allclose([x, y], 0, atol=1e-12) and np.allclose(turned, np.rint(turned), atol=1e-9)


def test_copies_that_are_equal_bit_by_bit_keep_their_shape() -> None:
    """Nothing is averaged where nothing differs: coordinates stay those of the file."""
    shape = chiral()
    soup = soup_of([shape] * 5, [_at(8.0 * k) for k in range(5)])
    own = parts_of(soup, EXACT).classes[0].mesh.vertices
    expected = shape.vertices - shape.vertices.min(axis=0)
    assert {tuple(row) for row in own.tolist()} == {tuple(row) for row in expected.tolist()}


def test_open_shells_that_share_a_vertex_are_one() -> None:
    """Parts hang together by vertices, whatever the file calls them."""
    panel = SHAPES["panel"]
    hinge = np.eye(3, 4)
    hinge[:, 3] = [2, 1, 0]
    assert len(parts_of(soup_of([panel, panel], [np.eye(3, 4), hinge]), EXACT).shape) == 1


def test_points_that_meet_but_for_rounding_are_one() -> None:
    """Vertices of their own for each face, a little off."""
    random = np.random.default_rng(1)
    mesh = ell()
    loose = mesh.vertices[mesh.corners] + random.uniform(-1e-8, 1e-8, (len(mesh.corners), 3))
    corners = np.arange(len(mesh.corners))
    made = Mesh(loose, corners, mesh.offsets, mesh.material, mesh.group, (), ((),))
    parts = parts_of(soup_of([made]), EXACT)
    assert len(parts.shape) == 1 and len(parts.classes[0].mesh.vertices) == len(mesh.vertices)


KNOWN = {
    "wall_straight.obj": (26, 2),
    "castle.obj": (178, 31),
    "building_F_nobase.obj": (110, 22),
    "scaffolding.obj": (152, 22),
    "tower_A.obj": (53, 10),
    "market.obj": (97, 40),
    "warehouse_boxes.glb": (24, 1),
    "warehouse_roof.glb": (12, 5),
    "recast_dungeon.obj": (9, 9),
    "pins.glb": (7, 2),
}


@pytest.mark.parametrize("name", KNOWN)
def test_real_models(name: str, data: Path) -> None:
    """The known numbers of parts and classes, and every face back in its place."""
    parts = observe(data / "mesh" / name)
    assert (len(parts.shape), len(parts.classes)) == KNOWN[name]
    assert parts.misfit.max() <= EXACT * parts.diagonal
    assert lost(parts, _as_read(data / "mesh" / name, parts)) < EXACT


def _as_read(path: Path, parts: Parts) -> Mesh:
    from ipmlang.formats.mesh import read_mesh

    mesh = read_mesh(path)
    turned = path.suffix == ".obj" and parts.up == "y-up"
    return moved(mesh, np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0]])) if turned else mesh
