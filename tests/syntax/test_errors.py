"""Messages about syntax: goldens of sources and what is said about them, and what must hold always.

A golden `errors/*.txt` holds cases: a source, a line of dashes, the rendered messages; cases are
parted by a line of equals signs.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipmlang.compiler.diagnostics import Source, render
from ipmlang.compiler.parse import parse

FOLDER = Path(__file__).parent / "errors"
CASE, ANSWER = "=" * 60, "-" * 60
PIECES = st.sampled_from(
    [
        *("A", "B", "x", "y", "é", "1", ".5", "1.", "30%", "'x'", '"', "//", "\n", "\n\t", "\r"),
        *("(", ")", "[", "]", "{", "}", "|", ":", ";", ",", "-->", "->", "+", "-", "*", "/"),
        *("~", "'", "=", "==", "<", ">", "..", "#", "%", "\\", "\0", "at", "each", "repeat"),
        *("split", "set", "start", "attr", "if", "then", "else", "and", "not", "true"),
    ]
)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.txt")), ids=lambda path: path.stem)
def test_messages(path: Path, update: bool) -> None:
    cases = path.read_text(encoding="utf-8").split(f"\n{CASE}\n")
    written = []
    for case in cases:
        text = case.split(f"\n{ANSWER}\n")[0]
        _, diagnostics = parse(Source("a.ipm", text))
        said = "\n\n".join(render(each) for each in diagnostics)
        written.append(f"{text}\n{ANSWER}\n{said}")
    result = f"\n{CASE}\n".join(written).rstrip("\n") + "\n"
    if update:
        path.write_text(result, encoding="utf-8")
    assert result == path.read_text(encoding="utf-8")


def test_a_broken_item_spoils_no_other() -> None:
    text = "A --> F [\nB --> F\nC -> F\nD --> F\n"
    grammar, diagnostics = parse(Source("a.ipm", text))
    assert [item.head.name for item in grammar.items] == ["B", "D"]  # type: ignore[union-attr]
    assert [text[each.start : each.end] for each in diagnostics] == ["[", "->"]


@settings(deadline=None, max_examples=400)
@given(st.lists(PIECES, max_size=14).map(" ".join) | st.text(max_size=20))
def test_any_text_gets_a_tree_or_a_message(text: str) -> None:
    """Never an exception; every message has a place in the file and can be shown."""
    _, diagnostics = parse(Source("a.ipm", text))
    for each in diagnostics:
        assert 0 <= each.start <= each.end <= len(text)
        assert each.message and render(each)


@pytest.mark.parametrize(
    "text",
    [
        "A --> " + "[" * 5000 + "]" * 5000,
        "A --> f(" + "(" * 5000 + "1" + ")" * 5000 + ")",
        "const x = " + "- " * 5000 + "y",
        "const x = " + "not " * 5000 + "y",
        "const x = " + " + ".join(["a"] * 5000),
        "const x = " + "if a then b else " * 5000 + "c",
        "const x = " + "f(" * 5000 + ")" * 5000,
        "A --> " + "comp { a: " * 5000 + "}" * 5000,
        "A --> split x { " + "{ 1: B }* | " * 3 + "{" * 5000,
        "[" * 5000 + "B" + "]" * 5000 + " < A --> C",
    ],
    ids=range(10),
)
def test_nesting_is_bounded(text: str) -> None:
    _, diagnostics = parse(Source("a.ipm", text))
    assert [each.code for each in diagnostics] == ["nested-too-deeply"]
