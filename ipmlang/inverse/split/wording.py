"""Syntax trees from numbers: what a printed scheme is put together from.

In go values and names, out come expressions, modules and brackets, without a zero, a one or a sign
that says nothing. Which items a grammar has is not known here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from ipmlang.compiler import ast

Vector: TypeAlias = tuple[ast.Expr, ast.Expr, ast.Expr]
NOTHING = ast.Number(0.0)


def call(name: str, *args: ast.Expr) -> ast.Module:
    """`name(a, b)`."""
    return ast.Module(name, tuple(ast.Argument(each) for each in args))


def bracket(body: Sequence[ast.Element]) -> ast.Element:
    """`[ … ]`; a bare symbol needs none, and a bracket around a bracket says nothing."""
    if len(body) == 1 and isinstance(body[0], ast.Module | ast.Bracket) and not _moves(body[0]):
        return body[0]
    return ast.Bracket(tuple(body))


def _moves(element: ast.Element) -> bool:
    return isinstance(element, ast.Module) and bool(element.args)


def plus(left: ast.Expr, right: ast.Expr) -> ast.Expr:
    """`left + right`, or `left - 2` for a right side that begins with a minus."""
    if is_nothing(left):
        return right
    if is_nothing(right):
        return left
    lowered = opposite(right)
    return ast.Binary("+", left, right) if lowered is None else ast.Binary("-", left, lowered)


def opposite(value: ast.Expr) -> ast.Expr | None:
    """What a value is the negative of, if it is written with a minus."""
    match value:
        case ast.Number(number) if number < 0:
            return ast.Number(-number)
        case ast.Unary("-", inner):
            return inner
        case ast.Binary(("*" | "/") as sign, left, right):
            lowered = opposite(left)
            return None if lowered is None else times_of(sign, lowered, right)
        case _:
            return None


def times_of(sign: str, left: ast.Expr, right: ast.Expr) -> ast.Expr:
    """`left * right` or `left / right`, without a factor of one."""
    if sign == "*":
        return times(left, right)
    return ast.Binary("/", left, right)


def times(left: ast.Expr, right: ast.Expr) -> ast.Expr:
    """`left * right`, shorter where a side is 0, 1 or -1."""
    for one, other in ((left, right), (right, left)):
        if isinstance(one, ast.Number):
            if one.value == 0:
                return NOTHING
            if one.value == 1:
                return other
            if one.value == -1 and not isinstance(other, ast.Number):
                return ast.Unary("-", other)
    return ast.Binary("*", left, right)


def is_nothing(value: ast.Expr) -> bool:
    """Whether an expression is the number 0."""
    return isinstance(value, ast.Number) and value.value == 0


def all_nothing(values: Sequence[ast.Expr]) -> bool:
    """Whether all are."""
    return all(map(is_nothing, values))


def added(left: Vector, right: Vector) -> Vector:
    """The sum of two vectors."""
    return (plus(left[0], right[0]), plus(left[1], right[1]), plus(left[2], right[2]))
