"""Snap lines: cuts against a slow oracle, in any order, across any direction, and what is told."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from ipmlang.runtime import pending
from ipmlang.runtime.scene import Scene
from tests.engine.snap_oracle import snapped
from tests.engine.split_oracle import text_of
from tests.engine.test_split import labelled, random_parts


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
