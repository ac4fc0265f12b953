"""Unlike things in a line, as a walk along it: `[at(5, 3) A B f(4) C]`.

Takes the bodies of rules as they are printed; where placements follow each other at one place or
ahead on one line, upright and unscaled (the letters of a word, the parts of a fence), says how far
it is from each to the next, so that one can be put between or widened and the others make room.
What is drawn stays the same. Rows of one thing are sequences and lattices, which others find.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import pairwise

from ipmlang.compiler import ast
from ipmlang.inverse.moves import call

LEAST = 2  # tokens that a walk saves
PLACED, STARTED, STEP = 8, 5, 4  # tokens of `[at(x, y) A]`, of `at(x, y)` and of `f(d)`


@dataclass(frozen=True, slots=True)
class _Stop:
    """A thing that is only moved, and where it stands."""

    x: float
    y: float
    thing: ast.Module

    @property
    def moved(self) -> bool:
        """Whether it takes words to get there."""
        return bool(self.x or self.y)


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
    return here.y == there.y and here.x <= there.x


def _written(walk: list[tuple[_Stop, ast.Element]]) -> Iterator[ast.Element]:
    """The walk, or as it was where that is no longer."""
    stops = [stop for stop, _ in walk]
    moves = sum(here.x != there.x for here, there in pairwise(stops))
    before = sum(PLACED if stop.moved else 1 for stop in stops)
    if not stops or before - 2 - STARTED * stops[0].moved - len(stops) - STEP * moves < LEAST:
        yield from (element for _, element in walk)
        return
    first = stops[0]
    made: list[ast.Element] = []
    if first.moved:
        made.append(call("at", ast.Number(first.x), ast.Number(first.y)))
    made.append(first.thing)
    for here, there in pairwise(stops):
        # The difference of decimals, so that sums of steps are the places that were rounded.
        step = Decimal(repr(there.x)) - Decimal(repr(here.x))
        if step:
            made.append(call("f", ast.Number(float(step))))
        made.append(there.thing)
    yield ast.Bracket(tuple(made))
