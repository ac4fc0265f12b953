"""Terminals and non-terminals replaced, by assets, symbols and other grammars."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import ipmlang
from ipmlang import IpmError, edit
from ipmlang.edit.trial import box_of
from ipmlang.formats.drawing import Drawing

Where = Callable[[Path, str], NDArray[np.float64]]
Drawn = Callable[[Path], Drawing]


def boxes(drawing: Drawing, fill: str) -> NDArray[np.float64]:
    """The boxes (n, 4) of what has a colour."""
    found = [each for each in drawing.elements if each.style.fill == fill]
    return np.array([box_of(Drawing((each,))) for each in found])


def test_an_asset_takes_the_frame_of_another(house: Path, where: Where) -> None:
    out = house.with_name("out.ipm")
    before = where(house, "leaf")
    edit.save(edit.replace_terminal(edit.read(house), "leaf", "flower.svg#f1"), out)
    text = out.read_text(encoding="utf-8")
    assert 'asset f1 = "flower.svg#f1"' in text
    assert "f(5) f1]" in text
    assert 'asset wall, pane, frame in "house.parts.svg"' in text
    assert np.allclose(where(out, "f1"), before)


def test_fitting_fills_the_box_of_what_stood_there(house: Path, drawn: Drawn) -> None:
    out = house.with_name("out.ipm")
    before = boxes(drawn(house), "#ffffff")
    draft = edit.replace_terminal(edit.read(house), "frame", "flower.svg#f1", fit=True)
    edit.save(draft, out)
    after = boxes(drawn(out), "#dd3333")
    assert len(after) == len(before) == 8
    assert np.allclose(after[:, 3], before[:, 3])  # the longer side
    middle = before[:, :2] + before[:, 2:] / 2
    assert np.allclose(after[:, :2] + after[:, 2:] / 2, middle, atol=1e-4)


def test_a_scale_is_one_of_the_frame(house: Path, drawn: Drawn) -> None:
    out = house.with_name("out.ipm")
    edit.save(edit.replace_terminal(edit.read(house), "wall", "flower.svg", scale=0.5), out)
    assert "[at(60, 30) *(0.5) flower]" in out.read_text(encoding="utf-8")
    assert np.allclose(boxes(drawn(out), "#dd3333")[0], [70, 60, 30, 30])


def test_a_symbol_of_the_grammar_will_do(house: Path, where: Where) -> None:
    out = house.with_name("out.ipm")
    edit.save(edit.replace_terminal(edit.read(house), "leaf", "Window", scale=0.2), out)
    assert len(where(out, "frame")) == 8 + 6


def test_several_uses_that_are_scaled_share_a_rule(house: Path) -> None:
    draft = edit.replace_terminal(edit.read(house), "pane", "leaf", scale=2)
    assert "Leaf   --> [*(2) leaf]" in draft.text
    assert "Window --> frame [at(-3, 0) Leaf] [at(3.01, 0) Leaf]" in draft.text


def test_the_axiom_of_another_grammar(house: Path, drawn: Drawn) -> None:
    out = house.with_name("out.ipm")
    draft = edit.replace_terminal(edit.read(house), "leaf", str(house.with_name("star.ipm")))
    saved = edit.save(draft, out)
    assert saved.terminals == 1 + 8 * 3 + 6
    text = out.read_text(encoding="utf-8")
    assert 'import "out.star" as star' in text
    # Its `turtle` item would not hold where it is imported: the adapted copy says it all.
    assert "F(10) +(144)" in house.with_name("out.star.ipm").read_text(encoding="utf-8")
    alone = drawn(house.with_name("star.ipm")).elements[0].outline
    star = next(e.outline for e in drawn(out).elements if len(e.outline.kind) == len(alone.kind))
    assert np.allclose(
        np.ptp(star.coords[:, 0], axis=0).max(), np.ptp(alone.coords[:, 0], axis=0).max()
    )


def test_what_another_grammar_sets_can_be_set(house: Path) -> None:
    out = house.with_name("out.ipm")
    edit.save(edit.replace_terminal(edit.read(house), "leaf", "star.ipm"), out)
    scene = ipmlang.load(out).run(attrs={"star.points": 7})
    assert {len(each) for each in scene.polygons} == {7, 8} or len(scene.polygons) == 6


def test_names_that_clash_are_avoided(house: Path) -> None:
    text = house.read_text(encoding="utf-8").replace("const rise", "const star")
    house.write_text(text.replace("+ rise", "+ star"), encoding="utf-8")
    draft = edit.replace_terminal(edit.read(house), "leaf", "star.ipm")
    assert 'import "star" as star_2' in draft.text
    assert "star_2.Star" in draft.text


def test_files_from_elsewhere_come_along(house: Path, tmp_path: Path, drawn: Drawn) -> None:
    there = tmp_path / "elsewhere"
    there.mkdir()
    shutil.move(house.with_name("flower.svg"), there / "flower.svg")
    shutil.copy(house.with_name("star.ipm"), there / "other.ipm")
    draft = edit.replace_terminal(edit.read(house), "leaf", str(there / "flower.svg"))
    draft = edit.replace_terminal(draft, "pane", str(there / "other.ipm"), scale=0.1)
    out = house.with_name("out.ipm")
    edit.save(draft, out)
    shutil.rmtree(there)
    assert len(drawn(out).elements) == 31


def test_a_rule_is_replaced_at_any_level(house: Path, where: Where) -> None:
    out = house.with_name("out.ipm")
    draft = edit.replace_rule(edit.read(house), edit.symbol("Storey"), "flower.svg", scale=0.1)
    edit.save(draft, out)
    assert np.allclose(where(out, "flower"), [[20, 12], [20, 36]])
    text = out.read_text(encoding="utf-8")
    for gone in ("Storey", "Window", "frame", "pane", "columns", "step :"):
        assert gone not in text
    assert "Wreath" in text and "// the front" in text


def test_only_the_use_with_these_arguments(tmp_path: Path) -> None:
    text = "ipm 1\nP(m) : m > 0 --> F(1) P(m - 1)\nP(m) : else --> nil\nstart [P(4)] [P(2)] leaf"
    draft = edit.replace_rule(edit.read_text(text), edit.symbol("P(2)"), "leaf")
    assert draft.text.endswith("start [P(4)] [leaf] leaf\n")
    assert "P(m - 1)" in draft.text


def test_under_a_number_of_steps_nothing_is_expanded_later(house: Path) -> None:
    text = "ipm 1\nF --> F [+ leaf] F [- leaf]\nstart F steps 3"
    draft = edit.read_text(text, folder=house.parent)
    scaled = edit.replace_terminal(draft, "leaf", "flower.svg", scale=0.1)
    assert "F --> F [+ *(0.1) flower] F [- *(0.1) flower]" in scaled.text
    with pytest.raises(IpmError, match="fixed number of steps"):
        edit.replace_terminal(draft, "leaf", "star.ipm")


def test_an_axiom_that_means_nothing_elsewhere_is_refused(house: Path) -> None:
    house.with_name("koch.ipm").write_text(
        "ipm 1\nF --> F + F\nstart F steps 3\n", encoding="utf-8"
    )
    with pytest.raises(IpmError, match="takes a fixed number of steps"):
        edit.replace_terminal(edit.read(house), "leaf", "koch.ipm")


def test_a_circle_is_refused(house: Path) -> None:
    for by in ("Window", "Storey"):
        with pytest.raises(IpmError, match=f"`{by}` is made of `frame`"):
            edit.replace_terminal(edit.read(house), "frame", by)


def test_rows_of_a_table_place_another_symbol() -> None:
    """By its name; what is more than one thing becomes a rule, for a cell holds no more."""
    head = "ipm 1\ntable T(shape, x) =\n    A, 1\n    B, 5\n    A, 9\nA --> F(1)\nB --> F(2)\n"
    draft = edit.read_text(f"{head}start repeat(r in T) {{ [f(r.x) r.shape] }} [A]")
    whole = edit.replace_rule(draft, edit.Symbol("A"), "B").text
    assert "A" not in whole
    assert whole.count("B") == 5
    half = edit.replace_rule(draft, edit.Symbol("A"), "B", scale=0.5)
    assert "B_2, 1" in half.text and "B_2, 9" in half.text
    assert "B_2 --> [*(0.5) B]" in half.text


GIVEN = """\
ipm 1
Row(s, n) : n > 0 --> s f(1) Row(if n > 2 then s else Bud, n - 1)
Row(s, n) : else  --> [s]
Leaf --> F(1) + F(0.5)
Bud  --> F(2)
start Row(Leaf, 3) [Row(Tip, 2)] Leaf
"""


def test_symbols_that_rules_are_given_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.ipm").write_text(GIVEN, encoding="utf-8")
    draft = edit.read(tmp_path / "a.ipm")
    twice = edit.replace_rule(draft, edit.symbol("Leaf"), "Bud").text
    assert "Leaf_2 --> [Bud]" in twice  # behind a symbol that is given the turtle may go on
    assert "start Row(Leaf_2, 3) [Row(Tip, 2)] Bud" in twice
    assert "\nLeaf " not in twice
    scaled = edit.replace_terminal(draft, "Tip", "Bud", scale=2).text
    assert "--> [*(2) Bud]" in scaled
    assert "start Row(Leaf, 3) [Row(Bud_2, 2)] Leaf" in scaled


def test_parameters_are_no_terminals(tmp_path: Path) -> None:
    (tmp_path / "a.ipm").write_text(GIVEN, encoding="utf-8")
    with pytest.raises(IpmError) as error:
        edit.replace_terminal(edit.read(tmp_path / "a.ipm"), "s", "Bud")
    assert error.value.diagnostics[0].message == "this grammar has no terminal `s`"
