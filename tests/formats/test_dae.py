"""DAE files: geometry, copies, axes, units and materials; and what is wrong with wrong ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.mesh import mesh_names, read_mesh, read_meshes

QUADS = """
<polylist count="2" material="paint"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#t" offset="1"/>
<vcount>4 3</vcount><p>0 0 1 1 2 2 3 3 0 0 1 1 2 2</p></polylist>"""
TRIANGLES = """
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2 0 2 3</p></triangles>"""
NODES = """
<node name="first"><translate>0 0 5</translate><rotate>0 0 1 90</rotate>
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="paint" target="#red"/></technique_common></bind_material>
</instance_geometry></node>
<node name="second"><matrix>1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<instance_geometry url="#g"/></node>"""


def dae(
    folder: Path,
    faces: str = TRIANGLES,
    nodes: str = NODES,
    asset: str = "<up_axis>Z_UP</up_axis>",
    points: str = "0 0 0 2 0 0 2 1 0 0 1 0",
) -> Path:
    """A file of one geometry."""
    path = folder / "a.dae"
    path.write_text(
        f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert>
<diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="red" name="Red"><instance_effect url="#e"/></material>
</library_materials>
<library_geometries><geometry id="g" name="tile"><mesh>
<source id="p"><float_array>{points}</float_array><technique_common>
<accessor stride="3"/></technique_common></source>
<source id="t"><float_array>0 0 1 0 1 1 0 1</float_array><technique_common>
<accessor stride="2"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{faces}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
    )
    return path


def test_copies_stand_where_nodes_put_them(tmp_path: Path) -> None:
    """One geometry in two places, by steps and by a matrix."""
    scene = read_meshes(dae(tmp_path))
    assert len(scene.meshes) == 2 and [scene.names[each] for each in scene.name] == [
        "first",
        "second",
    ]
    mesh = read_mesh(dae(tmp_path))
    assert np.allclose(mesh.vertices[:4], [[0, 0, 5], [0, 2, 5], [-1, 2, 5], [-1, 0, 5]])
    assert np.allclose(mesh.vertices[4:, 0], [7, 9, 9, 7])
    assert mesh_names(dae(tmp_path)) == ("first", "second")
    assert len(read_meshes(dae(tmp_path), "second").mesh) == 1


def test_polygons_stay_polygons_with_materials_and_texture_points(tmp_path: Path) -> None:
    """A quad and a triangle."""
    scene = read_meshes(dae(tmp_path, QUADS))
    mesh = scene.meshes[scene.mesh[0]]
    assert np.diff(mesh.offsets).tolist() == [4, 3]
    assert mesh.materials[0].name == "Red" and mesh.materials[0].color == (1.0, 0, 0, 1)
    assert mesh.uv is not None and mesh.uv[2].tolist() == [1, 1]


@pytest.mark.parametrize(
    ("axis", "top"), [("Y_UP", [0, -4, 1]), ("Z_UP", [0, 1, 4]), ("X_UP", [-1, -4, 0])]
)
def test_axes_are_turned_to_z_up(axis: str, top: list[float], tmp_path: Path) -> None:
    """What the file says is up is up, and nothing is mirrored."""
    nodes = '<node><instance_geometry url="#g"/></node>'
    points = "0 0 0 2 0 0 2 1 0 0 1 4"
    path = dae(tmp_path, TRIANGLES, nodes, f"<up_axis>{axis}</up_axis>", points)
    scene = read_meshes(path)
    assert np.allclose(read_mesh(path).vertices[3], top)
    assert np.linalg.det(scene.matrix[0, :, :3]) == pytest.approx(1)


def test_other_units_are_said(tmp_path: Path) -> None:
    """Lengths stay, a note says what one is."""
    asset = '<unit meter="0.01" name="centimeter"/><up_axis>Z_UP</up_axis>'
    scene = read_meshes(dae(tmp_path, asset=asset))
    assert [(note.code, "0.01" in note.message) for note in scene.notes] == [("unit", True)]


def test_strips_and_fans(tmp_path: Path) -> None:
    """Both cover the quad, facing up."""
    for faces in ("tristrips", "trifans"):
        run = "0 1 3 2" if faces == "tristrips" else "0 1 2 3"
        text = f'<{faces}><input semantic="VERTEX" source="#v" offset="0"/><p>{run}</p></{faces}>'
        mesh = read_meshes(dae(tmp_path, text)).meshes[0]
        corners = mesh.vertices[mesh.corners.reshape(-1, 3)]
        up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
        assert up.tolist() == [2, 2]


WRONG = {
    "not xml": ("<COLLADA", "no XML"),
    "another root": ("<svg/>", "no DAE file"),
    "a bad index": (TRIANGLES.replace("0 2 3", "0 2 9"), "POSITION that is not among the 4"),
    "a bad number": (TRIANGLES.replace("0 2 3", "0 2 x"), "no whole number"),
    "no such source": (TRIANGLES.replace("#v", "#w"), "which is not there"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files(name: str, tmp_path: Path) -> None:
    """One message that says what is wrong."""
    text, said = WRONG[name]
    path = dae(tmp_path, text)
    if not text.startswith("\n"):
        path.write_text(text)
    with pytest.raises(FormatError, match=said):
        read_meshes(path)


def test_a_node_that_holds_itself(tmp_path: Path) -> None:
    """Ends with a message."""
    nodes = '<node id="n"><instance_node url="#n"/></node>'
    with pytest.raises(FormatError, match="hold themselves"):
        read_meshes(dae(tmp_path, nodes=nodes))


def test_entities_are_not_followed(tmp_path: Path) -> None:
    """A file that grows by entities, or names others, gives nothing."""
    path = tmp_path / "bomb.dae"
    path.write_text(
        '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/hostname">]>'
        "<COLLADA><asset><up_axis>&a;</up_axis></asset></COLLADA>"
    )
    with pytest.raises(FormatError, match="no faces"):
        read_meshes(path)
