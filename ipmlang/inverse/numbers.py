"""Numbers as a person would write them: the shortest decimal that is close enough.

Takes values with the error that each may have; gives literals of the syntax tree. The bound on the
error is the caller's; nothing here knows what the numbers mean.
"""

from __future__ import annotations

from decimal import Decimal
from functools import lru_cache

from ipmlang.compiler import ast

KEPT = 1 << 14  # answers of `shortest`: candidates for one drawing print the same numbers again
PLACES = 16  # decimal places that are tried are fewer
NEARLY_WHOLE = 1e-2  # degrees that a full turn may seem to be off by the digits of its parts
ROOM = 16.0  # how many times the error a value may be off that is left out


@lru_cache(KEPT, typed=True)
def shortest(value: float, error: float) -> float:
    """The decimal with fewest places that is within `error` of the value, else the value itself.

    >>> shortest(12.999999999, 1e-6), shortest(0.3333333, 1e-4), shortest(-0.0, 0.1)
    (13.0, 0.3333, 0.0)
    """
    if error == 0:
        return value + 0.0
    best = round(value, 0)
    if abs(best - value) <= error:
        return best + 0.0
    # A decimal that is near enough is one with more places, too: halve the places that may be it.
    best, least, most = value, 1, PLACES
    while least < most:
        places = (least + most) // 2
        rounded = round(value, places)
        if abs(rounded - value) <= error:
            best, most = rounded, places
        else:
            least = places + 1
    return best + 0.0


def is_whole_turn(angle: float, count: int, room: float) -> bool:
    """Whether so many turns by an angle (degrees) come to a full one, within `room` or but for the
    last digit of the angle.

    >>> is_whole_turn(51.42857, 7, 1e-9), is_whole_turn(51.0, 7, 1e-9), is_whole_turn(60.0, 5, 1e-9)
    (True, False, False)
    """
    places = -int(Decimal(repr(angle)).normalize().as_tuple().exponent)
    digit = min(count * 0.5 * 10.0**-places, NEARLY_WHOLE)
    return abs(abs(angle) * count - 360) <= max(room, digit)


def settled(value: float, error: float, neutral: float = 0.0) -> float:
    """The same, with more room for the value that says nothing, so that it need not be said.

    >>> settled(3e-7, 1e-7), settled(0.9999995, 1e-7, 1.0), settled(2.0000005, 1e-7)
    (0.0, 1.0, 2.0000005)
    """
    if abs(value - neutral) <= ROOM * error:
        return neutral
    return shortest(value, error)


def number(value: float, error: float = 0.0) -> ast.Expr:
    """A literal; a negative one is one node, as the parser reads it."""
    return ast.Number(shortest(value, error))


def linear(first: float, slope: float, variable: str, errors: tuple[float, float]) -> ast.Expr:
    """`first + slope * variable`, parts that are nothing left out."""
    start, step = shortest(first, errors[0]), shortest(slope, errors[1])
    name = ast.Name(variable)
    if step == 0:
        return number(start)
    term: ast.Expr = name if abs(step) == 1 else ast.Binary("*", ast.Number(abs(step)), name)
    if start == 0:
        if step > 0:
            return term
        if isinstance(term, ast.Binary):
            return ast.Binary("*", number(step), name)
        return ast.Unary("-", name)
    return ast.Binary("+" if step > 0 else "-", number(start), term)


def quadratic(slope: float, second: float, variable: str, errors: tuple[float, float]) -> ast.Expr:
    """`slope * variable + second * variable * variable`, parts that are nothing left out."""
    bend = shortest(second, errors[1])
    if bend == 0:
        return linear(0.0, slope, variable, (0.0, errors[0]))
    name = ast.Name(variable)
    step = shortest(slope, errors[0])
    square = ast.Binary("*", ast.Binary("*", number(abs(bend) if step else bend), name), name)
    if step == 0:
        return square
    return ast.Binary("+" if bend > 0 else "-", linear(0.0, step, variable, (0.0, 0.0)), square)
