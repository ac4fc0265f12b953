"""Parts in frames as text: rows stay rows, copies become tables, numbers no longer than needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.edit.buildings.rows import Part, Room, laid_out
from ipmlang.inverse.frames import identity, moved_to

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


def test_mirrored_copies_are_a_table_of_their_own() -> None:
    mirrored = replace(identity(), hand=np.array([-1.0]))
    parts = posts([(k * k, 0, 0) for k in range(5)])
    parts += [(replace(mirrored, position=frame.position), inner) for frame, inner in parts]
    text = written(parts)
    assert text.count("table ") == 2
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
