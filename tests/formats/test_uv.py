"""How textures lie on what is drawn: on the sides of scopes, by planes, with every change."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.formats.mesh_types import MeshScene
from ipmlang.geometry.solid import polygon, solid_of
from ipmlang.runtime.export.models import mesh_scene_of, unit_cube, unit_square
from ipmlang.runtime.export.sides import in_tiles, on_sides
from ipmlang.runtime.export.solids import solid_mesh
from ipmlang.runtime.export.uv import Copies, laid
from ipmlang.runtime.scene import SCOPE, SOLID, PenStyle, Scene
from ipmlang.runtime.scopes.laying import Laying, LayingError
from tests.formats.built import png, scene, table

PLAIN = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0, "i": 0.0, "j": 0.0, "k": 0.0}


@pytest.fixture
def image(tmp_path: Path) -> Path:
    """An image file."""
    path = tmp_path / "brick.png"
    path.write_bytes(png(0, 255))
    return path


def begun(
    laying: Laying,
    name: str,
    count: int,
    args: tuple[float, ...],
    before: float = -1.0,
    state: dict[str, float] | None = None,
    plane: str = "xy",
) -> list[float]:
    """What rows carry of an application of that name."""
    found = laying.begin(name, count, args, before, state or PLAIN, plane)
    return np.broadcast_to(np.asarray(found), (count,)).tolist()


def upright(sizes: list[list[float]], places: list[list[float]], asset: int = SCOPE) -> Scene:
    """A scene of scopes that stand along the axes of the world."""
    rows = table(sizes, asset)
    rows.position[:] = places
    rows.rotation[:] = [1, 0, 0, 0]
    rows.scale[:] = 1
    return scene(rows)


def textured(found: Scene, image: Path, laying: Laying, of: list[float]) -> MeshScene:
    """The model, with an image on everything."""
    maps = laying.maps(np.array(of, np.int32))
    return mesh_scene_of(replace(found, styles=(PenStyle("", "", image),), texture_maps=maps))


def coordinates(made: MeshScene, row: int) -> dict[tuple[float, ...], tuple[float, ...]]:
    """The texture point of each place in the world that the copy of a row shows; one a place."""
    mesh, matrix = made.meshes[made.mesh[row]], made.matrix[row]
    assert mesh.uv is not None
    places = (mesh.vertices[mesh.corners] @ matrix[:, :3].T + matrix[:, 3]).round(6).tolist()
    return {
        tuple(place): tuple(uv) for place, uv in zip(places, mesh.uv.round(6).tolist(), strict=True)
    }


@pytest.mark.parametrize(
    ("normal", "right", "up"),
    [
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
        ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
        ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
        ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
        ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
    ],
)
def test_each_side_of_a_box_shows_the_image_upright(
    normal: tuple[int, ...], right: tuple[int, ...], up: tuple[int, ...]
) -> None:
    """From its lower left, seen from outside, to its upper right; never mirrored."""
    cube = unit_cube()
    uv = on_sides(cube)
    corners = cube.corners.reshape(6, 4)
    points = cube.vertices[corners]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    (side,) = np.flatnonzero((normals == normal).all(axis=1))
    own = uv.reshape(6, 4, 2)[side]
    steps = points[side] - points[side][np.argmin(own.sum(axis=1))]
    assert steps @ np.array(right) == pytest.approx(own[:, 0])
    assert steps @ np.array(up) == pytest.approx(own[:, 1])
    assert np.cross(right, up).tolist() == list(normal)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rectangles_face_right_front_or_up(axis: int) -> None:
    """As the geometry of a flat scope does; the image stands upright on them."""
    square = unit_square(axis)
    a, b, c = square.vertices[square.corners[:3]]
    assert np.cross(b - a, c - a).tolist() == [[1, 0, 0], [0, -1, 0], [0, 0, 1]][axis]
    uv = on_sides(square)
    assert uv.tolist() == np.delete(square.vertices[square.corners], axis, axis=1).tolist()


def test_without_a_projection_each_side_is_one_image(image: Path) -> None:
    """Whatever the size: all boxes share one mesh."""
    made = textured(upright([[1, 2, 3], [4, 1, 1]], [[0, 0, 0], [9, 0, 0]]), image, Laying(), [])
    assert len(made.meshes) == 1
    uv = made.meshes[0].uv
    assert uv is not None
    assert sorted(np.unique(uv).tolist()) == [0, 1]
    assert [each.texture is not None for each in made.materials] == [True]


def test_tiles_have_a_size_on_every_side(image: Path) -> None:
    """Boxes of one size share a mesh; each side counts its own tiles."""
    laying = Laying()
    ways = begun(laying, "tileUV", 3, (2.0, 0.5))
    found = upright([[1, 2, 3], [1, 2, 3], [4, 1, 1]], [[0, 0, 0], [0.3, 7, 0], [9, 0, 0]])
    made = textured(found, image, laying, ways)
    assert made.mesh[0] == made.mesh[1] != made.mesh[2]
    uv = [made.meshes[number].uv for number in made.mesh]
    assert uv[0] is not None
    assert uv[2] is not None
    # Sides of 1, 2 and 3 are 1/2, 1 wide and 2 or 3 are 4, 6 high; of 4 by 1 by 1: 2, 1/2 and 2.
    assert sorted({tuple(each) for each in uv[0].tolist()} - {(0, 0)}) == [
        (0, 4), (0, 6), (0.5, 0), (0.5, 4), (0.5, 6), (1, 0), (1, 6)]  # fmt: skip
    assert uv[2].max(axis=0).tolist() == [2, 2]


def test_slopes_count_along_themselves() -> None:
    """Level to the right, up the slope in its own length, from the eaves; upright sides as ever."""
    vertices = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0.5, 1), (1, 0.5, 1)]
    faces = [[[0, 1, 5, 4]], [[2, 3, 4, 5]], [[0, 4, 3]], [[1, 2, 5]], [[0, 3, 2, 1]]]
    mesh = solid_mesh(solid_of(vertices, faces))
    uv = in_tiles(mesh, np.array([10.0, 8.0, 3.0]))
    # Half of 8 along and 3 up: the slope is 5 long.
    assert uv[:8].round(9).tolist() == [
        [0, 0], [10, 0], [10, 5], [0, 5], [0, 0], [10, 0], [10, 5], [0, 5]]  # fmt: skip
    assert uv[8:14].round(9).tolist() == [[8, 0], [4, 3], [0, 0], [0, 0], [8, 0], [4, 3]]


def test_a_projection_goes_on_over_the_parts(image: Path) -> None:
    """Twelve parts of a wall: where two meet, their coordinates do, but for whole tiles."""
    laying = Laying()
    ready = begun(laying, "setupProjection", 1, (2.0, 1.0), -1.0, {**PLAIN, "x": 5.0})
    ways = begun(laying, "projectUV", 12, (), ready[0])
    places = [[5 + 1.0 * (k % 4), 0.75 * (k // 4), 0] for k in range(12)]
    made = textured(upright([[1.0, 0.75, 0]] * 12, places), image, laying, ways)
    # Along x every second part repeats, along y every fourth does: 2 by 3 are different.
    assert len(made.meshes) == 6
    for row in range(12):
        for place, uv in coordinates(made, row).items():
            wanted = np.array([(place[0] - 5) / 2, place[1]])
            assert np.abs((uv - wanted) - np.rint(uv - wanted)).max() < 1e-6
    for number in made.mesh.tolist():
        uv = made.meshes[number].uv
        assert uv is not None
        assert uv.min() >= 0
        assert uv.min() < 1


def test_equal_applications_are_one() -> None:
    """Whether they come in one batch, in many, or one by one; frames that differ stay apart."""
    laying = Laying()
    places = {**PLAIN, "x": np.array([0.0, 5.0, 0.0])}
    ready = laying.begin("setupProjection", 3, (1.0, 1.0), -1.0, places)
    ways = laying.begin("projectUV", 3, (), ready, PLAIN)
    assert np.asarray(ways).tolist() == [5, 7, 5]
    assert laying.count == 4
    alone = [laying.begin("tileUV", 1, (2.0, 2.0), 5.0, PLAIN) for _ in range(3)]
    assert len(set(alone)) == 1
    assert laying.count == 5


def test_equal_parts_share_meshes_however_many(image: Path) -> None:
    """A wall of ten thousand equal bricks is a handful of meshes, in little time."""
    laying = Laying()
    ready = begun(laying, "setupProjection", 1, (3 * 0.1, 0.1), -1.0)
    ways = begun(laying, "projectUV", 10_000, (), ready[0])
    places = [[0.1 * (k % 100), 0.1 * (k // 100), 0] for k in range(10_000)]
    made = textured(upright([[0.1, 0.1, 0]] * 10_000, places), image, laying, ways)
    assert len(made.meshes) <= 6
    assert len(made.mesh) == 10_000


ANGLES = st.floats(-180, 180)
PLACES = st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9))


@given(PLACES, PLACES, ANGLES, ANGLES, st.floats(0.25, 4), st.booleans(), st.sampled_from(
    ["xy", "xz", "yz"]))  # fmt: skip
def test_projected_coordinates_are_those_of_the_frame(
    place: tuple[float, ...],
    other: tuple[float, ...],
    about_z: float,
    about_x: float,
    scale: float,
    mirrored: bool,
    plane: str,
) -> None:
    """Any frame, any box: a point's coordinates in the frame over the tile, modulo whole tiles."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("ZX", [about_z, about_x], degrees=True)
    x, y, z, w = turn.as_quat()
    state = dict(zip("xyzwijk", (*place, w, x, y, z), strict=True))
    state["scale"] = -scale if mirrored else scale
    laying = Laying()
    ready = begun(laying, "setupProjection", 1, (0.7, 1.3), -1.0, state, plane)
    way = begun(laying, "projectUV", 1, (), ready[0])
    rows = table([[1, 2, 3]], SCOPE)
    rows.position[:] = other
    found = scene(rows)
    maps = laying.maps(np.array(way, np.int32))
    plain = mesh_scene_of(found)
    assert maps is not None
    copies = Copies(plain.mesh, plain.matrix, maps.of.astype(np.int64), np.ones(1, np.bool_))
    (mesh,), _ = laid(list(plain.meshes), copies, maps)
    assert mesh.uv is not None
    world = mesh.vertices[mesh.corners] @ plain.matrix[0][:, :3].T + plain.matrix[0][:, 3]
    local = turn.inv().apply(world - np.array(place)) / scale
    local[:, 0] *= -1 if mirrored else 1
    axes = ["xyz".index(each) for each in plane]
    off = mesh.uv - local[:, axes] / [0.7, 1.3]
    assert np.abs(off - np.rint(off)).max() < 1e-5
    assert np.ptp(off, axis=0) == pytest.approx([0, 0], abs=1e-5)


