"""Makes the nodes of expressions: one function per alias of `grammar.lark`, by the same name.

Each takes the members of a production and its range in the item. What the grammar cannot say, such
as how large a number may be or what an escape in a string means, is said here as
`UnbuildableError`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.compiler.ast import Span
from ipmlang.compiler.automaton import Members


@dataclass(slots=True)
class UnbuildableError(Exception):
    """A sentence that the grammar takes and the language does not."""

    code: str
    message: str
    start: int
    end: int
    hint: str | None = None


INFINITE = (float("inf"), float("-inf"))


def build_number(members: Members, start: int, end: int) -> ast.Number:
    text = members[0]
    value = float(text)
    if value in INFINITE:
        raise _too_large(text, start, end)
    return ast.Number(value, text, Span(start, end))


def _too_large(text: str, start: int, end: int) -> UnbuildableError:
    return UnbuildableError("bad-number", f"`{text}` is larger than a number can be", start, end)


def build_negative(members: Members, start: int, end: int) -> ast.Number:
    number = build_number(members[1:], start, end)
    return ast.Number(-number.value, "-" + number.text, Span(start, end))


def build_text(members: Members, start: int, end: int) -> ast.Text:
    return ast.Text(unquote(members[0], start), Span(start, end))


def build_truth(members: Members, start: int, end: int) -> ast.Truth:
    return ast.Truth(members[0] == "true", Span(start, end))


def build_name(members: Members, start: int, end: int) -> ast.Name:
    return ast.Name(members[0], Span(start, end))


def build_call(members: Members, start: int, end: int) -> ast.Call:
    return ast.Call(members[0], tuple(members[1]), Span(start, end))


def build_unary(members: Members, start: int, end: int) -> ast.Number | ast.Unary:
    """A minus before a literal without one makes a negative literal."""
    op, value = members
    if op == "-" and type(value) is ast.Number and not value.text.startswith("-"):
        return ast.Number(-value.value, "-" + value.text, Span(start, end))
    return ast.Unary(op, value, Span(start, end))


def build_binary(members: Members, start: int, end: int) -> ast.Binary:
    return ast.Binary(members[1], members[0], members[2], Span(start, end))


def build_if(members: Members, start: int, end: int) -> ast.If:
    return ast.If(members[1], members[3], members[5], Span(start, end))


def build_tuple_empty(members: Members, start: int, end: int) -> ast.Tuple:
    return ast.Tuple((), Span(start, end))


def build_tuple_single(members: Members, start: int, end: int) -> ast.Tuple:
    return ast.Tuple((members[1],), Span(start, end))


def build_tuple_many(members: Members, start: int, end: int) -> ast.Tuple:
    return ast.Tuple((members[1], *members[3]), Span(start, end))


_LITERAL = re.compile(r"-?[0-9][0-9.eE+-]*")


def build_literals_list(members: Members, start: int, end: int) -> list[ast.Number]:
    """The numbers of a token `(1, -2.5)`."""
    found = []
    for match in _LITERAL.finditer(members[0]):
        text = match[0]
        begin = start + match.start()
        finish = begin + len(text)
        value = float(text)
        if value in INFINITE:
            raise _too_large(text, begin, finish)
        found.append(ast.Number(value, text, Span(begin, finish)))
    return found


def build_literals_arguments(members: Members, start: int, end: int) -> list[ast.Argument]:
    numbers = build_literals_list(members, start, end)
    return [ast.Argument(number, None, number.span) for number in numbers]


def build_literals(members: Members, start: int, end: int) -> ast.Number | ast.Tuple:
    """One number in brackets is that number, several are a tuple."""
    numbers = build_literals_list(members, start, end)
    return numbers[0] if len(numbers) == 1 else ast.Tuple(tuple(numbers), Span(start, end))


def build_argument(members: Members, start: int, end: int) -> ast.Argument:
    return ast.Argument(members[0], None, Span(start, end))


def build_argument_named(members: Members, start: int, end: int) -> ast.Argument:
    return ast.Argument(members[2], members[0], Span(start, end))


# --------------------------------------------------------------- strings--------


ESCAPES = {"n": "\n", "t": "\t", "r": "\r", '"': '"', "\\": "\\"}
_ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{4})|(.))", re.DOTALL)


def unquote(literal: str, start: int) -> str:
    """The value of a string literal that stands at `start`."""
    if "\\" not in literal:
        return literal[1:-1]

    def resolve(match: re.Match[str]) -> str:
        if match[1]:
            return chr(int(match[1], 16))
        if match[2] not in ESCAPES:
            raise UnbuildableError(
                "bad-escape",
                f"`\\{match[2]}` means nothing in a string",
                start + match.start(),
                start + match.end(),
                'there are \\\\ \\" \\n \\r \\t and \\u0041; paths are written with /',
            )
        return ESCAPES[match[2]]

    return _ESCAPE.sub(resolve, literal[:-1])[1:]
