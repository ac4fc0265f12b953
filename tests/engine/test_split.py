"""Splits, checked against what other engines were measured to do, and against a slow oracle.

The oracle shares a length out by hand, one part after the other; the engine's splits are arithmetic
on columns. What is kept by every split (length, volume, closedness) is a property over random ones.
"""

from __future__ import annotations

import math
import random
from time import process_time

import numpy as np
import pytest

import ipmlang
from ipmlang.runtime.scene import SCOPE, SOLID, Scene
from tests.engine.split_oracle import Group, Part, text_of, widths


def run(text: str, **options: object) -> Scene:
    return ipmlang.parse("ipm 1\n" + text).run(**options)  # type: ignore[arg-type]


def labelled(scene: Scene) -> list[tuple[str, tuple[float, ...], tuple[float, ...]]]:
    """Symbol, place and size of every terminal."""
    table = scene.instances
    return [
        (scene.labels[table.label[row]], tuple(np.round(table.position[row], 9).tolist()),
         tuple(np.round(table.size[row], 9).tolist()))
        for row in range(len(table))
    ]  # fmt: skip


def lengths(body: str, length: float) -> list[tuple[str, float]]:
    """Symbol and length of the pieces of `split x`."""
    scene = run(f"A --> split x {{ {body} }}\nstart A on box({length!r}, 1, 0)\n")
    return [(name, size[0]) for name, _, size in labelled(scene)]


# ------------------------------------------------------------------ what others were measured to do


@pytest.mark.parametrize(
    ("length", "period", "count"),
    [(8, 10 / 3, (3, 2)), (8, 6.0, (2, 1)), (9, 3.75, (3, 2)), (9, 6.75, (2, 1)),
     (10, 25 / 6, (3, 2)), (10, 7.5, (2, 1))],
)  # fmt: skip
def test_a_repeat_switches_where_others_do(
    length: float, period: float, count: tuple[int, int]
) -> None:
    for factor, wanted in zip((1 - 1e-6, 1 + 1e-6), count, strict=True):
        found = lengths(f"{{ ~{period * factor!r}: B }}*", length)
        assert found == [("B", round(length / wanted, 9))] * wanted


def test_sizes_that_do_not_fit_are_cut_and_told() -> None:
    scene = run("A --> split x { 2: B | 1: C | 1: D | 2: E | 1: G }\nstart A on box(5, 1, 0)\n")
    assert [(name, size[0]) for name, _, size in labelled(scene)] == [
        ("B", 2), ("C", 1), ("D", 1), ("E", 1),
    ]  # fmt: skip
    assert any("not made" in note and "rule A" in note for note in scene.notes)


def test_sizes_of_nothing_make_no_shape() -> None:
    scene = run("attr w = 0\nA --> split x { w: B | w - 1: C | ~1: D }\nstart A on box(5, 1, 0)\n")
    assert [(name, size[0]) for name, _, size in labelled(scene)] == [("D", 5)]
    assert len(scene.notes) == 1 and "2 parts" in scene.notes[0]


def test_the_golden_section() -> None:
    assert lengths("'0.618: B | ~1: C", 10) == [("B", 6.18), ("C", 3.82)]


def test_a_rhythm_is_repeated_and_scaled_as_one() -> None:
    assert (
        lengths("{ ~1: B | ~2: C }*", 10) == [("B", 10 / 9), ("C", 20 / 9)] * 3
        or lengths("{ ~1: B | ~2: C }*", 10)
        == [("B", round(10 / 9, 9)), ("C", round(20 / 9, 9))] * 3
    )


def test_fixed_sizes_in_a_rhythm_stay_fixed() -> None:
    found = lengths("{ ~3: B | 0.5: C }*", 10)
    assert [size for name, size in found if name == "C"] == [0.5] * 3
    assert sum(size for _, size in found) == pytest.approx(10)


def test_whole_copies_of_fixed_sizes_leave_the_rest_empty() -> None:
    assert lengths("{ 3: B }*", 10) == [("B", 3)] * 3
    assert lengths("{ 3: B }+", 10) == [("B", 3)] * 3 + [("B", 1)]
    assert lengths("~1: L | { 3: B }* | ~1: R", 10)[1:-1] == [("B", 3)] * 2
    assert lengths("{ 2: B | 2: C }+", 7) == [("B", 2), ("C", 2), ("B", 2), ("C", 1)]


def test_several_repeats_share_what_is_left() -> None:
    found = lengths("{ ~1: B }* | 2: M | { ~2: C }*", 14)
    assert [name for name, _ in found] == ["B"] * 4 + ["M"] + ["C"] * 4
    assert sum(size for _, size in found) == pytest.approx(14)


