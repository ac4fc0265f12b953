"""Images on surfaces, through every format that keeps them, and what is wrong with some."""

from __future__ import annotations

import base64
import json
import os
import struct
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import write_files
from ipmlang.formats.mesh import mesh_contents, read_mesh, read_meshes
from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, single
from ipmlang.formats.textures import Texture, has_alpha, texture_at, texture_beside, texture_of
from tests.formats.built import png

QUAD = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"


def jpeg() -> bytes:
    """An image of one pixel, made by another program."""
    from PIL import Image

    found = BytesIO()
    Image.new("RGB", (1, 1), "red").save(found, "JPEG")
    return found.getvalue()


def quad(texture: Texture, name: str = "wall") -> Mesh:
    """A rectangle whose image fills it once, with v up."""
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    uv = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    zero = np.zeros(1, np.int64)
    materials = (Material(name, None, texture),)
    offsets = np.array([0, 4])
    return Mesh(vertices, np.arange(4), offsets, zero, zero, materials, ((),), uv)


def saved(scene: MeshScene, path: Path) -> Path:
    """The scene as a file."""
    write_files(mesh_contents(scene, path))
    return path


def corner_uv(mesh: Mesh) -> dict[tuple[float, ...], tuple[float, ...]]:
    """The texture point of each place."""
    assert mesh.uv is not None
    places = mesh.vertices[mesh.corners].round(6).tolist()
    return {tuple(p): tuple(q) for p, q in zip(places, mesh.uv.round(6).tolist(), strict=True)}


def content_of(texture: Texture | None) -> bytes:
    """What a texture holds."""
    assert texture is not None
    return texture.source if isinstance(texture.source, bytes) else texture.source.read_bytes()


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_images_and_their_places_survive_a_round(suffix: str, tmp_path: Path) -> None:
    """The same bytes, and each corner where it was."""
    scene = single(quad(texture_of("brick wall", png(0, 255))), "wall")
    mesh = read_mesh(saved(scene, tmp_path / f"house{suffix}"))
    material = mesh.materials[mesh.material[0]]
    assert content_of(material.texture) == png(0, 255)
    assert material.name == "wall"
    assert corner_uv(mesh) == {(0, 0, 0): (0, 0), (2, 0, 0): (1, 0), (2, 1, 0): (1, 1),
                               (0, 1, 0): (0, 1)}  # fmt: skip


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_another_program_sees_the_image_upright(suffix: str, tmp_path: Path) -> None:
    """The lower left corner of the wall shows the lower left of the image."""
    import trimesh

    scene = single(quad(texture_of("brick", png(0, 255))), "wall")
    found = trimesh.load(saved(scene, tmp_path / f"a{suffix}"), force="mesh", process=False)
    # In space of the file: GLB stands y-up, its (x, y, z) was (x, -z, y).
    upward = found.vertices[:, 1] if suffix == ".obj" else -found.vertices[:, 2]
    assert found.visual.uv[:, 1] == pytest.approx(upward)
    assert found.visual.uv[:, 0] == pytest.approx(found.vertices[:, 0] / 2)
    material = found.visual.material
    image = material.image if suffix == ".obj" else material.baseColorTexture
    assert np.asarray(image.convert("L")).tolist() == [[0, 255]]


def test_equal_images_are_written_once(tmp_path: Path) -> None:
    """By content, whatever they are called; in a file of copies, too."""
    (tmp_path / "a.png").write_bytes(png(7))
    one, two = texture_of("one", png(7)), texture_at(tmp_path / "a.png")
    scene = replace(
        single(quad(one), "wall"),
        meshes=(quad(one), quad(two, "roof")),
        mesh=np.array([0, 1, 1]),
        matrix=np.tile(np.eye(3, 4), (3, 1, 1)),
        name=np.zeros(3, np.int64),
        material=np.full(3, -1),
    )
    tree = json_of(saved(scene, tmp_path / "a.glb"))
    assert [image["mimeType"] for image in tree["images"]] == ["image/png"]
    assert len(tree["textures"]) == len(tree["samplers"]) == 1
    assert tree["samplers"][0]["wrapS"] == tree["samplers"][0]["wrapT"] == 10497
    assert len(tree["materials"]) == 2


def json_of(path: Path) -> dict:  # type: ignore[type-arg]
    """The JSON of a GLB file."""
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])


def test_an_obj_has_its_images_beside_it(tmp_path: Path) -> None:
    """Named by content: written again they are the same files, and nobody's file is lost."""
    scene = single(quad(texture_of("../brick wall", png(1, 2))), "wall")
    path = saved(scene, tmp_path / "house.obj")
    (image,) = (tmp_path / "house.textures").iterdir()
    assert image.read_bytes() == png(1, 2)
    assert f"map_Kd house.textures/{image.name}\n" in (tmp_path / "house.mtl").read_text()
    again = saved(read_meshes(path), path)
    assert [each.name for each in (tmp_path / "house.textures").iterdir()] == [image.name]
    assert content_of(read_mesh(again).materials[0].texture) == png(1, 2)
    image.write_bytes(b"something else")
    with pytest.raises(FormatError, match="another file stands there"):
        saved(scene, path)
    assert image.read_bytes() == b"something else"


