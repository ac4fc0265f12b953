"""Tables whose numbers an edit changed keep their names and their places.

In go a grammar as it was and as an edit wrote it, with tables of its own, out comes the latter with
the names of the former where these are free again. Nothing is read or judged.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.nodes import mapped
from ipmlang.edit.symbols import Asked, taken_names

MADE = re.compile(r"(_sized(_\d+)?)?(?P<kind>_places|_parts)(_\d+)?$")


def with_kept_tables(before: ast.Grammar, after: ast.Grammar, asked: Asked) -> ast.Grammar:
    """The grammar in which new tables bear the names of those with the same columns that are gone,
    else names without numbers, and stand where those stood.
    """
    old = {item.name: item for item in before.items if isinstance(item, ast.Table)}
    tables = [item for item in after.items if isinstance(item, ast.Table)]
    gone = [each for name, each in old.items() if all(name != own.name for own in tables)]
    names: dict[str, str] = {}
    taken = taken_names(after, asked)
    for table in tables:
        if table.name in old:
            continue
        like = [each for each in gone if each.columns == table.columns]
        like.sort(key=lambda each: abs(len(each.rows) - len(table.rows)))
        if like and like[0].name not in taken:
            gone.remove(like[0])
            names[table.name] = like[0].name
        else:
            names[table.name] = _free(MADE.sub(r"\g<kind>", table.name), table.name, taken)
        taken.add(names[table.name])
    places = list(old)
    tables = [replace(each, name=names.get(each.name, each.name)) for each in tables]
    tables.sort(key=lambda own: places.index(own.name) if own.name in old else len(places))
    ordered = iter(tables)
    items = [next(ordered) if isinstance(item, ast.Table) else item for item in after.items]
    return replace(after, items=tuple(_reading(item, names, asked) for item in items))


def _free(wish: str, own: str, taken: set[str]) -> str:
    """A name like a wish that nothing else bears."""
    number, name = 2, wish
    while name in taken and name != own:
        number, name = number + 1, f"{wish}_{number}"
    return name


def _reading(item: ast.Item, names: Mapping[str, str], asked: Asked) -> ast.Item:
    """An item that reads tables by their new names."""
    if isinstance(item, ast.Table) or names.keys().isdisjoint(asked.every(item)):
        return item

    def change(node: object) -> object:
        if isinstance(node, ast.Rows) and node.table in names:
            return replace(node, table=names[node.table])
        return node

    return mapped(item, change)
