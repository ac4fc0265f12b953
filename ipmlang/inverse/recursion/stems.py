"""Weeds whose every segment is rewritten by one of a few productions, with the draws they took.

In come strokes; out comes a program with alternatives such as F [+ F] F and F [- F] F (page 28 of
The Algorithmic Beauty of Plants). It is read from the twigs down: a side branch of one edge is new,
so the edges along a stem between nodes without one are what one edge became; they become that edge,
and so on until one is left or nothing fits. Nothing is proven here.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TypeAlias

from ipmlang.inverse.recursion.program import (
    Alternative,
    Body,
    Branch,
    Command,
    Recursion,
    Symbol,
    Turn,
)
from ipmlang.inverse.recursion.sizes import FEWEST_STEPS
from ipmlang.inverse.recursion.stochastic import (
    COPY,
    FEWEST_DRAWS,
    MOST_ALTERNATIVES,
    percentages,
)
from ipmlang.inverse.recursion.strokes import Strokes
from ipmlang.inverse.recursion.tree import grow_tree

MOST_EDGES = 24
MOST_AXIOM = 24

Shape: TypeAlias = "tuple[tuple[float, tuple[float, ...]], ...]"
"""A stem: the turn to each of its edges, and those to the side branches at the end of that edge."""


@dataclass(frozen=True, slots=True)
class _Edges:
    """A tree of edges in drawing order: roots, children of each, and the turn to each."""

    roots: tuple[int, ...]
    children: tuple[tuple[int, ...], ...]
    turn: tuple[float, ...]


def stem_program(strokes: Strokes) -> Recursion | None:
    """A program with at least two alternatives, None if there is none."""
    tree = grow_tree(strokes)
    if tree is None:
        return None
    *children, roots = (tuple(each) for each in tree.children)
    edges = _Edges(roots, tuple(children), tuple(tree.turn))
    generations: list[list[Shape]] = []
    while len(edges.turn) > 1:
        contracted = _contracted(edges)
        if contracted is None:
            break
        edges, shapes = contracted
        generations.append(shapes)
    return _written(edges, generations[::-1])


def _contracted(edges: _Edges) -> tuple[_Edges, list[Shape]] | None:
    """The tree one generation earlier, and what each of its edges became; None if one of them
    became nothing that a production makes.
    """
    turn: list[float] = []
    shapes: list[Shape] = []
    number: dict[int, int] = {}
    ahead = list(edges.roots[::-1])
    starts: list[tuple[int, ...]] = []
    while ahead:
        first = ahead.pop()
        stem = _stem(edges, first)
        if stem is None:
            return None
        shape, last = stem
        number[first] = len(shapes)
        shapes.append(shape)
        turn.append(edges.turn[first])
        starts.append(edges.children[last])
        ahead += edges.children[last][::-1]
    children = [tuple(number[first] for first in each) for each in starts]
    roots = tuple(number[first] for first in edges.roots)
    return _Edges(roots, tuple(children), tuple(turn)), shapes


def _stem(edges: _Edges, first: int) -> tuple[Shape, int] | None:
    """The stem that begins with an edge, and its last edge; None if it has no side branch."""
    shape: list[tuple[float, tuple[float, ...]]] = []
    last, turn = first, 0.0
    while len(shape) < MOST_EDGES:
        *sides, onward = edges.children[last] or (-1,)
        if not sides or any(edges.children[side] for side in sides):
            shape.append((turn, ()))
            break
        shape.append((turn, tuple(edges.turn[side] for side in sides)))
        last, turn = onward, edges.turn[onward]
    return (tuple(shape), last) if 1 < len(shape) < MOST_EDGES else None


def _written(edges: _Edges, generations: list[list[Shape]]) -> Recursion | None:
    seen = Counter(shape for shapes in generations for shape in shapes)
    few = 2 <= len(seen) <= MOST_ALTERNATIVES and FEWEST_DRAWS * len(seen) <= seen.total()
    if len(generations) < FEWEST_STEPS or not few or len(edges.turn) > MOST_AXIOM:
        return None
    number = {shape: index for index, shape in enumerate(seen)}
    pairs = zip(percentages(list(seen.values())), seen, strict=True)
    alternatives = tuple(Alternative(percent, _body(shape)) for percent, shape in pairs)
    return Recursion(
        {},
        _axiom(edges, edges.roots),
        len(generations),
        frozenset({COPY}),
        1.0,
        alternatives={COPY: alternatives},
        choices=tuple(number[shape] for shapes in generations for shape in shapes),
    )


def _body(shape: Shape) -> Body:
    """The production that makes a stem."""
    body: list[Command] = []
    for turn, sides in shape:
        body += [*_turn(turn), Symbol(COPY)]
        body += [Branch((*_turn(side), Symbol(COPY))) for side in sides]
    return tuple(body)


def _axiom(edges: _Edges, roots: tuple[int, ...]) -> Body:
    """What is left when no generation came before."""
    body: list[Command] = []
    for root in roots:
        part = (*_turn(edges.turn[root]), Symbol(COPY), *_axiom(edges, edges.children[root]))
        body += part if root == roots[-1] else [Branch(part)]
    return tuple(body)


def _turn(angle: float) -> list[Command]:
    return [Turn(angle)] if angle else []
