"""Sums and products of expressions, as short as a person would write them.

In go expressions of the syntax tree and numbers, out come expressions: literals are computed,
neutral parts left out. Nothing here knows where an expression stands.
"""

from __future__ import annotations

import math

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail

DIGITS = 12  # significant digits of a computed literal: enough, without the dust of binary floats


def literal(value: float) -> ast.Number:
    """A number without the last digits, which are rounding errors. Raises IpmError for one that is
    too large to be written.

    >>> literal(0.1 + 0.2).value
    0.3
    """
    if not math.isfinite(value):
        raise fail("out-of-range", "this edit makes a number that is too large to be written")
    return ast.Number(float(f"{value:.{DIGITS}g}") + 0.0)


def number_of(expr: ast.Expr) -> float | None:
    """The value of a literal, None for what is computed."""
    return expr.value if isinstance(expr, ast.Number) else None


def scaled(expr: ast.Expr, factor: float) -> ast.Expr:
    """`factor * expr`; a factor that is there already is multiplied.

    >>> from ipmlang.compiler.format import format_expression
    >>> format_expression(scaled(scaled(ast.Name("w"), 2), 1.5)), scaled(ast.Number(4.0), 0.5).value
    ('3 * w', 2.0)
    """
    value = number_of(expr)
    if value is not None:
        return literal(value * factor)
    match expr:
        case ast.Binary("*", ast.Number(before), rest):
            return scaled(rest, before * factor)
        case _ if math.isclose(factor, 1.0):
            return expr
        case _:
            return ast.Binary("*", literal(factor), expr)


def slope(expr: ast.Expr, variable: str) -> ast.Expr | None:
    """What one step of `variable` adds to an expression, where that is plain to see.

    >>> from ipmlang.compiler.format import format_expression
    >>> turn = ast.Binary("*", ast.Number(40.0), ast.Name("i"))
    >>> format_expression(slope(ast.Binary("+", ast.Number(7.0), turn), "i"))
    '40'
    """
    match expr:
        case ast.Name(name) if name == variable:
            return ast.Number(1.0)
        case ast.Binary("*", left, ast.Name(name)) if name == variable and not uses(left, name):
            return left
        case ast.Binary("*", ast.Name(name), right) if name == variable and not uses(right, name):
            return right
        case ast.Binary("+" | "-" as sign, left, right):
            if not uses(right, variable):
                return slope(left, variable)
            if uses(left, variable):
                return None
            found = slope(right, variable)
            return found if sign == "+" or found is None else scaled(found, -1.0)
        case _:
            return None


def uses(expr: ast.Expr, name: str) -> bool:
    """Whether a name stands in an expression."""
    match expr:
        case ast.Name(found):
            return found == name
        case ast.Call(args=args):
            return any(uses(each.value, name) for each in args)
        case ast.Unary(value=value):
            return uses(value, name)
        case ast.Binary(left=left, right=right):
            return uses(left, name) or uses(right, name)
        case ast.If(condition, value, other):
            return any(uses(each, name) for each in (condition, value, other))
        case ast.Tuple(items):
            return any(uses(each, name) for each in items)
        case _:
            return False


def added(expr: ast.Expr, more: ast.Expr) -> ast.Expr:
    """`expr + more`, without a first term that is 0."""
    return more if number_of(expr) == 0 else ast.Binary("+", expr, more)
