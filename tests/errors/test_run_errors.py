"""Every golden of the folder `run`: a grammar that checks and cannot be derived, and the message
that a person reads, whichever executor was asked for (`tests/gpu` asks the other one).

A golden is `NAME.txt` with the source and the message; `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import ipmlang
from ipmlang.compiler.diagnostics import IpmError, render
from ipmlang.runtime import derive
from tests.errors.test_errors import MESSAGE, SOURCE

GOLDENS = sorted((Path(__file__).parent / "run").glob("*.txt"))


def message(text: str, backend: str = "cpu") -> str:
    """What is wrong with a grammar, as a person sees it."""
    program = ipmlang.parse(text).program
    with pytest.raises(IpmError) as raised:
        derive(program, seed=1, backend=backend)
    return "\n\n".join(render(each) for each in raised.value.diagnostics) + "\n"


@pytest.mark.parametrize("path", GOLDENS, ids=lambda path: path.stem)
def test_the_message_is_as_it_was_read(path: Path, update: bool) -> None:
    content = path.read_text(encoding="utf-8")
    source, _, expected = content.removeprefix(SOURCE).partition(MESSAGE)
    found = message(source)
    if update:
        path.write_text(SOURCE + source + MESSAGE + found, encoding="utf-8")
    else:
        assert found == expected


def test_there_are_goldens() -> None:
    assert len(GOLDENS) >= 12
