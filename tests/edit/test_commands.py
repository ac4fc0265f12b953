"""The command line of `edit` and `vary`: what it writes and prints, and every message it has.

A golden is `errors/NAME.txt` with a command, run in a copy of the folder `files`, and what a person
reads; `pytest --update` writes the messages anew.
"""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from ipmlang.cli import run_command_line

GOLDENS = sorted((Path(__file__).parent / "errors").glob("*.txt"))
COMMAND, MESSAGE = "--- command ---\n", "--- message ---\n"


@pytest.mark.parametrize("path", GOLDENS, ids=lambda path: path.stem)
def test_the_message_is_as_it_was_read(
    path: Path,
    update: bool,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder)
    content = path.read_text(encoding="utf-8")
    command, _, expected = content.removeprefix(COMMAND).partition(MESSAGE)
    before = sorted(folder.iterdir())
    code = run_command_line(shlex.split(command))
    found = f"{capsys.readouterr().err.strip()}\nexit code {code}\n"
    assert code in (1, 2)
    assert sorted(folder.iterdir()) == before, "a command that fails writes nothing"
    if update:
        path.write_text(COMMAND + command + MESSAGE + found, encoding="utf-8")
    else:
        assert found == expected


def test_there_are_goldens() -> None:
    assert len(GOLDENS) >= 20


def test_without_an_output_the_text_is_printed(
    house: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["edit", "set", str(house), "columns=7"]) == 0
    assert "attr columns : int    = 7" in capsys.readouterr().out


def test_a_report_for_machines(house: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = house.with_name("flat.ipm")
    words = ["edit", "flatten", str(house), "--rule", "Window", "-o", str(out), "--json"]
    assert run_command_line(words) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["output"] == str(out)
    assert [Path(each).name for each in report["files"]] == ["flat.window.parts.svg"]
    assert report["terminals"] == 1 + 8 + 6
    assert report["changes"][0] == {
        "where": "Window", "before": "1 use", "after": "the asset window",
    }  # fmt: skip
    assert (report["errors"], report["diagnostics"]) == (0, [])


def test_a_person_is_told_what_was_changed(house: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = house.with_name("out.ipm")
    words = ["edit", "randomise", str(house), "columns", "--rule", "Wreath", "--by", "10%"]
    assert run_command_line([*words, "-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert "columns: 4 -> 4 + irand(-1, 1)" in told
    assert "Wreath: f distance: 5 -> 5 + rand(-0.5, 0.5)" in told
    assert told.rstrip().endswith("out.ipm: 3 changes")


@pytest.mark.parametrize("command", ["set", "randomise", "symmetrise", "replace", "flatten"])
def test_help_shows_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    run_command_line(["edit", command, "--help"])
    assert f"ipmlang edit {command}" in capsys.readouterr().out
