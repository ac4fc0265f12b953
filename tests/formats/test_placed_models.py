"""What a model is made of: assets that are fitted into scopes, and solids with their holes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats import obj_read
from ipmlang.formats.mesh import read_mesh
from ipmlang.formats.mesh_types import Mesh, baked, triangulated
from ipmlang.geometry.solid import Solid, polygon, unit_box
from ipmlang.runtime.export.models import mesh_scene_of
from ipmlang.runtime.export.solids import solid_mesh
from ipmlang.runtime.scene import SOLID, AssetRef, Scene
from tests.formats.built import scene, table

WEDGE = (
    "v 1 1 1\nv 3 1 1\nv 3 2 1\nv 1 2 1\nv 1 1 5\nf 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
)


def boxes(found: Scene) -> list[list[list[float]]]:
    """The least and greatest corner of every copy in the world."""
    made = mesh_scene_of(found)
    points = (
        made.meshes[mesh].vertices @ matrix[:, :3].T + matrix[:, 3]
        for mesh, matrix in zip(made.mesh.tolist(), made.matrix, strict=True)
    )
    return [np.round([each.min(axis=0), each.max(axis=0)], 9).tolist() for each in points]


def area(mesh: Mesh) -> float:
    """The surface of all faces."""
    corners = mesh.vertices[mesh.corners[triangulated(mesh)[0]]]
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(edges, axis=1).sum() / 2)


def test_assets_fill_the_scopes_that_have_a_size(tmp_path: Path) -> None:
    """The asset's box becomes the scope's; without a size it stays as it is, and where."""
    (tmp_path / "a.obj").write_text(WEDGE)
    found = scene(
        table([[4, 3, 8], [0, 0, 0], [4, 0, 8]], 0), AssetRef("a", tmp_path / "a.obj", None)
    )
    # Turned: local x goes along world y, local y along world -x; all lengths are doubled.
    assert boxes(found) == [
        [[10 - 6, 0, 0], [10, 8, 16]],
        [[20 - 4, 2, 2], [20 - 2, 6, 10]],
        [[30 - 2, 0, 0], [30, 8, 16]],
    ]


def test_what_has_no_extent_keeps_its_own(tmp_path: Path) -> None:
    """A flat asset in a deep scope; a vertex that no face uses does not count."""
    (tmp_path / "a.obj").write_text("v 9 9 9\nv 0 0 3\nv 1 0 3\nv 0 1 3\nf 2 3 4\n")
    found = scene(table([[5, 5, 7]], 0), AssetRef("a", tmp_path / "a.obj", None))
    made = mesh_scene_of(found)
    mesh, matrix = made.meshes[0], made.matrix[0]
    used = mesh.vertices[mesh.corners] @ matrix[:, :3].T + matrix[:, 3]
    assert np.round([used.min(axis=0), used.max(axis=0)], 9).tolist() == [[0, 0, 0], [10, 10, 0]]


def test_a_file_is_read_once_for_all_its_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixty parts of one file are one reading."""
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    groups = "".join(f"g part{k}\nf 1 2 3\n" for k in range(60))
    (tmp_path / "a.obj").write_text(points + groups)
    assets = [AssetRef(f"part{k}", tmp_path / "a.obj", f"part{k}") for k in range(60)]
    rows = table([[0, 0, 0]] * 60, 0)
    rows.asset[:] = np.arange(60)
    reads: list[Path] = []
    original = obj_read.read_obj
    monkeypatch.setattr(obj_read, "read_obj", lambda path: (reads.append(path), original(path))[1])
    assert len(mesh_scene_of(scene(rows, *assets)).meshes) == 60
    assert len(reads) == 1


