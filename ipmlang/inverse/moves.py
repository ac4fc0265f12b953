"""What moves the turtle from one copy of a sequence to the next, as elements of a rule's body.

Takes patterns and the error that a point may take; gives `+(α) f(d) *(s) +(β)`, or a placement that
is linear in the index `i`. Nothing here knows symbols or rules.
"""

from __future__ import annotations

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.frames import Row
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.numbers import is_whole_turn, linear, number, quadratic, settled


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


def placing(place: Row, errors: tuple[float, float, float]) -> tuple[ast.Element, ...]:
    """`at(x, y, angle, scale) mirror`, what is nothing left out; errors: what positions, angles and
    factors may be off.
    """
    x, y = (settled(each, errors[0]) for each in place[:2])
    angle, scale = settled(place[2], errors[1]), settled(place[3], errors[2], 1.0)
    made: list[ast.Element] = []
    if x or y:
        numbers = [x, y] + ([angle] if angle or scale != 1 else [])
        numbers += [scale] if scale != 1 else []
        made.append(call("at", *(number(each) for each in numbers)))
    else:
        made += turns(angle, scale)
    if place[4] < 0:
        made.append(ast.Module("mirror"))
    return tuple(made)


def turtle_step(
    pattern: Pattern, count: int, error: float, radius: float, variable: str
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
    values = [linear(first, slope, variable, (each, each / count)) for first, slope, each in terms]
    named = zip(("+", "f", "*", "+"), values, (0.0, 0.0, 1.0, 0.0), strict=True)
    made = [
        call(name, value)
        for name, value, nothing in named
        if not (isinstance(value, ast.Number) and value.value == nothing)
    ]
    return (*made, ast.Module("mirror")) if pattern.mirrored else tuple(made)


def even_place(
    pattern: Pattern, count: int, errors: tuple[float, float, float], variable: str
) -> tuple[ast.Element, ...]:
    """`at(x * i, y * i, a * i, 1 + s * i)`, what is nothing left out; errors of distances, angles
    (degrees) and factors that the last of `count` copies may have.
    """
    (x, y, angle, growth), (x2, y2, angle2, growth2) = pattern.base, pattern.delta
    size, turn, factor = (error / count for error in errors)
    turned = quadratic(angle, angle2, variable, (turn, turn / count))
    scaled = quadratic(growth, growth2, variable, (factor, factor / count))
    still = abs(angle) <= turn and abs(angle2) <= turn / count
    same = abs(growth) <= factor and abs(growth2) <= factor / count
    scaled = ast.Binary("+", ast.Number(1.0), scaled)
    if not growth2:
        scaled = linear(1.0, growth, variable, (0.0, factor))
    if any(abs(each) > size for each in (x, y)) or any(abs(e) > size / count for e in (x2, y2)):
        pairs = ((x, x2), (y, y2))
        arguments = [quadratic(*each, variable, (size, size / count)) for each in pairs]
        arguments += [turned] if not (still and same) else []
        return (call("at", *arguments, *([] if same else [scaled])),)
    around = () if still else (call("+", turned),)
    return around if same else (*around, call("*", scaled))


def around(
    turn: float, error: float, count: int, limit: ast.Expr | None, variable: str
) -> ast.Expr:
    """`50 * i`, or `360 / n * i` where `count` turns are a full one. limit: what says the count,
    None where it is not the same everywhere.
    """
    if limit is None or not is_whole_turn(turn, count, error * count):
        return linear(0.0, turn, variable, (0.0, error))
    each = ast.Binary("/", number(360.0 if turn > 0 else -360.0), limit)
    return ast.Binary("*", each, ast.Name(variable))


def polar_place(
    pattern: Pattern,
    count: int,
    errors: tuple[float, float, float],
    around: ast.Expr,
    variable: str,
) -> tuple[ast.Element, ...]:
    """`+(around) f(radius) *(1 + s * i)`, what is nothing left out; errors as above."""
    _, radius, change, growth = pattern.base
    size, _, factor = errors
    made: list[ast.Element] = [call("+", around)]
    if pattern.rooted:
        index: ast.Expr = linear(change, 1.0, variable, (1e-6, 0.0))
        share = size / float(np.sqrt(count + abs(change)))
        root = ast.Call("sqrt", (ast.Argument(index),))
        made.append(call("f", ast.Binary("*", number(radius, share), root)))
    elif abs(radius) > size or abs(change) * count > size:
        made.append(call("f", linear(radius, change, variable, (size, size / count))))
    if pattern.upright:
        made.append(call("-", around))
    if abs(growth) * count > factor:
        made.append(call("*", linear(1.0, growth, variable, (0.0, factor / count))))
    return tuple(made)
