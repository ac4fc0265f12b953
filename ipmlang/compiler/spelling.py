"""Spells what stands within a line of `.ipm` text: numbers, strings, expressions, labels, heads.

In come expressions of the syntax tree, out goes text with as few brackets as the grammar allows,
which parses to the same tree. A spelling is a list of words, so that a line can be broken between
any two of them; joined with blanks they are the text.
"""

from __future__ import annotations

import math
import re
from typing import assert_never

from ipmlang.compiler import ast

LEVELS = {"or": 1, "and": 2, "<": 4, "<=": 4, ">": 4, ">=": 4, "==": 4, "!=": 4} | {
    "+": 5, "-": 5, "*": 6, "/": 6,
}  # fmt: skip
# What stands in brackets and is no longer than this is not broken over lines.
UNBROKEN = 40
NOT, COMPARISON, SIGNED, ATOM = 3, 4, 7, 8
_LITERAL = re.compile(r"-?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?")
_SPECIAL = re.compile(r'[\\"\x00-\x1f\x7f]')
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def format_expression(expression: ast.Expr) -> str:
    """The text of an expression.

    >>> product = ast.Binary("*", ast.Name("a"), ast.Binary("+", ast.Name("b"), ast.Number(1.0)))
    >>> format_expression(product)
    'a * (b + 1)'
    """
    return " ".join(expression_words(expression))


def number_text(number: ast.Number) -> str:
    """A literal as it was written, or else in its shortest form."""
    if number.text and _LITERAL.fullmatch(number.text) and float(number.text) == number.value:
        return number.text
    if not math.isfinite(number.value):
        raise ValueError(f"{number.value} has no spelling in a grammar")
    if number.value == int(number.value) and abs(number.value) < 1e16:
        return f"{number.value:.0f}"
    return repr(float(number.value)).replace("e+", "e").replace("e0", "e").replace("e-0", "e-")


def quote(value: str) -> str:
    """A string literal."""
    if _SPECIAL.search(value) is None:
        return f'"{value}"'
    resolved = _SPECIAL.sub(lambda match: _ESCAPES.get(match[0], f"\\u{ord(match[0]):04x}"), value)
    return f'"{resolved}"'


def expression_words(expression: ast.Expr, level: int = 0) -> list[str]:
    """An expression that stands where operators of `level` or tighter are taken."""
    found, own = _words(expression)
    return _bracketed(found) if own < level else found


def bound_words(expression: ast.Expr) -> list[str]:
    """A value that stands beside others without a comma."""
    words, level = _words(expression)
    plain = level == ATOM and not isinstance(expression, ast.Text | ast.Truth)
    return words if plain or isinstance(expression, ast.Number) else _bracketed(words)


def _bracketed(words: list[str]) -> list[str]:
    words[0] = "(" + words[0]
    words[-1] += ")"
    return words


def _words(expression: ast.Expr) -> tuple[list[str], int]:
    """The words of an expression, and the level of its outermost operator."""
    match expression:
        case ast.Number():
            text = number_text(expression)
            return [text], SIGNED if text.startswith("-") else ATOM
        case ast.Text(value=value):
            return [quote(value)], ATOM
        case ast.Truth(value=truth):
            return ["true" if truth else "false"], ATOM
        case ast.Name(id=name):
            return [name], ATOM
        case ast.Call(name=name, args=args):
            return enclosed(name + "(", argument_words(args), ")"), ATOM
        case ast.Unary():
            return _unary(expression)
        case ast.Binary():
            return _binary(expression)
        case ast.If(condition=condition, value=value_, other=other):
            parts = [("if", condition), ("then", value_), ("else", other)]
            return [word for key, part in parts for word in [key, *expression_words(part)]], 0
        case ast.Tuple(items=items):
            return tuple_words(items), ATOM
        case _:
            assert_never(expression)


def _unary(expression: ast.Unary) -> tuple[list[str], int]:
    if expression.op == "not":
        return ["not", *expression_words(expression.value, NOT)], NOT
    words = expression_words(expression.value, SIGNED)
    return ["-" + words[0], *words[1:]], SIGNED