def test_what_fails_leaves_no_folder(tmp_path: Path) -> None:
    """The folder of images goes with the rest of the result."""
    texture = texture_of("brick", png(1))
    scene = single(quad(texture), "wall")
    contents = dict(mesh_contents(scene, tmp_path / "house.obj"))
    (tmp_path / "house.mtl").mkdir()
    with pytest.raises(FormatError, match="it is a folder"):
        write_files(contents)
    assert [each.name for each in tmp_path.iterdir()] == ["house.mtl"]


def test_libraries_say_colour_opacity_and_image(tmp_path: Path) -> None:
    """In any order; options of an image come before its name, which may hold blanks."""
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "old brick.png").write_bytes(png(3))
    (tmp_path / "m.mtl").write_text(
        "newmtl a\nd 0.5\nKd 0.1 0.2 0.3\n"
        "newmtl b\nmap_Kd -clamp on -s 2 4 1 -o 0.5 maps\\old brick.png\nTr 0.25\n"
        "newmtl c\nKd 2\nmap_d maps/none.png\n"
    )
    faces = "usemtl a\nf 1 2 3\nusemtl b\nf 1/1 2/2 3/3\nusemtl c\nf 1 2 3\n"
    (tmp_path / "a.obj").write_text(f"mtllib m.mtl\n{QUAD}{faces}")
    mesh = read_mesh(tmp_path / "a.obj")
    a, b, c = mesh.materials
    assert (a.color, b.color, c.color) == ((0.1, 0.2, 0.3, 0.5), (1, 1, 1, 0.75), (1, 1, 1, 1))
    assert (a.texture, c.texture, c.alpha) == (None, None, "")
    assert content_of(b.texture) == png(3)
    assert mesh.uv is not None
    assert mesh.uv[mesh.offsets[2] : mesh.offsets[3]].tolist() == [[0.5, 0], [4.5, 0], [4.5, 4]]
    assert not mesh.uv[: 4 + 3][4:].any()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("none.png", "no such file"),
        ("../secret.png", "outside the model's folder"),
        ("sub/../../secret.png", "outside the model's folder"),
        ("link.png", "outside the model's folder"),
        ("C:\\maps\\secret.png", "outside the model's folder"),
        ("/etc/hostname", "outside the model's folder"),
        ("text.png", "neither a PNG nor a JPEG"),
        ("empty.png", "is empty"),
        ("void.png", "has no pixels"),
        ("sub", "is a directory"),
        ("pipe.png", "is no file"),
    ],
)
def test_images_that_cannot_be_used_are_noted(name: str, said: str, tmp_path: Path) -> None:
    """The model is read without them, and nothing outside its folder is touched."""
    folder = tmp_path / "model"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "secret.png").write_bytes(png(9))
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    (folder / "text.png").write_text("no image at all, though its name says so")
    (folder / "empty.png").write_bytes(b"")
    os.mkfifo(folder / "pipe.png")
    (folder / "void.png").write_bytes(png(1)[:16] + bytes(8) + png(1)[24:])
    (folder / "m.mtl").write_text(f"newmtl a\nmap_Kd {name}\n")
    (folder / "a.obj").write_text(f"mtllib m.mtl\nusemtl a\n{QUAD}")
    scene = read_meshes(folder / "a.obj")
    assert [note.code for note in scene.notes] == ["texture"]
    assert said in scene.notes[0].message
    assert scene.meshes[0].materials[0].texture is None


def test_kinds_of_images_are_told_by_their_content(tmp_path: Path) -> None:
    """A JPEG that is called PNG is a JPEG; opacity is told without decoding."""
    (tmp_path / "a.png").write_bytes(jpeg())
    found = texture_beside(tmp_path, "a.png")
    assert (found.name, found.suffix) == ("a", ".jpg")
    clear = texture_of("x", png(1, 2, 3, 0, kind=6))
    assert [has_alpha(each) for each in (found, clear, texture_of("y", png(1)))] == [
        False, True, False]  # fmt: skip
    assert texture_of("x", png(1)) == texture_of("x", png(1))
    assert len({texture_of("x", png(1)), texture_of("x", png(2))}) == 2
    path = saved(single(quad(found), "wall"), tmp_path / "b.glb")
    assert json_of(path)["images"][0]["mimeType"] == "image/jpeg"