def test_repeats_within_repeats() -> None:
    found = lengths("{ ~1: W | { ~1: B }* }*", 8)
    assert sum(size for _, size in found) == pytest.approx(8)
    assert [name for name, _ in found] == ["W", "B"] * 4


def test_the_number_of_a_piece() -> None:
    scene = run(
        "A --> split x { 1: P | { ~1: P | ~1: P }* | 1: P }\n"
        "P --> split y { split.index + 1: Q }\n"
        "P : split.index == split.count - 1 --> Last\n"
        "start A on box(8, 100, 0)\n".replace(
            "P --> split", "P : split.index < split.count - 1 --> split"
        )
    )
    sizes = [round(size[1]) for name, _, size in labelled(scene) if name == "Q"]
    assert sizes == [1, 2, 3, 4, 5, 6, 7]
    assert sum(name == "Last" for name, _, _ in labelled(scene)) == 1


# ------------------------------------------------------------------------------- against the oracle


def random_parts(draw: random.Random, depth: int = 0) -> list[Part | Group]:
    parts: list[Part | Group] = []
    for _ in range(draw.randint(1, 4)):
        if depth < 2 and draw.random() < 0.3:
            parts.append(Group(random_parts(draw, depth + 1), draw.choice("**+")))
        else:
            kind = draw.choice(("absolute", "floating", "floating", "relative"))
            size = draw.choice((0.5, 1.0, 1.3, 2.0, 3.7))
            parts.append(Part(kind, size if kind != "relative" else size / 20))
    return parts


@pytest.mark.parametrize("seed", range(150))
def test_random_splits_are_those_of_the_oracle(seed: int) -> None:
    draw = random.Random(seed)
    parts = random_parts(draw)
    length = draw.choice((0.4, 3.0, 7.7, 12.0, 30.0))
    scene = run(f"A --> split x {{ {text_of(parts)} }}\nstart A on box({length!r}, 1, 0)\n")
    table = scene.instances
    found = np.stack([table.position[:, 0], table.size[:, 0]], axis=1)
    wanted = np.array(widths(parts, length)).reshape(-1, 2)
    assert found.shape == wanted.shape
    assert found == pytest.approx(wanted, abs=1e-9)


# ------------------------------------------------------------------------------------ what is kept


def closed_volume(scene: Scene) -> float:
    """The volume of all terminals, each a closed solid or a box."""
    from ipmlang.geometry.solid import is_closed, placed, volume

    total = 0.0
    table = scene.instances
    for row in range(len(table)):
        if table.asset[row] == SCOPE:
            total += float(np.prod(table.size[row]))
            continue
        assert table.asset[row] == SOLID
        solid = placed(scene.solids[table.shape[row]], table.size[row], (0, 0, 0))
        assert is_closed(solid)
        total += volume(solid)
    return total


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize(
    "outline",
    ["(0, 0), (12, 0), (12, 9), (0, 9)", "(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)",
     "(0, 0), (10, 1), (13, 6), (6, 11), (-1, 7)"],
)  # fmt: skip
def test_a_split_keeps_the_volume_and_closedness(axis: str, outline: str) -> None:
    split = f"split {axis} {{ 0.7: B | {{ ~1.1: C }}* | '0.13: D }}"
    ground = f"start A on polygon [{outline}]\n"
    whole = closed_volume(run(f"A --> extrude(7) B\n{ground}"))
    parts = closed_volume(run(f"A --> extrude(7) {split}\n{ground}"))
    assert parts == pytest.approx(whole, rel=1e-9)


def test_comp_has_all_faces_and_their_frames() -> None:
    scene = run("A --> extrude(10) comp { all: B }\nstart A on box(8, 11, 0)\n")
    table = scene.instances
    assert sorted(np.prod(table.size[:, :2], axis=1).round(9).tolist()) == [
        80,
        80,
        88,
        88,
        110,
        110,
    ]
    assert not table.size[:, 2].any()
    outward = turned(table.rotation, (0, 0, 1))
    middle = table.position + turned(table.rotation, table.size / 2)
    assert np.all(np.einsum("ij,ij->i", outward, middle - (4, 5.5, 5)) > 0)
    upright = np.abs(outward[:, 2]) < 0.5
    assert turned(table.rotation, (0, 1, 0))[upright] == pytest.approx(
        np.tile((0.0, 0.0, 1.0), (4, 1))
    )


def turned(rotation: np.ndarray, vector: object) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    vectors = np.broadcast_to(np.asarray(vector, float), (len(rotation), 3))
    return np.asarray(Rotation.from_quat(np.roll(rotation, -1, axis=1)).apply(vectors.copy()))


