"""Pictures of what lies on the card: the same as of the scene that numpy makes, and how much of it
is drawn from far away.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.mesh_types import Mesh
from ipmlang.runtime import derive_table
from ipmlang.runtime.export.models import mesh_scene_of
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.table import Table
from ipmlang.studio import Look, View, pictures_of
from ipmlang.studio.camera import fitted
from ipmlang.studio.context import gl_context
from ipmlang.studio.stage import Stage
from ipmlang.studio.table_model import model_of_table

WALL = """\
ipm 1
Wall --> split y { { ~3: Floor }* } translate(0, 0, 4) size(4, 3, 2) color("#c04020") Chimney
Floor --> split x { { ~2: Bay }* }
Bay : 60%  --> color("#808890") Pane
Bay : else --> translate(0, 0, -1) size(scope.sx, scope.sy, 1) color("#e0d8c0") Stone
start Wall on box(12, 9, 0)
"""
TWIGS = """\
ipm 1
Twig(n) : n > 0 --> !(0.1 * n) F(2) [&(30) Twig(n - 1)] /(120) [*(0.8) ^(40) Twig(n - 1)] F(1)
Twig(n) : else  --> F(1)
start Twig(4)
"""
ROOFS = """\
ipm 1
Lot --> split x { { ~4: House }* }
House --> extrude(3) comp { top: color("#a04030") roofHip(30) Tiles | side: Side }
Side --> split x { { ~1.3: Bay }* }
Bay : 60%  --> color("#506070") Pane
Bay : else --> color("#e0d8c0") Wall
start Lot on box(12, 5, 0)
"""
FITTED = """\
ipm 1
asset wedge = "wedge.obj"
Row --> split x { { ~2: Place }* }
Place : 50%  --> size(1.5, scope.sy, 3) wedge
Place : else --> translate(0, 4, 0) size(1.2, 1, 2) mirrorScope(x) color("#3060a0") wedge
start Row on box(9, 2, 0)
"""
WEDGE = "v 1 1 1\nv 4 1 1\nv 4 3 1\nv 1 3 1\nv 1 1 2\nv 1 3 2\n" + "".join(
    f"f {face}\n" for face in ("4 3 2 1", "1 2 5", "3 4 6", "2 3 6 5", "4 1 5 6")
)
BOX, CYLINDER = 0, 4  # kinds of copies
LOOK = Look(size=(240, 160), view=View(30.0, 25.0))


def table_of(text: str, folder: Path = Path()) -> Table:
    table = derive_table(ipmlang.parse(text, folder=folder).program, seed=4)
    assert table is not None
    return table


def pictured(seen: object, look: Look = LOOK) -> NDArray[np.float64]:
    (picture,) = pictures_of(seen, look)  # type: ignore[arg-type]
    return picture.astype(np.float64)


def assert_alike(text: str, folder: Path = Path(), look: Look = LOOK) -> None:
    """The pictures agree, square by square of ten pixels: edges may lie a little elsewhere, since a
    table is measured in another way.
    """
    ours = squares(pictured(table_of(text, folder), look))
    theirs = squares(pictured(ipmlang.parse(text, folder=folder).run(seed=4), look))
    assert np.abs(theirs - theirs[0, 0]).max() > 30  # something is seen
    differ = np.abs(ours - theirs).max(axis=2)
    assert differ.max() < 20
    assert differ.mean() < 2


def squares(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean colours of squares of ten pixels."""
    down, across = picture.shape[0] // 10, picture.shape[1] // 10
    means: NDArray[np.float64] = picture.reshape(down, 10, across, 10, 4).mean(axis=(1, 3))
    return means


def test_boxes_and_rectangles(card: Device) -> None:
    assert_alike(WALL)


def test_lines_are_drawn_on_them(card: Device) -> None:
    assert_alike(WALL, look=replace(LOOK, lines=True))


def test_what_the_cpu_draws_stands_among_it(card: Device) -> None:
    table = table_of(ROOFS)
    assert table.backend == "gpu+cpu"
    assert table.rest is not None
    assert len(table) > len(table.rest.instances) > 0
    assert_alike(ROOFS)


def test_what_lies_in_many_small_buffers(card: Device) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 17)
    text = WALL.replace("box(12, 9, 0)", "box(120, 90, 0)")
    assert len(table_of(text).parts) > 1
    assert_alike(text)


def test_segments_of_every_width(card: Device) -> None:
    assert_alike(TWIGS)
    assert_alike(TWIGS.replace("!(0.1 * n) ", ""))


