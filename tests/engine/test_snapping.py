"""Snap lines: cuts against a slow oracle, in any order, across any direction, and what is told.

The oracle moves cuts along one axis; frames are random here, so that what lines are in space is
tested with it.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.verify import verify
from ipmlang.runtime import pending
from ipmlang.runtime.scene import Scene
from tests.engine.snap_oracle import snapped
from tests.engine.split_oracle import text_of
from tests.engine.test_split import closed_volume, labelled, random_parts, turned


def run(text: str, seed: int = 0) -> Scene:
    grammar = ipmlang.parse("ipm 1\n" + text)
    assert verify(grammar.program) == []
    return grammar.run(seed=seed)


def made(lines: Sequence[float], axis: str = "x") -> str:
    """Elements that make lines across an axis."""
    places = {"x": "({}, 0, 0)", "y": "(0, {}, 0)", "z": "(0, 0, {})"}[axis]
    return " ".join(f'[translate{places.format(each)} snap("f", {axis})]' for each in lines)


def widths(parts: str, lines: Sequence[float], length: float, more: str = "") -> list[list[float]]:
    """Where the pieces of a split begin that snaps, and how long they are; from left to right."""
    scene = run(
        f"A --> {made(lines)} phase(2) S\n"
        f'S --> split x(snap: "f"{more}) {{ {parts} }}\nstart A on box({length!r}, 1, 0)\n'
    )
    table = scene.instances
    order = np.argsort(table.position[:, 0])
    found = np.stack([table.position[order, 0], table.size[order, 0]], axis=1)
    return np.round(found, 9).tolist()


# ------------------------------------------------------------------------------ what is written


def test_the_nearest_line_within_reach_takes_a_cut() -> None:
    assert widths("~1: B | ~1: B", [5.5, 3], 10) == [[0, 5.5], [5.5, 4.5]]
    assert widths("~1: B | ~1: B", [7.4], 10) == [[0, 7.4], [7.4, 2.6]]
    assert widths("~1: B | ~1: B", [7.5], 10) == [[0, 5], [5, 5]]  # half of the piece, no nearer
    assert widths("~1: B | ~1: B", [5.5], 10, ", reach: 0.4") == [[0, 5], [5, 5]]
    assert widths("~1: B | ~1: B", [5.5], 10, ", reach: 0.5") == [[0, 5.5], [5.5, 4.5]]
    assert widths("'0.5: B | ~1: B", [-1, 0, 10, 12], 10) == [[0, 5], [5, 5]]


def test_the_lower_of_two_lines_or_cuts_counts() -> None:
    assert widths("~1: B | ~1: B", [4, 6], 10) == [[0, 4], [4, 6]]
    assert widths("~1: B | ~1: B | ~1: B", [4.5], 9) == [[0, 3], [3, 3], [6, 3]]
    assert widths("~1: B | 2: B | ~1: B", [3.5, 5.5], 10) == [[0, 3.5], [3.5, 2], [5.5, 4.5]]
    assert widths("~1: B | 2: B | ~1: B", [3.5, 6.5], 10) == [[0, 3.5], [3.5, 2], [5.5, 4.5]]


def test_absolute_pieces_move_and_keep_their_size() -> None:
    assert widths("~1: B | 2: B | ~1: B", [6.2], 10)[1] == [4.2, 2]
    assert widths("1: B | 2: B | ~1: B", [1.2], 10) == [[0, 1], [1, 2], [3, 7]]
    assert widths("~1: B | 1: B | 2: B", [7.2], 10) == [[0, 7], [7, 1], [8, 2]]
    assert widths("{ 3: B }*", [3.1], 10) == [[0, 3], [3, 3], [6, 3]]


def test_a_piece_comes_to_lie_on_one_that_is_as_large() -> None:
    """Both of its cuts come to lines, though one alone would have less far to go."""
    assert widths("~1: B | 2: B | ~1: B", [6.1, 8.1], 12) == [[0, 6.1], [6.1, 2], [8.1, 3.9]]
    assert widths("~1: B | 2: B | ~1: B", [6.1, 8.2], 12) == [[0, 4.1], [4.1, 2], [6.1, 5.9]]
    assert widths("~1: B | 2: B | ~1: B", [7.4, 9.4], 12) == [[0, 7.4], [7.4, 2], [9.4, 2.6]]
    assert widths("~1: B | 2: B | ~1: B", [7.4, 9.5], 12) == [[0, 5.4], [5.4, 2], [7.4, 4.6]]


def test_copies_of_repeats_snap_and_know_their_numbers() -> None:
    scene = run(
        f"A --> {made([3.6, 6.2])} phase(2) S\n"
        'S --> split x(snap: "f") { ~1: P | { ~2: P | ~1: P }* }\n'
        "P --> split y { split.index + 1: Q | 20 + split.count: R }\nstart A on box(10, 100, 0)\n"
    )
    index = [round(size[1]) - 1 for name, _, size in labelled(scene) if name == "Q"]
    count = {round(size[1]) - 20 for name, _, size in labelled(scene) if name == "R"}
    assert sorted(index) == list(range(7)) and count == {7}
    ends = [place[0] + size[0] for name, place, size in labelled(scene) if name == "Q"]
    assert any(end == pytest.approx(3.6) for end in ends)
    assert any(end == pytest.approx(6.2) for end in ends)


# ------------------------------------------------------------------------------ against the oracle


@pytest.mark.parametrize("seed", range(120))
def test_random_splits_snap_as_the_oracle_does(seed: int) -> None:
    draw = random.Random(seed)
    parts = random_parts(draw)
    length = draw.choice((3.0, 7.7, 12.0, 30.0))
    lines = [round(draw.uniform(-1, length + 1), 2) for _ in range(draw.randint(0, 12))]
    reach = draw.choice((float("inf"), float("inf"), 0.2, 0.7))
    more = f", reach: {reach}" if reach < 9 else ""
    found = widths(text_of(parts), lines, length, more)
    wanted = snapped(parts, length, lines, reach)
    assert np.array(found).reshape(-1, 2) == pytest.approx(
        np.array(wanted).reshape(-1, 2), abs=1e-8
    )
    assert all(size > 0 for _, size in found)


@pytest.mark.parametrize("seed", range(60))
def test_lines_are_planes_in_space(seed: int) -> None:
    """Made and cut in different frames: turned, moved, mirrored, scaled, along other axes."""
    draw = random.Random(seed)
    parts, length = random_parts(draw), draw.choice((7.7, 12.0, 30.0))
    lines = [round(draw.uniform(-1, length + 1), 2) for _ in range(draw.randint(1, 9))]
    turn = f"rotate({draw.randint(-90, 90)}, {draw.randint(-90, 90)}, {draw.randint(0, 350)})"
    off, scale = draw.choice(((0.0, 1.0), (1.3, 2.5), (-0.7, 0.4)))
    axis = draw.choice("xyz")  # of the shape that splits: turned so that it lies along the lines' x
    lie = {"x": "", "y": "rotate(0, 0, -90)", "z": "rotate(0, 90, 0)"}[axis]
    mirror = draw.choice(("", "mirrorScope(x)", "mirrorScope(y)", "mirrorScope(z)"))
    scene = run(
        f"Lot --> {turn} [{made(lines)}] phase(2) M\n"
        f"M --> translate({off}, 3, -2) {lie} *({scale}) size({length}, {length}, {length}) "
        f"{mirror} [Whole] S\n"
        f'S --> split {axis}(snap: "f") {{ {text_of(parts)} }}\nstart Lot on box(1, 1, 1)\n'
    )
    table = scene.instances
    place = "xyz".index(axis)
    whole = table.label == scene.labels.index("Whole")
    hand = np.sign(table.scale[whole]) if axis == "x" else 1.0
    along = turned(table.rotation[whole], np.eye(3)[place])[0] * hand
    low = (table.position[~whole] - table.position[whole]) @ along / scale
    order = np.argsort(low)
    back = f"({axis})" in mirror
    seen = [(each - off) / scale for each in lines]
    wanted = snapped(parts, length, [length - each for each in seen] if back else seen)
    found = np.stack([low[order], table.size[~whole][order, place]], axis=1)
    assert found == pytest.approx(np.array(wanted).reshape(-1, 2), abs=1e-7)


# ---------------------------------------------------------------------------------- in any order

STREET = """
attr houses : int = 7
Street --> [repeat(i < houses) { [translate(9 * i, 0, 0) size(8, 6, rand(8, 11)) House(i)] }]
House(i) : mod(i, 2) == 0 --> label("pair") Old
House(i) : else --> phase(2) New
Old --> comp { front: split y { rand(2.5, 4): Base | { ~rand(2.6, 3.4): Storey }* } }
Base --> snap("belt", y, at: end) split x { { ~rand(1, 3): snap("bay", x) Bay }* }
Storey --> snap("belt", y) Wall
New --> comp { front: split y(snap: "belt") { { ~3: Floor }* } | back: Back }
Floor --> split x { ~1: W | { ~2: snap("pier", x, at: both) W }* }
Back --> phase(4) split y { { ~2: Deep }* }
Deep --> split x(snap: "pier", reach: 0.4) { { ~1.7: V }* }
"""


def signature(scene: Scene) -> list[tuple[object, ...]]:
    """All that is drawn, bit by bit, in the order of keys."""
    table = scene.instances
    rows = np.argsort(table.key)
    return [
        (scene.labels[table.label[row]], *table.position[row].tolist(), *table.size[row].tolist())
        for row in rows.tolist()
    ]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("chunk", [1, 3, 7])
def test_results_do_not_depend_on_batches(
    chunk: int, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = STREET + "start Street\n"
    whole = signature(run(text, seed))
    monkeypatch.setattr(pending, "CHUNK", chunk)
    assert signature(run(text, seed)) == whole
    assert len({name for name, *_ in whole}) == 4


def test_results_do_not_depend_on_what_stands_first() -> None:
    lines, split = made([2.2, 5.7]), 'S --> split x(snap: "f") { { ~2: B }* }\n'
    ground = "start A on box(9, 1, 0)\n"
    before = run(f"A --> [phase(2) S] {lines}\n{split}{ground}")
    after = run(f"A --> {lines} [phase(2) S]\n{split}{ground}")
    assert labelled(before) == labelled(after)
    assert {size[0] for _, _, size in labelled(after)} != {9 / 4}


def test_lines_of_the_same_phase_or_a_later_one_are_not_seen() -> None:
    text = (
        'A --> split y { 1: phase(2) L | 1: phase(2) S | 1: phase(3) S | 1: snap("f", x) nil }\n'
        'L --> translate(4, 0, 0) snap("f", x)\n'
        'S --> split x(snap: "f") { ~1: B | ~1: B }\nstart A on box(10, 4, 0)\n'
    )
    scene = run(text)
    found = {place: size[0] for _, place, size in labelled(scene)}
    assert found == {(0, 1, 0): 5, (5, 1, 0): 5, (0, 2, 0): 4, (4, 2, 0): 6}


def test_a_shape_can_keep_to_its_own_lines() -> None:
    text = (
        'A --> split x {{ 10: label("h") H(4) | 10: label("h") H(6) | ~1: phase(2) S }}\n'
        'H(p) --> [translate(0, p, 0) snap("f", y)] phase(2) S\n'
        'S --> split y(snap: "f"{}) {{ ~1: B | ~1: B }}\nstart A on box(30, 10, 0)\n'
    )
    alone = [size[1] for _, _, size in labelled(run(text.format(', within: "h"')))]
    assert alone == [4, 6, 6, 4, 5, 5]
    every = [size[1] for _, _, size in labelled(run(text.format("")))]
    assert every == [4, 6, 4, 6, 4, 6]


def test_lines_at_the_middle_and_the_ends() -> None:
    for at, cut in (("start", 2.5), ("middle", 3.5), ("end", 4.5)):
        scene = run(
            f'A --> [translate(2.5, 0, 0) size(2, 1, 0) snap("f", x, at: {at})] phase(2) S\n'
            'S --> split x(snap: "f") { ~1: B | ~1: B }\nstart A on box(8, 1, 0)\n'
        )
        assert [size[0] for _, _, size in labelled(scene)] == [cut, 8 - cut]
    assert widths("~1: B | ~2: B | ~1: B", [], 8) == [[0, 2], [2, 4], [6, 2]]
    scene = run(
        'A --> [translate(1.5, 0, 0) size(5, 1, 0) snap("f", x, at: both)] phase(2) S\n'
        'S --> split x(snap: "f") { ~1: B | ~2: B | ~1: B }\nstart A on box(8, 1, 0)\n'
    )
    assert [size[0] for _, _, size in labelled(scene)] == [1.5, 5, 1.5]


def test_a_scaled_scope_makes_its_lines_where_it_ends() -> None:
    scene = run(
        'A --> [*(2) size(3, 1, 0) snap("f", x, at: end)] phase(2) S\n'
        'S --> split x(snap: "f") { ~1: B | ~1: B }\nstart A on box(10, 1, 0)\n'
    )
    assert [size[0] for _, _, size in labelled(scene)] == [6, 4]


def test_lines_that_stand_askew_are_not_seen() -> None:
    text = (
        'A --> [translate(4.5, 0, 0) rotate(0, 0, {}) snap("f", x)] phase(2) S\n'
        'S --> split x(snap: "f") {{ ~1: B | ~1: B }}\nstart A on box(10, 1, 0)\n'
    )
    cuts = [labelled(run(text.format(turn)))[0][2][0] for turn in (0, 180, 0.001, 5, 90)]
    assert cuts == [4.5, 4.5, 5, 5, 5]


def test_polygons_snap_as_boxes_do() -> None:
    scene = run(
        f"A --> {made([5.4])} phase(2) S\n"
        'S --> extrude(2) split x(snap: "f") { ~1: B | ~1: B }\n'
        "start A on polygon [(0, 0), (12, 0), (12, 4), (5, 4), (5, 9), (0, 9)]\n"
    )
    table = scene.instances
    assert table.size[:, 0].tolist() == pytest.approx([5.4, 6.6])
    assert closed_volume(scene) == pytest.approx(2 * (12 * 4 + 5 * 5))


# --------------------------------------------------------------------------------- what is told


def test_a_split_of_the_first_phase_cannot_snap() -> None:
    text = 'A --> snap("f", x) split x(snap: "f") { ~1: B }\nstart A on box(3, 1, 0)\n'
    with pytest.raises(IpmError) as caught:
        run(text)
    (found,) = caught.value.diagnostics
    assert found.code == "first-phase" and "phase(2)" in str(found.hint)
    assert len(run(text.replace('snap: "f"', 'snap: ""')).instances) == 1
    assert not run(text.replace('snap: "f"', 'snap: ""')).notes


def test_a_reach_is_no_less_than_nothing() -> None:
    with pytest.raises(IpmError, match="reach"):
        widths("~1: B | ~1: B", [4], 10, ", reach: 0 - 1")


def test_lines_that_come_too_late_are_told() -> None:
    split = 'S --> split x(snap: "f") { ~1: B | ~1: B }\nstart A on box(3, 1, 0)\n'
    (note,) = run(f'A --> phase(2) snap("f", x) S\n{split}').notes
    assert "phase 2 finds no snap line" in note and "all 1 are of phase 2" in note
    (note,) = run(f'A --> snap("g", x) phase(2) S\n{split}').notes
    assert "there are none" in note


def test_parts_without_room_are_told() -> None:
    scene = run(
        f'A --> {made([1])} phase(2) S\nS --> split x(snap: "f") {{ 2: B | 2: B | ~1: B | 9: B }}\n'
        "start A on box(4, 1, 0)\n"
    )
    assert len(scene.instances) == 2 and "2 parts of splits" in scene.notes[0]
