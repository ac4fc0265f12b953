"""Contact sheets: which variations, how they are laid out, and what becomes of broken ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang import IpmError
from ipmlang.cli import run_command_line
from ipmlang.edit.contact_sheet import Cell, contact_sheet
from ipmlang.edit.trial import box_of
from ipmlang.edit.variations import Sweep, vary, wishes
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import read_svg
from ipmlang.runtime.export.sheet import drawing_of

TWIG = """\
ipm 1
attr length : float = 4 in 1..9 "of a twig"
attr twigs : int = 3 in 1.. "how many"
attr style : string = "thin" in { "thin", "wide" } "how they look"
Twig --> F(rand(length, 2 * length))
start repeat(i < twigs) { [+(30 * i) Twig] }
"""
BRITTLE = """\
ipm 1
attr n : int = irand(0, 1) in 1..9
start repeat(i < n) { F(rand(1, 2)) }
"""


def program(text: str) -> ipmlang.Grammar:
    return ipmlang.parse(text)


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    return tmp_path / "sheet.svg"


def test_every_cell_shows_what_run_draws_with_its_seed(tmp_path: Path, sheet: Path) -> None:
    path = tmp_path / "twig.ipm"
    path.write_text(TWIG, encoding="utf-8")
    assert run_command_line(["vary", str(path), "-n", "6", "-o", str(sheet), "--seed", "7"]) == 0
    lines = [each for each in read_svg(sheet).elements if each.style.stroke == "#000000"]
    assert len(lines) == 6 * 3
    for number in range(6):
        alone = drawing_of(ipmlang.load(path).run(seed=7 + number)).elements
        here = lines[3 * number : 3 * number + 3]
        for one, other in zip(alone, here, strict=True):
            assert one.outline is not None and other.outline is not None
            moved = other.outline.coords[:, :2] - one.outline.coords[:, :2]
            assert np.ptp(moved.reshape(-1, 2), axis=0).max() < 1e-5  # moved, never scaled
    seeds = re.findall(r">seed (\d+)<", sheet.read_text(encoding="utf-8"))
    assert seeds == [str(each) for each in range(7, 13)]


def test_cells_do_not_overlap_and_fit_the_page() -> None:
    grammar = program(TWIG)
    made = [each.drawing for each in vary(grammar.program, wishes(grammar.program, 7))]
    page = contact_sheet([Cell(each, ("seed",)) for each in made])
    assert page.box is not None
    frames = [box_of(Drawing((each,))) for each in page.elements if each.style.stroke == "#dddddd"]
    assert len(frames) == 7
    corners = np.array([each[:2] for each in frames if each is not None])
    size = np.array(frames[0])[2:]
    apart = np.abs(corners[:, None] - corners[None]) >= size - 1e-9
    assert (apart.any(axis=2) | np.eye(7, dtype=bool)).all()
    assert (corners >= 0).all() and (corners + size <= np.array(page.box[2:])).all()


def test_what_leaves_its_canvas_is_clipped(tmp_path: Path, sheet: Path) -> None:
    path = tmp_path / "wide.ipm"
    path.write_text("ipm 1\ncanvas (0, 0, 10, 10)\nstart [F(rand(3, 9))] F(50)\n", encoding="utf-8")
    assert run_command_line(["vary", str(path), "-n", "3", "-o", str(sheet)]) == 0
    text = sheet.read_text(encoding="utf-8")
    assert text.count("<clipPath") == 3
    assert text.count('clip-path="url(#') == 3


def test_a_sweep_keeps_the_seed_and_goes_in_equal_steps() -> None:
    found = wishes(program(TWIG).program, 5, seed=3, sweeps=[Sweep("length", 2, 6)])
    assert [(each.seed, each.told["length"]) for each in found] == [
        (3, value) for value in (2.0, 3.0, 4.0, 5.0, 6.0)
    ]


def test_whole_numbers_are_swept_once_each() -> None:
    found = wishes(program(TWIG).program, 16, sweeps=[Sweep("twigs", 1, 4)])
    assert [each.told["twigs"] for each in found] == [1, 2, 3, 4]


def test_two_sweeps_are_columns_and_rows() -> None:
    sweeps = [Sweep("length", 1, 4), Sweep("twigs", 1, 3)]
    found = wishes(program(TWIG).program, 12, sweeps=sweeps)
    assert [each.told["length"] for each in found[:4]] == [1.0, 2.0, 3.0, 4.0]
    assert [each.told["twigs"] for each in found[::4]] == [1, 2, 3]


def test_attributes_are_drawn_within_their_ranges() -> None:
    grammar = program(TWIG).program
    found = wishes(grammar, 200, draw_attributes=True)
    lengths = np.array([each.values["length"] for each in found])
    assert lengths.min() >= 1 and lengths.max() <= 9 and np.ptp(lengths) > 6
    assert {each.values["twigs"] for each in found} == {1, 2, 3, 4, 5}  # 3, open above
    assert {each.values["style"] for each in found} == {"thin", "wide"}
    fixed = wishes(grammar, 20, draw_attributes=True, fixed={"length": 5})
    assert {each.values["length"] for each in fixed} == {5}
    assert all(each.drawing is not None for each in vary(grammar, found[:20]))


def test_a_broken_seed_is_told_and_spoils_no_other(
    tmp_path: Path, sheet: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "brittle.ipm"
    path.write_text(BRITTLE, encoding="utf-8")
    assert run_command_line(["vary", str(path), "-n", "12", "-o", str(sheet), "--json"]) == 0
    printed = capsys.readouterr()
    report = json.loads(printed.out)
    failed = [each["seed"] for each in report["variations"] if each["error"]]
    assert 0 < len(failed) < 12
    assert report["different"] == 12 - len(failed)
    assert f"seed {failed[0]}: `n` is 0, but must be from 1 to 9" in printed.err
    assert sheet.read_text(encoding="utf-8").count("attribute-out-of-range") == len(failed)


def test_if_all_are_broken_nothing_is_written(tmp_path: Path, sheet: Path) -> None:
    path = tmp_path / "broken.ipm"
    path.write_text(BRITTLE.replace("irand(0, 1)", "irand(0, 0)"), encoding="utf-8")
    assert run_command_line(["vary", str(path), "-o", str(sheet)]) != 0
    assert not sheet.exists()


def test_what_does_not_vary_is_told(
    house: Path, sheet: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["vary", str(house), "-n", "3", "-o", str(sheet), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["different"] == 1
    assert report["diagnostics"][0]["code"] == "does-not-vary"
    assert "edit randomise" in report["diagnostics"][0]["hint"]


def test_a_png_and_the_same_bytes_again(tmp_path: Path) -> None:
    path = tmp_path / "twig.ipm"
    path.write_text(TWIG, encoding="utf-8")
    outs = [tmp_path / "a.png", tmp_path / "b.png"]
    for out in outs:
        assert run_command_line(["vary", str(path), "-n", "4", "-o", str(out)]) == 0
    assert outs[0].read_bytes().startswith(b"\x89PNG")
    assert outs[0].read_bytes() == outs[1].read_bytes()


def test_space_comes_with_another_command() -> None:
    grammar = program("ipm 1\nstart F(3) &(30) F(3)").program
    with pytest.raises(IpmError, match="render"):
        list(vary(grammar, wishes(grammar, 2)))


def test_a_sheet_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    grammar = program(TWIG).program
    with pytest.raises(IpmError, match="1 to 400"):
        wishes(grammar, 401)
    monkeypatch.setattr("ipmlang.edit.variations.ELEMENTS", 10)
    with pytest.raises(IpmError, match="fewer variations"):
        list(vary(grammar, wishes(grammar, 4)))
