"""What hangs together and is cut into what repeats, and what is left whole; names of the file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inverse import solids
from inverse.solids import Floats, box, lost, obj_text, regular, soup_of

from ipmlang.formats import FormatError
from ipmlang.formats.mesh_types import Mesh, merged, moved
from ipmlang.inverse.parts import observe, parts_of

EXACT = 1e-6


def at(x: float, y: float = 0.0, z: float = 0.0) -> Floats:
    """A shift."""
    return np.concatenate([np.eye(3), [[x], [y], [z]]], axis=1)


def test_boxes_that_touch_are_bricks() -> None:
    """Each has its own vertices in the file, whatever lies at the same place."""
    places = [at(2.0 * i, 0, 1.0 * k) for i in range(5) for k in range(4)]
    soup = soup_of([box(2, 1, 1)] * 20, places)
    parts = parts_of(soup, EXACT)
    assert (len(parts.shape), len(parts.classes)) == (20, 1)
    assert lost(parts, soup.mesh) < EXACT
    assert any(note.code == "segmented" for note in parts.notes)


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_welded_boxes_are_solids_again(tilt: float) -> None:
    """Six walls of a row that lie in each other with whole faces, and six above them that touch
    along edges: welded by position, no edge tells by itself which faces are one box.
    """
    places = [at(3.0 * i, 0.4 * k, 3.0 * k) for i in range(6) for k in range(2)]
    mesh = merged([moved(box(3.0, 0.4, 3.0), place) for place in places])
    points, same = np.unique(mesh.vertices.round(9), axis=0, return_inverse=True)
    cosine, sine = np.cos(tilt), np.sin(tilt)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    turn = turn @ np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    corners = same.reshape(-1)[mesh.corners]
    parts = parts_of(soup_of([replace(mesh, vertices=points @ turn.T, corners=corners)]), EXACT)
    assert (len(parts.shape), len(parts.classes)) == (12, 1)


def test_flat_panels_of_a_wall() -> None:
    """Quads side by side in one plane, each with its own vertices."""
    panel = solids.polygons([[0, 0, 0], [2, 0, 0], [2, 0, 3], [0, 0, 3]], [[0, 1, 2, 3]])
    places = [at(2.0 * i, 0, 3.0 * k) for i in range(8) for k in range(6)]
    parts = parts_of(soup_of([panel] * 48, places), EXACT)
    assert (len(parts.shape), len(parts.classes)) == (48, 1)


@pytest.mark.parametrize("mesh", [box(1, 2, 3), regular(24), regular(7, 3.0)])
def test_faces_with_their_own_vertices_are_one_shape(mesh: Mesh) -> None:
    """Files part vertices to shade faces apart; that does not take shapes apart."""
    corners = np.arange(len(mesh.corners))
    loose = replace(mesh, vertices=mesh.vertices[mesh.corners], corners=corners)
    assert len(parts_of(soup_of([loose]), EXACT).shape) == 1


def fan(sides: int, radius: float, height: float) -> Mesh:
    """A cylinder of triangles, its caps about a point in their middles."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = [[radius * np.cos(a), radius * np.sin(a)] for a in angle]
    points = [[*each, z] for z in (0.0, height) for each in ring] + [[0, 0, 0], [0, 0, height]]
    faces = []
    for i in range(sides):
        k, low, high = (i + 1) % sides, 2 * sides, 2 * sides + 1
        faces += [[i, k, sides + k], [i, sides + k, sides + i], [k, i, low]]
        faces += [[sides + i, sides + k, high]]
    return solids.polygons(points, faces)


@pytest.mark.parametrize("sides", [8, 24, 48])
def test_a_convex_solid_stays_whole(sides: int) -> None:
    """A disc has planes that no face crosses, and quarters that repeat: it is one disc."""
    assert len(parts_of(soup_of([fan(sides, 2.0, 0.5)]), EXACT).shape) == 1


def test_solids_that_touch_in_a_point_come_apart() -> None:
    """The caps of a shaft and of the slab on it have one point in common."""
    soup = soup_of([fan(24, 2.0, 0.5), fan(24, 0.5, 4.0)], [at(0, 0, 3.5), at(0)])
    parts = parts_of(soup, EXACT)
    assert (len(parts.shape), len(parts.classes)) == (2, 2)
    assert lost(parts, soup.mesh) < EXACT


def test_pieces_that_others_have_too_come_apart() -> None:
    """Books on shelves: no two rows are alike, and within a row hardly two books."""
    kinds = [box(0.02 * w, 0.2, 0.3) for w in (1, 2, 3, 4, 5)]
    rows = [(0, 1, 2, 3), (3, 0, 4, 2), (4, 1, 0, 3), (2, 4, 3, 1), (1, 0, 2, 4)]
    meshes, places = [], []
    for level, row in enumerate(rows):
        x = 0.0
        for kind in row:
            meshes.append(kinds[kind])
            places.append(at(x, 0, 0.4 * level))
            x += 0.02 * (kind + 1)
    soup = soup_of(meshes, places)
    parts = parts_of(soup, EXACT)
    assert (len(parts.shape), len(parts.classes)) == (20, 5)
    assert lost(parts, soup.mesh) < EXACT


