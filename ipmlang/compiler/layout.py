"""Lays the elements of a successor out in lines of at most 100 columns.

What fits stays on one line. A long body is broken between elements, a long block has one part per
line, with its bars below each other; a node with a comment has lines of its own. In come elements
and a page that is being written, nothing goes out but lines on that page; each element is spelled a
bounded number of times, so the time is linear.
"""

from __future__ import annotations

from typing import TypeAlias, assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.spelling import (
    argument_words,
    enclosed,
    expression_words,
    label_words,
    row_words,
)

WIDTH = 100
INDENT = 4
AnyPart: TypeAlias = "ast.Part | ast.SplitPart | ast.SplitGroup"
Commented: TypeAlias = "AnyPart | ast.Element"


class Page:
    """Lines that are being written, word by word."""

    def __init__(self, first: str = "") -> None:
        self.lines: list[str] = []
        self.line = first
        self.glued = not first
        self.ended = False

    def word(self, text: str, base: int, reserve: int = 0) -> None:
        """Adds a word to the line, or to a new one indented by `base` when the line would be longer
        than WIDTH with `reserve` more characters.
        """
        needed = len(self.line) + (not self.glued) + len(text) + reserve
        if self.ended or (needed > WIDTH and self.line.strip() and not self.glued):
            self.break_line(base)
        self.line += text if self.glued else " " + text
        self.glued = False

    def words(self, texts: list[str], base: int, reserve: int = 0) -> None:
        """Adds words; `reserve` is what must still fit behind the last one."""
        for text in texts[:-1]:
            self.word(text, base)
        for text in texts[-1:]:
            self.word(text, base, reserve)

    def close(self, text: str, base: int) -> None:
        """Adds a closing bracket right behind the last word."""
        self.glued = True
        self.word(text, base)

    def break_line(self, base: int) -> None:
        """Starts a new line, unless the current one is still empty."""
        if self.line.strip():
            self.lines.append(self.line.rstrip())
        self.line = " " * base
        self.glued, self.ended = True, False

    def comment(self, comment: ast.Comment, base: int) -> None:
        """Writes a comment behind the line or on its own."""
        text = comment_text(comment)
        if comment.trailing and not self.ended and self.line.strip():
            self.line += "  " + text
        else:
            self.break_line(base)
            if comment.blank_before and not comment.trailing and self.lines:
                self.lines.append("")
            self.line += text
        self.ended = True

    def finish(self) -> list[str]:
        """All lines."""
        self.break_line(0)
        return self.lines


def comment_text(comment: ast.Comment) -> str:
    """`// text`, on one line."""
    return f"// {' '.join(comment.text.split(chr(10)))}".rstrip()


# --------------------------------------------------------------------- one line


def flat_body(body: tuple[ast.Element, ...], room: int) -> str | None:
    """A body on one line of at most `room` characters, if it has no comment and fits."""
    texts: list[str] = []
    for index, element in enumerate(body):
        text = None if element.comments else flat(element, room, _is_mark(body, index + 1))
        if text is None or len(text) > room:
            return None
        texts.append(text)
        room -= len(text) + 1
    return " ".join(texts)


def _is_mark(body: tuple[ast.Element, ...], index: int) -> bool:
    """Whether an element starts with a mark that an expression before it would take in."""
    if index >= len(body):
        return False
    element = body[index]
    if isinstance(element, ast.Each):
        element = element.target
    return isinstance(element, ast.Module) and element.name in ("+", "-", "*", "/")


def flat(element: ast.Element, room: int, before_mark: bool = False) -> str | None:
    """One element on one line; its own comments are left to the caller."""
    match element:
        case ast.Module():
            return " ".join(module_words(element))
        case ast.Assign() | ast.Local():
            return " ".join(naming_words(element, before_mark))
        case ast.Bracket(body=body):
            inner = flat_body(body, room - 2)
            return None if inner is None else f"[{inner}]"
        case ast.Repeat(body=body):
            inner = flat_body(body, room)
            return (
                None if inner is None else f"{_opening(element)} {inner} }}".replace("{  }", "{ }")
            )
        case ast.Split() | ast.Block() | ast.Each():
            inner = _flat_parts(element.parts, room)
            return None if inner is None else f"{_opening(element)} {inner}}}"
        case _:
            assert_never(element)


def _opening(element: ast.Repeat | ast.Split | ast.Block | ast.Each) -> str:
    return " ".join(opening_words(element))


def _flat_parts(parts: tuple[AnyPart, ...], room: int) -> str | None:
    texts: list[str] = []
    for part in parts:
        text = None if part.comments else _flat_part(part, room)
        if text is None or len(text) > room:
            return None
        texts.append(text)
        room -= len(text) + 3
    return " | ".join(texts) + " " if texts else ""


def _flat_part(part: AnyPart, room: int) -> str | None:
    if isinstance(part, ast.SplitGroup):
        inner = _flat_parts(part.parts, room - 4)
        return None if inner is None else f"{{ {inner}}}{part.mode}"
    body = flat_body(part.body, room)
    if body is None:
        return None
    return " ".join([*part_words(part), body]).rstrip()


# ------------------------------------------------------------------------ words


