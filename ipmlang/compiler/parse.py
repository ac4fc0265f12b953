"""Text to syntax tree: a file is split into items, each is read alone and remembered by its text.

Out come the tree of all items that could be read and one diagnostic for each that could not; a
broken item spoils no other. What an item was parsed to depends on its text alone, so after an edit
only the items that changed are read again. Nothing is looked up here: names are the checker's.

These words are keywords only where the grammar can take them; elsewhere they are names: first in an
item, `ipm import style asset table surface context attr const fn turtle limit tropism ignore canvas
axes residual site start interpret`; in expressions, `if then else and or not true false`; in a
successor, `repeat split set with`; after the colon of a head, `else weight`; after the axiom of
`start`, `on steps seeds direction with avoiding retries choices`; and `as style extends in
stretch atlas radius except box polygon over nearest` after what they belong to.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from ipmlang.compiler import ast, build, build_declarations, build_expressions
from ipmlang.compiler.automaton import Automaton, RefusedError, TooDeepError, load, run
from ipmlang.compiler.build_expressions import UnbuildableError
from ipmlang.compiler.comments import attach, comment
from ipmlang.compiler.depth import too_deep
from ipmlang.compiler.diagnostics import Diagnostic, Source
from ipmlang.compiler.items import ItemCache as Cache
from ipmlang.compiler.items import Piece, split, stray_code
from ipmlang.compiler.syntax_errors import Trouble, explain
from ipmlang.formats.collection import without_collection

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
    r"""The tree of a file, and what is wrong with its syntax.

    >>> grammar, diagnostics = parse(Source("koch.ipm", "F --> F + F\nstart F F\n"))
    >>> [type(item).__name__ for item in grammar.items], diagnostics
    (['Rule', 'Start'], ())
    """
    text = source.text
    pieces = split(text)
    header, blank = _lead(text[: max(0, pieces[0][0] - 1)] if pieces else text)
    with without_collection():
        parsed = _parse_all([text[start:end] for start, end in pieces], blank, cache)
    diagnostics = _stray(source, pieces)
    diagnostics += [
        _diagnostic(each.trouble, source, start)
        for each, (start, _) in zip(parsed, pieces, strict=True)
        if each.trouble is not None
    ]
    items = tuple(each.item for each in parsed if each.item is not None)
    offsets = tuple(
        start for each, (start, _) in zip(parsed, pieces, strict=True) if each.item is not None
    )
    trailer = _lead(text[pieces[-1][1] :])[0] if pieces else ()
    return ast.Grammar(items, header, trailer, offsets), tuple(diagnostics)


def _parse_all(texts: list[str], blank: bool, cache: ItemCache | None) -> list[Parsed]:
    """All items, from the cache where they can be. Only the first can have an empty line above it
    that is not in its text; then it is read anew.
    """
    found: list[Parsed | None] = [None] * len(texts)
    if cache is not None:
        found = cache.find_all(texts)
    if blank and texts:
        found[0] = parse_item(texts[0], True)
    parsed = []
    for text, known in zip(texts, found, strict=True):
        if known is None:
            known = parse_item(text)
            if cache is not None:
                cache.keep(text, known)
        parsed.append(known)
    return parsed


def parse_item(text: str, blank_before: bool = False) -> Parsed:
    """One item with its lead. Never raises; the time is linear in the text."""
    if len(text) > MAX_ITEM:
        message = f"an item of more than {MAX_ITEM // 1_000_000} million characters is not read"
        hint = "bulk numbers belong in a table of the parts file"
        return Parsed(None, Trouble("item-too-long", message, 0, 1, hint=hint))
    comments: list[tuple[int, int]] = []
    try:
        item = run(_machine(), text, comments)
    except RefusedError as refused:
        return Parsed(None, explain(refused, text))
    except UnbuildableError as wrong:
        return Parsed(
            None, Trouble(wrong.code, wrong.message, wrong.start, wrong.end, None, wrong.hint)
        )
    except TooDeepError as deep:
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
    """The automaton, with the functions that build by the aliases of the grammar."""
    builders = {
        name.removeprefix("build_"): function
        for file in (build, build_expressions, build_declarations)
        for name, function in vars(file).items()
        if name.startswith("build_") and callable(function)
    }
    return load(builders)


def _lead(text: str) -> tuple[tuple[ast.Comment, ...], bool]:
    """The comments of a text without code, and whether its last line is empty."""
    found = []
    blank = False
    offset = 0
    for line in text.split("\n"):
        content = line.strip()
        if content.startswith("//"):
            start = offset + line.index("//")
            found.append(comment(text, start, offset + len(line.rstrip()), False, blank))
        blank = not content and offset > 0
        offset += len(line) + 1
    return tuple(found), blank


def _stray(source: Source, pieces: list[Piece]) -> list[Diagnostic]:
    """The diagnostic for code above the first item."""
    text = source.text
    place = stray_code(text, pieces[0][0] if pieces else len(text))
    if place is None:
        return []
    end = text.find("\n", place)
    end = len(text) if end < 0 else end
    if place == 0 or text[place - 1] == "\n":
        code, message = "no-item", f"no item starts with `{text[place]}`"
    else:
        code = "item-not-in-first-column"
        message = "this line is indented, and there is no item above that it could go on with"
    hint = "every item starts in the first column, with a word or with the head of a rule"
    return [Diagnostic(code, message, source=source, start=place, end=end, hint=hint)]


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
