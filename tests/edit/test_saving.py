"""What is written, where it goes, and what is never overwritten."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from ipmlang import IpmError, edit
from ipmlang.formats.drawing import Drawing

Drawn = Callable[[Path], Drawing]


def test_beside_its_source_a_grammar_shares_the_parts(house: Path, drawn: Drawn) -> None:
    saved = edit.save(edit.read(house), house.with_name("copy.ipm"))
    assert saved.files == {}
    assert len(drawn(house.with_name("copy.ipm")).elements) == 31


def test_elsewhere_its_own_parts_bear_its_name(house: Path, tmp_path: Path, drawn: Drawn) -> None:
    out = tmp_path / "other" / "villa.ipm"
    out.parent.mkdir()
    edit.save(edit.read(house), out)
    shutil.rmtree(house.parent)
    assert 'in "villa.parts.svg"' in out.read_text(encoding="utf-8")
    assert sorted(each.name for each in out.parent.iterdir()) == ["villa.ipm", "villa.parts.svg"]
    assert len(drawn(out).elements) == 31


def test_imports_and_what_they_need_come_along(folder: Path, tmp_path: Path, drawn: Drawn) -> None:
    (folder / "sub").mkdir()
    for name in ("house.ipm", "house.parts.svg"):
        shutil.move(folder / name, folder / "sub" / name)
    street = folder / "street.ipm"
    street.write_text(
        'ipm 1\nimport "sub/house" as house\nstart house.House [at(130, 0) house.House]\n',
        encoding="utf-8",
    )
    out = tmp_path / "out" / "road.ipm"
    out.parent.mkdir()
    edit.save(edit.read(street), out)
    shutil.rmtree(folder)
    assert len(drawn(out).elements) == 50


def test_a_different_file_is_not_replaced(house: Path, tmp_path: Path) -> None:
    there = tmp_path / "there"
    there.mkdir()
    (there / "flower.svg").write_text("something else", encoding="utf-8")
    draft = edit.replace_terminal(edit.read(house), "leaf", "flower.svg")
    with pytest.raises(IpmError, match="is there already and differs"):
        edit.save(draft, there / "out.ipm")
    assert [each.name for each in there.iterdir()] == ["flower.svg"]


def test_the_same_command_again_writes_the_same(house: Path) -> None:
    out = house.with_name("flat.ipm")
    contents = []
    for _ in range(2):
        edit.save(edit.flatten(edit.read(house), edit.symbol("Window")), out)
        contents.append({each.name: each.read_bytes() for each in house.parent.iterdir()})
    assert contents[0] == contents[1]


def test_in_place(house: Path, drawn: Drawn) -> None:
    edit.save(edit.set_values(edit.read(house), {"columns": 2}), house)
    assert len(drawn(house).elements) == 1 + 2 * 2 * 3 + 6
    edit.save(edit.flatten(edit.read(house), edit.symbol("Window")), house)
    assert len(drawn(house).elements) == 1 + 2 * 2 * 3 + 6


def test_a_result_that_does_not_run_is_not_written(house: Path) -> None:
    out = house.with_name("out.ipm")
    draft = edit.change(edit.read(house), edit.Selection("Wreath", "f"), to="1 / 0")
    with pytest.raises(IpmError):
        edit.save(draft, out)
    assert not out.exists()


def test_a_record_of_the_drawing_as_it_was_is_left_out(tmp_path: Path) -> None:
    text = """\
ipm 1
attr n : int = 2 in 1..9
table T(x) =
    (0.5)
    (-0.5)
residual T
start repeat(i < n) { F(4) }
"""
    before, after = tmp_path / "a.ipm", tmp_path / "b.ipm"
    before.write_text(text, encoding="utf-8")
    kept = edit.save(edit.set_values(edit.read(before), {"n": 2}), after)
    assert "residual T" in kept.text
    found = edit.save(edit.set_values(edit.read(before), {"n": 5}), after)
    assert "residual" not in found.text and "table" not in found.text
    assert found.terminals == 5
    assert [each.code for each in found.warnings] == ["outdated"]


def test_what_no_executor_runs_yet_is_checked_and_written(tmp_path: Path) -> None:
    before, after = tmp_path / "a.ipm", tmp_path / "b.ipm"
    before.write_text(
        "ipm 1\nattr h = 3\nLot --> extrude(h) comp { top: Roof | side: Wall }\n"
        "start Lot on box(8, 9, 0)\n",
        encoding="utf-8",
    )
    edit.save(edit.set_values(edit.read(before), {"h": 5}), after)
    assert "attr h = 5" in after.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["out.svg", 'a"b.ipm', "a#b.ipm"])
def test_names_that_no_grammar_can_have(house: Path, name: str) -> None:
    with pytest.raises(IpmError):
        edit.save(edit.read(house), house.with_name(name))
