"""What stands on the page of a written grammar by itself: names with their places in the axiom.

Takes a grammar; gives the frames of the symbols that the axiom, or the one rule that it starts,
places by `at` alone, and the grammar with such symbols where the page begins. Nothing here knows
what the symbols draw.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.frames import Frames, frames


def places(grammar: ast.Grammar) -> dict[str, Frames]:
    """(1,) where each symbol stands that is placed on the page."""
    found: dict[str, Frames] = {}
    for element in _body(grammar):
        placed = _placed(element)
        if placed is not None:
            found[placed[0]] = placed[1]
    return found


def unplaced(grammar: ast.Grammar, names: Set[str]) -> ast.Grammar:
    """The grammar with these symbols where the page begins, in the same order."""
    if not names:
        return grammar
    first = _first(grammar)
    items: list[ast.Item] = []
    for item in grammar.items:
        match item:
            case ast.Rule() if item.head.name == first:
                item = replace(item, body=_moved(item.body, names))
            case ast.Start() if first is None:
                item = replace(item, axiom=_moved(item.axiom, names))
            case _:
                pass
        items.append(item)
    return replace(grammar, items=tuple(items))


def _moved(body: tuple[ast.Element, ...], names: Set[str]) -> tuple[ast.Element, ...]:
    known = [_placed(each) for each in body]
    return tuple(
        ast.Module(placed[0]) if placed is not None and placed[0] in names else each
        for each, placed in zip(body, known, strict=True)
    )


def _first(grammar: ast.Grammar) -> str | None:
    """The rule that the axiom starts where it stands, None where it says more."""
    rules = {each.head.name for each in grammar.items if isinstance(each, ast.Rule)}
    for item in grammar.items:
        match item:
            case ast.Start(axiom=(ast.Module(name, ()),)) if name in rules:
                return name
            case _:
                pass
    return None


def _body(grammar: ast.Grammar) -> tuple[ast.Element, ...]:
    first = _first(grammar)
    for item in grammar.items:
        match item:
            case ast.Rule() if item.head.name == first:
                return item.body
            case ast.Start() if first is None:
                return item.axiom
            case _:
                pass
    return ()


def _placed(element: ast.Element) -> tuple[str, Frames] | None:
    """A symbol without arguments, and its place."""
    match element:
        case ast.Module(name, ()):
            return name, frames(np.zeros(1, np.complex128))
        case ast.Bracket((ast.Module("at", args), ast.Module(name, ()))):
            values = [each.value.value for each in args if isinstance(each.value, ast.Number)]
            if len(values) != len(args) or len(values) > 4:
                return None
            x, y, angle, scale = (*values, *(0.0, 1.0)[len(values) - 2 :])
            return name, frames(np.array([complex(x, y)]), angle, scale)
        case _:
            return None
