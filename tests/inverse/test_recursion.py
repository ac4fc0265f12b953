"""L-systems recovered from what their turtles drew: textbook systems, plants drawn by chance, real
drawings, noise. Every grammar that comes out is run by the engine and compared segment by segment.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from inverse.textbook import PAGE_28, STOCHASTIC, SYSTEMS, Complexes, drawn, system

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.drawing import DrawnElement
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse.recursion import Recursion, as_grammar, fold, segments


def text_of(recursion: Recursion) -> str:
    return format_grammar(ast.Grammar((ast.Version(1), *as_grammar(recursion))))


def off(text: str, start: Complexes, end: Complexes) -> float:
    """How far the engine's drawing of a grammar is off, as a share of the diagonal."""
    again = drawn(text)
    assert len(again[0]) == len(start)
    points = np.concatenate([start, end])
    diagonal = abs(complex(np.ptp(points.real), np.ptp(points.imag)))
    gap = np.abs(np.concatenate(again) - points)
    return float(gap.max()) / diagonal


def lines(path: Path) -> tuple[Complexes, Complexes, np.ndarray]:
    """The single lines of a drawing, y up, with the numbers of their styles."""
    drawing = split_compound(read_svg(path))
    found: list[DrawnElement] = [
        each
        for each in drawing.elements
        if each.outline is not None and len(each.outline.kind) == 1
    ]
    got = segments([each.outline for each in found if each.outline is not None], 0.0)
    assert got is not None
    known: dict[object, int] = {}
    styles = [known.setdefault(each.style, len(known)) for each in found]
    return got.start, got.end, np.array(styles, np.int64)


@pytest.mark.parametrize("name", SYSTEMS)
def test_textbook_system_is_recovered_as_short_as_it_was_written(name: str) -> None:
    start, end = drawn(SYSTEMS[name])
    found = fold(start, end)
    assert found is not None
    text = text_of(found)
    assert off(text, start, end) < 1e-6
    assert count_text_tokens(text) <= 1.4 * count_text_tokens(SYSTEMS[name])


def test_weed_reads_as_published() -> None:
    found = fold(*drawn(SYSTEMS["weed, 1.24a"]))
    assert found is not None
    assert text_of(found) == (
        "ipm 1\nturtle angle 25.7\nF --> F [+ F] F [- F] F\nstart F steps 4\n"
    )


@pytest.mark.parametrize("places", [4, 2, 1])
@pytest.mark.parametrize("name", ["plant, 1.24f", "Gosper, 1.11a", "shrinking tree"])
def test_rounded_points_change_nothing_but_numbers(name: str, places: int) -> None:
    start, end = drawn(SYSTEMS[name])
    size = 800 / max(np.ptp(start.real), np.ptp(start.imag))
    start, end = (np.round(points * size + 13.37 + 5j, places) for points in (start, end))
    found = fold(start, end, tolerance=1.5 * 10.0**-places / 1000)
    assert found is not None
    assert found.steps == fold(*drawn(SYSTEMS[name])).steps
    assert off(text_of(found), start, end) < 4 * 10.0**-places / 1000


def test_real_dragon_is_two_rules(data: Path) -> None:
    start, end, _ = lines(data / "svg" / "lsys_dragon.svg")
    found = fold(start, end)
    assert found is not None
    text = text_of(found)
    assert off(text, start, end) < 1e-6
    assert len(text.encode()) <= 300


def test_real_plant_is_two_rules_whatever_its_colours(data: Path) -> None:
    start, end, styles = lines(data / "svg" / "lsys_plant.svg")
    found = fold(start, end, styles=styles)
    assert found is not None
    assert not found.styles
    text = text_of(found)
    assert off(text, start, end) < 1e-6
    assert len(text.encode()) <= 500
    assert found.angle == 25