def test_changes_follow_each_other(image: Path) -> None:
    """Moved, scaled, turned: in the order in which they stand; a new projection begins anew."""
    laying = Laying()
    ready = begun(laying, "setupProjection", 1, (1.0, 1.0), -1.0)
    way = begun(laying, "projectUV", 1, (), ready[0])
    for name, values in (("translateUV", (0.25, 0)), ("scaleUV", (2, 4)), ("rotateUV", (90,))):
        way = begun(laying, name, 1, values, way[0])
    again = begun(laying, "projectUV", 1, (), way[0])
    found = upright([[1, 1, 0], [1, 1, 0]], [[0, 0, 0], [0, 0, 0]])
    made = textured(found, image, laying, [way[0], again[0]])
    # (x + 1/4) * 2 and y * 4, turned by a right angle: (-4 y, 2 x + 1/2), modulo whole tiles.
    assert coordinates(made, 0) == {
        (0, 0, 0): (0, 0.5), (1, 0, 0): (0, 2.5), (1, 1, 0): (-4, 2.5), (0, 1, 0): (-4, 0.5),
    }  # fmt: skip
    assert coordinates(made, 1)[1, 1, 0] == (1, 1)


def test_a_tile_within_a_projection_is_that_of_the_projection(image: Path) -> None:
    """It takes the place of the size that was set up."""
    laying = Laying()
    ready = begun(laying, "setupProjection", 1, (1.0, 1.0), -1.0)
    way = begun(laying, "projectUV", 1, (), ready[0])
    tiled = begun(laying, "tileUV", 1, (4.0, 2.0), way[0])
    made = textured(upright([[1, 1, 0]], [[0, 0, 0]]), image, laying, tiled)
    assert coordinates(made, 0)[1, 1, 0] == (0.25, 0.5)


