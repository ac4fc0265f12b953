"""Scopes against numbers that are none, too large, too many: an error of the rule, nothing else.

And against the size of batches: what comes out never depends on how many shapes go together.
"""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.runtime import pending
from ipmlang.runtime.scene import Scene
from tests.engine.random_splits import Splits

GROUND = "polygon [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]"
LIMITS = "limit shapes 100000\n"


def run(body: str, ground: str = GROUND) -> Scene:
    return ipmlang.parse(f"ipm 1\n{LIMITS}Lot --> {body}\nstart Lot on {ground}\n").run()


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("cylinder(sqrt(-1)) A", "an argument of cylinder is not a finite number"),
        ("cone(2 * 1e9) A", r"`cone` cannot have 2e\+09 sides"),
        ("roofGable(30, overhang: 1e300) A", "too large a number"),
        ("envelope(9, front: log(0)) A", "not a finite number"),
        ("envelope(9, front: sqrt(geometry.area - 1e9)) A", "not a finite number"),
        ("subdivide(1e5, 1e5, 1) A", "100,000"),
        ("scatter(1e7) A", "100,000"),
        ("repeat(i < 1e12) { A }", "100,000 shapes"),
        ("split x { { ~1e-12: A }* }", "100,000 shapes"),
        ("[Lot][Lot]", "100,000 shapes"),
    ],
)
def test_a_number_that_will_not_do_is_said(body: str, message: str) -> None:
    with pytest.raises(ipmlang.IpmError, match=message) as found:
        run(body)
    assert "Lot" in found.value.diagnostics[0].message


def test_coordinates_too_far_apart_are_said() -> None:
    far = "polygon [(0, 0), (12, 0), (12, 4), (5, 1e9), (5, 9), (0, 9)]"
    with pytest.raises(ipmlang.IpmError):
        run("envelope(18, front: 3, side: 2, angle: 60) A", far)


@pytest.mark.parametrize("body", ["Lot", "split x { ~1: Lot }", "comp { all: Lot }"])
def test_a_rule_that_makes_itself_stops_at_a_limit(body: str) -> None:
    with pytest.raises(ipmlang.IpmError, match=r"rule Lot .* stopped at its limit"):
        run(body, "box(8, 11, 6)")


def test_so_little_inset_is_none() -> None:
    scene = run("taper(2, 0.001 * 1e-12) A")
    assert len(scene.instances) == 1


def test_primitives_of_a_batch_differ() -> None:
    scene = run("split x { { ~1: B }* }\nB --> cylinder(3 + split.index) comp { side: C }",
                "box(4, 1, 1)")  # fmt: skip
    assert len(scene.instances) == 3 + 4 + 5 + 6


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("center", [[0, 2], [1.25, 0], [2, 2], [3, 2]]),
        ("mirrorScope", [[0, 1], [1.5, 0], [2, 1], [3, 1]]),
    ],
)
def test_words_of_a_batch_differ(name: str, places: list[list[float]]) -> None:
    word = 'if split.index == 1 then "x" else "y"'
    split = f"split x {{ {{ ~1: B }}* }}\nB --> size(0.5, 1, 1) {name}({word}) C"
    assert run(split, "box(4, 5, 1)").instances.position[:, :2].tolist() == places


def test_a_word_that_is_none_of_them_is_said() -> None:
    with pytest.raises(ipmlang.IpmError, match="`axis` of `mirrorScope` cannot be `q`"):
        run('mirrorScope(if scope.sx > 1 then "q" else "x") A')


def test_what_is_not_there_gives_no_arguments() -> None:
    scene = run("split x { scope.sx - 4: cylinder(scope.sx - 4) A | ~1: A }", "box(4, 1, 1)")
    assert len(scene.instances) == 1


def test_nothing_comes_of_nothing() -> None:
    scene = run("split x { ~1: scatter(5) P | ~1: comp { top: P } }\n"
                "P --> extrude(2) Q\nQ --> A", "box(4, 1, 1)")  # fmt: skip
    assert [scene.labels[each] for each in scene.instances.label] == ["A"]


SOLIDS = (
    "A --> extrude(3) comp { side: split x { { ~0.7: B }* } | top: roofHip(30) Roof }\n"
    "Roof --> comp { slope: C }\n"
    "B : 40% --> extrude(irand(1, 4) / 10) W\nB : else --> split y { ~1: W | 0.2: cylinder(6) W }\n"
    "C --> split y { { ~0.5: W }* } scatter(3) size(0.1, 0.1, 0.1) cube P\n"
    f"start A on {GROUND}\n"
)


@pytest.mark.parametrize("text", [SOLIDS, *(Splits(seed).text()[6:] for seed in (3, 14, 25, 36))])
def test_the_size_of_batches_changes_nothing(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    grammar = ipmlang.parse("ipm 1\n" + text)
    wanted = grammar.run(seed=5)
    for size in (1, 7, 100):
        monkeypatch.setattr(pending, "CHUNK", size)
        found = grammar.run(seed=5)
        for name in ("key", "position", "rotation", "size", "scale"):
            one, other = getattr(found.instances, name), getattr(wanted.instances, name)
            assert one.tobytes() == other.tobytes(), name
        assert [found.labels[each] for each in found.instances.label] == [
            wanted.labels[each] for each in wanted.instances.label
        ]
        assert corners(found) == corners(wanted)


def corners(scene: Scene) -> list[bytes]:
    """The geometry of every terminal that has one of its own."""
    table = scene.instances
    own = np.asarray(table.shape)
    return [scene.solids[each].vertices.tobytes() for each in own.tolist() if each >= 0]


@pytest.mark.parametrize("ground", ["", " on box(1, 1, 1)"])
@pytest.mark.parametrize(
    "body",
    [
        "+(sqrt(0 - 1)) F", "&(sqrt(0 - 1)) F", "at(0, 0, 0, 0, 0, 0, 0) F", "*(sqrt(0 - 1)) F",
        "*(1e300) *(1e300) F", "size(1, 1, 1) rotate(sqrt(0 - 1), 0, 0) cube B",
        "F [+(sqrt(0 - 1)) F cut F]", "at(0, 0, 0, 0, 0, 0, 0) F [F cut F]",
    ],
)  # fmt: skip
def test_nothing_is_drawn_in_a_frame_of_no_numbers(body: str, ground: str) -> None:
    grammar = ipmlang.parse(f"ipm 1\nP --> {body}\nstart P{ground}\n")
    with pytest.raises(ipmlang.IpmError, match="finite"):
        grammar.run()


def test_an_operation_on_a_batch_of_nothing() -> None:
    operations = ("roofGable(20)", "roofHip(20)", "setback(1) { all: C }", "innerRect",
                  "subdivide(2, 2, 1)", "split x { ~1: subdivide(2, 1, 1) B }")  # fmt: skip
    for operation in operations:
        for parts in ("rest: {} B", "rest: extrude(2) comp {{ top: {} B }}"):
            own = parts.format(operation)
            own = own.replace("} B", "}") if operation.endswith("}") else own
            text = f"ipm 1\nA --> setback(9) {{ all: W | {own} }}\nstart A on box(4, 4, 0)\n"
            scene = ipmlang.parse(text).run()
            assert {scene.labels[each] for each in scene.instances.label} == {"W"}