def test_copies_of_a_solid_share_a_mesh() -> None:
    """Stretched along the scope's axes; an axis without size is left alone."""
    rows = table([[1, 2, 3], [2, 2, 0], [1, 1, 1]], SOLID)
    rows.shape[:] = [1, 0, 1]
    found = scene(rows, solids=(polygon([(0, 0), (1, 0), (1, 1)]), unit_box()))
    made = mesh_scene_of(found)
    assert len(made.meshes) == 2
    assert made.mesh[0] == made.mesh[2] != made.mesh[1]
    assert boxes(found) == [
        [[10 - 4, 0, 0], [10, 2, 6]],
        [[20 - 4, 0, 0], [20, 4, 0]],
        [[30 - 2, 0, 0], [30, 2, 2]],
    ]
    assert area(baked(made)) == pytest.approx(4 * (2 * (2 + 3 + 6) + 2 + 6))


@pytest.mark.parametrize("turned", [False, True])
def test_holes_stay_open(turned: bool) -> None:
    """The area is that of the face without its holes, and it faces where it did."""
    holes = [[(1, 1), (1, 2), (2, 2), (2, 1)], [(3, 1), (3, 3), (4, 3), (4, 1)]]
    flat = polygon([(0, 0), (5, 0), (5, 4), (0, 4)], holes)
    if turned:
        flat = Solid(
            flat.vertices[:, [2, 0, 1]], flat.corners, flat.rings, flat.faces, flat.tags, None
        )
    mesh = solid_mesh(flat)
    corners = mesh.vertices[mesh.corners[triangulated(mesh)[0]]]
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    assert vectors.sum(axis=0) == pytest.approx([17, 0, 0] if turned else [0, 0, 17])
    assert area(mesh) == pytest.approx(17)


def test_faces_keep_their_texture_points_around_holes() -> None:
    """Triangles of a pierced face and whole faces beside it."""
    pierced = polygon([(0, 0), (5, 0), (5, 4), (0, 4)], [[(1, 1), (1, 2), (2, 2), (2, 1)]])
    count = len(pierced.corners)
    both = Solid(
        np.concatenate([pierced.vertices, pierced.vertices[:4] + np.array([0.0, 0, 3])]),
        np.concatenate([pierced.corners, np.arange(4) + len(pierced.vertices)]),
        np.append(pierced.rings, count + 4),
        np.append(pierced.faces, 3),
        (frozenset(), frozenset()),
        np.concatenate([pierced.vertices, pierced.vertices[:4]])[:, :2] / 7,
    )
    mesh = solid_mesh(both)
    assert mesh.uv is not None
    assert mesh.uv == pytest.approx(mesh.vertices[mesh.corners][:, :2] / 7)
    assert area(mesh) == pytest.approx(19 + 20)
    assert sorted(np.diff(mesh.offsets).tolist()) == [3] * 8 + [4]


def test_written_solids_are_read_back(tmp_path: Path) -> None:
    """Through a file: the faces of a box, six quads."""
    from ipmlang.runtime.export import save

    rows = table([[1, 2, 3]], SOLID)
    save(scene(rows, solids=(unit_box(),)), tmp_path / "a.obj")
    assert np.diff(read_mesh(tmp_path / "a.obj").offsets).tolist() == [4] * 6


@pytest.mark.parametrize("kinds", [3, 200])
@pytest.mark.parametrize("instancing", [False, True])
def test_copies_come_back_where_they_were(kinds: int, instancing: bool, tmp_path: Path) -> None:
    """Many that are turned alike, or each in its own way; some at the origin, some mirrored."""
    from ipmlang.formats.mesh import read_meshes
    from ipmlang.runtime.export import save

    rows = table([[1, 2, 3]] * 200, SOLID)
    rows.shape[:] = 0
    generator = np.random.default_rng(5)
    rotation = generator.normal(size=(kinds, 4))
    rotation /= np.linalg.norm(rotation, axis=1, keepdims=True)
    rows.rotation[:] = rotation[np.arange(200) % kinds]
    rows.scale[:] = np.where(np.arange(200) % kinds == 1, -0.5, 2.0)
    rows.position[::5] = 0
    found = scene(rows, solids=(unit_box(),))
    save(found, tmp_path / "a.glb", instancing=instancing)
    wanted = mesh_scene_of(found).matrix
    again = read_meshes(tmp_path / "a.glb").matrix
    assert np.sort(again, axis=0) == pytest.approx(np.sort(wanted, axis=0), abs=1e-4)
