"""Parts in frames as text: rows stay rows, copies become tables, numbers no longer than needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.edit.buildings.regularity import Part
from ipmlang.edit.buildings.rows import Room, laid_out
from ipmlang.inverse.frames import compose, from_matrices, identity, moved_to

NEAR = 1e-5


def written(parts: list[Part]) -> str:
    """The rule and the tables that say these parts."""
    body, tables = laid_out(parts, Room(NEAR), lambda wish: wish, "Hall")
    rule = ast.Rule(ast.Head("House"), body)
    return format_grammar(ast.Grammar((ast.Version(1), *tables, rule)))


def posts(places: list[tuple[float, float, float]]) -> list[Part]:
    return [(moved_to(np.array([place])), (ast.Module("post"),)) for place in places]


def test_an_even_row_is_a_repeat_in_spite_of_noise() -> None:
    row = posts([(2 / 3 * k + 1e-8 * (k % 2), 0, 1) for k in range(7)])
    assert "repeat(i < 7) { [translate(0.66666667 * i, 0, 1) post] }" in written(row)


def test_uneven_copies_are_a_table() -> None:
    text = written(posts([(0, 0, 1), (1, 0, 1), (2.5, 0, 1), (4.25, 0, 1), (5, 0, 2)]))
    assert "table post_places(x, z) =" in text
    assert "repeat(at post_places) { post }" in text


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_uneven_copies_stand_one_by_one(count: int) -> None:
    text = written(posts([(k * k + 1.0, 0, 0) for k in range(count)]))
    assert text.count("translate") == count
    assert "repeat" not in text


def test_mirrored_copies_are_apart_from_others() -> None:
    mirrored = replace(identity(), hand=np.array([-1.0]))
    parts = posts([(k * k, 0, 0) for k in range(5)])
    parts += [(replace(mirrored, position=frame.position), inner) for frame, inner in parts]
    text = written(parts)
    assert text.count("table ") == 1, "the places are the same"
    assert "{ post }" in text
    assert "{ mirror post }" in text


def test_uneven_symbols_share_a_table_in_their_order() -> None:
    rows = posts([(1, 0, 0), (2.5, 0, 1)]) + [
        (moved_to(np.array([[k * k, 3.0, 0]])), (ast.Module(name),))
        for k, name in enumerate(["beam", "beam", "sill", "post", "gate"])
    ]
    text = written(rows)
    assert "table hall_parts(shape, x, y, z) =\n    post, 1, 0, 0\n    post, 2.5, 0, 1\n" in text
    assert "    sill, 4, 3, 0\n" in text
    assert text.count("post, ") == 2, "a table would draw the third post before the beams"
    assert "[translate(9, 3, 0) post]" in text


def test_motifs_around_an_axis_are_one_repeat() -> None:
    parts = []
    for k in range(6):
        turn = from_matrices(np.hstack([rotation(60.0 * k), [[5.0], [5.0], [0.0]]])[None])
        parts += [
            (compose(turn, moved_to(np.array([place]))), (ast.Module(name),))
            for place, name in (((3.0, 0, 0), "post"), ((3.0, 0, 4.0), "lamp"))
        ]
    text = written(parts)
    assert text.count("repeat(i < 6)") == 1
    assert "translate(5, 5, 0) rotate(0, 0, 60 * i)" in text


def rotation(degrees: float) -> np.ndarray:
    """(3, 3) about z."""
    angle = np.radians(degrees)
    return np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]]
    )


def test_three_on_some_circle_are_no_ring() -> None:
    frames = [
        from_matrices(np.hstack([rotation(50.0 * k), [[k * 2.0], [k * k * 1.0], [0.0]]])[None])
        for k in range(3)
    ]
    assert "repeat" not in written([(frame, (ast.Module("post"),)) for frame in frames])


def test_a_table_that_is_there_serves_again() -> None:
    parts = posts([(0, 0, 1), (1, 0, 1), (2.5, 0, 1), (4.25, 0, 1), (5, 0, 2)])
    first, tables = laid_out(parts, Room(NEAR), lambda wish: wish, "Hall")
    again, more = laid_out(parts, Room(NEAR), lambda wish: f"{wish}_2", "Hall", tables)
    assert again == first
    assert not more