def glb_quad(tmp_path: Path, image: dict[str, object], info: dict[str, object], **more: object
             ) -> Path:  # fmt: skip
    """A triangle with two sets of texture points, (0, 0) (1, 0) (0, 1) and twice these."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    uv = np.array([[0, 0], [1, 0], [0, 1]], "<f4")
    data = points.tobytes() + uv.tobytes() + (2 * uv).tobytes() + png(5)
    spans = [(0, 36), (36, 24), (60, 24), (84, len(png(5)))]
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"material": 0, "attributes": {
            "POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2}}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": info}, **more}],
        "textures": [{"source": 0}],
        "images": [image],
        "accessors": [
            {"bufferView": k, "componentType": 5126, "count": 3, "type": "VEC2" if k else "VEC3"}
            for k in range(3)
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": b} for a, b in spans],
        "buffers": [{"byteLength": len(data)}],
    }  # fmt: skip
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    body += struct.pack("<I4s", len(data), b"BIN\0") + data
    path = tmp_path / "a.glb"
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return path


def test_glb_images_from_all_three_places(tmp_path: Path) -> None:
    """In the file, in its JSON, beside it."""
    (tmp_path / "my map.png").write_bytes(png(5))
    address = "data:image/png;base64," + base64.b64encode(png(5)).decode()
    for image in ({"bufferView": 3}, {"uri": address}, {"uri": "my%20map.png"}):
        material = read_mesh(glb_quad(tmp_path, dict(image), {"index": 0})).materials[0]
        assert content_of(material.texture) == png(5)


def test_glb_texture_points_pass_through_their_map(tmp_path: Path) -> None:
    """Scaled, turned counter-clockwise, moved: with v down; and the set that the map names."""
    change = {"scale": [2, 1], "rotation": np.pi / 2, "offset": [0, 0.25], "texCoord": 1}
    info = {"index": 0, "extensions": {"KHR_texture_transform": change}}
    mesh = read_mesh(glb_quad(tmp_path, {"bufferView": 3}, info, alphaMode="MASK"))
    # (1, 0) of the second set is (2, 0): scaled (4, 0), turned (0, -4), moved (0, -3.75), v up.
    assert mesh.uv is not None
    assert mesh.uv.round(5).tolist() == [[0, 0.75], [0, 4.75], [2, 0.75]]
    assert mesh.materials[0].alpha == "MASK"
    plain = read_mesh(glb_quad(tmp_path, {"bufferView": 3}, {"index": 0, "texCoord": 1}))
    assert plain.uv is not None
    assert plain.uv.tolist() == [[0, 1], [2, 1], [0, -1]]


@pytest.mark.parametrize(
    ("image", "said"),
    [
        ({"uri": "../x.png"}, "outside"),
        ({"uri": "none.png"}, "no such file"),
        ({"uri": "data:image/png;base64,????"}, "cannot be read"),
        ({"uri": "data:image/png"}, "no content"),
        ({"bufferView": 0}, "neither"),
        ({"bufferView": 77}, "bufferViews"),
        ({}, "bufferViews"),
    ],
)
def test_glb_images_that_cannot_be_used(
    image: dict[str, object], said: str, tmp_path: Path
) -> None:
    """They are left out with a note, and the model is read."""
    scene = read_meshes(glb_quad(tmp_path, image, {"index": 0}))
    assert [note.code for note in scene.notes] == ["texture"]
    assert said in scene.notes[0].message
    assert scene.meshes[0].materials[0].texture is None


def test_an_image_that_goes_away_is_an_error(tmp_path: Path) -> None:
    """Images are read when they are written: what changed meanwhile is said."""
    (tmp_path / "a.png").write_bytes(png(1))
    scene = single(quad(texture_at(tmp_path / "a.png")), "wall")
    (tmp_path / "a.png").unlink()
    for suffix in (".obj", ".glb"):
        with pytest.raises(FormatError, match=r"cannot read the image a\.png"):
            mesh_contents(scene, tmp_path / f"b{suffix}")


@pytest.mark.parametrize(
    "name",
    ["chess_board.glb", "house_scene.glb", "warehouse_boxes.glb", "warehouse_roof.glb",
     "warehouse_shelf.glb"],
)  # fmt: skip
def test_real_models_keep_their_images(name: str, data: Path, tmp_path: Path) -> None:
    """Read, written as OBJ, read again: the same images on as many faces."""
    if name == "chess_board.glb":
        pytest.importorskip("DracoPy", reason="this model is packed by Draco")
    scene = read_meshes(data / "mesh" / name)
    images = [m.texture for mesh in scene.meshes for m in mesh.materials if m.texture]
    assert images
    assert not [note for note in scene.notes if note.code == "texture"]
    again = read_mesh(saved(scene, tmp_path / "a.obj"))
    found = [m.texture for m in again.materials if m.texture]
    assert {content_of(each) for each in found} == {content_of(each) for each in images}
    assert all(mesh.uv is not None and np.isfinite(mesh.uv).all() for mesh in scene.meshes)
