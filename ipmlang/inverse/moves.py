"""What moves the turtle from one copy of a sequence to the next, as elements of a rule's body.

Takes patterns and the error that a point may take; gives `+(α) f(d) *(s) +(β)`, or a placement that
is linear in the index `i`. Nothing here knows symbols or rules.
"""

from __future__ import annotations

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.numbers import linear


def call(name: str, *args: ast.Expr) -> ast.Module:
    """An operation with plain arguments."""
    return ast.Module(name, tuple(ast.Argument(each) for each in args))


def turns(angle: float, scale: float) -> tuple[ast.Element, ...]:
    """`+(30) *(0.5)`, what is nothing left out."""
    made: list[ast.Element] = []
    if angle:
        made.append(call("+" if angle > 0 else "-", ast.Number(abs(angle))))
    if scale != 1:
        made.append(call("*", ast.Number(scale)))
    return tuple(made)


def turtle_step(
    pattern: Pattern, count: int, error: float, radius: float
) -> tuple[ast.Element, ...]:
    """`+(α) f(d) *(s) +(β)` with t(m) = t0 + tΔ·m (section 5.1 of the paper).

    error: what the last of `count` copies, of extent `radius`, may be off; errors add up twice, as
    a wrong turn moves all that follows.
    """
    reach = abs(pattern.base[1]) + abs(pattern.delta[1]) * count + radius
    share = error / max(1.0, float(count) ** 2)
    factor = share / max(reach * count, share)
    errors = (float(np.rad2deg(factor)), share, factor, float(np.rad2deg(factor)))
    terms = zip(pattern.base, pattern.delta, errors, strict=True)
    values = [linear(first, slope, "i", (each, each / count)) for first, slope, each in terms]
    named = zip(("+", "f", "*", "+"), values, (0.0, 0.0, 1.0, 0.0), strict=True)
    made = [
        call(name, value)
        for name, value, nothing in named
        if not (isinstance(value, ast.Number) and value.value == nothing)
    ]
    return (*made, ast.Module("mirror")) if pattern.mirrored else tuple(made)


def even_place(
    pattern: Pattern, count: int, errors: tuple[float, float, float]
) -> tuple[ast.Element, ...]:
    """`at(x * i, y * i, a * i, 1 + s * i)`, what is nothing left out; errors of distances, angles
    (degrees) and factors that the last of `count` copies may have.
    """
    x, y, angle, growth = pattern.base
    size, turn, factor = (error / count for error in errors)
    turned = linear(0.0, angle, "i", (0.0, turn))
    scaled = linear(1.0, growth, "i", (0.0, factor))
    if abs(x) > size or abs(y) > size:
        arguments = [*(linear(0.0, each, "i", (0.0, size)) for each in (x, y)), turned]
        return (call("at", *arguments, *([scaled] if abs(growth) > factor else [])),)
    around = (call("+", turned),) if abs(angle) > turn else ()
    return (*around, call("*", scaled)) if abs(growth) > factor else around
