"""Every golden of this folder: a wrong grammar, and the message that a person reads.

A golden is `NAME.txt` with the source and the messages; `pytest --update` writes the messages anew.
Read the difference aloud before committing it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.compiler.check import Cache, check
from ipmlang.compiler.diagnostics import Source, render
from ipmlang.compiler.load import load_source

FOLDER = Path(__file__).parent
GOLDENS = sorted(FOLDER.glob("*.txt"))
SOURCE, MESSAGE = "--- source ---\n", "--- message ---\n"


def messages(text: str, name: str) -> str:
    """All that is wrong with a grammar, as a person sees it."""
    loaded = load_source(Source(f"parts/{name}.ipm", text), Path("parts"))
    found = check(loaded, Cache()).diagnostics
    return "\n\n".join(render(each) for each in found).replace("parts/", "") + "\n"


@pytest.mark.parametrize("path", GOLDENS, ids=lambda path: path.stem)
def test_the_message_is_as_it_was_read(
    path: Path, update: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(FOLDER)
    content = path.read_text(encoding="utf-8")
    source, _, expected = content.removeprefix(SOURCE).partition(MESSAGE)
    found = messages(source, path.stem)
    if update:
        path.write_text(SOURCE + source + MESSAGE + found, encoding="utf-8")
    else:
        assert found == expected


def test_there_are_goldens() -> None:
    assert len(GOLDENS) >= 40