def _binary(expression: ast.Binary) -> tuple[list[str], int]:
    level = LEVELS[expression.op]
    left = expression_words(expression.left, level + 1 if level == COMPARISON else level)
    right = expression_words(expression.right, level + 1)
    return [*left, f"{expression.op} {right[0]}", *right[1:]], level


def tuple_words(items: tuple[ast.Expr, ...]) -> list[str]:
    """`(a, b)`; of one item `(a,)`."""
    words = comma_separated([expression_words(item) for item in items])
    return enclosed("(", words, ",)" if len(items) == 1 else ")")


def row_words(items: tuple[ast.Expr, ...]) -> list[str]:
    """`(a, b)` where one item in brackets is a list of one."""
    return enclosed("(", comma_separated([expression_words(item) for item in items]), ")")


def argument_words(args: tuple[ast.Argument, ...]) -> list[str]:
    """`1, by: (2, 0)`."""
    return comma_separated([_argument(each) for each in args])


def _argument(argument: ast.Argument) -> list[str]:
    words = expression_words(argument.value)
    return [f"{argument.name}:", *words] if argument.name is not None else words


def comma_separated(spellings: list[list[str]]) -> list[str]:
    """Several spellings with commas behind all but the last."""
    for words in spellings[:-1]:
        words[-1] += ","
    return [word for words in spellings for word in words]


def enclosed(opening: str, words: list[str], closing: str) -> list[str]:
    """Words between two brackets, without blanks inside; few of them are one word."""
    if not words:
        return [opening + closing]
    words[0] = opening + words[0]
    words[-1] += closing
    return words if sum(map(len, words)) > UNBROKEN else [" ".join(words)]


# ------------------------------------------------------------------------ labels


def label_words(label: ast.Expr, level: int = 0) -> list[str]:
    """A label of a part: all but names, literals, calls, `and`, `or`, `not` is in brackets."""
    match label:
        case ast.Binary(op="or" | "and" as op, left=left, right=right):
            own = LEVELS[op]
            words = [*label_words(left, own), f"{op} {' '.join(label_words(right, own + 1))}"]
        case ast.Unary(op="not", value=value):
            own = NOT
            words = ["not", *label_words(value, NOT)]
        case ast.Text() | ast.Name() | ast.Call() | ast.Tuple():
            return expression_words(label)
        case ast.Number() if not number_text(label).startswith("-"):
            return expression_words(label)
        case _:
            return _bracketed(expression_words(label))
    return _bracketed(words) if own < level else words


# ------------------------------------------------------------------------- heads


def head_text(head: ast.Head) -> str:
    """`A < B(x) > C`."""
    left = f"{_context(head.left.modules)} < " if head.left is not None else ""
    right = f" > {_context(head.right.modules)}" if head.right is not None else ""
    return left + head.name + parameters_text(head.parameters) + right


def parameters_text(parameters: tuple[ast.Parameter, ...]) -> str:
    """`(x, y)`, or nothing for none."""
    return f"({', '.join(each.name for each in parameters)})" if parameters else ""


def _context(modules: tuple[ast.ContextModule | ast.ContextBranch, ...]) -> str:
    return " ".join(_context_entry(each) for each in modules)


def _context_entry(entry: ast.ContextModule | ast.ContextBranch) -> str:
    if isinstance(entry, ast.ContextBranch):
        return f"[{_context(entry.modules)}]"
    return entry.name + parameters_text(entry.parameters)


def clause_text(rule: ast.Rule) -> str:
    """`: guard : 30%`, or nothing."""
    clauses = []
    if isinstance(rule.guard, ast.Otherwise):
        clauses.append(": else")
    elif rule.guard is not None:
        clauses.append(": " + format_expression(rule.guard))
    if rule.chance is not None:
        value = format_expression(rule.chance.value)
        clauses.append(f": {value}%" if rule.chance.kind == "percent" else f": weight {value}")
    return " ".join(clauses)
