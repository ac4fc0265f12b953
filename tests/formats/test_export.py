"""Scenes made by hand to files, and what the files show."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.drawing import DrawnElement, PaintServer
from ipmlang.formats.mesh import read_mesh, read_meshes
from ipmlang.formats.svg import read_svg
from ipmlang.runtime.export import check_output, save
from ipmlang.runtime.export.models import mesh_scene_of, unit_cube, unit_cylinder
from ipmlang.runtime.export.sheet import drawing_of
from ipmlang.runtime.scene import (
    OUTLINE,
    SCOPE,
    SEGMENT,
    AssetRef,
    Groups,
    Instances,
    Origin,
    PenStyle,
    Scene,
)
from tests.formats.outlines import points
from tests.formats.test_meshes import volume

PARTS = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">
<defs><linearGradient id="g"><stop stop-color="red"/><stop offset="1" stop-color="blue"/>
</linearGradient><clipPath id="k"><rect width="5" height="5"/></clipPath></defs>
<g id="flag"><path d="M0 0L2 0L2 1Z" fill="#00ff00"/>
<path d="M0 0L0 3" fill="none" stroke="#0000ff" stroke-width="0.5"/></g>
<path id="shade" d="M0 0L4 0L4 4Z" fill="url(#g)"/>
<text id="word" font-size="2">Hi</text>
<g id="clip" clip-path="url(#c)"><defs><clipPath id="c"><rect width="5" height="5"/></clipPath>
</defs></g></svg>"""


def instances(count: int, asset: int) -> Instances:
    """Rows at the origin that do nothing special."""
    rotation = np.zeros((count, 4))
    rotation[:, 0] = 1
    whole = np.zeros(count, np.int32)
    return Instances(
        np.zeros((count, 3)),
        rotation,
        np.ones(count),
        np.zeros((count, 3)),
        np.full(count, asset, np.int32),
        np.full(count, -1, np.int32),
        whole.copy(),
        np.full(count, np.nan, np.float32),
        np.zeros(count, np.uint32),
        np.zeros(count),
        whole.copy(),
        whole.copy(),
        np.arange(count, dtype=np.uint64),
    )


def scene(table: Instances, *assets: AssetRef, **more: object) -> Scene:
    """A flat scene of one label and one rule."""
    rest: dict[str, object] = {"styles": (PenStyle(),), "flat": True, **more}
    return Scene(table, assets, labels=("leaf",), rules=(Origin("a.ipm", "A", 1),), **rest)  # type: ignore[arg-type]


def turn(table: Instances, row: int, degrees: float) -> None:
    """Turn a row to the left."""
    half = np.radians(degrees) / 2
    table.rotation[row] = [np.cos(half), 0, 0, np.sin(half)]


def ends(element: DrawnElement) -> list[list[float]]:
    """Where the segments of an element begin, and where the last one ends."""
    assert element.outline is not None
    found = points(element.outline, 2)
    return np.round([*found[0], found[1, -1]], 9).tolist()


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    """A parts file with two assets, a gradient, a text and an effect."""
    path = tmp_path / "a.parts.svg"
    path.write_text(PARTS)
    return path


def test_segments_go_along_the_heading_and_y_is_flipped_about_the_canvas() -> None:
    """A left turn goes up in the model and up on the screen."""
    table = instances(2, SEGMENT)
    table.size[:, 0] = 3
    table.scale[1] = -2
    table.position[1] = [1, 1, 0]
    turn(table, 0, 90)
    made = drawing_of(scene(table, canvas=(0, 10, 20, 30)))
    assert ends(made.elements[0]) == [[0, 50], [0, 47]]
    assert ends(made.elements[1]) == [[1, 49], [-5, 49]]
    style = made.elements[0].style
    assert (style.fill, style.stroke, style.stroke_width) == ("none", "#000000", 1.0)
    assert made.box == (0, 10, 20, 30)
    free = drawing_of(scene(table))
    assert ends(free.elements[0]) == [[0, 0], [0, -3]]
    assert free.elements[0].style.stroke_width == pytest.approx(np.hypot(6, 3) / 500, rel=0.01)


def test_pens_set_colour_width_and_declarations() -> None:
    """A pen's declarations come last."""
    table = instances(2, SEGMENT)
    table.size[:, 0] = 1
    table.color[:] = 0xFF8000FF
    table.color[1] = 0xFF800080
    table.width[:] = 2.5
    table.style[1] = 1
    css = PenStyle(css="stroke-dasharray:2 1;stroke-linecap:round;stroke:#00f")
    first, second = drawing_of(scene(table, styles=(PenStyle(), css))).elements
    assert (first.style.stroke, first.style.stroke_width) == ("#ff8000", 2.5)
    assert (second.style.stroke, second.style.dashes) == ("#0000ff", (2.0, 1.0))
    assert dict(second.style.more) == {"stroke-linecap": "round", "stroke-opacity": "0.502"}
    assert first.source == ("leaf",)