def test_geometry_keeps_coordinates_of_its_own(image: Path) -> None:
    """Where no projection is applied, and with what changes them."""
    square = polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    own = replace(square, uv=np.array([[0.1, 0.1], [0.4, 0.1], [0.4, 0.4], [0.1, 0.4]]))
    laying = Laying()
    way = begun(laying, "scaleUV", 1, (10.0, 10.0))
    rows = table([[1, 1, 0], [1, 1, 0]], SOLID)
    found = scene(rows, solids=(own,))
    rows.shape[:] = 0
    made = textured(found, image, laying, [-1, *way])
    plain, scaled = (made.meshes[number].uv for number in made.mesh)
    assert plain is not None
    assert scaled is not None
    assert plain.tolist() == own.uv.tolist()
    assert scaled == pytest.approx(plain * 10)


def test_only_what_bears_an_image_gets_coordinates(image: Path) -> None:
    """Rows of another style stay as they are and share their meshes."""
    found = upright([[1, 1, 1], [1, 1, 1]], [[0, 0, 0], [5, 0, 0]])
    found.instances.style[:] = [0, 1]
    made = mesh_scene_of(replace(found, styles=(PenStyle(), PenStyle("", "wall", image))))
    plain, own = (made.meshes[number].uv for number in made.mesh)
    assert plain is None
    assert own is not None
    assert made.materials[made.material[1]].name == "wall"


@pytest.mark.parametrize("name", ["setupProjection", "tileUV"])
def test_tiles_need_a_size(name: str) -> None:
    """0 and less are refused, and what is no number."""
    with pytest.raises(LayingError, match="above 0"):
        Laying().begin(name, 2, (np.array([1.0, 0.0]), 1.0), -1.0, {})
    with pytest.raises(LayingError, match="finite"):
        Laying().begin("translateUV", 1, (np.inf, 1.0), -1.0, {})
