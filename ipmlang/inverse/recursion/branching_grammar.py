"""A branching structure as rules of the language: the paper's r3 and r4, without what says nothing.

In come a proven `Branching`, a name and what stands at each node; out come the two rules of
R(m) and the elements that start it. Nothing here draws or searches.
"""

from __future__ import annotations

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.numbers import linear, shortest
from ipmlang.inverse.recursion.branching import Branching
from ipmlang.inverse.recursion.tips import Tipped
from ipmlang.inverse.recursion.twigs import LENGTH, SCALE, SPIN, TURN, Twig, steps_of

DEPTH = "m"
EXACT = (0.0, 0.0)


def branching_rules(
    branching: Branching,
    name: str,
    node: tuple[ast.Element, ...],
    tip: tuple[ast.Element, ...] | None = None,
) -> tuple[ast.Rule, ...]:
    """The rules of `name`. node: what is drawn at a node, it must leave the turtle in place; tip:
    what is drawn at the ends if that is something else.

    `R(m) : m > 0 --> node [step R(m - 1)] …` and `R(m) : else --> node`; where branches take
    different amounts from m, what is below 0 draws nothing.
    """
    head = ast.Head(name, (ast.Parameter(DEPTH),))
    even = all(twig.less == 1 for twig in branching.twigs)
    guard = ast.Binary(">" if even else ">=", ast.Name(DEPTH), ast.Number(0.0))
    twigs = tuple(ast.Bracket(_twig(twig, name)) for twig in branching.twigs)
    last = (tip or node) if even else (ast.Module("nil"),)
    return (
        ast.Rule(head, (*node, *twigs), guard=guard),
        ast.Rule(head, last, guard=ast.Otherwise()),
    )


def branching_start(branching: Branching, name: str) -> tuple[ast.Element, ...]:
    """`at(x, y, angle, scale) R(depth)`, what says nothing left out."""
    root = branching.root
    numbers = [float(each[0]) for each in (root.x, root.y, root.angle, root.scale)]
    wanted = 4 if numbers[3] != 1 else 3 if numbers[2] != 0 else 2
    place = ast.Module("at", tuple(_argument(value) for value in numbers[:wanted]))
    mirror = (ast.Module("mirror"),) * bool(root.handedness[0] < 0)
    return (place, *mirror, ast.Module(name, (_argument(float(branching.depth)),)))


def tip_place(tipped: Tipped) -> tuple[ast.Element, ...]:
    """What leads from an end to where its tip stands: `+(turn) f(length) *(scale) +(spin)`."""
    numbers = [shortest(float(value), 1e-9) for value in steps_of(tipped.place)[0]]
    hand = int(tipped.place.handedness[0])
    return _steps(Twig(np.array(numbers), np.zeros(4), hand, 0))


def _argument(value: float) -> ast.Argument:
    return ast.Argument(ast.Number(value))


def _twig(twig: Twig, name: str) -> tuple[ast.Element, ...]:
    """`+(turn) f(length) *(scale) +(spin) R(m - less)`."""
    depth = ast.Binary("-", ast.Name(DEPTH), ast.Number(float(twig.less)))
    return (*_steps(twig), ast.Module(name, (ast.Argument(depth),)))


def _steps(twig: Twig) -> tuple[ast.Element, ...]:
    """What leads from a node to the next, what says nothing left out."""
    made: list[ast.Element] = []
    for index, neutral in ((TURN, 0.0), (LENGTH, 0.0), (SCALE, 1.0), (SPIN, 0.0)):
        first, slope = float(twig.first[index]), float(twig.slope[index])
        if first == neutral and slope == 0:
            continue
        if index in (TURN, SPIN):
            made.append(_turn(first, slope))
        else:
            value = linear(first, slope, DEPTH, EXACT)
            made.append(ast.Module("f" if index == LENGTH else "*", (ast.Argument(value),)))
    return (*made, *(ast.Module("mirror"),) * (twig.hand < 0))


def _turn(first: float, slope: float) -> ast.Module:
    """Left or right, so that no angle is written negative."""
    left = first > 0 or (first == 0 and slope > 0)
    sign = 1.0 if left else -1.0
    value = linear(sign * first, sign * slope, DEPTH, EXACT)
    return ast.Module("+" if left else "-", (ast.Argument(value),))