def test_layers_order_and_ties_keep_the_order_of_rows(parts: Path) -> None:
    """Assets with several elements stay together."""
    table = instances(3, 0)
    table.asset[1] = SEGMENT
    table.size[1, 0] = 1
    table.layer[:] = [1, 0, 1]
    table.position[:, 0] = [10, 20, 30]
    made = drawing_of(scene(table, AssetRef("flag", parts, "flag")))
    assert [ends(each)[0][0] for each in made.elements] == [20, 10, 10, 30, 30]


def test_assets_keep_their_style_where_the_pen_sets_none(parts: Path) -> None:
    """Placed, turned and mirrored; a colour takes the place of what is painted."""
    table = instances(3, 0)
    table.position[:, 0] = 10
    turn(table, 0, 90)
    table.scale[1] = -2
    table.color[2] = 0xFF0000FF
    made = drawing_of(scene(table, AssetRef("flag", parts, "flag"), canvas=(0, 0, 50, 50)))
    assert ends(made.elements[0]) == [[10, 50], [10, 48], [11, 48], [10, 50]]
    assert ends(made.elements[2]) == [[10, 50], [6, 50], [6, 52], [10, 50]]
    assert made.elements[2].style.fill == "#00ff00"
    assert made.elements[3].style.stroke_width == 0.5
    assert (made.elements[4].style.fill, made.elements[4].style.stroke) == ("#ff0000", "none")
    assert (made.elements[5].style.fill, made.elements[5].style.stroke) == ("none", "#ff0000")


def test_gradients_and_texts_go_along(parts: Path) -> None:
    """Their own spaces are moved with each copy."""
    for node in ("shade", "word"):
        table = instances(2, 0)
        table.position[1, :2] = [3, 4]
        made = drawing_of(scene(table, AssetRef("x", parts, node), canvas=(0, 0, 9, 9)))
        moved = []
        for each in made.elements:
            carrier = each.fragment if node == "word" else each.style.fill
            assert carrier is not None
            assert not isinstance(carrier, str)
            moved.append(np.array(carrier.matrix))
        assert (moved[1] - moved[0]).tolist() == pytest.approx([0, 0, 0, 0, 3, -4])
        assert moved[0][3] > 0  # the y axis points down as in the file: text is not mirrored


def test_an_effect_wraps_its_run(parts: Path, tmp_path: Path) -> None:
    """Rows with one effect are in one group, which comes back from the file."""
    table = instances(3, SEGMENT)
    table.size[:, 0] = 7
    frame = np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.ones(1)
    one = np.zeros(1, np.int32)
    effect = AssetRef("clip", parts, "clip")
    of = np.array([-1, 0, 0], np.int32)
    groups = Groups(of, one - 1, one, (effect,), *frame, np.zeros(1))
    made = scene(table, groups=groups, canvas=(0, 0, 9, 9))
    save(made, tmp_path / "o.svg")
    found = read_svg(tmp_path / "o.svg")
    assert [len(each.style.effects) for each in found.elements] == [0, 1, 1]
    assert found.effects[found.elements[1].style.effects[0]].matrix[5] == 9
    assert (tmp_path / "o.svg").read_text().count("clip-path=") == 1


def test_polygons_and_scopes() -> None:
    """Polygons are filled, scopes are rectangles, a scope without extent is nothing."""
    table = instances(3, SCOPE)
    table.size[1, :2] = [3, 2]
    table.asset[2], table.shape[2] = OUTLINE, 0
    corners = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    box, polygon = drawing_of(scene(table, polygons=(corners,))).elements
    assert ends(box) == [[0, 0], [3, 0], [3, -2], [0, -2], [0, 0]]
    assert ends(polygon) == [[0, 0], [2, 0], [0, -2], [0, 0]]
    assert polygon.style.fill == "#808080"


def test_files_are_the_same_every_time(parts: Path, tmp_path: Path) -> None:
    """Byte for byte, in svg and in glb."""
    table = instances(4, SCOPE)
    table.size[:] = [3, 2, 1]
    for name in ("a.svg", "a.glb", "a.obj"):
        save(scene(table), tmp_path / name)
        first = (tmp_path / name).read_bytes()
        save(scene(table), tmp_path / name)
        assert (tmp_path / name).read_bytes() == first


def test_primitives_enclose_what_they_should() -> None:
    """Faces of boxes and cylinders face outward."""
    assert volume(unit_cube()) == pytest.approx(1)
    assert volume(unit_cylinder(64)) == pytest.approx(np.pi / 4, rel=0.01)


