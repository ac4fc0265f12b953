"""Splitting, spans, the cache, line ends, and that time grows with the text and no faster."""

from __future__ import annotations

import cProfile
import pstats
from collections.abc import Callable

import pytest

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.items import ItemCache, split
from ipmlang.compiler.parse import new_cache, parse
from ipmlang.compiler.tables import TABLES, generate
from ipmlang.compiler.tokens import count_tokens, is_free_name, reserved_words
from tests.syntax.test_round_trip import tree


def test_the_shipped_tables_are_those_of_the_grammar() -> None:
    assert TABLES.read_text(encoding="utf-8") == generate(), (
        "grammar.lark was changed: run `python -m ipmlang.compiler.tables`"
    )


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("", []),
        ("// only\n  // comments", []),
        ("A --> B", ["A --> B"]),
        ("\n\nA --> B\n  C\n", ["A --> B\n  C"]),
        ("A --> B\n// c\nC --> D\n// e", ["A --> B", "\n// c\nC --> D"]),
        ("A --> x {\n  B\n}\nC --> D", ["A --> x {\n  B\n}", "\nC --> D"]),
        ("A\n--> B\n", ["A\n--> B"]),
        ('"doc"\n"more"\nA --> B\nC --> D', ['"doc"\n"more"\nA --> B', "\nC --> D"]),
        ("A --> B\n\t// c\n\tC\n", ["A --> B\n\t// c\n\tC"]),
        ("/ --> B\n//\n", ["/ --> B"]),
    ],
)
def test_split(text: str, pieces: list[str]) -> None:
    assert [text[start:end] for start, end in split(text)] == pieces


def test_line_ends_and_tabs() -> None:
    text = "// a\nA(x) --> B // b\n\n    [C]\n\nD --> E // f\n"
    plain = tree(text)
    other = tree(text.replace("\n", "\r\n").replace("    ", "\t"))
    assert other == plain
    assert format_grammar(other) == format_grammar(plain)


def test_spans_are_those_of_the_text() -> None:
    text = "// above\nA --> F\n\n// note\nB(x) : x > 1 --> [C(x + 1)]\n"
    grammar = tree(text)
    rule = grammar.items[1]
    assert isinstance(rule, ast.Rule)
    offset = grammar.offsets[1]

    def cut(span: ast.Span) -> str:
        return text[offset + span.start : offset + span.end]

    assert cut(rule.span) == "B(x) : x > 1 --> [C(x + 1)]"
    assert cut(rule.head.span) == "B(x)"
    assert rule.guard is not None and cut(rule.guard.span) == "x > 1"
    assert cut(rule.body[0].span) == "[C(x + 1)]"
    assert cut(rule.comments[0].span) == "// note"


def test_only_what_changed_is_read_again() -> None:
    text = "".join(f"A{i} --> B C({i})\n" for i in range(300))
    cache = new_cache()
    first, _ = parse(Source("a.ipm", text), cache)
    second, _ = parse(Source("a.ipm", text.replace("A7 -->", "A7 --> D")), cache)
    kept = [old is new for old, new in zip(first.items, second.items, strict=True)]
    assert kept.count(False) == 1 and not kept[7]
    assert parse(Source("a.ipm", text))[0] == first


def test_a_cached_error_has_its_place_in_the_new_text() -> None:
    cache = new_cache()
    parse(Source("a.ipm", "A --> B\nC -> D\n"), cache)
    _, diagnostics = parse(Source("a.ipm", "A --> B B B\nC -> D\n"), cache)
    assert [each.start for each in diagnostics] == [14]


def test_the_cache_is_bounded() -> None:
    cache: ItemCache[str] = ItemCache(limit=10)
    for number in range(1000):
        cache.keep(str(number), "x")
    assert cache.find("999") == "x" and cache.find("0") is None
    assert len(cache.young) + len(cache.old) <= 20


def calls(action: Callable[[], object]) -> int:
    """How many calls, of Python and C functions, an action makes."""
    profile = cProfile.Profile()
    profile.runcall(action)
    return int(pstats.Stats(profile).total_calls)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "make",
    [
        lambda n: "".join(f"A{i} : x > {i} --> [at({i}, 2, 3.5) B] C(x + 1)\n" for i in range(n)),
        lambda n: "start " + " ".join(f"[at({i}, 2) A]" for i in range(n)),
        lambda n: "table T(x, y) =\n" + "\n".join(f"    ({i}, -2.5)" for i in range(n)),
        lambda n: "table T(x, y) =\n" + "\n".join(f"    ({i}, n)" for i in range(n)),
        lambda n: "A --> comp { " + " | ".join(f"{i}: B" for i in range(n)) + " }",
        lambda n: "//\n" * n + "A --> B\n" + "    // c\n    C\n" * n,
        lambda n: "A --> f(" + ", ".join(["x"] * n) + ")",
        lambda n: "\n" * n + " " * n + "//\nA --> B" + " " * n,
    ],
    ids=["rules", "axiom", "rows", "names", "parts", "comments", "arguments", "blanks"],
)
def test_work_grows_with_the_text(make: Callable[[int], str]) -> None:
    def work(size: int) -> int:
        source = Source("a.ipm", make(size))
        return calls(lambda: format_grammar(parse(source)[0]))

    work(10)
    small, large = work(300), work(600)
    assert large <= 2.1 * small + 200


def test_tokens() -> None:
    assert count_tokens(tree("A(x) --> f(1, -2.5) [B] // c")) == 14
    assert count_tokens(tree('asset A, B in "http://x" // c')) == 5


def test_reserved_words() -> None:
    assert {"start", "repeat", "and", "at", "weight"} <= reserved_words()
    assert is_free_name("Wall") and is_free_name("roofs.Hip") and is_free_name("Größe")
    assert not is_free_name("steps") and not is_free_name("2a") and not is_free_name("a-b")
