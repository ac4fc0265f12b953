"""Unlike things in a line, as a walk along it: `[at(5, 3) A f(2.5) B f(4) C]`.

Takes the bodies of rules as they are printed; where placements follow each other ahead on one line,
upright and unscaled (the letters of a word, the parts of a fence), says how far it is from each to
the next, so that one can be put between or widened and the others make room. What is drawn stays
the same. Rows of one thing are sequences and lattices, which others find.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import pairwise

from ipmlang.compiler import ast
from ipmlang.inverse.moves import call

LEAST = 3  # placements that make a walk


@dataclass(frozen=True, slots=True)
class _Stop:
    """A thing that is only moved, and where it stands."""

    x: float
    y: float
    thing: ast.Module


def with_walks(rule: ast.Rule, staying: Set[str]) -> ast.Rule:
    """The rule with walks; staying: names of what leaves the turtle where it was."""
    return replace(rule, body=_walked(rule.body, staying))


def _walked(body: tuple[ast.Element, ...], staying: Set[str]) -> tuple[ast.Element, ...]:
    made: list[ast.Element] = []
    walk: list[tuple[_Stop, ast.Element]] = []
    for element in body:
        stop = _stop(element, staying)
        if walk and (stop is None or not _ahead(walk[-1][0], stop)):
            made += _written(walk)
            walk = []
        if stop is not None:
            walk.append((stop, element))
        elif isinstance(element, ast.Bracket):
            made.append(replace(element, body=_walked(element.body, staying)))
        else:
            made.append(element)
    return (*made, *_written(walk))


def _stop(element: ast.Element, staying: Set[str]) -> _Stop | None:
    """`A` or `[at(x, y) A]`."""
    match element:
        case ast.Module(name, ()) if name in staying:
            return _Stop(0.0, 0.0, element)
        case ast.Bracket(
            (
                ast.Module(
                    "at",
                    (ast.Argument(ast.Number(x)), ast.Argument(ast.Number(y))),
                ),
                ast.Module(name, ()) as thing,
            )
        ) if name in staying:
            return _Stop(x, y, thing)
    return None


def _ahead(here: _Stop, there: _Stop) -> bool:
    return here.y == there.y and here.x < there.x


def _written(walk: list[tuple[_Stop, ast.Element]]) -> Iterator[ast.Element]:
    """The walk, or as it was where it is too short."""
    if len(walk) < LEAST:
        yield from (element for _, element in walk)
        return
    first = walk[0][0]
    made: list[ast.Element] = []
    if first.x or first.y:
        made.append(call("at", ast.Number(first.x), ast.Number(first.y)))
    made.append(first.thing)
    for (here, _), (there, _) in pairwise(walk):
        # The difference of decimals, so that sums of steps are the places that were rounded.
        step = Decimal(repr(there.x)) - Decimal(repr(here.x))
        made += [call("f", ast.Number(float(step))), there.thing]
    yield ast.Bracket(tuple(made))
