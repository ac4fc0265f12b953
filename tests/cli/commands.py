"""Three ways to give a command in a test: in this process, which says as much wherever the process
is not the point; in a process of its own; and in a fork of a process that has the libraries loaded,
with memory and time bounded.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import select
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from subprocess import CompletedProcess

from ipmlang.__main__ import main
from ipmlang.cli import run_command_line

MEMORY = 3 << 30  # address space of a fork, bytes: libraries map far more than they touch
SECONDS = 60  # of CPU that a fork may take: what is expected is a few
PATIENCE = 900  # seconds until a fork that does nothing is given up
DRAWING = '<svg xmlns="http://www.w3.org/2000/svg"><path style="fill: red" d="M0 0h1v1z"/></svg>'


def ipmlang(*words: str | Path, folder: Path) -> CompletedProcess[str]:
    """Give a command in this process, in `folder`; any exception but an exit fails the test."""
    out, err = io.StringIO(), io.StringIO()
    told = [str(word) for word in words]
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        code = run_command_line(told)
    return CompletedProcess(told, code, out.getvalue(), err.getvalue())


def process(*words: str | bytes | Path, folder: Path) -> CompletedProcess[str]:
    """Give a command in a process of its own."""
    command = [sys.executable, "-m", "ipmlang", *words]
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )


def bounded(*words: str | Path, folder: Path) -> CompletedProcess[str]:
    """Give a command in a fork with bounded memory and time; a traceback fails the test."""
    told = [str(word) for word in words]
    names = [folder.parent / f"{folder.name}.{name}" for name in ("out", "err")]
    server = _server()
    assert server.stdin and server.stdout
    print(json.dumps([told, str(folder), *map(str, names)]), file=server.stdin, flush=True)
    if not select.select([server.stdout], [], [], PATIENCE)[0]:
        server.kill()
        _server.cache_clear()
        raise TimeoutError(f"{told} is not done after {PATIENCE} s")
    code = int(server.stdout.readline())
    out, err = (name.read_text(encoding="utf-8") for name in names)
    assert "Traceback" not in err, err
    assert code in (0, 1), err
    return CompletedProcess(told, code, out, err)


@cache
def _server() -> subprocess.Popen[str]:
    """A process that forks for each command: it ends when its input does, with the tests."""
    return subprocess.Popen(
        [sys.executable, "-m", "tests.cli.commands"],
        cwd=Path(__file__).resolve().parents[2],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _serve() -> None:
    with tempfile.TemporaryDirectory() as folder:  # all that is loaded when needed is loaded now
        Path(folder, "a.svg").write_text(DRAWING, encoding="utf-8")
        for words in ("infer a.svg -o a.ipm", "run a.ipm -o b.svg", "check nowhere.ipm"):
            ipmlang(*words.split(), folder=Path(folder))
    for line in sys.stdin:
        words, folder, *names = json.loads(line)
        child = os.fork()
        if not child:
            for stream, name in zip((1, 2), names, strict=True):
                os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
            os.chdir(folder)
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
            sys.argv[1:] = words
            main()
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    _serve()
