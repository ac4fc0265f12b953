"""Models in, meshes out, in every format; and what is wrong with those that are wrong."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import write_files
from ipmlang.formats.mesh import mesh_contents, mesh_names, read_mesh, read_meshes
from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, triangulated
from ipmlang.runtime.export.models import unit_cube

QUAD = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n"


def area(mesh: Mesh) -> float:
    """The surface of all faces."""
    corners = mesh.vertices[mesh.corners[triangulated(mesh)[0]]]
    edges = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(edges, axis=1).sum() / 2)


def volume(mesh: Mesh) -> float:
    """What a closed mesh encloses, above zero if its faces face outward."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.corners[triangulated(mesh)[0]]], 1, 0)
    return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6)


def written(folder: Path, name: str, content: str | bytes) -> Path:
    """A file of that content."""
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def glb(folder: Path, tree: dict[str, object], binary: bytes = b"") -> Path:
    """A GLB file of that JSON and data."""
    text = json.dumps({"asset": {"version": "2.0"}, **tree}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return written(folder, "a.glb", struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def triangle_tree(**position: object) -> tuple[dict[str, object], bytes]:
    """One triangle (0,0,0), (1,0,0), (0,1,0) in y-up space, named by node and mesh."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", **position}
    tree: dict[str, object] = {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "leaf", "mesh": 0}],
        "meshes": [{"name": "sheet", "primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [accessor],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data)}],
    }
    return tree, data


def test_obj_keeps_polygons_groups_and_materials(tmp_path: Path) -> None:
    """Quads stay quads; negative indices count back; a name picks its faces."""
    written(tmp_path, "m.mtl", "newmtl red\nKd 1 0 0\n")
    text = f"mtllib m.mtl\n{QUAD}o wall\nusemtl red\nf 1 2 3 4\ng left roof\nf -4 -3 -2\n"
    path = written(tmp_path, "a.obj", text)
    mesh = read_mesh(path)
    assert np.diff(mesh.offsets).tolist() == [4, 3]
    assert [mesh.groups[i] for i in mesh.group] == [("wall",), ("wall", "left", "roof")]
    assert mesh.materials[mesh.material[0]].color == (1.0, 0.0, 0.0, 1.0)
    assert mesh_names(path) == ("wall", "left", "roof")
    assert np.diff(read_mesh(path, "roof").offsets).tolist() == [3]
    with pytest.raises(FormatError, match="`door`"):
        read_mesh(path, "door")


def test_obj_textures_belong_to_corners(tmp_path: Path) -> None:
    """All the ways in which a corner is written, alike or mixed."""
    for face in ("1/1 2/2 3/1", "1/1/1 2/2/1 3/1/1", "1/1 2/2/1 3/1"):
        path = written(tmp_path, "a.obj", f"{QUAD}vt 0 0\nvt 1 0.5\nvn 0 0 1\nf {face}\n")
        uv = read_mesh(path).uv
        assert uv is not None
        assert uv.tolist() == [[0, 0], [1, 0.5], [0, 0]]
    assert read_mesh(written(tmp_path, "a.obj", f"{QUAD}f 1 2 \\\n3 4\n")).uv is None


def test_concave_polygons_are_covered_exactly(tmp_path: Path) -> None:
    """An L of six corners in each of the three planes, either way round."""
    flat = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    for axes in ("{0} {1} 0", "0 {0} {1}", "{1} 0 {0}"):
        points = "".join(f"v {axes.format(*point)}\n" for point in flat)
        for face in ("1 2 3 4 5 6", "6 5 4 3 2 1"):
            mesh = read_mesh(written(tmp_path, "a.obj", f"{points}f {face}\n"))
            corners = mesh.vertices[mesh.corners[triangulated(mesh)[0]]]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            assert area(mesh) == pytest.approx(3)
            assert np.linalg.norm(normals.sum(axis=0)) == pytest.approx(6)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"{QUAD}f 1 2 9\n", 5),
        (f"{QUAD}f 0 1 2\n", 5),
        (f"{QUAD}f 1 2 3\nf -9 1 2\n", 6),
        (f"{QUAD}f 1 2 x\n", 5),
        ("v 0 0\n", 1),
        ("v 0 0 0\nv 0 zero 0\nf 1 1 1\n", 2),
    ],
)
def test_a_wrong_obj_names_its_line(text: str, line: int, tmp_path: Path) -> None:
    """Indices that point nowhere and numbers that are none."""
    with pytest.raises(FormatError) as caught:
        read_mesh(written(tmp_path, "a.obj", text))
    assert caught.value.line == line


def test_faces_without_value_are_counted(tmp_path: Path) -> None:
    """NaN drops the faces that touch it, and says how many."""
    path = written(tmp_path, "a.obj", f"{QUAD}v nan 0 0\nf 1 2 3\nf 1 2 5\nf 1 1 2\n")
    scene = read_meshes(path)
    assert len(scene.meshes[0].offsets) - 1 == 1
    assert {note.code: note.count for note in scene.notes} == {
        "bad-vertex": 1,
        "degenerate-face": 1,
    }


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_in_all_forms(form: str, tmp_path: Path) -> None:
    """A quad and a triangle, with a colour that is passed over."""
    header = (
        f"ply\nformat {form} 1.0\ncomment x\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement face 2\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    points = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)]
    faces = [(0, 1, 2, 3), (0, 1, 2)]
    if form == "ascii":
        body = "".join(f"{x} {y} {z} 7\n" for x, y, z in points)
        body += "".join(f"{len(face)} {' '.join(map(str, face))}\n" for face in faces)
        data = body.encode()
    else:
        order = "<" if "little" in form else ">"
        data = b"".join(struct.pack(order + "fffB", *point, 7) for point in points)
        data += b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)
    mesh = read_mesh(written(tmp_path, "a.ply", header.encode() + data))
    assert np.diff(mesh.offsets).tolist() == [4, 3]
    assert area(mesh) == pytest.approx(3)
    with pytest.raises(FormatError):
        read_mesh(written(tmp_path, "b.ply", header.encode() + data[:-9]))


def test_stl_in_both_forms(tmp_path: Path) -> None:
    """Equal corners are one vertex."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    lines = [f"vertex {x} {y} {z}" for x, y, z in corners]
    text = "solid a\n" + "\n".join(lines) + "\nendsolid\n"
    data = b"solid".ljust(80) + struct.pack("<I", 2)
    for k in (0, 3):
        data += struct.pack("<12fH", 0, 0, 1, *np.ravel(corners[k : k + 3]).tolist(), 0)
    for content in (text, data):
        mesh = read_mesh(written(tmp_path, "a.stl", content))
        assert len(mesh.vertices) == 4
        assert area(mesh) == pytest.approx(1)
    with pytest.raises(FormatError, match="states 2 triangles and holds 1"):
        read_mesh(written(tmp_path, "a.stl", data[:-10]))


def test_glb_is_turned_to_z_up_and_nodes_have_names(tmp_path: Path) -> None:
    """y-up (x, y, z) is z-up (x, -z, y), under all transforms above."""
    tree, data = triangle_tree()
    tree["nodes"] = [
        {"children": [1], "scale": [2, 2, 2]},
        {"name": "leaf", "mesh": 0, "translation": [0, 0, 5]},
    ]
    path = glb(tmp_path, tree, data)
    assert mesh_names(path) == ("leaf", "sheet")
    assert read_mesh(path).vertices.tolist() == [[0, -10, 0], [2, -10, 0], [0, -10, 2]]
    assert read_mesh(path, "leaf").vertices.tolist() == [[0, -5, 0], [1, -5, 0], [0, -5, 1]]
    assert read_mesh(path, "sheet").vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 0, 1]]