def test_real_stochastic_plant_has_three_alternatives(data: Path) -> None:
    start, end, styles = lines(data / "svg" / "lsys_plant_stochastic.svg")
    found = fold(start, end, styles=styles)
    assert found is not None
    ((_, alternatives),) = found.alternatives.items()
    assert len(alternatives) == 3
    assert all(abs(each.percent - 100 / 3) < 5 for each in alternatives)
    text = text_of(found)
    assert off(text, start, end) < 1e-6
    assert len(text.encode()) <= 4000


@pytest.mark.parametrize(
    ("angle", "start", "steps", "rules"),
    [
        (90, "A", 9, {"A": "A + B +", "B": "- A - B"}),
        (25, "X", 6, {"X": "F [+ X] [- X] G X", "F": "F F", "G": "F F"}),
        (120, "F - G - G", 5, {"F": "F - G + F + G - F", "G": "G G"}),
    ],
)
def test_symbols_of_their_own_colours_are_kept(
    angle: float, start: str, steps: int, rules: dict[str, str]
) -> None:
    text = system(angle, start, steps, **rules)
    text += 'interpret F --> color("#000000") F\n' if "F" in rules else ""
    text = text.replace("interpret A --> F", 'interpret A --> color("#000000") F')
    for head in "BG":
        text = text.replace(f"interpret {head} --> F", f'interpret {head} --> color("#000001") F')
    styles = ipmlang.parse(text).run().instances.color >> 8
    assert set(styles.tolist()) == {0, 1}
    points = drawn(text)
    found = fold(*points, styles=styles.astype(np.int64))
    assert found is not None
    assert len(set(found.styles.values())) == 2
    pens = {k: (ast.Module("color", (ast.Argument(ast.Text(f"#00000{k}")),)),) for k in (0, 1)}
    items = as_grammar(found, pens=pens)
    again = ipmlang.parse(format_grammar(ast.Grammar((ast.Version(1), *items)))).run().instances
    assert np.array_equal(again.color >> 8, styles)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_alternatives_and_their_draws_are_found(seed: int) -> None:
    start, end = drawn(STOCHASTIC, seed)
    found = fold(start, end)
    assert found is not None
    ((_, alternatives),) = found.alternatives.items()
    assert sum(each.percent for each in alternatives) == 100
    text = text_of(found)
    for body in ("F [+ X] F [- X] X", "F [- X] F X", "F [+ X] [- X] F [+ F X] - X"):
        assert f"% --> {body}\n" in text
    assert off(text, start, end) < 1e-6


@pytest.mark.parametrize("seed", [1, 2])
def test_weed_of_page_28_is_read_from_its_twigs(seed: int) -> None:
    start, end = drawn(PAGE_28, seed)
    found = fold(start, end)
    assert found is not None
    text = text_of(found)
    for body in ("F [+ F] F [- F] F", "F [+ F] F", "F [- F] F"):
        assert f"% --> {body}\n" in text
    assert off(text, start, end) < 1e-6


def test_random_lines_have_no_rule(data: Path) -> None:
    start, end, _ = lines(data / "svg" / "vpype_7k_lines.svg")
    assert fold(start, end) is None


@pytest.mark.parametrize("count", [1, 5, 64, 729])
def test_noise_has_no_rule(count: int) -> None:
    random = np.random.default_rng(count)
    walk = np.cumsum(1j ** random.integers(0, 4, count + 1))
    assert fold(walk[:-1], walk[1:]) is None


def test_one_wrong_segment_is_noticed() -> None:
    start, end = drawn(SYSTEMS["Koch curve"])
    end[500] += 0.1
    assert fold(start, end) is None


def test_lengths_of_zero_are_no_drawing() -> None:
    start = np.zeros(64, np.complex128)
    assert fold(start, start.copy()) is None


def test_a_symbol_may_not_take_a_name_of_the_file() -> None:
    found = fold(*drawn(system(20, "X", 6, X="F [+ X] F [- X] + X", F="F F")))
    assert found is not None
    heads = [
        each.head.name for each in as_grammar(found, frozenset({"X"})) if isinstance(each, ast.Rule)
    ]
    assert heads == ["X1", "F"]
