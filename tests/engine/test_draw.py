"""What a threaded turtle draws: pens, polygons, holes, terminals, in the string's order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import ir
from ipmlang.runtime.export import save
from ipmlang.runtime.scene import OUTLINE, PATH, SEGMENT, Scene
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled


def drawn(grammar: str, folder: Path = Path()) -> Scene:
    return derive_string(compiled(grammar + "\n", folder), (), 0, ir.Limits())


@pytest.fixture
def parts(tmp_path: Path) -> Path:
    """A folder with a parts file."""
    text = '<svg xmlns="http://www.w3.org/2000/svg"><g id="g1"/><path id="leaf" d="M0 0h1"/></svg>'
    (tmp_path / "x.parts.svg").write_text(text)
    return tmp_path


def test_pens_hold_until_their_bracket_closes() -> None:
    scene = drawn(
        'start F color("#f00") F [fill("none") !(2) F layer(3) F] css("opacity:.5;") F\n'
        '    fill("#00f") F color("teal") F'
    )
    found = scene.instances
    assert [f"{each:08x}" for each in found.color] == [
        "00000000", "ff0000ff", "ff0000ff", "ff0000ff", "ff0000ff", "ff0000ff", "008080ff",
    ]  # fmt: skip
    assert [scene.styles[each].css for each in found.style] == [
        "", "", "fill:none", "fill:none", "opacity:.5", "opacity:.5;fill:#00f", "opacity:.5",
    ]  # fmt: skip
    assert found.width[2:4].tolist() == [2, 2]
    assert found.layer.tolist() == [0, 0, 0, 3, 0, 0, 0]


def test_effects_and_materials_are_references_and_names(parts: Path) -> None:
    scene = drawn('start [effect("x.parts.svg#g1") F] material("brick") F', parts)
    assert scene.groups is not None
    assert scene.groups.of.tolist() == [0, -1]
    (effect,) = scene.groups.effects
    assert effect is not None
    assert (effect.path.name, effect.node) == ("x.parts.svg", "g1")
    assert [scene.styles[each].material for each in scene.instances.style] == ["", "brick"]


def test_a_polygon_has_the_ends_of_its_edges_as_corners() -> None:
    scene = drawn("turtle angle 90\nstart F polygon { F + F + F } polygon { F } F")
    assert scene.instances.asset.tolist() == [SEGMENT, OUTLINE, SEGMENT]
    assert scene.instances.shape.tolist() == [-1, 0, -1]
    (square,) = scene.polygons
    np.testing.assert_allclose(square[:, :2], [(1, 0), (2, 0), (2, 1), (1, 1)], atol=1e-12)
    assert scene.instances.position[2, :2] == pytest.approx([0, 1])


def test_polygons_nest_and_take_marks() -> None:
    scene = drawn(
        "turtle angle 90\n"
        "start polygon { vertex [f(4) polygon { F + F + F }] f(2) + f(2) + f(2) vertex }"
    )
    outer, inner = scene.polygons
    assert scene.instances.shape.tolist() == [1, 0]  # the inner one closes first
    np.testing.assert_allclose(inner[:, :2], [(4, 0), (5, 0), (5, 1), (4, 1)], atol=1e-12)
    corners = [(0, 0), (4, 0), (0, 0), (2, 0), (2, 2), (0, 2)]
    np.testing.assert_allclose(outer[:, :2], corners, atol=1e-12)


def parts_of(points: np.ndarray) -> list[list[tuple[float, float]]]:
    """The parts of a path, rounded."""
    split = np.split(points[:, :2], np.flatnonzero(np.isnan(points[:, 0])))
    told = [np.round(part[~np.isnan(part[:, 0])], 9) + 0.0 for part in split]
    return [[(x, y) for x, y in part.tolist()] for part in told]


def test_a_path_begins_anew_where_nothing_is_drawn() -> None:
    scene = drawn("turtle angle 90\nstart path { F + F [- F] F f F } F path { f } path { F }")
    assert scene.instances.asset.tolist() == [PATH, SEGMENT, PATH]
    first, last = map(parts_of, scene.polygons)
    assert first == [[(0, 0), (1, 0), (1, 1), (2, 1)], [(1, 1), (1, 2)], [(1, 3), (1, 4)]]
    assert last == [[(1, 6), (1, 7)]]


def test_a_path_goes_straight_to_what_is_marked() -> None:
    scene = drawn("start path { vertex f(2) F at(0, 3) vertex } path { vertex f F f vertex }")
    assert [parts_of(each) for each in scene.polygons] == [
        [[(2, 0), (3, 0), (3, 3)]],
        [[(4, 3), (5, 3), (6, 3)]],
    ]


def test_a_path_is_one_element_of_a_drawing(tmp_path: Path) -> None:
    scene = drawn('turtle angle 90\nstart color("teal") path { F + F f F } polygon { F + F }')
    save(scene, tmp_path / "x.svg")
    text = (tmp_path / "x.svg").read_text(encoding="utf-8")
    assert text.count("<path") == 2
    assert 'd="M0 0L1 0L1 -1M1 -2L1 -3" fill="none" stroke="#008080"' in text
    save(scene, tmp_path / "x.obj")
    lines = (tmp_path / "x.obj").read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("f ") for line in lines) == 3 * 10 + 1  # closed tubes, a triangle


def test_an_outer_edge_that_leaves_its_branch_stays_in_order() -> None:
    scene = drawn("turtle angle 90\nstart polygon { [+ F(3)] F(1) + F(1) }")
    (points,) = scene.polygons
    np.testing.assert_allclose(points[:, :2], [(0, 0), (0, 3), (0, 0), (1, 0), (1, 1)], atol=1e-12)


def test_holes_move_but_draw_nothing() -> None:
    scene = drawn("A(i) --> F(1)\nstart repeat(i < 5) except (1, 3) { A(i) } steps 2")
    assert scene.instances.position[:, 0].tolist() == [0, 2, 4]


def test_terminals_stand_where_the_turtle_is(parts: Path) -> None:
    scene = drawn(
        'asset leaf = "x.parts.svg#leaf"\nturtle angle 90\nA --> F + leaf\nstart A *(2) mirror A',
        parts,
    )
    found = scene.instances
    assert [scene.labels[each] for each in found.label] == ["F", "leaf", "F", "leaf"]
    assert found.asset.tolist() == [SEGMENT, 0, SEGMENT, 0]
    assert found.scale.tolist() == [1, 1, -2, -2]
    # mirrored: the heading turns around first, and left is where it was
    np.testing.assert_allclose(found.position[3, :2], [1, -2], atol=1e-12)
    assert [scene.rules[each].rule for each in found.rule] == ["A"] * 4


def test_origins_say_which_rule_drew() -> None:
    scene = drawn("A --> F\nF --> F [A]\nstart F steps 2")
    rules = [(scene.rules[each].rule, scene.rules[each].line) for each in scene.instances.rule]
    assert rules == [("F", 2), ("A", 1)]
    assert scene.generations == 2
    assert scene.rules[-1].rule == "start"
