"""Which lengths in the rules above a shape can decide how large it is.

In go a tree and the keys of shapes, out come numbers of the grammar that are worth a try: those on
the way from a rule to the shape, and none that others of its kind hang on alike. Nothing is
derived.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

from ipmlang.compiler import ast
from ipmlang.compiler.nodes import nodes
from ipmlang.edit.arithmetic import number_of
from ipmlang.edit.buildings.measuring import Unit, measured
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.places import Found, Place, places, places_in

Key = tuple[Literal["shape", "terminal"], int]
SIZING = ("size", "extrude", "offset")
ALIKE = 1e-9  # of a size, by which those of a kind may differ


def deciding(tree: Tree, key: Key, others: Sequence[Key], axis: int) -> Iterator[tuple[int, Found]]:
    """The lengths that may decide the size of a shape along an axis, with their numbers among
    `places`: of the shape's own rule first, then of those above. others: of the same kind, which
    are to keep their sizes.
    """
    unit = unit_of(tree, key)
    way = _way(tree, unit)
    twins = _twins(tree, unit, others, axis)
    grammar, numbers = tree.draft.grammar, dict[int, int]()
    for rule, step in _first_of_each(tree, way).items():
        if any(_hang_alike(tree, way, other, step) for other in twins):
            continue
        if step == 0 and key[0] == "shape" and _is_given(tree, way[0], axis):
            continue
        aside = set() if step == 0 else _aside(tree, rule, tree.names[way[step - 1]])
        for place, expr in places_in(grammar, rule):
            if id(expr) not in aside and _is_length(place, axis, step == 0):
                value = number_of(expr)
                if value is not None and value > 0:
                    numbers = numbers or {id(own): k for k, (_, own) in enumerate(places(grammar))}
                    yield numbers[id(expr)], (place, expr)


def _way(tree: Tree, unit: Unit) -> list[int]:
    """The shapes from a shape, or from the one that drew a terminal, up to the start."""
    kind, row = unit
    return tree.above(tree.owners[row] if kind == "terminal" else row)


def _first_of_each(tree: Tree, way: Sequence[int]) -> dict[str, int]:
    """The rules on a way, each with the step where it is first met."""
    return {tree.names[way[step]]: step for step in reversed(range(len(way)))}


def _twins(tree: Tree, unit: Unit, others: Sequence[Key], axis: int) -> list[list[int]]:
    """The ways of the others that are as large now, terminals drawn in the same place of a rule."""
    known = measured(tree)
    own = float(known.extent(unit)[axis])
    return [
        _way(tree, other)
        for other in (unit_of(tree, key) for key in others)
        if abs(float(known.extent(other)[axis]) - own) <= ALIKE * max(own, 1.0)
        and _drawn(tree, other) == _drawn(tree, unit)
    ]


def unit_of(tree: Tree, key: Key) -> Unit:
    """The shape or terminal of a key."""
    kind, own = key
    return kind, tree.rows_of(kind)[own]


def _drawn(tree: Tree, unit: Unit) -> int:
    """Which of the terminals that its shape drew a terminal is; 0 for shapes."""
    kind, row = unit
    return 0 if kind == "shape" else tree.drawn[tree.owners[row]].index(row)


def _hang_alike(tree: Tree, way: Sequence[int], other: Sequence[int], step: int) -> bool:
    """Whether two shapes stand alike in two uses of the rule so many steps above them: what changes
    one of them by that rule changes the other.
    """
    if len(other) <= step or way[step] == other[step]:
        return False
    named = all(tree.names[way[k]] == tree.names[other[k]] for k in range(step + 1))
    return named and all(_child(tree, way, k) == _child(tree, other, k) for k in range(step))


def _child(tree: Tree, way: Sequence[int], step: int) -> int:
    """Which child of the shape above it a shape on a way is."""
    return tree.children[way[step + 1]].index(way[step])


def _is_given(tree: Tree, row: int, axis: int) -> bool:
    """Whether a shape's size is that of the scope that it was given, which its own rule comes too
    late to change.
    """
    return bool(tree.size[row, axis] > 0) and measured(tree).fills(("shape", row))


def _aside(tree: Tree, rule: str, below: str) -> set[int]:
    """The expressions in brackets of a rule that do not lead to a symbol: they end there."""
    found: set[int] = set()
    for item in tree.draft.grammar.items:
        if isinstance(item, ast.Rule) and item.head.name == rule:
            for node in nodes(item.body):
                if isinstance(node, ast.Bracket) and not _leads_to(node, below):
                    found |= {id(each) for each in nodes(node)}
    return found


def _leads_to(bracket: ast.Bracket, symbol: str) -> bool:
    return any(isinstance(each, ast.Module) and each.name == symbol for each in nodes(bracket))


def _is_length(place: Place, axis: int, own: bool) -> bool:
    """Whether a number is a length that sizes what follows; in the rule of the shape itself also
    one that moves a part of it along the axis.
    """
    if place.operation == "translate":
        return own and place.parameter == "xyz"[axis]
    return place.kind == "length" or place.operation in SIZING
