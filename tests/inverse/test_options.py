"""What a person may ask of an inference: weights, an explanation, similar shapes, tolerances, the
paper's pairs. Each must change what it is meant to change, and nothing by default.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from inverse.synth import copies, drawing, grid, jittered, leaf, rectangle, ring, row, star

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.drawing import CUBIC, DrawnElement, Floats
from ipmlang.formats.svg.write import write_svg
from ipmlang.inverse import infer
from ipmlang.inverse.attempt import Made
from ipmlang.inverse.explanation import Tried
from ipmlang.inverse.lsystem.frames import frames
from ipmlang.inverse.lsystem.importance import Cluster, Measure, Terms
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement
from ipmlang.inverse.lsystem.symmetry import trivial
from ipmlang.inverse.options import Options, Weights, check_options
from ipmlang.inverse.regular import grammar_of


def made_of(elements: Sequence[DrawnElement], options: Options) -> Made:
    return grammar_of(drawing(elements), "x", False, lambda _: None, options)


def text(made: Made) -> str:
    return format_grammar(made.grammar)


def bodies(made: Made) -> list[tuple[ast.Element, ...]]:
    return [item.body for item in made.grammar.items if isinstance(item, ast.Rule)]


def names(body: Sequence[ast.Element]) -> list[str]:
    """The symbols of a body that stand there without a move."""
    return [each.name for each in body if isinstance(each, ast.Module)]


def alternating() -> list[DrawnElement]:
    """A leaf, then six times a star far from the leaf before it and near the next one."""
    elements = copies(leaf(4), row(1, (0, 0), (4, 50)))
    for k in range(6):
        elements += copies(star(5, 2, 1), row(1, (0, 0), (17 + 15 * k, 50)))
        elements += copies(leaf(4), row(1, (0, 0), (19 + 15 * k, 50)))
    return elements


def broken_row() -> list[DrawnElement]:
    """Nine pairs of a leaf and a star, three in each line."""
    elements: list[DrawnElement] = []
    for line in range(3):
        for k in range(3):
            x, y = 10 + 24 * k - 2 * line, 20 + 22 * line
            elements += copies(leaf(4), row(1, (0, 0), (x, y)))
            elements += copies(star(5, 3, 1.2), row(1, (0, 0), (x + 20, y)))
    return elements


def clutter(count: int = 9) -> list[DrawnElement]:
    """Copies of one shape in any place, turn and size: Figure 8b of the paper."""
    random = np.random.default_rng(1)
    at = random.uniform(10, 90, (count, 2))
    turn, size = random.uniform(0, 360, count), random.uniform(0.7, 1.5, count)
    return copies(leaf(5), np.column_stack([at, turn, size, np.ones(count)]))


def wobbly(elements: Sequence[DrawnElement], amount: float) -> list[DrawnElement]:
    """Elements whose curves bend a little otherwise, each on its own."""
    random = np.random.default_rng(2)
    result = []
    for element in elements:
        assert element.outline is not None
        coords = element.outline.coords.copy()
        curved = element.outline.kind == CUBIC
        coords[curved, 1:3] += random.normal(0, amount, (int(curved.sum()), 2, 2))
        result.append(replace(element, outline=replace(element.outline, coords=coords)))
    return result


# -------------------------------------------------------------------------- weights


def test_near_decides_which_of_two_neighbours_belongs_to_a_leaf() -> None:
    usual = made_of(alternating(), Options(explain=True))
    near = made_of(alternating(), Options(Weights(near=10), explain=True))
    assert winner(usual).symbols[0] != winner(near).symbols[0]
    assert winner(near).near > winner(usual).near
    assert text(usual) != text(near)


def test_long_decides_between_pairs_and_lines() -> None:
    usual = made_of(broken_row(), Options(explain=True))
    short = made_of(broken_row(), Options(Weights(long=0), explain=True))
    assert winner(usual).kind == "motif"
    assert winner(short).kind == "pair"
    assert text(usual) != text(short)


def test_similar_puts_equal_shapes_together_first() -> None:
    elements: list[DrawnElement] = []
    for x, y in np.random.default_rng(4).uniform(5, 85, (6, 2)):
        for shape, ahead in ((leaf(4), 0), (leaf(4), 5), (star(5, 2, 1), 9)):
            elements += copies(shape, row(1, (0, 0), (x + ahead, y)))
    assert winner(made_of(elements, Options(explain=True))).kind == "motif"
    alike = winner(made_of(elements, Options(Weights(similar=4), explain=True)))
    assert (alike.kind, len(set(alike.symbols))) == ("pair", 1)


def test_weights_by_themselves_are_neutral() -> None:
    for elements in (alternating(), broken_row(), clutter()):
        usual = made_of(elements, Options())
        asked = made_of(elements, Options(Weights(1, 1, 1, 1), explain=True))
        assert text(usual) == text(asked)
        assert usual.explanation is None


@pytest.mark.parametrize("name", ["near", "similar", "long", "many"])
def test_a_term_counts_as_much_as_its_weight(name: str) -> None:
    half = replace(Terms(1.0, 1.0, 1.0, 1.0), **{name: 0.5})
    assert half.multiplier(Weights()) == 1.0
    assert half.multiplier(replace(Weights(), **{name: 3.0})) == 0.25
    assert half.multiplier(replace(Weights(), **{name: 0.0})) == 2.0


def test_terms_are_measured_on_the_shapes_themselves() -> None:
    alphabet = Alphabet(1e-6)
    for _ in range(3):
        alphabet.add_terminal(trivial(), 5.0)
    at = frames(np.array([0, 12, 40, 60], np.complex128))
    symbols = np.array([0, 1, 1, 2])
    string = Arrangement(symbols, at, np.arange(4), np.zeros(4, np.int64))
    measure = Measure([rectangle(4, 4), rectangle(4, 4), star(5)], 100.0)
    clusters = [
        Cluster(np.array([k]), np.array([k + 1]), 1, length)
        for k, length in ((0, 2.0), (1, 4.0), (2, 2.0))
    ]
    close, far, mixed = measure.terms(alphabet, string, clusters)
    assert close.near == pytest.approx(0.92, abs=0.01)  # 12 units less two halves of 4
    assert far.near == pytest.approx(0.76, abs=0.01)
    assert close.similar == pytest.approx(1.0, abs=0.01)
    assert mixed.similar < 0.7
    assert (close.long, far.long) == (0.5, 1.0)


# ---------------------------------------------------------------------- explanation


def winner(made: Made) -> Tried:
    """The foremost cluster of the first round."""
    assert made.explanation is not None
    return made.explanation.rounds[0].tried[0]


def test_the_explanation_names_what_won_and_what_was_refused() -> None:
    made = made_of(copies(rectangle(3, 20), row(24, (4, 0), (3, 50))), Options(explain=True))
    explanation = made.explanation
    assert explanation is not None
    first = explanation.rounds[0].tried[0]
    assert first.kind in ("sequence", "lattice")
    assert (first.symbols, first.outcome, first.name) == (("rect",), "taken", "RectRow")
    assert first.length == 24
    assert first.gain > 50
    assert "RectRow -->" in text(made)
    assert "-> RectRow" in explanation.text
    assert explanation.chosen == "rules"
    assert dict(explanation.attempts)["flat"] > dict(explanation.attempts)["rules"]


def test_only_rules_that_are_printed_have_names() -> None:
    random = np.random.default_rng(4)
    ladders = [
        copies(rectangle(3, 20), row(6, (4 + k, 0), (40 * k, float(50 + random.uniform(0, 9)))))
        for k in range(6)
    ]
    made = made_of([each for ladder in ladders for each in ladder], Options(explain=True))
    assert made.explanation is not None
    text = format_grammar(made.grammar)
    tried = [trial for told in made.explanation.rounds for trial in told.tried]
    named = {each.name for each in tried if each.name.isidentifier()}
    assert all(name in text for name in named)
    assert any(each.outcome == "taken" for each in tried)


def test_folding_that_is_given_up_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    folding = import_module("ipmlang.inverse.folding.fold")
    monkeypatch.setattr(folding, "MOST_ROWS", 3)
    made = made_of(broken_row(), Options(explain=True))
    assert made.explanation is not None
    assert any("rules with parameters were not looked for" in note for note in made.report.notes)
    assert "note: rules with parameters" in made.explanation.text


def test_what_a_better_cluster_has_taken_is_told() -> None:
    explanation = made_of(broken_row(), Options(explain=True)).explanation
    assert explanation is not None
    outcomes = {each.outcome for each in explanation.rounds[0].tried}
    assert {"taken", "overlaps"} <= outcomes
    records = explanation.as_records()
    assert [each["round"] for each in records] == list(range(1, len(records) + 1))


# ------------------------------------------------------------------------ similarity


def test_similar_copies_become_one_shape() -> None:
    elements = wobbly(copies(leaf(10), row(8, (11, 0), (8, 50))), 0.015)
    exact = made_of(elements, Options())
    ideal = made_of(elements, Options(similarity=0.8))
    assert exact.parts.count("<path") == 8
    assert ideal.parts.count("<path") == 1
    assert (exact.report.mode, ideal.report.mode) == ("exact", "ideal")
    assert exact.report.max_error <= 1e-6 < ideal.report.max_error <= ideal.report.limit < 1e-2


def test_similar_copies_in_a_row_are_a_regular_row() -> None:
    elements = wobbly(copies(leaf(10), row(8, (11, 0), (8, 50))), 0.015)
    made = made_of(elements, Options(similarity=0.8, symmetrize=True))
    assert "repeat(i < curve_row_count) { [curve] f(curve_row_step) }" in text(made)
    assert "curve_row_step  : float = 11 " in text(made)


# ----------------------------------------------------------------------- symmetrize


@pytest.mark.parametrize(
    ("placed", "rule"),
    [
        (row(16, (5, 0), (10, 50)), "f(star_row_step)"),
        (ring(12, 30, (50, 50)), "360 / star_ring_count"),
        (np.add(grid(6, 5, (14, 0), (0, 16)), [10, 15, 0, 0, 0]), "star_column_step"),
    ],
    ids=["row", "ring", "grid"],
)
def test_a_jittered_arrangement_becomes_regular(placed: Floats, rule: str) -> None:
    elements = copies(star(4, 2, 1), jittered(placed, 0.05))
    exact = made_of(elements, Options())
    regular = made_of(elements, Options(symmetrize=True))
    assert rule in text(regular)
    assert regular.report.tokens_flat > 2 * exact_tokens(regular)
    assert rule not in text(exact)
    report = regular.report
    assert report.mode == "within"
    assert 1e-6 < report.max_error <= report.limit
    assert report.rule_errors
    assert max(each.error for each in report.rule_errors) <= report.limit


def exact_tokens(made: Made) -> int:
    return len(text(made).split())


def test_within_bounds_what_may_be_off() -> None:
    elements = copies(star(4, 2, 1), jittered(row(16, (5, 0), (10, 50)), 0.05))
    wide = made_of(elements, Options(within=2e-3))
    narrow = made_of(elements, Options(within=1e-5))
    assert "star_row_step" in text(wide)
    assert wide.report.max_error <= 2e-3
    assert "star_row_step" not in text(narrow)
    assert narrow.report.max_error <= 1e-5


def test_a_regular_drawing_stays_what_it_is_when_symmetrized() -> None:
    elements = copies(rectangle(3, 8), row(10, (6, 0), (10, 50)))
    usual, regular = (made_of(elements, Options(symmetrize=on)) for on in (False, True))
    assert text(usual) == text(regular)
    assert regular.report.max_error <= 1e-6


# ---------------------------------------------------------------------------- paper


def test_the_paper_prints_the_pairs_of_clutter() -> None:
    usual, paper = (made_of(clutter(), Options(paper=on)) for on in (False, True))
    assert usual.report.rules == 0
    assert paper.report.rules == 8  # nine elements, joined two at a time until one symbol is left
    assert all(len(body) == 2 for body in bodies(paper))
    assert paper.report.max_error <= 1e-6


# ---------------------------------------------------------------------------- ranges


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (Options(Weights(near=-1)), "`near` must be from 0 to 10, not -1"),
        (Options(Weights(many=math.inf)), "`many` must be from 0 to 10, not inf"),
        (Options(similarity=0.5), "from 0.6 to 1, not 0.5"),
        (Options(similarity=math.nan), "from 0.6 to 1, not nan"),
        (Options(within=0.0), "from 1e-06 to 0.1, not 0"),
    ],
)
def test_values_out_of_range_are_refused_with_the_range(options: Options, says: str) -> None:
    with pytest.raises(IpmError) as caught:
        check_options(options)
    assert says in caught.value.diagnostics[0].message


def test_the_options_go_through_both_interfaces(tmp_path: Path) -> None:
    path = tmp_path / "row.svg"
    noisy = copies(star(4, 2, 1), jittered(row(12, (5, 0), (10, 50)), 0.05))
    path.write_text(write_svg(drawing(noisy)), encoding="utf-8")
    assert infer(path).report.mode == "exact"
    found = ipmlang.infer(path, symmetrize=True, weights=Weights(long=2), explain=True)
    assert found.report.mode == "within"
    assert found.explanation is not None
    assert "being allowed; most of it in StarRow." in found.text
    with pytest.raises(IpmError):
        infer(path, similarity=0.1)
