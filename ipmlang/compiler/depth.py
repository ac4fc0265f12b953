"""Refuses trees that are too deep for those who walk them by recursion.

Nesting is bounded while an item is read; a long chain of operators (`a + a + …`) is not nested in
the text and still makes a deep tree. The walk here keeps its own stack.
"""

from __future__ import annotations

from ipmlang.compiler import ast
from ipmlang.compiler.ast import Binary

MAX_DEPTH = 250
_OPERATORS = ("+", "-", "*", "/", "and", "or")


def too_deep(item: ast.Item, text: str) -> bool:
    """Whether a tree, read from `text`, is deeper than MAX_DEPTH nodes."""
    if sum(text.count(mark) for mark in _OPERATORS) < MAX_DEPTH // 2:
        return False
    waiting: list[tuple[object, int]] = [(item, 1)]
    while waiting:
        node, depth = waiting.pop()
        if depth > MAX_DEPTH:
            return True
        if isinstance(node, tuple):
            waiting.extend((member, depth) for member in node)
        elif isinstance(node, Binary):
            waiting.append((node.left, depth + 1))
            waiting.append((node.right, depth + 1))
        else:
            names = getattr(node, "__dataclass_fields__", ())
            waiting.extend((getattr(node, name), depth + 1) for name in names if name != "span")
    return False
