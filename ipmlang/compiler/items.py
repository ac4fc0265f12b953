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
# takes in every such line once, so a file of comments alone is no trap.
_LINE = re.compile(r"\n(?:[^\S\n]*+(?://[^\n]*+)?+\n)*+((?!//|-->)(?=[^\s)\]}|,]))?")
_FIRST = re.compile(r"(?!//|-->)(?=[^\s)\]}|,])")
_INDENTED_CODE = re.compile(r"^[^\S\n]+(?!//)[^\s/]|^[^\S\n]+/(?!/)", re.MULTILINE)
_NO_CODE = re.compile(r"[^\S\n]*+(?://[^\n]*+)?+\Z")

Piece: TypeAlias = "tuple[int, int]"


def split(text: str) -> list[Piece]:
    """The ranges of a file's items, in order. An item starts where the one before it ends, so that
    its lead (empty lines, comments) is in it; the first starts at its code: what is above is the
    file's header."""
    ends, starts = [], []
    if _FIRST.match(text):
        starts.append(0)
    documents = text.startswith('"')
    for match in _LINE.finditer(text):
        if match.lastindex:
            if not documents:
                ends.append(match.start())
                starts.append(match.end())
            documents = text[match.end()] == '"'
    if not starts:
        return []
    if len(ends) == len(starts):
        del ends[0]
    return list(zip([starts[0], *ends], [*ends, _last_end(text, starts[-1])], strict=True))


def _last_end(text: str, code: int) -> int:
    """Where the last item ends: after its last line that is not empty and not only a comment."""
    end = code
    for match in _LINE.finditer(text, code):
        if not _NO_CODE.match(text, match.end()):
            end = match.end()
    line_end = text.find("\n", end)
    return len(text) if line_end < 0 else line_end


def stray_code(text: str, stop: int) -> int | None:
    """Where an indented line of code stands before the first item, if there is one."""
    match = _INDENTED_CODE.search(text, 0, stop)
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

    def keep(self, text: str, result: Result) -> None:
        """Remembers a result."""
        if len(self.young) >= self.limit:
            self.old = self.young
            self.young = {}
        self.young[text] = result
