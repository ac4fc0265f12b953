"""Which rules the card runs, told without one: the reasons are the encoder's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import ipmlang
from ipmlang.cli import run_command_line
from ipmlang.runtime.gpu.explain import Reason, reasons

HOUSE = """\
ipm 1
Lot        --> split x { ~1: Wall | ~2: House }
House : 50%  --> extrude(3) Block
House : else --> roofHip(30) Tiles
start Lot on box(9, 9, 0)
"""


def test_a_rule_without_a_body_keeps_its_alternatives() -> None:
    found = reasons(ipmlang.parse(HOUSE).program)
    assert {(each.rule, each.line) for each in found} == {("House", 3), ("House", 4)}
    assert ("roofHip", 4) in {(each.operation, each.line) for each in found}
    assert "line 4" in next(each.why for each in found if each.line == 3)


def test_a_bending_turtle_is_the_whole_program() -> None:
    text = "ipm 1\ntropism (0, -1, 0) 0.2\nA --> F +(rand(9)) A\nstart A F steps 2\n"
    assert reasons(ipmlang.parse(text).program)[0].rule == ""
    assert not reasons(ipmlang.parse(text.replace("tropism (0, -1, 0) 0.2\n", "")).program)


def test_rules_of_imported_files_are_told_with_them() -> None:
    found = reasons(
        ipmlang.parse('ipm 1\nimport "std/roofs"\nstart roofs.Hip on box(5, 4, 0)').program
    )
    assert {Path(each.path).name for each in found} == {"roofs.ipm"}
    assert isinstance(found[0], Reason)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "house.ipm").write_text(HOUSE, encoding="utf-8")
    return tmp_path


def test_the_command_tells_a_table(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["run", "house.ipm", "--explain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["rule", "line", "runs", "on", "because"]
    assert [line.split()[:3] for line in lines[1:]] == [
        ["start", "5", "cpu"], ["Lot", "2", "gpu"], ["House", "3", "cpu"], ["House", "4", "cpu"],
    ]  # fmt: skip
    assert not list(folder.glob("*.obj"))


def test_the_command_tells_it_beside_what_it_wrote(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["run", "house.ipm", "-o", "x.obj", "--explain", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["explain"][1] == {
        "rule": "Lot", "file": "", "line": 2, "runs_on": "gpu", "operation": "", "why": "",
    }  # fmt: skip
    assert report["backend"] == "cpu"
    assert report["device"] is None


def test_without_either_the_command_is_wrong(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["run", "house.ipm"]) == 2
    assert "-o" in capsys.readouterr().err
