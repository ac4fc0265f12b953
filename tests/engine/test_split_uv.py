"""Splits along texture coordinates, against the coordinates that models are written with.

The oracle is the writer of models: it lays images on what was drawn, and knows nothing of splits.
Where a piece ends, the coordinate there is what the split was told.
"""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.verify import verify
from ipmlang.formats.mesh_types import MeshScene
from ipmlang.runtime import pending
from ipmlang.runtime.export.models import mesh_scene_of
from ipmlang.runtime.scene import Scene
from tests.engine.test_split import closed_volume, labelled
from tests.formats.built import png

BOX = "start Lot on box(12, 8, 9)\n"
ANGLE = "start Lot on polygon [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]\n"


def run(text: str, folder: Path | None = None) -> Scene:
    grammar = ipmlang.parse("ipm 1\n" + text, folder=folder or Path.cwd())
    assert verify(grammar.program) == []
    return grammar.run()


def model(folder: Path, text: str) -> MeshScene:
    """The model of a grammar that may lay an image."""
    (folder / "brick.png").write_bytes(png(0, 255))
    return mesh_scene_of(run(text, folder))


def spans(made: MeshScene, which: int) -> dict[str, tuple[float, float]]:
    """From where to where u or v goes on each name, as far as it counts: lengths."""
    found: dict[str, tuple[float, float]] = {}
    for name, number in zip(made.name.tolist(), made.mesh.tolist(), strict=True):
        uv = made.meshes[number].uv
        assert uv is not None
        found[made.names[name]] = (float(uv[:, which].min()), float(uv[:, which].max()))
    return found


# ------------------------------------------------------------------------------ what is written


def test_sizes_are_in_images() -> None:
    scene = run(
        "Lot --> comp { front: Face | top: Top }\n"
        "Face --> setupProjection(xy, 2, 1.5) projectUV\n"
        "  split u { 1.5: A | { ~1: B }* | '0.25: C }\n"
        "Top --> tileUV(3, 4) split v { 0.5: D | ~1: E }\n" + BOX
    )
    assert labelled(scene) == [
        ("A", (0, 0, 0), (3, 9, 0)),
        ("B", (3, 0, 0), (2, 9, 0)),
        ("B", (5, 0, 0), (2, 9, 0)),
        ("B", (7, 0, 0), (2, 9, 0)),
        ("C", (9, 0, 0), (3, 9, 0)),
        ("D", (0, 0, 9), (12, 2, 0)),
        ("E", (0, 2, 9), (12, 6, 0)),
    ]


def test_without_a_projection_a_side_is_one_image() -> None:
    scene = run("Lot --> comp { front: split u { 0.25: A | ~1: B } }\n" + BOX)
    assert [(name, size[0]) for name, _, size in labelled(scene)] == [("A", 3), ("B", 9)]


def test_a_coordinate_that_runs_back_is_cut_from_its_own_end() -> None:
    scene = run(
        "Lot --> comp { front: setupProjection(xy, 2, 3) projectUV scaleUV(-1, 1) split u {"
        " 1: A | ~1: B | 2: C } }\n" + BOX
    )
    places = {name: place[0] for name, place, _ in labelled(scene)}
    assert places == {"A": 10, "B": 4, "C": 0}


def test_pieces_know_their_numbers_along_the_texture() -> None:
    scene = run(
        "Lot --> comp { front: tileUV(2, 3) split u { { ~1: P }* } }\n"
        "P : split.index < split.count - 1 --> Q\nP : else --> Last\n" + BOX
    )
    names = [name for name, _, _ in labelled(scene)]
    assert names == ["Q"] * 5 + ["Last"]


# ------------------------------------------------------------------------ against what is written


