"""Styles of a file, and the names that items define or, with dots in them, redefine.

In go trees, out come names. `Night.Window --> …` puts another rule in the place of `Window` where
the style `Night` is chosen; `roofs.Hip --> …` does so for an import. Nothing here looks names up.
"""

from __future__ import annotations

from collections.abc import Mapping

from ipmlang.compiler import ast


def styles_of(grammar: ast.Grammar) -> dict[str, ast.Style]:
    """The styles of a file by their names; the first definition of a name stands."""
    found: dict[str, ast.Style] = {}
    for item in grammar.items:
        if isinstance(item, ast.Style):
            found.setdefault(item.name, item)
    return found


def lineage(styles: Mapping[str, ast.Style], name: str | None) -> list[str]:
    """A style and all that it extends, the first one first; a circle ends where it closes."""
    found: list[str] = []
    while name is not None and name in styles and name not in found:
        found.insert(0, name)
        name = styles[name].parent
    return found


def names_of(item: ast.Item) -> tuple[str, ...]:
    """What an item defines or redefines."""
    match item:
        case ast.Rule(head=head):
            return (head.name,)
        case ast.Asset(names=names):
            return names
        case ast.Table(name=name) | ast.Attr(name=name) | ast.Const(name=name):
            return (name,)
        case ast.Function(name=name) | ast.Surface(name=name) | ast.Field(name=name):
            return (name,)
        case ast.Site(name=name):
            return (name,)
        case _:
            return ()