def test_glb_mirrored_copies_face_outward(tmp_path: Path) -> None:
    """A negative scale turns the order of the corners."""
    tree, data = triangle_tree()
    tree["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]
    mesh = read_mesh(glb(tmp_path, tree, data))
    a, b, c = mesh.vertices[mesh.corners]
    assert np.cross(b - a, c - a).tolist() == [0, -1, 0]


def test_glb_quantised_and_sparse_numbers(tmp_path: Path) -> None:
    """Normalised integers are parts of one; a sparse accessor replaces some values."""
    tree, _ = triangle_tree(componentType=5122, normalized=True)
    data = np.array([[0, 0, 0], [32767, 0, 0], [0, 32767, 0]], "<i2").tobytes() + b"\0\0"
    tree["bufferViews"] = [{"buffer": 0, "byteLength": len(data)}]
    assert read_mesh(glb(tmp_path, tree, data)).vertices[1].tolist() == [1, 0, 0]
    tree, data = triangle_tree()
    extra = struct.pack("<HH3f", 1, 0, 7, 0, 0)
    tree["bufferViews"] = [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 2},
        {"buffer": 0, "byteOffset": 40, "byteLength": 12},
    ]
    sparse = {
        "count": 1,
        "indices": {"bufferView": 1, "componentType": 5123},
        "values": {"bufferView": 2},
    }
    accessors = tree["accessors"]
    assert isinstance(accessors, list)
    accessors[0]["sparse"] = sparse
    assert read_mesh(glb(tmp_path, tree, data + extra)).vertices[1].tolist() == [7, 0, 0]