def module_words(module: ast.Module) -> list[str]:
    """`at(1, 2)`."""
    if not module.args:
        return [module.name]
    return enclosed(module.name + "(", argument_words(module.args), ")")


def naming_words(naming: ast.Assign | ast.Local, before_mark: bool) -> list[str]:
    """`set x = 1`, in brackets where a mark follows that would go on with the expression."""
    word = "set" if isinstance(naming, ast.Assign) else "with"
    value = expression_words(naming.value)
    if before_mark:
        return [word, f"({naming.name}", "=", *value[:-1], value[-1] + ")"]
    return [word, naming.name, "=", *value]


def opening_words(element: ast.Repeat | ast.Split | ast.Block | ast.Each) -> list[str]:
    """What stands before the body of a block, with its opening brace."""
    match element:
        case ast.Repeat():
            return [*_repeat_words(element), "{"]
        case ast.Split(axis=axis, args=args):
            return ["split", *(_called(axis, args)), "{"]
        case ast.Block(name=name, args=args):
            return [*_called(name, args), "{"]
        case ast.Each(target=target, feature=feature):
            return [*module_words(target), f"at each {feature}", "{"]
        case _:
            assert_never(element)


def _called(name: str, args: tuple[ast.Argument, ...]) -> list[str]:
    return enclosed(name + "(", argument_words(args), ")") if args else [name]


def _repeat_words(repeat: ast.Repeat) -> list[str]:
    match repeat.head:
        case ast.Count(variable=variable, limit=limit):
            words = [f"repeat({variable} <", *expression_words(limit)]
        case ast.Rows(table=table, places=True):
            words = ["repeat(at", table]
        case ast.Rows(variable=variable, table=table):
            words = [f"repeat({variable} in", table]
        case _:
            assert_never(repeat.head)
    words[-1] += ")"
    if repeat.holes:
        words += ["except", *row_words(repeat.holes)]
    if repeat.steps:
        words += ["steps", *row_words(repeat.steps)]
    if repeat.rows is not None:
        words.append(f"with {repeat.rows.variable} in {repeat.rows.table}")
    return words


def part_words(part: ast.Part | ast.SplitPart) -> list[str]:
    """A part's label or size, with its colon; nothing for none."""
    if isinstance(part, ast.Part):
        words = [] if part.label is None else label_words(part.label)
    else:
        words = expression_words(part.size.value)
        sign = {"absolute": "", "relative": "'", "floating": "~"}[part.size.kind]
        words[0] = sign + words[0]
    if words:
        words[-1] += ":"
    return words


# ------------------------------------------------------------------- many lines


def fill(page: Page, body: tuple[ast.Element, ...], base: int, reserve: int = 0) -> None:
    """Writes elements one after the other, broken between them where a line is full."""
    for index, element in enumerate(body):
        _leading(page, element, base)
        room = WIDTH - base - reserve
        before_mark = _is_mark(body, index + 1)
        text = flat(element, room, before_mark)
        if text is not None and len(text) <= room:
            page.word(text, base, reserve)
        else:
            _broken(page, element, base, reserve, before_mark)
        _trailing(page, element, base)


def _leading(page: Page, node: Commented, base: int) -> None:
    for comment in node.comments:
        if not comment.trailing:
            page.comment(comment, base)


def _trailing(page: Page, node: Commented, base: int) -> None:
    for comment in node.comments:
        if comment.trailing:
            page.comment(comment, base)


def _broken(page: Page, element: ast.Element, base: int, reserve: int, before_mark: bool) -> None:
    match element:
        case ast.Module():
            page.words(module_words(element), base + INDENT, reserve)
        case ast.Assign() | ast.Local():
            page.words(naming_words(element, before_mark), base + INDENT, reserve)
        case ast.Bracket(body=body):
            if not page.glued:
                page.break_line(base)
            page.word("[", base)
            page.glued = True
            fill(page, body, base + INDENT, reserve + 1)
            page.close("]", base)
        case ast.Repeat(body=body):
            page.words(opening_words(element), base + INDENT)
            page.break_line(base + INDENT)
            fill(page, body, base + INDENT)
            page.break_line(base)
            page.word("}", base)
        case ast.Split() | ast.Block() | ast.Each():
            page.words(opening_words(element), base + INDENT)
            _parts(page, element.parts, base)
            page.word("}", base)
        case _:
            assert_never(element)


def _parts(page: Page, parts: tuple[AnyPart, ...], base: int) -> None:
    """Parts on lines of their own, bars below each other, up to the line of the closing brace."""
    for index, part in enumerate(parts):
        page.break_line(base + 2)
        _leading(page, part, base + 2)
        page.break_line(base)
        page.line += "| " if index else "  "
        page.glued = True
        _part(page, part, base + INDENT)
        _trailing(page, part, base + 2)
    page.break_line(base)


def _part(page: Page, part: AnyPart, base: int) -> None:
    room = WIDTH - base
    text = _flat_part(part, room)
    if text is not None and len(text) <= room:
        page.word(text, base)
    elif isinstance(part, ast.SplitGroup):
        page.word("{", base)
        _parts(page, part.parts, base)
        page.word("}" + part.mode, base)
    else:
        page.words(part_words(part), base)
        fill(page, part.body, base)