@pytest.mark.parametrize("suffix", ["glb", "obj", "ply", "stl"])
def test_boxes_in_every_model_format(suffix: str, tmp_path: Path) -> None:
    """Mirrored, turned and scaled copies keep their volume and place."""
    table = instances(3, SCOPE)
    table.size[:] = [2, 1, 3]
    table.scale[:] = [1, -2, 1]
    table.position[2] = [10, 20, 30]
    turn(table, 2, 90)
    table.color[1] = 0x336699FF
    path = tmp_path / f"a.{suffix}"
    save(scene(table, flat=False), path)
    mesh = read_mesh(path)
    assert volume(mesh) == pytest.approx(6 + 48 + 6, rel=1e-6)
    assert mesh.vertices.max(axis=0).tolist() == pytest.approx([10, 22, 33], rel=1e-6)
    if suffix in ("glb", "obj"):
        colors = {material.name: material.color for material in mesh.materials}
        assert colors["#336699"] == pytest.approx((0.2, 0.4, 0.6, 1), abs=1e-5)
    save(scene(table, flat=False, up="y-up"), path)
    top = read_mesh(path).vertices.max(axis=0).tolist()
    turned = [10, 33, 0] if suffix != "glb" else [10, 22, 33]
    assert top == pytest.approx(turned, rel=1e-6)


def test_glb_keeps_copies_and_says_who_made_them(tmp_path: Path) -> None:
    """One mesh, a node a copy, names and keys; with the extension one node, which says so."""
    table = instances(5, SCOPE)
    table.size[:] = [2, 1, 3]
    table.position[:, 0] = np.arange(5)
    made = scene(table, flat=False, seed=7)
    path = tmp_path / "a.glb"
    save(made, path)
    found = read_meshes(path)
    assert (len(found.meshes), len(found.mesh), found.names) == (1, 5, ("leaf",))
    assert found.matrix == pytest.approx(mesh_scene_of(made).matrix, abs=1e-9)
    tree = json_of(path)
    extras = tree["scenes"][0]["extras"]
    assert (extras["seed"], extras["rules"], extras["labels"]) == (7, ["A"], ["leaf"])
    assert tree["accessors"][extras["key"]]["count"] == 5
    save(made, path, instancing=True)
    tree = json_of(path)
    assert len(tree["nodes"]) == 2
    assert tree["extensionsRequired"] == ["EXT_mesh_gpu_instancing"]
    assert read_meshes(path).matrix == pytest.approx(found.matrix, abs=1e-6)


def json_of(path: Path) -> dict:  # type: ignore[type-arg]
    """The JSON of a GLB."""
    data = path.read_bytes()
    return dict(json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]]))


def test_glb_is_read_alike_by_another_reader(tmp_path: Path) -> None:
    """trimesh finds the same volume and, y being up, the same bounds."""
    trimesh = pytest.importorskip("trimesh")
    table = instances(3, SEGMENT)
    table.size[:, 0] = [1, 2, 3]
    table.width[:] = 0.5
    table.asset[1] = SCOPE
    table.size[1] = [1, 2, 4]
    table.scale[2] = -1
    save(scene(table, flat=False), tmp_path / "a.glb")
    other = trimesh.load(tmp_path / "a.glb", force="mesh")
    mesh = read_mesh(tmp_path / "a.glb")
    assert other.volume == pytest.approx(volume(mesh), rel=1e-5)
    assert other.bounds[1][1] == pytest.approx(mesh.vertices[:, 2].max())


def test_model_assets_are_placed_with_their_materials(tmp_path: Path) -> None:
    """An OBJ part by its name; each copy is a node of the shared mesh."""
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no x\nf 1 2 3\no y\nf 1 2 4\n"
    )
    table = instances(3, 0)
    table.position[:, 2] = [0, 1, 2]
    save(scene(table, AssetRef("x", tmp_path / "a.obj", "x"), flat=False), tmp_path / "a.glb")
    found = read_meshes(tmp_path / "a.glb")
    assert (len(found.meshes), len(found.mesh)) == (1, 3)
    assert len(found.meshes[0].corners) == 3


@pytest.mark.parametrize(
    ("name", "code"),
    [("a.svgg", "unknown-format"), ("a", "unknown-format"), ("no/a.svg", "cannot-write")],
)
def test_outputs_that_cannot_be(name: str, code: str, tmp_path: Path) -> None:
    """Refused before any work, with what would do."""
    with pytest.raises(IpmError) as caught:
        check_output(tmp_path / name)
    assert caught.value.diagnostics[0].code == code
    assert caught.value.diagnostics[0].hint


def test_a_scene_in_space_has_no_drawing(tmp_path: Path, parts: Path) -> None:
    """And a model has no drawings in it; nothing is written in either case."""
    table = instances(1, SCOPE)
    table.size[:] = 1
    drawn = instances(1, 0)
    asset = AssetRef("flag", parts, "flag")
    missing = AssetRef("flag", parts, "flug")
    for made, name, code in (
        (scene(table, flat=False), "a.svg", "not-flat"),
        (scene(drawn, asset, flat=False), "a.glb", "not-a-model"),
        (scene(drawn, missing), "a.svg", "bad-asset"),
        (scene(instances(0, SCOPE)), "a.obj", "nothing-drawn"),
    ):
        with pytest.raises(IpmError) as caught:
            save(made, tmp_path / name)
        assert caught.value.diagnostics[0].code == code
        assert not (tmp_path / name).exists()


def test_gradient_type() -> None:
    """The fixture's gradient is read as a paint server, else the tests above show nothing."""
    found = read_svg(PARTS.encode()).elements[2].style.fill
    assert isinstance(found, PaintServer)