def facade(columns: int, rows: int) -> Mesh:
    """One shell: a wall with niches in a grid, vertices shared."""
    points: dict[tuple[float, float, float], int] = {}
    faces: list[list[int]] = []

    def add(*corners: tuple[float, float, float]) -> None:
        faces.append([points.setdefault(corner, len(points)) for corner in corners])

    def wall(x: float, z: float) -> None:
        add((x, 0, z), (x + 1, 0, z), (x + 1, 0, z + 1), (x, 0, z + 1))

    for i in range(columns):
        for k in range(rows):
            x, z = 3.0 * i, 3.0 * k
            for a, b in ((a, b) for a in range(3) for b in range(3) if (a, b) != (1, 1)):
                wall(x + a, z + b)
            ring = [(x + 1, z + 1), (x + 2, z + 1), (x + 2, z + 2), (x + 1, z + 2)]
            add(*[(u, 0.4, w) for u, w in ring])
            for (u, w), (p, q) in zip(ring, [*ring[1:], ring[0]], strict=True):
                add((u, 0, w), (p, 0, q), (p, 0.4, q), (u, 0.4, w))
    return solids.polygons([list(each) for each in points], faces)


def test_a_facade_of_one_shell_is_cut() -> None:
    """Into pieces of a few kinds, each of them many times."""
    soup = soup_of([facade(8, 6)])
    parts = parts_of(soup, EXACT)
    assert sorted(len(each.members) for each in parts.classes) == [1, 48]
    assert lost(parts, soup.mesh) < EXACT


def test_nothing_is_cut_where_nothing_repeats() -> None:
    """A rough terrain stays whole."""
    random = np.random.default_rng(2)
    x, y = np.meshgrid(np.arange(30.0), np.arange(30.0))
    points = np.stack([x, y, random.normal(size=x.shape)], axis=2).reshape(-1, 3)
    begin = (np.arange(29)[:, None] * 30 + np.arange(29)).reshape(-1)
    faces = np.concatenate(
        [begin[:, None] + [0, 1, 30], begin[:, None] + [1, 31, 30]]
    ).tolist()  # fmt: skip
    assert len(parts_of(soup_of([solids.polygons(points.tolist(), faces)]), EXACT).shape) == 1


@pytest.mark.parametrize("name", ["recast_dungeon.obj", "castle.obj", "market.obj", "barracks.obj"])
def test_real_parts_stay_whole(name: str, data: Path) -> None:
    """Parts of hand-made models are what their makers made."""
    parts = observe(data / "mesh" / name)
    assert not [note for note in parts.notes if note.code == "segmented"]


def test_objects_that_touch_stay_apart(tmp_path: Path) -> None:
    """A wall and a slab that share an edge, with the names the file gives them."""
    text = (
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 1\nv 0 0 1\n"
        "o IfcSlab_1\nf 1 2 3 4\no IfcWallStandardCase_2\nf 1 6 5 2\n"
    )
    parts = observe(solids.written(tmp_path / "a.obj", text))
    assert parts.path == (("IfcSlab_1",), ("IfcWallStandardCase_2",))
    assert [each.name for each in parts.classes] in (
        ["Slab", "WallStandardCase"],
        ["Slab"],
    )


def test_what_was_mended_is_said() -> None:
    """Faces without area, faces there twice, one that looks the other way."""
    mesh = box(1, 2, 3)
    faces = [mesh.corners[4 * k : 4 * k + 4].tolist() for k in range(6)]
    faces[2] = faces[2][::-1]
    wrong = solids.polygons(
        [*mesh.vertices.tolist(), [9, 9, 9]], [*faces, faces[0], [0, 1, 0, 1], [0, 2, 2]]
    )
    parts = parts_of(soup_of([wrong]), EXACT)
    assert {note.code: note.count for note in parts.notes} == {
        "unused-vertex": 1,
        "degenerate-face": 2,
        "duplicate-face": 1,
        "flipped-face": 1,
    }
    assert lost(parts, mesh) < EXACT


def test_up_is_guessed_and_can_be_said(tmp_path: Path) -> None:
    """A house that stands on z = 0 in a format where y is usual."""
    lifted = moved(box(4, 3, 5), at(-2, -1, 0))
    path = solids.written(tmp_path / "a.obj", obj_text(lifted))
    assert observe(path).up == "z-up" and observe(path, up="y").up == "y-up"
    assert np.allclose(observe(path, unit=0.5).classes[0].size, [2, 1.5, 2.5])
    assert np.allclose(observe(path, up="y").classes[0].size, [4, 5, 3])


def test_a_site_under_a_house_tells_what_is_up(tmp_path: Path) -> None:
    """A plate that sticks out on all sides, across y or across z; with a cellar below it, so that
    nothing ends at 0 but by chance. A wall as large as its side is no plate.
    """
    site = moved(box(20, 18, 0.2), at(-4, -5, -0.2))
    house = [moved(box(10, 8, 5), at(0, 0, 0)), moved(box(3, 3, 2), at(2, 2, -2.4))]
    z_up = merged([site, *house])
    turn = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]])
    wall = merged([moved(box(10, 1, 5), at(1, 1, 1)), moved(box(2, 2, 1), at(3, 1, 6))])
    for name, mesh, up in (
        ("z", z_up, "z-up"),
        ("y", moved(z_up, turn), "y-up"),
        ("wall", moved(wall, turn), "y-up"),
    ):
        path = solids.written(tmp_path / f"{name}.obj", obj_text(mesh))
        assert observe(path).up == up, name


def test_names_of_building_models_tell_what_is_up(tmp_path: Path) -> None:
    """An exchange format of architects in which z is up always."""
    lifted = moved(box(4, 3, 5), at(-2, -1, 7))
    text = obj_text(lifted)
    assert observe(solids.written(tmp_path / "a.obj", text)).up == "y-up"
    named = solids.written(tmp_path / "b.obj", f"o IfcWall_12\n{text}")
    assert observe(named).up == "z-up"


@pytest.mark.parametrize(
    "name", ["degenerate.obj", "huge_coords.obj", "nan_vertices.obj", "empty.obj"]
)
def test_hostile_models(name: str, data: Path) -> None:
    """One message, with a hint."""
    with pytest.raises(FormatError) as caught:
        observe(data / "hostile" / name)
    assert "\n" not in caught.value.message