def test_the_first_selector_that_takes_a_face_has_it() -> None:
    scene = run(
        "A --> extrude(3) comp { front: F | side and not back: S | 1: T }\n"
        "start A on box(2, 1, 0)\n"
    )
    assert [name for name, _, _ in labelled(scene)] == ["F", "S", "S", "T"]


def test_faces_bear_the_tags_of_what_made_them() -> None:
    scene = run(
        "A --> extrude(3) split z { 1: B | ~1: B }\n"
        'B --> comp { "extrude.top": T | "split.cut": X }\nstart A on box(2, 1, 0)\n'
    )
    assert [name for name, _, _ in labelled(scene)] == ["X", "T", "X"]


# --------------------------------------------------------------------------------- scope operations


def test_scope_operations_end_with_their_body() -> None:
    scene = run(
        "A --> B C\nB --> translate(5, 0, 0) size(1, 1, 1) D\nC --> E\nstart A on box(2, 2, 2)\n"
    )
    assert labelled(scene) == [("D", (5, 0, 0), (1, 1, 1)), ("E", (0, 0, 0), (2, 2, 2))]


def test_the_pen_ends_with_its_body_where_there_are_scopes() -> None:
    scene = run('A --> Red B\nRed --> color("#f00") Part\nstart A on box(1, 1, 1)\n')
    assert [hex(color) for color in scene.instances.color.tolist()] == ["0xff0000ff", "0x0"]


def test_a_turtle_that_carries_on_is_refused_where_it_stands() -> None:
    with pytest.raises(ipmlang.IpmError) as caught:
        run("A --> extrude(2) Out B\nOut --> f(2) Part\nstart A\n")
    (found,) = caught.value.diagnostics
    assert "`Out`" in found.message and found.source is not None
    assert "[ Out ]" in str(found.hint)


def test_center_and_mirror() -> None:
    scene = run("A --> size(2, 4, 1) center(xz) B\nstart A on box(10, 10, 10)\n")
    assert labelled(scene) == [("B", (4, 0, 4.5), (2, 4, 1))]
    scene = run("A --> mirrorScope(x) split x { 1: B | ~1: C }\nstart A on box(3, 2, 1)\n")
    table = scene.instances
    assert table.scale.tolist() == [-1, -1]
    assert table.position[:, 0].tolist() == [3, 2]


@pytest.mark.parametrize("angle", [0, 30, 200])
def test_octants_and_cells_fill_the_box(angle: float) -> None:
    parts = " ".join(f"[octant(4, 3, 2, {q}) Q]" for q in range(1, 9))
    scene = run(f"A --> rotate(0, 0, {angle}) {parts}\nstart A on box(10, 7, 5)\n")
    assert len(scene.instances) == 8
    assert closed_volume(scene) == pytest.approx(350)
    assert scene.instances.size[7].tolist() == pytest.approx([6, 4, 3])
    scene = run("A --> subdivide(3, 2, 1) Q\nstart A on box(10, 7, 5)\n")
    assert scene.instances.size == pytest.approx(np.tile((10 / 3, 3.5, 5), (6, 1)))


def test_a_scope_is_read_where_it_stands() -> None:
    scene = run(
        "A --> split x { ~1: [size(scope.sx / 2, scope.sy, scope.sz) B] | ~3: C }\n"
        "C : scope.sx > 5 --> Wide\nC : else --> Narrow\n"
        "start A on box(8, 2, 0)\n"
    )
    assert labelled(scene) == [("B", (0, 0, 0), (1, 2, 0)), ("Wide", (2, 0, 0), (6, 2, 0))]


def test_measures_of_geometry() -> None:
    scene = run(
        "A --> extrude(2) B\nB : geometry.volume > 35.9 and geometry.volume < 36.1 --> Right\n"
        "B : else --> Wrong\nstart A on polygon [(0, 0), (6, 0), (6, 2), (2, 2), (2, 5), (0, 5)]\n"
    )
    assert [name for name, _, _ in labelled(scene)] == ["Right"]


def test_a_part_that_makes_itself_ends_when_no_room_is_left() -> None:
    scene = run("A --> split x { 1: B | ~1: A }\nstart A on box(10.5, 1, 0)\n")
    assert len(scene.instances) == 11
    assert math.isclose(float(scene.instances.size[-1, 0]), 0.5)


@pytest.mark.parametrize("depth", [1, 7, 100])
def test_repeats_in_repeats_are_written_once_each(depth: int) -> None:
    """A repeat's body is one more loop over copies, not one more for each repeat around it."""
    text = "ipm 1\nLot --> split x { " + "{ " * depth + "~1: A" + " }*" * depth
    grammar = ipmlang.parse(f"{text} }}\nstart Lot on box(10, 10, 0)\n")
    begin = process_time()
    assert len(grammar.run().instances) == 10
    assert process_time() - begin < 20
