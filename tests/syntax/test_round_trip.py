"""What is formatted parses to the same tree, and formatting it again changes nothing."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings

from ipmlang.compiler import ast
from ipmlang.compiler.automaton import lexicon, tokens
from ipmlang.compiler.diagnostics import Source, render
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.compiler.tokens import count_tokens
from tests.syntax.strategies import GRAMMARS

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = ROOT.parent / "shared" / "design" / "LANGUAGE.md"


def tree(text: str) -> ast.Grammar:
    """The tree of a text without errors."""
    grammar, diagnostics = parse(Source("<text>", text))
    assert not diagnostics, "\n\n".join(render(each) for each in diagnostics)
    return grammar


def check_round_trip(text: str) -> None:
    """Same tree, stable, no comment lost."""
    grammar = tree(text)
    formatted = format_grammar(grammar)
    again = tree(formatted)
    assert again == grammar
    assert format_grammar(again) == formatted
    assert comments(formatted) == comments(text)
    assert count_tokens(grammar) == lexed(formatted)


def lexed(text: str) -> int:
    """The tokens of a text as the automaton reads them, but for commas."""
    count = 0
    for token in tokens(lexicon(), text):
        if token.terminal == "LITERALS":
            count += 3 + token.text.count(",") + len(re.findall(r"(?<![eE])-", token.text))
        elif token.terminal != "COMMA":
            count += 1 + (token.terminal == "AT_EACH")
    return count


def comments(text: str) -> list[str]:
    """The comments of a text, in any order."""
    without_strings = re.sub(r'"(?:[^"\\\n]|\\.)*"', "", text)
    return sorted(each.strip() for each in re.findall(r"//(.*)", without_strings))


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@settings(deadline=None, max_examples=300)
@given(GRAMMARS)
def test_any_tree(grammar: ast.Grammar) -> None:
    text = format_grammar(grammar)
    again = tree(text)
    assert again == grammar
    assert format_grammar(again) == text
    assert count_tokens(grammar) == lexed(text)


@pytest.mark.parametrize(
    "path", [*sorted(ROOT.glob("examples/*.ipm")), *sorted(ROOT.glob("stdlib/**/*.ipm"))], ids=str
)
def test_shipped_files(path: Path) -> None:
    check_round_trip(path.read_text(encoding="utf-8"))


def test_every_example_of_the_language_page() -> None:
    if not PAGE.exists():
        pytest.skip(f"the language page is not here: {PAGE} is absent")
    page = PAGE.read_text(encoding="utf-8").replace("| … ", "").replace("…", "nil")
    blocks = [
        "\n".join(line[4:] for line in block.splitlines())
        for block in re.findall(r"(?:^ {4}.*\n|^\n)+", page, re.MULTILINE)
    ]
    blocks = [block for block in blocks if block.strip()]
    assert len(blocks) >= 6
    for block in blocks:
        check_round_trip(block)
