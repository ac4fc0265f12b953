"""`--style` of the commands that derive."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.commands import ipmlang

LAMP = """\
ipm 1
attr lit = 0 in 0..1
Lamp --> F(1 + lit)
style Night "lit"
attr Night.lit = 1
Night.Lamp --> F(1 + lit) F(3)
start Lamp
"""


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    path = tmp_path / "lamp.ipm"
    path.write_text(LAMP, encoding="utf-8")
    return path


def test_run_derives_in_a_style(lamp: Path, tmp_path: Path) -> None:
    counts = []
    for words in ((), ("--style", "Night"), ("--style", "Night", "--set", "lit=0.5")):
        done = ipmlang("run", lamp, "-o", "lamp.svg", "--json", *words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        counts.append(json.loads(done.stdout)["terminals"])
    assert counts == [1, 2, 2]


@pytest.mark.parametrize("command", ["run", "vary"])
def test_a_style_that_is_not_there_is_a_wrong_command(
    command: str, lamp: Path, tmp_path: Path
) -> None:
    done = ipmlang(command, lamp, "-o", "lamp.svg", "--style", "Nihgt", folder=tmp_path)
    assert done.returncode == 2
    assert "has no style `Nihgt`" in done.stderr
    assert "did you mean `Night`?" in done.stderr
    assert not (tmp_path / "lamp.svg").exists()


def test_a_model_has_no_styles(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    done = ipmlang("render", "a.obj", "-o", "a.png", "--style", "Night", folder=tmp_path)
    assert done.returncode == 2
    assert "are for grammars" in done.stderr