@pytest.mark.parametrize("seed", range(40))
def test_cuts_are_where_the_model_has_the_coordinate(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    which = draw.choice("uv")
    plane = draw.choice(("xy", "xy", "xz", "yz"))
    turn = f"rotate({draw.randint(0, 90)}, {draw.randint(0, 90)}, {draw.randint(0, 350)})"
    more = " ".join(
        draw.choice(("rotateUV(90)", "rotateUV(37)", "scaleUV(0.5, -2)", "translateUV(0.3, 4)"))
        for _ in range(draw.randint(0, 3))
    )
    mirror = draw.choice(("", "mirrorScope(x)", "mirrorScope(y)"))
    scale = draw.choice(("", "*(2.5)"))
    before, after = (mirror, scale) if draw.random() < 0.5 else (scale, mirror)
    after += draw.choice(("", "", " rotate(0, 0, 25)", " rotate(10, 50, 0)"))
    ground = draw.choice((BOX, ANGLE))
    solid = "" if ground == BOX else "extrude(9)"
    made = model(
        tmp_path,
        f'Lot --> texture("brick.png") {solid} {turn} [{before} setupProjection({plane}, 2.5, 3.5) '
        f"projectUV {more} {after} split {which} {{ 0.3: A | '0.2: B | ~1: C | ~3: D }}]\n{ground}",
    )
    found = spans(made, "uv".index(which))
    sizes = {name: high - low for name, (low, high) in found.items()}
    whole = sum(sizes.values())
    assert sizes["A"] == pytest.approx(0.3, abs=1e-6)
    assert sizes["B"] == pytest.approx(0.2 * whole, abs=1e-6)
    assert sizes["D"] == pytest.approx(3 * sizes["C"], abs=1e-6)
    tops = [found[name][1] % 1.0 for name in "ABC"]
    begins = [found[name][0] % 1.0 for name in "BCD"]
    off = np.array(tops) - begins
    assert np.abs(off - np.rint(off)).max() < 1e-6  # each begins where the one before it ends


@pytest.mark.parametrize("turn", ["", "rotateUV(33)"])
def test_a_polygon_with_a_hole_keeps_its_area(turn: str) -> None:
    ring = "shapeO(2, 3, 2.5, 1) {{ shape: {} }}\nstart Lot on box(12, 9, 0)\n"
    whole = closed_volume(run("Lot --> " + ring.format("extrude(1) A")))
    split = "split v { 0.5: extrude(1) A | { ~0.8: extrude(1) B }* }"
    laid = "Lot --> setupProjection(xy, 2, 2) projectUV "
    parts = run(f"{laid}{turn} " + ring.format(split))
    assert whole == pytest.approx(12 * 9 - 6.5 * 6)
    assert closed_volume(parts) == pytest.approx(whole)
    assert turn or len(parts.instances) == 6


def test_tiles_that_lie_aslant_are_cut_from_each_other() -> None:
    """Paving in lozenges: pieces have the boxes of what they are, and their areas add up."""
    scene = run(
        "Lot --> setupProjection(xy, 1, 1) projectUV rotateUV(45) split u { { ~1: Row }* }\n"
        "Row --> split v { { ~1: extrude(1) Slab }* }\nstart Lot on box(7, 5, 0)\n"
    )
    assert closed_volume(scene) == pytest.approx(35)
    assert len(scene.instances) > 30
    assert (scene.instances.size[:, :2] <= 2).all()


@pytest.mark.parametrize("chunk", [1, 3])
def test_results_do_not_depend_on_batches(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (
        "Lot --> split x { { ~2: extrude(2) Part(split.index) }* }\n"
        "Part(n) --> setupProjection(xy, 0.7, 0.9) projectUV rotateUV(15 * n)\n"
        "  split u { { ~1: P }* }\n"
        "start Lot on polygon [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]\n"
    )
    whole = labelled(run(text))
    monkeypatch.setattr(pending, "CHUNK", chunk)
    assert labelled(run(text)) == whole
    assert len(whole) > 20


def mesh(folder: Path, bend: float) -> str:
    """A ramp in a file with coordinates of its own; with a bend they do not run evenly."""
    (folder / "ramp.obj").write_text(
        "v 0 0 0\nv 4 0 0\nv 8 0 0\nv 0 6 2\nv 4 6 2\nv 8 6 2\n"
        f"vt 0 0\nvt {2 + bend} 0\nvt 4 0\nvt 0 3\nvt {2 + bend} 3\nvt 4 3\n"
        "f 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n"
    )
    return 'asset ramp = "ramp.obj"\nLot --> insert(ramp) '


def test_a_mesh_is_cut_by_its_own_coordinates(tmp_path: Path) -> None:
    rule = mesh(tmp_path, 0.0)
    scene = run(f"{rule} split u {{ 0.5: A | ~1: B }}\nstart Lot on box(8, 6, 2)\n", tmp_path)
    assert [(name, place[0], size[0]) for name, place, size in labelled(scene)] == [
        ("A", 0, 1), ("B", 1, 7),
    ]  # fmt: skip


# ------------------------------------------------------------------------------- what is refused


def told(text: str, folder: Path | None = None) -> str:
    with pytest.raises(IpmError) as caught:
        run(text, folder)
    (found,) = caught.value.diagnostics
    assert found.code == "no-texture-axis"
    return found.message


def test_what_does_not_run_evenly_is_told(tmp_path: Path) -> None:
    split = "split u { 1: A | ~1: B }"
    assert "more than one side" in told(f"Lot --> {split}\n{BOX}")
    laid = "setupProjection(xy, 2, 1) projectUV"
    assert "the same all over" in told(f"Lot --> {laid} comp {{ left: {split} }}\n{BOX}")
    assert "run evenly" in told(f"{mesh(tmp_path, 0.5)} {split}\n{BOX}", tmp_path)
