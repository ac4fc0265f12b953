"""Gives the comments of an item to the nodes they speak of.

A comment on a line of its own goes to the next element, part or item that starts below it; one
behind code goes to the last that ends before it; one in front of a closing bracket stays behind
what it follows. In come an item fresh from the parser and the ranges of its comments, out goes the
same item with every comment in it.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

from ipmlang.compiler import ast

Anchor: TypeAlias = "ast.Element | ast.Part | ast.SplitPart | ast.SplitGroup | ast.Item"
Ranges: TypeAlias = "list[tuple[int, int]]"


def comment(text: str, start: int, end: int, trailing: bool, blank_before: bool) -> ast.Comment:
    """The comment that stands at a range of a text."""
    words = text[start + 2 : end].strip()
    return ast.Comment(words, ast.Span(start, end), trailing, blank_before)


def attach(item: ast.Item, text: str, ranges: Ranges, blank_before: bool) -> ast.Item:
    """The item with its comments, and with a note whether an empty line stands above its code."""
    code = item.span.start
    comments = [_read(text, start, end) for start, end in ranges]
    lead = tuple(each for each in comments if each.span.start < code)
    inner = comments[len(lead) :]
    blank = _blank_above(text, code) or (blank_before and not lead)
    if lead or blank:
        item = replace(item, comments=lead, blank_before=blank)
    if inner and isinstance(item, ast.Table) and item.rows:
        return _attach_rows(item, text, inner)
    if inner:
        _attach_inner(item, text, inner)
    return item


def _read(text: str, start: int, end: int) -> ast.Comment:
    line = text.rfind("\n", 0, start) + 1
    trailing = bool(text[line:start].strip())
    return comment(text, start, end, trailing, not trailing and _blank_above(text, start))


def _blank_above(text: str, place: int) -> bool:
    """Whether an empty line stands above the line of `place`. What is left of the line on which
    the text begins belongs to the item before it, and does not count.
    """
    line = text.rfind("\n", 0, place)
    above = text.rfind("\n", 0, line) if line > 0 else -1
    return above >= 0 and not text[above:line].strip()


@dataclass(slots=True)
class _Anchors:
    """The nodes that can bear comments: by start, and by end; outer ones first to be found."""

    opening: list[Anchor]
    starts: list[int]
    closing: list[Anchor]
    ends: list[int]


def _anchors(item: ast.Item) -> _Anchors:
    opening = list(_bearers(item))
    order = sorted(
        range(len(opening)), key=lambda i: (opening[i].span.end, -opening[i].span.start, -i)
    )
    closing = [opening[i] for i in order]
    return _Anchors(
        opening,
        [node.span.start for node in opening],
        closing,
        [node.span.end for node in closing],
    )


def _bearers(node: Anchor) -> Iterator[Anchor]:
    """A node and all below it that can bear comments, in the order of the text."""
    yield node
    if isinstance(node, ast.Start):
        below: tuple[Anchor, ...] = node.axiom
    elif isinstance(node, ast.Split | ast.SplitGroup | ast.Block | ast.Each):
        below = node.parts
    elif isinstance(node, ast.Rule | ast.Bracket | ast.Repeat | ast.Part | ast.SplitPart):
        below = node.body
    else:
        below = ()
    for each in below:
        yield from _bearers(each)


def _attach_inner(item: ast.Item, text: str, comments: list[ast.Comment]) -> None:
    """Gives comments to the nodes of an item that nobody has seen yet, which alone is why they may
    be changed.
    """
    anchors = _anchors(item)
    closes = _before_closing(text, comments)
    owned: dict[int, tuple[Anchor, list[ast.Comment]]] = {}
    for each, closing in zip(comments, closes, strict=True):
        owner, trailing = _owner(anchors, text, each, closing)
        node = owner or item
        owned.setdefault(id(node), (node, []))[1].append(replace(each, trailing=trailing))
    for node, found in owned.values():
        object.__setattr__(node, "comments", (*node.comments, *found))


def _owner(
    anchors: _Anchors, text: str, each: ast.Comment, closing: bool
) -> tuple[Anchor | None, bool]:
    """The node a comment belongs to, and whether it stands behind that node."""
    after = bisect_left(anchors.starts, each.span.end)
    before = bisect_right(anchors.ends, each.span.start)
    following = anchors.opening[after] if after < len(anchors.opening) else None
    preceding = anchors.closing[before - 1] if before else None
    if preceding is not None:
        near = each.trailing and each.span.start - preceding.span.end < 1000
        follows = near and not text[preceding.span.end : each.span.start].strip(" \t\r\n|,")
        if follows or following is None or closing:
            return preceding, True
    return following, False


def _before_closing(text: str, comments: list[ast.Comment]) -> list[bool]:
    """For each comment whether the first code after it is a closing bracket."""
    flags = []
    flag, limit = False, len(text)
    for each in reversed(comments):
        code = text[each.span.end : limit].lstrip()[:1]
        flag = code in ")]}" if code else flag
        flags.append(flag)
        limit = each.span.start
    return flags[::-1]


def _attach_rows(table: ast.Table, text: str, comments: list[ast.Comment]) -> ast.Table:
    """Comments of an inline table stand with their rows, by index."""
    starts = [row[0].span.start for row in table.rows]
    ends = [row[-1].span.end for row in table.rows]
    placed = []
    for each in comments:
        before = bisect_right(ends, each.span.start) - 1
        if each.trailing and before >= 0:
            placed.append((before, each))
        else:
            row = min(bisect_left(starts, each.span.end), len(starts) - 1)
            placed.append((row, replace(each, trailing=False)))
    return replace(table, row_comments=tuple(placed))
