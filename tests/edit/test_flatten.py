"""Rules made terminals: the drawing stays, the rules go."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from ipmlang import IpmError, edit
from ipmlang.formats.drawing import Drawing
from ipmlang.inverse.compare import compare

Drawn = Callable[[Path], Drawing]
MOVING = """\
ipm 1
canvas (0, 0, 100, 100)
Steps(m) : m > 0 --> F(8) +(12) *(0.9) Steps(m - 1)
Steps(m) : else --> mirror f(2)
Fork --> F(5) [+(30) Steps(3)] [-(30) Steps(3)]
start [at(10, 10) Fork] [at(40, 20, 30) Steps(5) F(6) +(20) Steps(2) F(3)]
"""


@pytest.mark.parametrize("rule", ["Window", "Storey", "House", "Wreath"])
def test_the_drawing_stays_as_it_was(house: Path, drawn: Drawn, rule: str) -> None:
    out = house.with_name("flat.ipm")
    saved = edit.save(edit.flatten(edit.read(house), edit.symbol(rule)), out)
    assert len(saved.files) == 1
    assert next(iter(saved.files)).name.startswith(f"flat.{rule.lower()}")
    assert compare(drawn(house), drawn(out)).agrees(1e-9)
    assert f"\n{rule} " not in out.read_text(encoding="utf-8")


@pytest.mark.parametrize("rule", ["Steps", "Steps(5)", "Fork"])
def test_so_does_the_motion_of_the_turtle(tmp_path: Path, drawn: Drawn, rule: str) -> None:
    before, after = tmp_path / "a.ipm", tmp_path / "b.ipm"
    before.write_text(MOVING, encoding="utf-8")
    edit.save(edit.flatten(edit.read(before), edit.symbol(rule)), after)
    assert compare(drawn(before), drawn(after)).agrees(1e-9)


GIVEN = """\
ipm 1
canvas (0, 0, 40, 40)
turtle width 1
Row(s, n) : n > 0 --> s f(1) Row(s, n - 1)
Row(s, n) : else  --> [s]
Leaf --> F(3) +(30) F(2)
Bud  --> F(2)
start at(10, 10) Row(Leaf, 3) [Row(Bud, 2)] Leaf
"""


@pytest.mark.parametrize("rule", ["Leaf", "Bud", "Row", "Row(Bud, 2)"])
def test_rules_that_are_given_and_rules_that_take_them(
    tmp_path: Path, drawn: Drawn, rule: str
) -> None:
    before, after = tmp_path / "a.ipm", tmp_path / "b.ipm"
    before.write_text(GIVEN, encoding="utf-8")
    edit.save(edit.flatten(edit.read(before), edit.symbol(rule)), after)
    assert compare(drawn(before), drawn(after)).agrees(1e-9)


def test_each_set_of_arguments_is_an_asset(tmp_path: Path) -> None:
    draft = edit.flatten(edit.read_text(MOVING), edit.symbol("Steps"))
    for name in ("steps_3", "steps_5", "steps_2"):
        assert f'asset {name} in "{name}.parts.svg"' in draft.text


def test_a_level_on_top_of_another(house: Path, drawn: Drawn) -> None:
    out = house.with_name("flat.ipm")
    draft = edit.flatten(edit.read(house), edit.symbol("Window"))
    saved = edit.save(edit.flatten(draft, edit.symbol("Storey")), out)
    assert compare(drawn(house), drawn(out)).agrees(1e-9)
    assert {each.name for each in saved.files} >= {"flat.storey.parts.svg"}


def test_a_random_rule_is_one_of_its_drawings(tmp_path: Path) -> None:
    text = "ipm 1\nTwig --> repeat(i < 3 + irand(0, 20)) { F(rand(1, 9)) }\nstart [Twig] Twig"
    one, other = (edit.flatten(edit.read_text(text), edit.symbol("Twig"), seed=k) for k in (1, 2))
    assert one.added["twig.parts.svg"] != other.added["twig.parts.svg"]
    again = edit.flatten(edit.read_text(text), edit.symbol("Twig"), seed=1)
    assert again.added["twig.parts.svg"] == one.added["twig.parts.svg"]


def test_computed_arguments_are_refused_with_the_way_out() -> None:
    text = "ipm 1\nattr n : int = 3\nP(m) : m > 0 --> F P(m - 1)\nP(m) : else --> nil\nstart P(n)"
    with pytest.raises(IpmError, match=r"--rule 'P\(3\)'"):
        edit.flatten(edit.read_text(text), edit.symbol("P"))


def test_what_the_asset_does_not_do_is_told() -> None:
    text = 'ipm 1\ncanvas (0, 0, 9, 9)\nRed --> color("red") F(2)\nstart Red F(3)'
    draft = edit.flatten(edit.read_text(text), edit.symbol("Red"))
    assert [each.message for each in draft.notes] == [
        "`Red` also left its pen to what follows; its asset does not"
    ]


def test_real_grammars_stay_as_they_were(data: Path, tmp_path: Path, drawn: Drawn) -> None:
    from ipmlang import infer

    before, after = tmp_path / "a.ipm", tmp_path / "b.ipm"
    infer(data / "svg" / "mandala.svg").save(before)
    rules = edit.read(before)
    names = [item.head.name for item in rules.grammar.items if hasattr(item, "head")]
    for name in names[1:4]:
        edit.save(edit.flatten(rules, edit.symbol(name)), after)
        assert compare(drawn(before), drawn(after)).agrees(1e-8)
