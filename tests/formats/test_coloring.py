"""Colours that files give vertices and faces come in as materials, one for each colour."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats.coloring import MOST, with_face_colors
from ipmlang.formats.mesh import read_mesh
from ipmlang.formats.mesh_types import Material, Mesh, triangle_mesh

RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 0, 0], [4, 0, 0], [3, 1, 0]], float)


def colors(mesh: Mesh) -> list[object]:
    """Of each face."""
    return [mesh.materials[k].color if k >= 0 else None for k in mesh.material.tolist()]


HEADER = "ply\nformat ascii 1.0\nelement vertex 6\n" + "".join(
    f"property float {axis}\n" for axis in "xyz"
)


@pytest.mark.parametrize("kind", ["uchar", "float"])
def test_colours_of_ply_vertices(tmp_path: Path, kind: str) -> None:
    most = 255 if kind == "uchar" else 1
    channels = "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue"))
    rows = [f"{x} {y} {z} {r} 0 {b}" for (x, y, z), r, b in zip(
        POINTS, [most] * 3 + [0] * 3, [0] * 3 + [most] * 3, strict=True)]  # fmt: skip
    faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    text = HEADER + channels + faces + "\n".join([*rows, "3 0 1 2", "3 3 4 5", ""])
    path = tmp_path / "x.ply"
    path.write_text(text)
    assert colors(read_mesh(path)) == [RED, BLUE]


def test_colours_of_ply_faces(tmp_path: Path) -> None:
    faces = "element face 2\nproperty list uchar int vertex_indices\n" + "".join(
        f"property uchar {name}\n" for name in ("red", "green", "blue")
    )
    rows = [f"{x} {y} {z}" for x, y, z in POINTS]
    text = HEADER + faces + "end_header\n"
    path = tmp_path / "x.ply"
    path.write_text(text + "\n".join([*rows, "3 0 1 2 255 0 0", "3 3 4 5 0 0 255", ""]))
    assert colors(read_mesh(path)) == [RED, BLUE]


@pytest.mark.parametrize("most", ["1.0", "255"])
def test_colours_behind_the_points_of_an_obj(tmp_path: Path, most: str) -> None:
    rows = [f"v {x} {y} {z} {most if k < 3 else 0} 0 {0 if k < 3 else most}"
            for k, (x, y, z) in enumerate(POINTS)]  # fmt: skip
    path = tmp_path / "x.obj"
    path.write_text("\n".join([*rows, "f 1 2 3", "usemtl brick", "f 4 5 6", ""]))
    mesh = read_mesh(path)
    assert colors(mesh)[0] == RED
    assert mesh.materials[mesh.material[1]].name == "brick", "a material is more than a colour"


def test_colours_of_a_glb_are_linear_light(tmp_path: Path) -> None:
    light = np.array([[0.5, 0, 0, 1]] * 3, np.float32)
    binary = POINTS[:3].astype(np.float32).tobytes() + light.tobytes()
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": 36},
                        {"buffer": 0, "byteOffset": 36, "byteLength": 48}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC4"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]}],
    }  # fmt: skip
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path = tmp_path / "x.glb"
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
    (color,) = colors(read_mesh(path))
    assert color == pytest.approx((188 / 255, 0, 0, 1), abs=1e-6)


def test_shaded_vertices_are_no_paint() -> None:
    count = MOST + 1
    points = np.tile(POINTS[:3], (count, 1))
    mesh = triangle_mesh(points, np.arange(3 * count).reshape(-1, 3))
    shades = np.stack([np.arange(count) % 256, np.arange(count) // 256, np.zeros(count)], axis=1)
    made, notes = with_face_colors(mesh, shades / 255)
    assert made is mesh
    assert [note.code for note in notes] == ["colors-left-out"]


def test_faces_with_a_material_keep_it() -> None:
    mesh = triangle_mesh(POINTS, np.array([[0, 1, 2], [3, 4, 5]]))
    mesh = Mesh(mesh.vertices, mesh.corners, mesh.offsets, np.array([0, -1]), mesh.group,
                (Material("brick"),), mesh.groups)  # fmt: skip
    made, _ = with_face_colors(mesh, np.array([RED, BLUE]))
    assert [made.materials[k].name for k in made.material.tolist()] == ["brick", "color_0000ff"]
