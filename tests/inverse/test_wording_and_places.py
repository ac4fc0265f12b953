"""How found rules are put: rows whose lengths change, parts that lie in their file as in the thing,
lines in smaller copies, and what counts and steps are called.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from inverse.synth import circle, copies, drawing, grid, leaf, line, polygon, star

import ipmlang
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.drawing import DrawnElement, Floats, Outline, Style
from ipmlang.inverse import infer
from ipmlang.inverse.attempt import best_grammar

PEN = Style(fill="none", stroke="#204060")


def text_of(elements: list[DrawnElement]) -> str:
    """The proven grammar of a drawing."""
    made = best_grammar(drawing(elements), "x", False, lambda _: None)
    return format_grammar(made.grammar)


def placements(at: list[tuple[float, float]]) -> Floats:
    places = np.zeros((len(at), 5))
    places[:, :2], places[:, 3:] = at, 1
    return places


def triangle(growing: bool, about: tuple[float, float] = (0, 0)) -> list[tuple[float, float]]:
    """Seven rows of one to seven, in one order or the other."""
    rows = range(1, 8) if growing else range(7, 0, -1)
    return [
        (about[0] + 12 * i + 5 * k, about[1] + 9 * k)
        for k, count in enumerate(rows)
        for i in range(count)
    ]


@pytest.mark.parametrize("shape", [leaf(4), circle(3), star(5)])
@pytest.mark.parametrize("growing", [False, True])
def test_rows_of_lengths_that_change_evenly_are_a_repeat(shape: Outline, growing: bool) -> None:
    text = text_of(copies(shape, placements(triangle(growing))))
    assert "repeat(i < 7)" in text
    assert ("Row(1 + i)" if growing else "Row(7 - i)") in text
    assert text.count("Row(") == 2


def test_a_triangle_that_comes_again_is_one_rule() -> None:
    places = triangle(False) + triangle(False, (110, 31))
    text = text_of(copies(leaf(4), placements(places)))
    assert len(re.findall(r"\[at\([^)]*\) Motif\]", text)) == 2
    assert "Row(7 - i)" in text


def test_parts_of_a_thing_lie_in_their_file_as_they_do_in_the_thing() -> None:
    parts = [leaf(7), star(5), polygon([(0, 0), (9, 1), (3, 6)])]
    offsets = [(0.0, 0.0), (11.3, 4.1), (-6.2, 8.7)]
    elements = []
    for x, y in ((20, 30), (83, 41), (57, 90)):
        for part, (right, up) in zip(parts, offsets, strict=True):
            elements += copies(part, placements([(x + right, y + up)]))
    body = next(each for each in text_of(elements).splitlines() if each.startswith("Motif"))
    assert "at(" not in body
    assert len(body.split("-->")[1].split()) == 3


def test_lines_of_a_thing_that_stands_smaller_elsewhere_are_its_own() -> None:
    elements = []
    for x, size in ((20.0, 1.0), (70.0, 0.6), (85.0, 1.5)):
        places = placements([(x, 50)])
        places[:, 3] = size
        for part, style in ((line(17), PEN), (leaf(7), Style()), (star(5), Style())):
            elements += copies(part, places, style)
    text = text_of(elements)
    assert "line_2" not in text
    assert text.count("Motif]") == 3


def test_a_grid_has_rows_and_columns() -> None:
    text = text_of(copies(star(5), grid(7, 5, (12, 0), (0, 15))))
    assert re.search(r'attr star_rows +: int +=\s+5 +in 1\.\. "rows of stars"', text)
    assert re.search(r'attr star_columns +: int +=\s+7 +in 1\.\. "stars in a row"', text)
    assert re.search(r'attr star_row_step +: float = -?15 +"from one row to the next"', text)


def test_pens_are_as_wide_as_they_were_told_to_be(tmp_path: Path) -> None:
    path = tmp_path / "a.ipm"
    path.write_text("ipm 1\ncanvas (0, 0, 9, 9)\nturtle step 2 width 0.8\nstart F")
    out = path.with_suffix(".svg")
    ipmlang.save(ipmlang.load(path).run(), out)
    assert 'stroke-width="0.8"' in out.read_text()


def test_rounded_shapes_have_their_names(tmp_path: Path) -> None:
    """Ids that programs give by themselves say nothing."""
    source = tmp_path / "drawn.svg"
    source.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100">'
        '<rect class="cls-1" x="10" y="10" width="30" height="20" rx="4"/>'
        '<rect id="patch_7" x="50" y="10" width="30" height="12" rx="6"/>'
        '<path class="st0" d="M100 30L120 30A20 20 0 0 0 114 16z"/>'
        '<path d="M10 60h20v10c0 5-5 10-10 10h-10z"/></svg>'
    )
    assert "asset rect, pill, sector, curve in" in infer(source).text