@pytest.mark.parametrize("text", [WALL, TWIGS, TWIGS.replace("!(0.1 * n)", ""), FITTED])
def test_every_copy_stands_where_the_scene_has_it(card: Device, tmp_path: Path, text: str) -> None:
    (tmp_path / "wedge.obj").write_text(WEDGE, encoding="utf-8")
    found, middle, size = copies_of(table_of(text, tmp_path))
    scene = mesh_scene_of(ipmlang.parse(text, folder=tmp_path).run(seed=4))
    expected = np.concatenate([
        placed(scene.meshes[number], scene.matrix[scene.mesh == number], middle, size)
        for number in range(len(scene.meshes))
    ])  # fmt: skip
    assert len(found) == len(expected)
    # Those of a segment whose pen sets no width depend on how the table was measured.
    loose = 2e-3 if "!" not in text else 1e-6
    distance = np.abs(found[:, None] - expected[None]).max(axis=2)
    assert distance.min(axis=1).max() < loose
    assert distance.min(axis=0).max() < loose


def copies_of(table: Table) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """The matrices (n, 12) of all copies for a camera that is near, and the world's place."""
    with gl_context() as context:
        model, copies = model_of_table(table, lines=False)
        stage = Stage(context, model, LOOK, copies)
        copies.see(fitted(model.outline, LOOK.view, (9000, 9000)), 9000)
        rows = [
            each.copies.array(np.float32).reshape(-1, 13) for each in copies._parts if each.copies
        ]
        assert stage.copies is copies
    return np.concatenate(rows)[:, :12].astype(np.float64), copies.middle, copies.size


def placed(
    mesh: Mesh, matrix: NDArray[np.float64], middle: NDArray[np.float64], size: float
) -> NDArray[np.float64]:
    """What a stage is given of copies: meshes about their own middles, in a world of size one."""
    points = mesh.vertices[mesh.corners]
    low, high = points.min(axis=0), points.max(axis=0)
    place = matrix[:, :, :3] @ ((low + high) / 2) + matrix[:, :, 3] - middle
    rows = np.concatenate([matrix[:, :, :3] * (high - low).max(), place[:, :, None]], axis=2) / size
    return rows.reshape(-1, 12)


def test_what_is_far_from_the_origin(card: Device) -> None:
    far = WALL.replace("Wall -->", "Wall --> translate(4000000, -7000000, 90000)")
    assert_alike(far)


def test_a_turn_is_made_of_one_table(card: Device) -> None:
    table = table_of(WALL)
    pictures = list(pictures_of(table, LOOK, 3))
    assert len({each.tobytes() for each in pictures}) == 3


@pytest.mark.parametrize(
    "text",
    [
        "ipm 1\nA --> F(1) +(90) A\nstart A steps 3",  # a drawing in the plane
        "ipm 1\nLot --> roofHip(30) Tiles\nstart Lot on box(4, 3, 0)",  # the CPU makes it
    ],
)
def test_what_the_card_cannot_do_alone_is_no_table(card: Device, text: str) -> None:
    assert derive_table(ipmlang.parse(text).program, seed=1) is None


def test_what_is_wrong_is_no_table(card: Device) -> None:
    text = "ipm 1\nA(n) --> F(1) &(20) F(sqrt(0 - n)) B\nB --> F(1)\nstart A(2)\n"
    grammar = ipmlang.parse(text)
    assert derive_table(grammar.program) is None
    with pytest.raises(IpmError) as told:
        grammar.run(backend="gpu")
    assert told.value.diagnostics[0].code == "not-a-number"


def test_nothing_to_see_is_told(card: Device) -> None:
    table = table_of("ipm 1\nLot --> split x { ~1: nil }\nstart Lot on box(4, 3, 0)")
    with pytest.raises(IpmError) as caught:
        pictured(table)
    assert caught.value.diagnostics[0].code == "nothing-drawn"


def test_from_far_away_fewer_and_simpler_copies_are_drawn(card: Device) -> None:
    text = WALL.replace("box(12, 9, 0)", "box(400, 300, 0)")
    table = table_of(text)
    model, copies = model_of_table(table, lines=False)
    counts = [
        int(copies.counts(fitted(model.outline, LOOK.view, (side, side)), side).sum())
        for side in (4000, 40, 8)
    ]
    assert counts[0] == len(table)
    assert counts[0] > 1.5 * counts[1] > 3 * counts[2] > 0


def test_far_segments_are_boxes(card: Device) -> None:
    model, copies = model_of_table(table_of(TWIGS), lines=False)
    near, far = (
        copies.counts(fitted(model.outline, LOOK.view, (side, side)), side).sum(axis=0)
        for side in (4000, 30)
    )
    assert near[CYLINDER] > 0 == near[BOX]
    assert far[BOX] > 0 == far[CYLINDER]
