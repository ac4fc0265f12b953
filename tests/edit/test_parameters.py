"""Parameters set: attributes, constants, turtle settings, and numbers anywhere in rules."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ipmlang import IpmError, edit
from ipmlang.edit import Selection

Where = Callable[[Path, str], NDArray[np.float64]]


def test_attributes_and_constants_move_what_they_should(house: Path, where: Where) -> None:
    out = house.with_name("wide.ipm")
    edit.save(edit.set_values(edit.read(house), {"columns": 6, "step": 15, "rise": 30}), out)
    frames = where(out, "frame")
    assert len(frames) == 12
    assert np.allclose(frames[:6, 0], 20 + 15 * np.arange(6))
    assert np.allclose(np.unique(frames[:, 1]), [12, 42])


def test_an_expression_and_a_text_are_values(house: Path) -> None:
    draft = edit.set_values(edit.read(house), {"rise": "columns * 6", "style": "rich"})
    assert "const rise = columns * 6" in draft.text
    assert '"rich" in { "plain", "rich" }' in draft.text


def test_turtle_settings_are_parameters_too(house: Path) -> None:
    draft = edit.set_values(edit.read(house), {"turtle.angle": 45})
    assert "turtle angle 45 step 2" in draft.text


def test_a_number_of_a_rule_is_set(house: Path, where: Where) -> None:
    draft = edit.change(edit.read(house), Selection("Wreath", "f"), to=9)
    out = house.with_name("out.ipm")
    edit.save(draft, out)
    assert np.allclose(np.hypot(*(where(out, "leaf") - (60, 70)).T), 9)


def test_a_factor_scales_all_numbers_of_a_rule(house: Path) -> None:
    draft = edit.change(edit.read(house), Selection("Window"), factor=2)
    assert "Window --> frame [at(-6, 0) pane] [at(6.02, 0) pane]" in draft.text
    assert len(draft.changes) == 2  # 0 stays 0


def test_a_factor_of_what_is_computed_stands_in_front(house: Path) -> None:
    chosen = Selection("Wreath", "left")  # the other name of `+`
    draft = edit.change(edit.read(house), chosen, factor=0.5)
    draft = edit.change(draft, chosen, factor=3)
    assert "+(90 * i)" in edit.change(edit.read(house), chosen, to="90 * i").text
    assert "+(90 * i)" in draft.text


@pytest.mark.parametrize(
    ("selection", "changed"),
    [
        (Selection("Window", "at", "x"), 2),
        (Selection("Window", "at", "x", 2), 1),
        (Selection("House", "at", "y"), 3),
        (Selection(None, "repeat", "count"), 2),
        (Selection("start", "at"), 2),
    ],
)
def test_selections_mean_what_they_say(house: Path, selection: Selection, changed: int) -> None:
    assert len(edit.change(edit.read(house), selection, to=1).changes) == changed


def test_the_parameters_of_symbols_have_the_names_of_the_head() -> None:
    draft = edit.read_text("ipm 1\nP(m) : m > 0 --> F(1) P(m - 1)\nP(m) : else --> nil\nstart P(4)")
    draft = edit.change(draft, Selection("start", "P", "m"), to=7)
    assert draft.text.endswith("start P(7)\n")


def test_probabilities_are_parameters() -> None:
    draft = edit.read_text("ipm 1\nA : 30% --> F\nA : else --> nil\nstart A A")
    assert "A : 60%" in edit.change(draft, Selection("A", "percent"), to=60).text


def test_comments_and_the_rest_of_the_text_stay(house: Path) -> None:
    before = house.read_text(encoding="utf-8").splitlines()
    after = edit.set_values(edit.read(house), {"columns": 5}).text.splitlines()
    different = [k for k, pair in enumerate(zip(before, after, strict=True)) if pair[0] != pair[1]]
    assert [before[k].split()[1] for k in different] == ["columns"]


def test_the_same_edit_twice_is_that_edit_once(house: Path) -> None:
    once = edit.set_values(edit.read(house), {"columns": 5})
    twice = edit.set_values(once, {"columns": 5})
    assert twice.text == once.text
    assert twice.changes == once.changes


def test_every_wrong_name_is_told(house: Path) -> None:
    with pytest.raises(IpmError) as caught:
        edit.set_values(edit.read(house), {"colums": 5, "stp": 1, "columns": 99})
    found = caught.value.diagnostics
    assert [each.suggestions[:1] for each in found] == [("columns",), ("step",), ()]
    assert found[2].code == "attribute-out-of-range"


def test_what_is_wrong_with_the_result_is_told_and_nothing_is_written(house: Path) -> None:
    out = house.with_name("out.ipm")
    draft = edit.change(edit.read(house), Selection("Wreath", "f"), to="no_such_name")
    with pytest.raises(IpmError, match="no_such_name"):
        edit.save(draft, out)
    assert not out.exists()
