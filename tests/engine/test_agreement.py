"""The proof of agreement proved: random grammars run alike where two ways to run them exist, and
every kind of difference that is planted into a scene is found and told.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ipmlang.compiler import compile_text
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.ir import Program
from ipmlang.runtime import derive, frontier, single
from ipmlang.runtime.bind import bind
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import Groups, Instances, PenStyle, Scene
from ipmlang.runtime.strings import derive_string
from tests.agreement import Outcome, assert_agree, bound_of, disagreements, outcome
from tests.random_grammars import FOLDER, grammar

WRITTEN = (
    "repeat(", "except (", "split x", "split y", "split z", "split u", "}*", "}+", "| '", "| ~",
    "comp {", "comp(edges)", "extrude(", "taper(", "roofGable", "roofHip", "roofShed",
    "roofPyramid", "roofMansard", "offset(", "setback(", "shapeL(", "subdivide(", "scatter(",
    "octant(", "innerRect", "cube", "cylinder", "sphere", "quad", "translate(", "rotate(",
    "rotateScope", "size(", "center(", "mirrorScope", "alignScopeToAxes", "about:", "set (",
    "with (", "weight", "%", "else", "interpret", "steps ", "polygon {", "path {",
    "cut", "effect(", "css(",
    "color(", "fill(", "stroke(", "layer(", "material(", "texture(", "projectUV", "tileUV",
    "report(", "tag(", "label(", "mirror", "*(", "at(",
    "&(", "^(", "/(", "\\(", "$", "turn", "leaf",
    "rand(", "irand(", "pick(", "gauss(", "noise(", "sqrt(", "mod(", "tiles(", "if ", "and ",
    "not ", "fn ", "const ", "table ", "attr ", "split.index", "split.count", "scope.sx",
    "on polygon", "on box", 'on "lots.obj"',
    "tropism", "ignore", " < A", "> B", "snap(", "(snap:", "phase(", "count(", "overlaps(",
    "fetch(", "sym", "then leaf", "then block",
)  # fmt: skip


def program(number: int) -> Program:
    return compile_text(grammar(number), folder=FOLDER)[1]


def narrowly(monkeypatch: pytest.MonkeyPatch, narrow: int) -> None:
    """Batches for everything (0), or single shapes for everything."""
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", max(narrow, 96))


@pytest.mark.parametrize("start", range(0, 120, 40))
def test_batches_single_shapes_and_strings_agree(
    start: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(start, start + 40):
        text = grammar(number)
        bound, attrs = bind(program(number), None, number)
        narrowly(monkeypatch, 0)
        wanted = outcome(lambda: derive(bound, seed=number))  # noqa: B023
        narrowly(monkeypatch, 1 << 30)
        assert_agree(wanted, outcome(lambda: derive(bound, seed=number)), text)  # noqa: B023
        if not bound.scoped:
            string = outcome(lambda: derive_string(bound, attrs, number, bound.limits))  # noqa: B023
            assert_agree(wanted, string, text)
            if not isinstance(wanted, Scene):
                continue
            scene = derive_frontier(bound, attrs, number, bound.limits)
            assert scene is None or disagreements(scene, string) == []


def test_a_grammar_is_a_function_of_its_number() -> None:
    assert [grammar(number) for number in range(16)] == [grammar(number) for number in range(16)]
    assert len({grammar(number) for number in range(400)}) == 400


def test_generated_grammars_check_and_end() -> None:
    failed = 0
    for number in range(1000, 1080):
        made = outcome(lambda: derive(program(number), seed=1))  # noqa: B023
        if isinstance(made, Scene):
            assert made.shapes < 20_000, number
        else:
            failed += 1
    assert failed <= 4  # such as a roof on a polygon that is not level


def test_generated_grammars_write_all_of_the_language() -> None:
    texts = "\n".join(grammar(number) for number in range(1000))
    assert [word for word in WRITTEN if word not in texts] == []


# ------------------------------------------------------------------- planted differences

BUSH = """ipm 1
asset leaf, star in "pieces.parts.svg"
A(n) : n > 0 --> F(2) !(n) color("#f00") [+(30) A(n - 1)] [-(25) css("a:b") A(n - 1)] leaf
A(n) : else --> polygon { F + F + F } path { F [+ F] f F } layer(1) star
start [effect("pieces.parts.svg#shade") A(2)] A(3)
"""
HOUSE = """ipm 1
Lot --> extrude(3) report("area", scope.sx) comp { side: Wall | top: roofHip(30) Roof }
Wall --> setupProjection(xy, 2, 1) projectUV texture("brick.png") split x { { ~1.5: Bay }* }
start Lot on box(8, 5, 0)
"""


def scene_of(text: str) -> Scene:
    return derive(compile_text(text, folder=FOLDER)[1], seed=1)


def changed(scene: Scene, **columns: Callable[[np.ndarray], None]) -> Scene:
    """The scene with some columns of its rows changed."""
    made = {}
    for name, change in columns.items():
        made[name] = getattr(scene.instances, name).copy()
        change(made[name])
    return replace(scene, instances=replace(scene.instances, **made))


def moved(row: int, by: float) -> Callable[[np.ndarray], None]:
    def change(column: np.ndarray) -> None:
        column[row] += by

    return change


def first(value: object) -> Callable[[np.ndarray], None]:
    def change(column: np.ndarray) -> None:
        column[0] = value

    return change


def swapped(column: np.ndarray) -> None:
    column[[0, 1]] = column[[1, 0]]


def rows(instances: Instances, order: np.ndarray) -> Instances:
    names = Instances.__dataclass_fields__
    return Instances(**{name: getattr(instances, name)[order] for name in names})


@pytest.mark.parametrize("text", [BUSH, HOUSE])
def test_a_scene_agrees_with_itself(text: str) -> None:
    assert disagreements(scene_of(text), scene_of(text)) == []


@pytest.mark.parametrize("text", [BUSH, HOUSE])
@pytest.mark.parametrize(
    ("column", "change", "told"),
    [
        ("position", moved(3, 1e-8), "position"),
        ("position", first(np.nan), "position"),
        ("rotation", moved(2, 1e-9), "rotation"),
        ("scale", moved(2, 1e-9), "scale"),
        ("scale", first(-1.0), "scale"),
        ("size", moved(1, 1e-9), "size"),
        ("layer", moved(4, 1e-9), "layer"),
        ("width", first(7.0), "width"),
        ("color", first(77), "color"),
        ("key", moved(5, 1), "missing"),
        ("key", swapped, "another order"),
        ("label", first(1), "label"),
        ("rule", first(1), "rule"),
        ("asset", first(-1), "asset"),
    ],
)  # fmt: skip
def test_a_planted_difference_is_told(
    text: str, column: str, change: Callable[[np.ndarray], None], told: str
) -> None:
    scene = scene_of(text)
    found = disagreements(scene, changed(scene, **{column: change}))
    if column in ("label", "rule", "asset") and not found:
        assert getattr(scene.instances, column)[0] in (1, -1)  # it was so before
    else:
        assert any(told in line for line in found), found


def test_what_lies_within_the_bound_agrees() -> None:
    scene = scene_of(BUSH)
    allowed = bound_of(scene).length
    within = changed(scene, position=moved(2, 0.9 * allowed), rotation=lambda q: np.negative(q, q))
    assert disagreements(scene, within) == []
    assert disagreements(scene, changed(scene, position=moved(2, 1.1 * allowed)))


def test_rows_missing_too_many_or_in_another_order_are_told() -> None:
    scene = scene_of(BUSH)
    count = len(scene.instances)
    fewer = replace(scene, instances=rows(scene.instances, np.arange(count - 1)))
    turned = replace(scene, instances=rows(scene.instances, np.arange(count)[::-1]))
    assert any("is missing" in line for line in disagreements(scene, fewer))
    assert any("should not be there" in line for line in disagreements(fewer, scene))
    assert any("another order" in line for line in disagreements(scene, turned))


def test_a_disagreement_names_key_rule_and_field() -> None:
    scene = scene_of(BUSH)
    (line, *_) = disagreements(scene, changed(scene, position=moved(0, 0.5)))
    assert re.match(
        r"key 0x[0-9a-f]{16}: segment `F` of rule `A` \(line 3\), row 0: position is .* by 0.5\)",
        line,
    )


def test_what_rows_point_at_is_compared() -> None:
    bush, house = scene_of(BUSH), scene_of(HOUSE)
    groups = bush.groups
    assert isinstance(groups, Groups) and house.texture_maps is not None
    corners = tuple(each + 1e-6 for each in bush.polygons)
    solids = tuple(replace(each, vertices=each.vertices * (1 + 1e-6)) for each in house.solids)
    styles = tuple(PenStyle(css="other") for _ in bush.styles)
    tiles = replace(house.texture_maps, tile=house.texture_maps.tile + 1e-3)
    for scene, other in (
        (bush, replace(bush, polygons=corners)),
        (bush, replace(bush, styles=styles)),
        (bush, replace(bush, groups=replace(groups, position=groups.position + 1))),
        (bush, replace(bush, groups=replace(groups, of=groups.of[::-1].copy()))),
        (bush, replace(bush, groups=None)),
        (house, replace(house, solids=solids)),
        (house, replace(house, texture_maps=tiles)),
        (house, replace(house, texture_maps=None)),
        (house, replace(house, reports={})),
        (house, replace(house, shapes=house.shapes + 1)),
        (house, replace(house, generations=0)),
        (house, replace(house, notes=(*house.notes,), flat=True)),
    ):
        assert disagreements(scene, other), other
    assert disagreements(replace(house, notes=("something",)), house)


def test_a_solid_is_the_same_however_its_faces_are_numbered() -> None:
    house = scene_of(HOUSE)
    (roof,) = (each for each in house.solids if len(each) == 5)
    order = np.roll(np.arange(len(roof.vertices)), 2)
    numbered = replace(roof, vertices=roof.vertices[np.argsort(order)], corners=order[roof.corners])
    solids = [numbered if each is roof else each for each in house.solids]
    assert disagreements(house, replace(house, solids=tuple(solids))) == []
    pulled = replace(numbered, vertices=numbered.vertices + 1e-6)
    turned = replace(numbered, corners=numbered.corners[::-1])
    for other in (pulled, turned):
        solids = [other if each is roof else each for each in house.solids]
        assert disagreements(house, replace(house, solids=tuple(solids)))


def test_errors_agree_by_code() -> None:
    def failing(code: str) -> Outcome:
        def derive_nothing() -> Scene:
            raise fail(code, "no")

        return outcome(derive_nothing)

    assert disagreements(failing("a"), failing("a")) == []
    assert disagreements(failing("a"), failing("b"))
    assert disagreements(failing("a"), scene_of(BUSH))
    assert disagreements(scene_of(BUSH), failing("a"))
