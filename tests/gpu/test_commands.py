"""The commands with a card: `--backend gpu` of `run` and `render`, and `bench`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ipmlang.bench import TASKS, runs_of
from ipmlang.cli import run_command_line
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime.gpu import context as contexts
from ipmlang.runtime.gpu.device import Device
from ipmlang.studio.card_copies import CardCopies

WALL = """\
ipm 1
Wall --> split x { { ~2: Bay }* }
Bay  --> split y { ~1: Stone | ~1: Pane }
start Wall on box(10, 3, 0)
"""
ROOF = """\
ipm 1
Lot  --> split x { { ~4: House }* }
House --> extrude(3) comp { top: roofHip(30) Tiles | side: Wall }
start Lot on box(12, 5, 0)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wall.ipm").write_text(WALL, encoding="utf-8")
    return tmp_path


def without_opengl(version: int, **settings: str) -> None:
    raise Exception("libEGL.so.1 not loaded")  # what the library raises is no better


def test_run_says_which_card(
    folder: Path, card: Device, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line(["run", "wall.ipm", "-o", "x.obj", "--backend", "gpu", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["terminals"] == 10
    assert report["backend"] in ("gpu", "gpu+cpu")
    assert report["device"]["renderer"] == card.info.renderer
    assert run_command_line(["run", "wall.ipm", "-o", "y.obj"]) == 0
    assert (folder / "x.obj").read_text().replace("x.mtl", "y.mtl") == (
        folder / "y.obj"
    ).read_text()


@pytest.mark.usefixtures("no_device")
def test_run_without_a_card(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(contexts, "_context", without_opengl)
    assert run_command_line(["run", "wall.ipm", "-o", "x.obj", "--backend", "gpu"]) == 1
    assert "apt-get install" in capsys.readouterr().err
    assert not (folder / "x.obj").exists()
    assert run_command_line(["run", "wall.ipm", "-o", "x.obj", "--backend", "auto"]) == 0
    assert "derived on the CPU" in capsys.readouterr().err


def test_render_derives_on_the_card(folder: Path, card: Device) -> None:
    words = ["render", "wall.ipm", "--size", "80x50"]
    assert run_command_line([*words, "-o", "x.png", "--backend", "gpu"]) == 0
    assert run_command_line([*words, "-o", "y.png"]) == 0
    ours, theirs = (np.asarray(Image.open(folder / f"{name}.png"), np.float64) for name in "xy")
    assert np.abs(ours - theirs).mean() < 2
    assert theirs.std() > 2


def test_render_falls_back_where_the_card_is_full(
    folder: Path, card: Device, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(copies: CardCopies, *words: object) -> None:
        raise fail("gpu-memory", "the graphics card is out of memory in `copies`")

    monkeypatch.setattr(Device, "is_software", property(lambda card: False))
    words = ["render", "wall.ipm", "--size", "80x50", "-o", "x.png", "--json"]
    assert run_command_line([*words, "--backend", "auto"]) == 0
    assert json.loads(capsys.readouterr().out)["backend"] == "gpu"
    (folder / "x.png").unlink()
    monkeypatch.setattr(CardCopies, "see", full)
    assert run_command_line([*words, "--backend", "auto"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["backend"] == "cpu"
    assert "derived on the CPU: the graphics card is out of memory" in said.err
    assert (folder / "x.png").exists()
    assert run_command_line([*words, "--backend", "gpu"]) == 1


def test_render_lets_the_cpu_help(
    folder: Path, card: Device, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "roof.ipm").write_text(ROOF, encoding="utf-8")
    words = ["render", "roof.ipm", "--size", "80x50", "-o", "x.png", "--backend", "gpu", "--json"]
    assert run_command_line(words) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["backend"] == "gpu+cpu"
    assert report["device"]["vendor"] == card.info.vendor


def test_bench_measures_both(
    folder: Path, card: Device, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["bench", "town", "seeds", "--scale", "0.0005", "--repeat", "1", "--json", "b.json"]
    assert run_command_line(words) == 0
    table = capsys.readouterr().out.splitlines()
    assert table[0].startswith(card.info.renderer)
    assert [line.split()[0] for line in table[1:]] == ["task", "town", "seeds", "seeds"]
    report = json.loads((folder / "b.json").read_text())
    assert report["device"]["driver"] == card.info.driver
    assert report["machine"]["numpy"]
    for row in report["tasks"]:
        assert row["cpu"]["terminals"] == row["gpu"]["terminals"] > 0
        assert row["gpu"]["ran"] == "gpu"
        assert row["gpu"]["resident"] > 0
        assert row["ratio"] == pytest.approx(row["cpu"]["best"] / row["gpu"]["best"])


@pytest.mark.usefixtures("no_device")
def test_bench_without_a_card(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(contexts, "_context", without_opengl)
    assert run_command_line(["bench", "facade", "--repeat", "1"]) == 0
    said = capsys.readouterr()
    assert "only the CPU is measured" in said.err
    assert "0.01 of the work" in said.err
    assert "gpu" not in said.out
    assert run_command_line(["bench", "facade", "--backend", "gpu"]) == 1


def test_bench_says_what_is_no_task(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["bench", "fasade"]) == 2
    assert "`facade`" in capsys.readouterr().err


def test_sizes_of_tasks() -> None:
    assert TASKS["seeds"].at(0.01) == (10, 100, 1000)
    assert TASKS["seeds"].at(1.0) == (10, 100, 1_000, 10_000, 100_000)
    assert TASKS["tree"].at(1 / 2.5**3) == (13,)
    assert [run.name for run in runs_of(["town"], 1)] == ["town"]
    with pytest.raises(IpmError):
        runs_of(["town", "city"], 1)


@pytest.mark.parametrize("name", TASKS)
def test_grammars_of_tasks_are_well_written(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = Path(__file__).resolve().parents[2] / "ipmlang" / "bench" / f"{name}.ipm"
    assert run_command_line(["check", str(path)]) == 0
    assert ": 0 errors, 0 warnings" in capsys.readouterr().out
    assert run_command_line(["fmt", "--check", str(path)]) == 0
