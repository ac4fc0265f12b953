"""Splits a file into its top-level items, and remembers what their texts were parsed to.

An item starts in the first column; indented lines go on with it, and so do lines that start with a
closing bracket, a comma, a bar or `-->`, as no item starts like that. Empty lines and whole-line
comments belong to the item below them. Nothing is parsed here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Generic, TypeAlias, TypeVar

Result = TypeVar("Result")

# The end of a line, the empty and comment lines below it, and group 1 if an item starts there. It
# takes in every such line once, so a file of comments alone is no trap. (Possessive groups, `)*+`,
# would say so better, but before Python 3.11.5 they do not match what they should.)
_LINE = re.compile(r"\n(?:[^\S\n]*+(?://[^\n]*+)?\n)*((?!//|-->)(?=[^\s)\]}|,]))?")
_FIRST = re.compile(r"(?!//|-->)(?=[^\s)\]}|,])")
_CODE = re.compile(r"^[^\S\n]*+(?!//)\S", re.MULTILINE)
_NO_CODE = re.compile(r"[^\S\n]*+(?://[^\n]*+)?\Z")

Piece: TypeAlias = "tuple[int, int]"


def split(text: str) -> list[Piece]:
    """The ranges of a file's items, in order. An item starts where the one before it ends, so that
    its lead (empty lines, comments) is in it; the first starts at its code: what is above is the
    file's header.
    """
    gaps = [match.span() for match in _LINE.finditer(text) if match.lastindex]
    if not _FIRST.match(text):
        if not gaps:
            return []
        gaps[0] = (gaps[0][1], gaps[0][1])
    else:
        gaps.insert(0, (0, 0))
    if '\n"' in text or text.startswith('"'):
        gaps = _without_docs(text, gaps)
    starts = [start for start, _ in gaps]
    return list(zip(starts, [*starts[1:], _last_end(text, gaps[-1][1])], strict=True))


def _without_docs(text: str, gaps: list[Piece]) -> list[Piece]:
    """The gaps above items, but for those below a string: it documents the rule that follows."""
    kept = []
    documents = False
    for gap in gaps:
        if not documents:
            kept.append(gap)
        documents = text[gap[1]] == '"'
    return kept


def _last_end(text: str, code: int) -> int:
    """Where the last item ends: after its last line that is not empty and not only a comment."""
    end = code
    for match in _LINE.finditer(text, code):
        if not _NO_CODE.match(text, match.end()):
            end = match.end()
    line_end = text.find("\n", end)
    return len(text) if line_end < 0 else line_end


def stray_code(text: str, stop: int) -> int | None:
    """Where code stands above the first item, if there is any."""
    match = _CODE.search(text, 0, stop)
    return None if match is None else match.end() - 1


@dataclass(slots=True)
class ItemCache(Generic[Result]):
    """What the texts of items were parsed to: at least the last `limit` that were asked for.

    Two generations stand in for an order of use: what is used moves to the young one, and when that
    is full the old one is dropped.
    """

    limit: int = 50_000
    young: dict[str, Result] = field(default_factory=dict)
    old: dict[str, Result] = field(default_factory=dict)

    def find(self, text: str) -> Result | None:
        """What was kept for this text."""
        found = self.young.get(text)
        if found is None:
            found = self.old.get(text)
            if found is not None:
                self.keep(text, found)
        return found

    def find_all(self, texts: list[str]) -> list[Result | None]:
        """What was kept for each of many texts."""
        found = list(map(self.young.get, texts))
        for index, each in enumerate(found):
            if each is None:
                found[index] = self.find(texts[index])
        return found

    def keep(self, text: str, result: Result) -> None:
        """Remembers a result."""
        if len(self.young) >= self.limit:
            self.old = self.young
            self.young = {}
        self.young[text] = result
