"""Text to syntax tree: a file is split into items, each is read by itself, and remembered by its text.

Out come the tree of all items that could be read and one diagnostic for each that could not; a
broken item spoils no other. What an item was parsed to depends on its text alone, so after an edit
only the items that changed are read again. Nothing is looked up here: names are the checker's.

These words are keywords only where the grammar can take them; elsewhere they are names:
first in an item, `ipm import asset table surface context attr const fn turtle limit tropism ignore canvas axes
site start interpret`; in expressions, `if then else and or not true false`; in a successor, `repeat split
set`; after a colon of a head, `else weight`; after the axiom of `start`, `on steps seeds direction with
avoiding retries choices`; and `as in atlas radius except box polygon` after what they belong to.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.automaton import Automaton, Refused, TooDeep, load, run
from ipmlang.compiler.build import Unbuildable, builders
from ipmlang.compiler.comments import attach, comment
from ipmlang.compiler.depth import too_deep
from ipmlang.compiler.diagnostics import Diagnostic, Source
from ipmlang.compiler.items import ItemCache as Cache
from ipmlang.compiler.items import Piece, split, stray_code
from ipmlang.compiler.syntax_errors import Trouble, explain

MAX_ITEM = 64_000_000


@dataclass(frozen=True, slots=True)
class Parsed:
    """What the text of one item was parsed to; places are relative to that text."""

    item: ast.Item | None
    trouble: Trouble | None


ItemCache: TypeAlias = "Cache[Parsed]"


def new_cache(limit: int = 50_000) -> ItemCache:
    """An empty cache, to be given to every parse of a file that is being edited."""
    return Cache(limit)


def parse(
    source: Source, cache: ItemCache | None = None
) -> tuple[ast.Grammar, tuple[Diagnostic, ...]]:
    """The tree of a file, and what is wrong with its syntax.

    >>> grammar, diagnostics = parse(Source("koch.ipm", "F --> F + F\\nstart F F\\n"))
    >>> [type(item).__name__ for item in grammar.items], diagnostics
    (['Rule', 'Start'], ())
    """
    text = source.text
    pieces = split(text)
    header, blank = _lead(text, pieces[0][0] if pieces else len(text))
    items, offsets, diagnostics = [], [], _stray(source, pieces)
    with _without_collection():
        for start, end in pieces:
            parsed = _parsed(text[start:end], blank, cache)
            blank = False
            if parsed.item is not None:
                items.append(parsed.item)
                offsets.append(start)
            if parsed.trouble is not None:
                diagnostics.append(_diagnostic(parsed.trouble, source, start))
    trailer = _lead(text[pieces[-1][1] :], None)[0] if pieces else ()
    return ast.Grammar(tuple(items), header, trailer, tuple(offsets)), tuple(diagnostics)


@contextmanager
def _without_collection() -> Iterator[None]:
    """Holds the search for reference cycles off: trees have none, and on a large file it takes as
    long as the parsing, and grows faster than the file."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def parse_successor(text: str) -> tuple[ast.Element, ...]:
    """The elements of a successor by itself; raises IpmError where it is wrong."""
    from ipmlang.compiler.diagnostics import IpmError

    grammar, diagnostics = parse(Source("<text>", "Successor --> " + text))
    rule = grammar.items[0] if grammar.items else None
    if diagnostics or not isinstance(rule, ast.Rule):
        raise IpmError(diagnostics)
    return rule.body


def _parsed(text: str, blank: bool, cache: ItemCache | None) -> Parsed:
    """One item, from the cache where it can be. Only the first item can have an empty line above
    that is not in its text; it is read again each time."""
    if blank or cache is None:
        return parse_item(text, blank)
    found = cache.find(text)
    if found is None:
        found = parse_item(text, False)
        cache.keep(text, found)
    return found


def parse_item(text: str, blank_before: bool = False) -> Parsed:
    """One item with its lead. Never raises; the time is linear in the text."""
    if len(text) > MAX_ITEM:
        message = f"an item of more than {MAX_ITEM // 1_000_000} million characters is not read"
        hint = "bulk numbers belong in a table of the parts file"
        return Parsed(None, Trouble("item-too-long", message, 0, 1, hint=hint))
    comments: list[tuple[int, int]] = []
    try:
        item = run(_machine(), text, comments)
    except Refused as refused:
        return Parsed(None, explain(refused, text))
    except Unbuildable as wrong:
        return Parsed(None, Trouble(wrong.code, wrong.message, wrong.start, wrong.end, None, wrong.hint))
    except TooDeep as deep:
        return Parsed(None, _nesting(deep.start, deep.end))
    assert isinstance(item, ast.Item)
    if too_deep(item, text):
        return Parsed(None, _nesting(item.span.start, item.span.end))
    return Parsed(attach(item, text, comments, blank_before), None)


def _nesting(start: int, end: int) -> Trouble:
    message = "this is nested too deeply to be read"
    return Trouble("nested-too-deeply", message, start, end, hint="make a rule of the inner part")


@cache
def _machine() -> Automaton:
    return load(builders())


def _lead(text: str, stop: int | None) -> tuple[tuple[ast.Comment, ...], bool]:
    """The comments of a text without code, and whether it ends with an empty line."""
    found = []
    blank = False
    offset = 0
    for line in _lines(text[:stop]):
        content = line.strip()
        if content.startswith("//"):
            start = offset + line.index("//")
            found.append(comment(text, start, offset + len(line.rstrip()), False, blank))
        blank = not content and offset > 0
        offset += len(line)
    return tuple(found), blank


def _lines(text: str) -> list[str]:
    return [line + "\n" for line in text.split("\n")]


def _stray(source: Source, pieces: list[Piece]) -> list[Diagnostic]:
    """The diagnostic for indented code above the first item."""
    place = stray_code(source.text, pieces[0][0] if pieces else len(source.text))
    if place is None:
        return []
    end = source.text.find("\n", place)
    return [
        Diagnostic(
            "item-not-in-first-column",
            "this line is indented, and there is no item above that it could go on with",
            source=source,
            start=place,
            end=len(source.text) if end < 0 else end,
            hint="every item starts in the first column",
        )
    ]


def _diagnostic(trouble: Trouble, source: Source, offset: int) -> Diagnostic:
    return Diagnostic(
        trouble.code,
        trouble.message,
        source=source,
        start=offset + trouble.start,
        end=offset + trouble.end,
        expected=trouble.expected,
        hint=trouble.hint,
    )
