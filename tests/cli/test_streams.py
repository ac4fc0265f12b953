"""What a command prints and where: one object with --json, closed and full outputs, Ctrl-C, and
inputs that no output may replace.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.commands import ipmlang, process

GRAMMAR = 'ipm 1\nattr tone : string = "red"\nstart color(tone) F(1)\n'
DRAWING = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">'
    '<rect id="a" width="1" height="1"/><rect x="3" width="1" height="1"/></svg>'
)
COMMAND = [sys.executable, "-m", "ipmlang"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.ipm").write_text(GRAMMAR, encoding="utf-8")
    (tmp_path / "broken.ipm").write_text("ipm 1\nA --> F(\nstart A\n", encoding="utf-8")
    (tmp_path / "ragged.ipm").write_text("ipm 1\nstart    F(1)\n", encoding="utf-8")
    (tmp_path / "x.parts.svg").write_text(DRAWING, encoding="utf-8")
    (tmp_path / "placed.ipm").write_text(
        'ipm 1\nasset a = "x.parts.svg#a"\nstart a\n', encoding="utf-8"
    )
    return tmp_path


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("run nowhere.ipm -o x.svg --json", 1),
        ("run a.ipm -o x.svg --set tine=red --json", 2),
        ("infer nowhere.svg --json", 1),
        ("check broken.ipm --json", 1),
        ("fmt broken.ipm --json", 1),
        ("fmt a.ipm --stdout --json", 2),
    ],
)
def test_a_failure_is_one_object_too(words: str, code: int, folder: Path) -> None:
    done = ipmlang(*words.split(), folder=folder)
    assert done.returncode == code
    report = json.loads(done.stdout)
    assert report["errors"] == 1
    assert report["diagnostics"][0]["message"]


def test_fmt_goes_on_after_a_broken_file(folder: Path) -> None:
    done = ipmlang("fmt", "broken.ipm", "nowhere.ipm", "ragged.ipm", folder=folder)
    assert done.returncode == 1
    assert "broken.ipm:2" in done.stderr and "nowhere.ipm" in done.stderr
    assert (folder / "ragged.ipm").read_text(encoding="utf-8") == "ipm 1\nstart F(1)\n"


def test_fmt_can_check_and_print(folder: Path) -> None:
    done = ipmlang("fmt", "--check", "--stdout", "ragged.ipm", folder=folder)
    assert (done.returncode, done.stdout) == (1, "ipm 1\nstart F(1)\n")


def test_a_text_attribute_takes_what_looks_like_a_number(folder: Path) -> None:
    done = ipmlang("run", "a.ipm", "-o", "x.svg", "--set", "tone=1", folder=folder)
    assert "`1` is no colour" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        "infer x.parts.svg -o x.ipm",
        "run placed.ipm -o x.parts.svg",
        "run placed.ipm -o ./x.parts.svg",
    ],
)
def test_what_is_read_is_not_written_over(words: str, folder: Path) -> None:
    done = ipmlang(*words.split(), folder=folder)
    assert done.returncode == 2
    assert "x.parts.svg" in done.stderr
    assert (folder / "x.parts.svg").read_text(encoding="utf-8") == DRAWING
    assert not (folder / "x.ipm").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="file names are bytes on Linux only")
def test_a_name_that_is_no_text_is_refused(folder: Path) -> None:
    name = b"bad\xff.svg"
    (folder / os.fsdecode(name)).write_text(DRAWING, encoding="utf-8")
    done = process("infer", name, folder=folder)
    assert done.returncode == 2 and "Traceback" not in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_full_disk_under_the_output_is_said(folder: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*COMMAND, "check", "a.ipm"], cwd=folder, stdout=full, stderr=subprocess.PIPE,
            text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert "no space left" in done.stderr and "Traceback" not in done.stderr


def test_a_pipe_that_nobody_reads_is_no_trouble(folder: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as closed:
        done = subprocess.run(
            [*COMMAND, "check", "a.ipm"], cwd=folder, stdout=closed, stderr=subprocess.PIPE,
            text=True, check=False,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(sys.platform == "win32", reason="signals are different there")
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_a_stopped_command_says_so_and_leaves_nothing(number: str, folder: Path) -> None:
    """The grammar is read from a pipe, so that the command is surely at work when it is stopped.
    Where the tests run in the background of a shell, the command must not inherit that it is deaf.
    """
    os.mkfifo(folder / "waiting.ipm")
    process = subprocess.Popen(
        [*COMMAND, "run", "waiting.ipm", "-o", "x.svg"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(getattr(signal, number), signal.SIG_DFL),
    )  # fmt: skip
    with (folder / "waiting.ipm").open("w"):  # opens once the command reads
        process.send_signal(getattr(signal, number))
        _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "stopped" in said and "Traceback" not in said
    assert not (folder / "x.svg").exists()


def test_a_file_cannot_write_to_the_terminal(folder: Path) -> None:
    (folder / "escape.ipm").write_text(
        "ipm 1\nA --> \x1b[31m \u202e F\nstart A\n", encoding="utf-8"
    )
    done = ipmlang("check", "escape.ipm", folder=folder)
    assert done.returncode == 1
    assert "\x1b" not in done.stderr and "\u202e" not in done.stderr


@pytest.mark.parametrize("words", ["infer . -o x.ipm", "infer x.parts.svg -o no/folder/x.ipm"])
def test_what_cannot_work_is_said_before_any_work(words: str, folder: Path) -> None:
    done = ipmlang(*words.split(), "--json", folder=folder)
    assert done.returncode == 1
    assert "folder" in json.loads(done.stdout)["diagnostics"][0]["message"]


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="root may read all")
def test_a_file_that_may_not_be_read_is_the_files_fault(folder: Path) -> None:
    (folder / "a.ipm").chmod(0)
    done = ipmlang("check", "a.ipm", folder=folder)
    assert done.returncode == 1 and "a.ipm" in done.stderr
