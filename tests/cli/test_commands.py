"""The commands as a person types them: what they print, write and exit with."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from tests.cli.commands import ipmlang, process

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("infer", "run", "check", "fmt", "bench")

FENCE = """\
ipm 1
attr pickets : int = 5 in 1..99 "how many"
turtle step 1
Fence --> repeat(i < pickets) { [F(30)] -(90) f(8) +(90) }
start +(90) Fence
"""
WITHOUT_END = """\
ipm 1
Tree --> F(1) [+(30) Tree] [-(30) Tree]
start Tree
"""


@pytest.fixture
def fence(tmp_path: Path) -> Path:
    path = tmp_path / "fence.ipm"
    path.write_text(FENCE, encoding="utf-8")
    return path


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_an_example(command: str, tmp_path: Path) -> None:
    done = ipmlang(command, "--help", folder=tmp_path)
    assert done.returncode == 0
    assert f"ipmlang {command} " in done.stdout.partition("Example:")[2]


def test_run_reports_one_object(fence: Path, tmp_path: Path) -> None:
    done = ipmlang("run", fence, "-o", "fence.svg", "--seed", "3", "--set", "pickets=7", "--json",
                   folder=tmp_path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["terminals"] == 7
    assert report["seed"] == 3
    assert report["backend"] == "cpu"
    assert {"shapes", "generations", "seconds", "peak_memory_bytes"} <= set(report)
    assert (tmp_path / "fence.svg").read_text(encoding="utf-8").count("<path") == 7


@pytest.mark.parametrize("suffix", ["svg", "png", "obj", "glb", "ply", "stl"])
def test_run_writes_every_format(fence: Path, tmp_path: Path, suffix: str) -> None:
    done = ipmlang("run", fence, "-o", f"fence.{suffix}", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / f"fence.{suffix}").stat().st_size > 100


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["run", "fence.ipm", "-o", "x.svg", "--set", "picket=3"], 2, "pickets"),
        (["run", "fence.ipm", "-o", "x.svg", "--set", "pickets=0"], 2, "99"),
        (["run", "fence.ipm", "-o", "x.svg", "--set", "pickets=red"], 2, "whole number"),
        (["run", "fence.ipm", "-o", "x.svg", "--set", "pickets"], 2, "--set name=value"),
        (["run", "fence.ipm", "-o", "x.svg", "--limit", "speed=3"], 2, "shapes"),
        (["run", "fence.ipm", "-o", "x.gif"], 2, ".svg"),
        (["run", "fence.ipm", "-o", "no/such/folder/x.svg"], 1, "folder"),
        (["run", "missing.ipm", "-o", "x.svg"], 1, "missing.ipm"),
        (["run", "fence.ipm"], 2, "--output"),
        (["infer", "missing.svg", "-o", "x.ipm"], 1, "missing.svg"),
        (["infer", "fence.ipm", "-o", "x.ipm"], 1, "fence.ipm"),
        (["infer", "fence.ipm", "-o", "x.txt"], 2, ".ipm"),
        (["infer", "x.svg", "--similarity", "0.2"], 2, "from 0.6 to 1, not 0.2"),
        (["infer", "x.svg", "--weight-near", "-1"], 2, "from 0 to 10, not -1"),
        (["infer", "x.svg", "--within", "nan"], 2, "from 1e-06 to 0.1, not nan"),
        (["infer", "x.svg", "--weight-long", "much"], 2, "--weight-long"),
        (["grow"], 2, "grow"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_a_wrong_command_says_why(
    fence: Path, tmp_path: Path, words: list[str], code: int, says: str
) -> None:
    done = ipmlang(*words, folder=tmp_path)
    assert done.returncode == code, done.stderr
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fence.ipm"]


def test_growth_without_end_stops_and_names_the_rule(tmp_path: Path) -> None:
    (tmp_path / "tree.ipm").write_text(WITHOUT_END, encoding="utf-8")
    done = ipmlang("run", "tree.ipm", "-o", "tree.svg", "--limit", "shapes=100000", folder=tmp_path)
    assert done.returncode == 1
    assert "Tree" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "tree.svg").exists()


def test_check_reports_every_error_with_its_place(tmp_path: Path) -> None:
    (tmp_path / "bad.ipm").write_text(
        "ipm 1\nA --> F(1 f(2)\nB --> [ F\nstart A\n", encoding="utf-8"
    )
    done = ipmlang("check", "bad.ipm", "--json", folder=tmp_path)
    assert done.returncode == 1
    lines = {each["line"] for each in json.loads(done.stdout)["diagnostics"]}
    assert {2, 3} <= lines


def test_check_tells_what_only_making_the_program_shows(tmp_path: Path) -> None:
    grammar = tmp_path / "wall.ipm"
    grammar.write_text("ipm 1\nA --> extrude(3) B box\nB --> f(2) C box\nC --> f(1) box\nstart A\n")
    commands = (("check", grammar), ("run", grammar, "-o", "wall.glb"))
    found = [ipmlang(*words, folder=tmp_path) for words in commands]
    assert [each.returncode for each in found] == [1, 1]
    assert all("error[misplaced]: `B` moves the turtle" in each.stderr for each in found)
    grammar.write_text("ipm 1\nA --> F\nstart A seeds 4\n")
    told = ipmlang("check", grammar, folder=tmp_path)
    assert (told.returncode, "warning[not-executable]" in told.stderr) == (0, True)


def test_fmt_is_stable(fence: Path, tmp_path: Path) -> None:
    assert ipmlang("fmt", fence, folder=tmp_path).returncode == 0
    assert ipmlang("fmt", "--check", fence, folder=tmp_path).returncode == 0


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_folder_is_said(fence: Path, tmp_path: Path) -> None:
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    done = ipmlang("run", fence, "-o", locked / "x.svg", folder=tmp_path)
    assert done.returncode == 1 and "locked" in done.stderr


def test_two_processes_write_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "bush.ipm").write_text(
        "ipm 1\nA(n) : n > 0 : 50% --> F(1) [+(rand(20, 40)) A(n - 1)] A(n - 1)\n"
        "A(n) : n > 0 --> F(1) [-(rand(20, 40)) A(n - 1)] A(n - 1)\nA(n) : else --> F(1)\n"
        "start A(7)\n",
        encoding="utf-8",
    )
    for name in ("one.svg", "two.svg"):
        done = process("run", "bush.ipm", "-o", name, "--seed", "5", folder=tmp_path)
        assert done.returncode == 0
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def readme_commands() -> list[str]:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.findall(r"```sh\n(.*?)\n```", text, flags=re.DOTALL)


def test_the_readme_has_two_commands_and_the_second_is_what_ci_runs() -> None:
    commands = readme_commands()
    assert len(commands) == 2
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


def test_the_readmes_first_command_does_its_job(tmp_path: Path) -> None:
    """The part after the installation, word for word, in a folder with the example."""
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "garden.svg").write_bytes(
        (ROOT / "examples" / "garden.svg").read_bytes()
    )
    steps = readme_commands()[0].split(" && ")[2:]
    for step in steps:
        _, *words = step.split()
        done = process(*words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "garden-again.svg").exists()


def test_infer_explains_itself_on_request(tmp_path: Path) -> None:
    pickets = "".join(f'<path d="M{4 * k} 0h2v9h-2z"/>' for k in range(12))
    (tmp_path / "fence.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 50 10">{pickets}</svg>',
        encoding="utf-8",
    )
    plain = ipmlang("infer", "fence.svg", folder=tmp_path)
    told = ipmlang("infer", "fence.svg", "--explain", "--weight-long", "1", folder=tmp_path)
    assert told.returncode == 0, told.stderr
    assert told.stdout == plain.stdout
    assert "taken" in told.stderr and "chosen: rules" in told.stderr
    assert "round" not in plain.stderr
    words = ("--explain", "--symmetrize", "--similarity", "0.9", "--paper", "--json")
    done = ipmlang("infer", "fence.svg", *words, folder=tmp_path)
    report = json.loads(done.stdout)
    assert report["mode"] == "ideal"
    assert report["explanation"][0]["tried"][0]["outcome"] == "taken"
