"""Trees of syntax as nodes in nodes: every one of them, or the tree with others in their place.

In go trees of any kind of node, out come their nodes, or trees. What nodes mean is not known here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from operator import is_not
from typing import TypeVar, cast

from ipmlang.compiler import ast

Tree = TypeVar("Tree")


def nodes(tree: object, closed: type | None = None) -> Iterator[object]:
    """Every node of a tree, comments apart, from the outside in; closed: a kind of node into which
    nobody needs to look.
    """
    waiting = [tree]
    while waiting:
        one = waiting.pop()
        kind = type(one)
        if kind is tuple:
            waiting += cast("tuple[object, ...]", one)
            continue
        names = INNER[kind]
        if names is None:
            continue
        yield one
        if kind is closed:
            continue
        for name in names:
            value = getattr(one, name)
            if value:  # neither None nor empty: a node is always true
                waiting.append(value)


def outer_nodes(tree: object) -> Iterator[object]:
    """Every node of a tree but those in the arguments of modules, where there are values alone."""
    return nodes(tree, ast.Module)


class _Inner(dict[type, "tuple[str, ...] | None"]):
    """The fields of the nodes of a kind that may hold others; None where these are no nodes, or
    comments.
    """

    def __missing__(self, kind: type) -> tuple[str, ...] | None:
        node = is_dataclass(kind) and kind is not ast.Comment
        own = fields(kind) if node else ()
        inner = (each.name for each in own if not _is_plain(str(each.type)))
        self[kind] = tuple(inner) if node else None
        return self[kind]


INNER = _Inner()


def _is_plain(type_: str) -> bool:
    """Whether what a field is declared to hold has no nodes in it, comments apart."""
    return type_.startswith("Literal[") or type_ in _PLAIN


_PLAIN = frozenset({
    "str", "int", "float", "bool", "str | None", "int | None", "tuple[str, ...]", "BinaryOp",
    "tuple[int, ...]", "Span", "tuple[Comment, ...]", "tuple[tuple[int, Comment], ...]",
})  # fmt: skip


def mapped(tree: Tree, change: Callable[[object], object]) -> Tree:
    """The tree with every node put through `change`, from the inside out; comments stay."""
    kind = type(tree)
    if kind is tuple:
        own = cast("tuple[object, ...]", tree)
        parts = tuple([mapped(each, change) for each in own])
        return cast("Tree", parts) if any(map(is_not, parts, own)) else tree
    names = INNER[kind]
    if names is None:
        return tree
    different: dict[str, object] = {}
    for name in names:
        value = getattr(tree, name)
        made = mapped(value, change)
        if made is not value:
            different[name] = made
    one = replace(tree, **different) if different else tree  # type: ignore[type-var]
    return cast("Tree", change(one))
