"""Rules found in made-up arrangements: each must come out as the one rule a person would write, and
what has no structure must come out without any.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from inverse.synth import (
    circle,
    copies,
    drawing,
    grid,
    jittered,
    leaf,
    line,
    mirror_cell,
    rectangle,
    ring,
    row,
    scaled,
    star,
)

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import Drawing, DrawnElement, Style
from ipmlang.inverse.attempt import Made, best_grammar

RED = Style(fill="#ff0000")


def made_of(elements: Sequence[DrawnElement], flat: bool = False) -> Made:
    return best_grammar(drawing(elements), "x", flat, lambda _: None)


def repeats(made: Made) -> list[ast.Repeat]:
    """All repeats of all rules, also those in one another."""
    rules = [item for item in made.grammar.items if isinstance(item, ast.Rule)]
    return [each for rule in rules for each in _repeats_in(rule.body)]


def _repeats_in(body: Sequence[ast.Element]) -> Iterator[ast.Repeat]:
    for element in body:
        if isinstance(element, ast.Repeat):
            yield element
        if isinstance(element, ast.Repeat | ast.Bracket):
            yield from _repeats_in(element.body)


def text(made: Made) -> str:
    return format_grammar(made.grammar)


def test_row_of_pickets_is_one_repeat() -> None:
    made = made_of(copies(rectangle(3, 20), row(24, (4, 0), (3, 50))))
    assert made.report.rules == 1
    assert made.report.explained == 1.0
    assert "repeat(i < rect_row_count) { [rect] f(rect_row_step) }" in text(made)
    assert "rect_row_count : int   = 24" in text(made)
    assert "= 4 " in text(made)


def test_column_goes_up_in_equal_steps() -> None:
    made = made_of(copies(leaf(5), row(9, (0, 7), (50, 5))))
    assert made.report.rules == 1
    assert "[curve] at(0, curve_column_step)" in text(made)


def test_grid_is_a_repeat_of_a_repeat() -> None:
    made = made_of(copies(star(5), grid(7, 5, (12, 0), (0, 15))))
    assert len(repeats(made)) == 2
    assert made.report.explained == 1.0
    assert made.report.tokens_flat > 4 * 50


def test_skewed_grid_too() -> None:
    made = made_of(copies(leaf(4), grid(6, 4, (9, 2), (-3, 11))))
    assert len(repeats(made)) == 2
    assert made.report.explained == 1.0


def test_grid_of_turned_pairs_is_a_grid() -> None:
    """Pairs that save nothing by themselves do so as a row; no rule only names another."""
    places = grid(9, 12, (24, 0), (0, 11))
    turned = places + np.array([9.0, 6, 90, 0, 0])
    both = np.stack([places, turned], axis=1).reshape(-1, places.shape[1])
    made = made_of(copies(rectangle(2, 12), both))
    assert len(repeats(made)) == 2
    rules = [each for each in made.grammar.items if isinstance(each, ast.Rule)]
    assert len(rules) == 2
    assert made.report.tokens_flat > 15 * count_text_tokens(text(made))


@pytest.mark.parametrize("shape", [leaf(6), rectangle(6, 6), circle(3), rectangle(4, 8)])
def test_ring_turns_about_its_centre(shape: object) -> None:
    made = made_of(copies(shape, ring(12, 30, (50, 50))))  # type: ignore[arg-type]
    assert made.report.rules == 1
    assert "360 / " in text(made)
    assert "at(50, 50" in text(made)


@pytest.mark.parametrize("count", [7, 34])
def test_a_ring_closes_whatever_its_step(count: int) -> None:
    made = made_of(copies(leaf(6), ring(count, 30, (50, 50))))
    assert "360 / curve_ring_count * i" in text(made)


def test_a_stack_that_turns_once_around_says_so() -> None:
    arm = [*copies(line(30), ring(6, 0, (50, 50)))]
    twig = [*copies(line(9), ring(6, 20, (50, 50)))]
    made = made_of([each for pair in zip(arm, twig, strict=True) for each in pair])
    assert "360 / motif_stack_count * i" in text(made)


def test_arc_of_a_ring_is_not_closed() -> None:
    made = made_of(copies(leaf(6), ring(12, 30, (50, 50))[:7]))
    assert made.report.rules == 1
    assert "30 * i" in text(made)


def test_sequence_that_shrinks_and_turns() -> None:
    made = made_of(copies(leaf(6), scaled(12, 1.5, 0.9, 13)))
    assert made.report.rules == 1
    assert "*(0.9)" in text(made)


def test_spiral_with_a_turn_that_grows() -> None:
    placed = np.zeros((14, 5))
    placed[:, 3:] = 1
    at, heading = 20 + 40j, 0.0
    for index in range(14):
        placed[index, :3] = at.real, at.imag, heading
        at += 5 * np.exp(1j * np.deg2rad(heading))
        heading += 4 + 3 * index
    made = made_of(copies(rectangle(4, 2), placed))
    assert made.report.rules == 1
    assert "* i)" in text(made)


def test_concentric_circles_grow_by_equal_steps() -> None:
    placed = np.tile([50.0, 50.0, 0, 1, 1], (8, 1))
    placed[:, 3] = 1 + 0.5 * np.arange(8)
    made = made_of(copies(circle(5), placed))
    assert made.report.rules == 1
    assert "*(1 + 0.5 * i)" in text(made)


def test_rows_of_different_lengths_share_a_rule() -> None:
    rows = [row(count, (6, 0), (4, 10 + 9 * count)) for count in (5, 6, 8)]
    made = made_of([each for placed in rows for each in copies(leaf(3), placed)])
    assert made.report.rules == 1
    assert "(n) --> repeat(i < n)" in text(made)


def test_motif_of_different_shapes_is_a_group() -> None:
    elements = []
    for x, y in ((10, 10), (44, 13), (31, 60), (80, 71), (63, 22)):
        elements += copies(leaf(5), row(1, (0, 0), (x, y)))
        elements += copies(circle(2), row(1, (0, 0), (x + 6, y + 1)), RED)
        elements += copies(star(5), row(1, (0, 0), (x + 3, y + 9)))
    made = made_of(elements)
    assert made.report.rules == 1
    assert made.report.rules_twice == 1
    assert made.report.explained == 1.0


def test_mirror_image_of_loose_lines_is_one_motif_twice() -> None:
    cell = jittered(row(60, (0.7, 0.4), (3, 20)), 6, 3)
    cell[:, 2] = np.random.default_rng(1).uniform(-180, 180, 60)
    made = made_of(copies(line(3), mirror_cell(cell, 50)))
    assert made.report.rules == 1
    assert "mirror" in text(made)
    assert made.report.explained == 1.0


def test_paint_order_is_kept_where_shapes_alternate_irregularly() -> None:
    shapes = [leaf(5), star(5), circle(2)]
    order = np.random.default_rng(4).integers(0, 3, 40)
    elements = [
        copies(shapes[kind], row(1, (0, 0), (2.1 * index, 3 + 2 * index)))[0]
        for index, kind in enumerate(order.tolist())
    ]
    made = made_of(elements)
    assert made.report.max_error < 1e-6


def test_slight_noise_stands_beside_the_rule() -> None:
    made = made_of(copies(leaf(5), jittered(row(50, (1.7, 1)), 0.01, 3)))
    assert made.report.rules == 1
    assert made.report.max_error < 1e-6
    assert "with r in" in text(made)


@pytest.mark.parametrize("amount", [0.5, 3])
def test_noise_is_not_taken_for_a_pattern(amount: float) -> None:
    made = made_of(copies(leaf(5), jittered(row(50, (1.7, 1)), amount, 3)))
    flat = made_of(copies(leaf(5), jittered(row(50, (1.7, 1)), amount, 3)), flat=True)
    assert made.report.rules == 0
    assert made.report.tokens_flat == flat.report.tokens_flat


def test_steps_that_are_equal_by_chance_make_no_rule() -> None:
    random = np.random.default_rng(7)
    places = row(1500, (0, 0))
    places[:, :2] = random.uniform(0, 100, (1500, 2)).round(2)
    made = made_of(copies(circle(1), places))
    assert made.report.rules == 0


def test_uneven_steps_are_listed() -> None:
    placed = row(9, (0, 0), (5, 50))
    placed[:, 0] += np.cumsum([0, 8, 7, 8, 9, 8, 7, 7, 9])
    made = made_of(copies(leaf(5), placed))
    assert "steps (8, 7, 8, 9, 8, 7, 7, 9)" in text(made)


def test_two_runs_give_the_same_bytes() -> None:
    def make() -> tuple[str, str]:
        made = made_of(copies(star(5), grid(7, 5, (12, 0), (0, 15))))
        return text(made), made.parts

    assert make() == make()


def test_empty_drawing() -> None:
    made = best_grammar(Drawing((), (0, 0, 10, 10)), "x", False, lambda _: None)
    assert made.report.elements == 0
    assert "start Drawing" in text(made)