def test_glb_copies_of_the_instancing_extension(tmp_path: Path) -> None:
    """One node, two copies."""
    tree, data = triangle_tree()
    places = np.array([[0, 0, 0], [0, 5, 0]], "<f4").tobytes()
    tree["accessors"] += [  # type: ignore[operator]
        {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}
    ]
    tree["bufferViews"] += [  # type: ignore[operator]
        {"buffer": 0, "byteOffset": 36, "byteLength": 24}
    ]
    spread = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}
    tree["nodes"] = [{"mesh": 0, "extensions": spread}]
    scene = read_meshes(glb(tmp_path, tree, data + places))
    assert scene.matrix[:, :, 3].tolist() == [[0, 0, 0], [0, 0, 5]]
    assert len(scene.meshes) == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"extensionsRequired": ["EXT_meshopt_compression"]}, "EXT_meshopt_compression"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "below itself"),
        ({"nodes": [{"mesh": 7}]}, r"meshes\[7\]"),
        ({"nodes": [{"mesh": 0, "scale": [1, "x", 1]}]}, "3 numbers"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 999}]}, "past the end"),
        ({"buffers": [{"uri": "a.bin", "byteLength": 36}]}, "other files"),
        ({"accessors": [{"bufferView": 0, "componentType": 5126, "count": 10**9, "type": "VEC3"}]},
         "more than its data"),
        ({"accessors": [{"componentType": 5126, "count": 10**12, "type": "VEC3"}]}, "has none"),
    ],
)  # fmt: skip
def test_a_wrong_glb_says_why(change: dict[str, object], message: str, tmp_path: Path) -> None:
    """Never a traceback, never silently empty."""
    tree, data = triangle_tree()
    with pytest.raises(FormatError, match=message):
        read_meshes(glb(tmp_path, {**tree, **change}, data))


def test_a_cut_glb_and_files_that_are_not_there(tmp_path: Path) -> None:
    """Truncation at any byte, and a missing file."""
    whole = glb(tmp_path, *triangle_tree()).read_bytes()
    for size in range(0, len(whole), 7):
        with pytest.raises(FormatError):
            read_mesh(written(tmp_path, "b.glb", whole[:size]))
    for name in ("nowhere.glb", "nowhere.obj", "nowhere.stl"):
        with pytest.raises(FormatError, match="no such file"):
            read_mesh(tmp_path / name)
        with pytest.raises(FormatError, match="no such file"):
            mesh_names(tmp_path / name)
    with pytest.raises(FormatError, match="no model"):
        read_mesh(tmp_path / "a.doc")


# Triangles as counted by another reader (the list of inputs), some of them after dropping
# degenerate faces.
REAL = {
    "castle.obj": 5659,
    "tower_A.obj": 1538,
    "fzk_haus.obj": 36290,
    "map_pandora.obj": 60694,
    "warehouse_shelf.glb": 2926,
    "pins.glb": 3408,
    "house_scene.glb": 10497,
    "map_zdm2.glb": 58772,
    "cycloidal.ply": 43368,
    "bosl2_ring_gear.stl": 6264,
}


@pytest.mark.parametrize("name", REAL)
def test_real_models(name: str, data: Path) -> None:
    """All their triangles, and copies where the file has them."""
    mesh = read_mesh(data / "mesh" / name)
    assert len(triangulated(mesh)[0]) == REAL[name]
    assert np.isfinite(mesh.vertices).all()


def test_draco(data: Path) -> None:
    """A packed model is read whole, or the missing library is named."""
    pytest.importorskip("DracoPy")
    scene = read_meshes(data / "mesh" / "chess_board.glb")
    assert sum(len(mesh.corners) for mesh in scene.meshes) == 3 * 178848


HOSTILE = {
    "truncated.obj": FormatError,
    "nan_vertices.obj": FormatError,
    "index_out_of_range.obj": FormatError,
    "empty.obj": FormatError,
    "not_utf8.obj": None,
    "huge_coords.obj": None,
    "assimp_malformed.obj": FormatError,
    "assimp_empty.off": FormatError,
    "assimp_OutOfMemory.off": FormatError,
    "assimp_fuzz_crash.ply": FormatError,
    "assimp_empty.ply": FormatError,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_models(name: str, data: Path) -> None:
    """A clean end: a mesh, or a message without a traceback."""
    expected = HOSTILE[name]
    if expected is None:
        assert len(read_mesh(data / "hostile" / name).corners)
        return
    with pytest.raises(expected) as caught:
        read_mesh(data / "hostile" / name)
    assert "\n" not in str(caught.value)


def test_ply_keeps_the_colour_of_each_face(tmp_path: Path) -> None:
    """What another program reads: a copy's colour, else that of its mesh, else grey."""
    import trimesh

    red, blue = Material("red", (1, 0, 0, 1)), Material("blue", (0, 0, 1, 0.6))
    cube = unit_cube()
    mesh = replace(cube, material=np.arange(len(cube.material)) % 2 - 1, materials=(red,))
    copies = np.stack([np.eye(3, 4), np.eye(3, 4) + [[0, 0, 0, 5]] * 3])
    none = np.zeros(2, np.int64)
    scene = MeshScene((mesh,), none, copies, none, np.array([-1, 0]), ("cube",), (blue,))
    path = tmp_path / "a.ply"
    write_files(mesh_contents(scene, path))
    found = trimesh.load(path, process=False)
    seen = np.unique(found.visual.face_colors, axis=0).tolist()
    assert seen == [[0, 0, 255, 153], [204, 204, 204, 255], [255, 0, 0, 255]]
    blues = (found.visual.face_colors == [0, 0, 255, 153]).all(axis=1)
    assert found.triangles_center[blues].min() >= 4.5
    assert volume(read_mesh(path)) == pytest.approx(2)
