"""No comment is lost and none changes the tree, wherever it stands."""

from __future__ import annotations

import pytest

from ipmlang.compiler.automaton import lexicon, tokens
from ipmlang.compiler.format import format_grammar
from tests.syntax.test_round_trip import check_round_trip, tree

SAMPLES = [
    "A(x) : x > 1 : 30% --> f(1, 2) [g(x + 1) B] set x = 3 repeat(i < 3) { F } C",
    "A --> split y { 4.4: Ground | { ~3.2: Floor B }* | 0.6: } comp { side: A | top and not b: B }",
    "Bark --> tube(0.01, sides: 12) at each segment { leaf | twig } F",
    "table T(x, y) = (1, 2), (3, 4)\n    (5, n)",
    'start A [B] on polygon [(0, 0), (1, 0)] steps 3, retries 4 choices "01"',
    'attr floors : int = 6 in 1..60 "storeys"',
    'asset A, B in "x.svg"',
    "A < B > [C] D --> E",
]


@pytest.mark.parametrize("sample", SAMPLES)
def test_one_comment_anywhere(sample: str) -> None:
    plain = tree(sample)
    for token in tokens(lexicon(), sample):
        for gap in (" // here\n    ", "\n    // here\n    ", "\n\n  // one\n  // two\n\n  "):
            if token.start == 0:
                continue
            text = sample[: token.start] + gap + sample[token.start :]
            assert tree(text) == plain
            check_round_trip(text)
    check_round_trip(sample + " // behind")
    check_round_trip("// above\n" + sample + "\n// below\n")


@pytest.mark.parametrize("sample", SAMPLES)
def test_a_comment_in_every_gap(sample: str) -> None:
    found = [token for token in tokens(lexicon(), sample) if token.start]
    text = sample
    for number, token in reversed(list(enumerate(found))):
        text = f"{text[: token.start]} // {number}\n    {text[token.start :]}"
    check_round_trip(text)


def test_comments_keep_their_places() -> None:
    text = """\
// header

// about ipm
ipm 1  // version

// about A
A --> split x {
      // the wall
      ~1: Wall  // left
    | 2: Door
    // nothing more
    }
// trailer
"""
    formatted = format_grammar(tree(text))
    assert formatted == text.replace(
        "    | 2: Door\n    // nothing more\n", "    | 2: Door  // nothing more\n"
    )


def test_empty_lines_are_kept_once() -> None:
    text = "A --> B\n\n\n\nC --> D\nE --> F\n\n\n// note\n\nG --> H\n\n\n"
    assert format_grammar(tree(text)) == "A --> B\n\nC --> D\nE --> F\n\n// note\n\nG --> H\n"
