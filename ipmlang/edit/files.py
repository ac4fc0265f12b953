"""The files that a grammar names: which they are, and the grammar with other names for them.

In go trees and folders, out come names, paths and trees. References are names relative to the
folder of the grammar, with `#node` behind some. Imported grammars are followed; of the standard
library nothing is told. Only `files_with` reads, namely imported grammars.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from functools import cache as remember
from pathlib import Path, PurePosixPath

from ipmlang.compiler import ast
from ipmlang.compiler.load import SUFFIX, read_source
from ipmlang.compiler.nodes import outer_nodes
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.parse import parse
from ipmlang.edit.places import Found, places, with_changes

STANDARD = "std/"
MOST_ITEMS = 4096  # that are known to name files or not


def with_file_names(grammar: ast.Grammar, rename: Callable[[str], str]) -> ast.Grammar:
    r"""The grammar with every file name put through `rename`; imports are given with their suffix.

    >>> from ipmlang.compiler.diagnostics import Source
    >>> source = Source("x.ipm", 'asset A, B in "x.parts.svg"\ntable T = "x.parts.svg#T"')
    >>> named = with_file_names(parse(source)[0], lambda name: "y.parts.svg")
    >>> named.items[0].reference, named.items[1].reference
    ('y.parts.svg', 'y.parts.svg#T')
    """

    def reference(text: str) -> str:
        name, mark, node = text.partition("#")
        return rename(name) + mark + node

    naming = any(map(_names_file, grammar.items))
    changes = {
        number: ast.Text(reference(expr.value))
        for number, (place, expr) in enumerate(places(grammar) if naming else ())
        if isinstance(expr, ast.Text) and names_file((place, expr))
    }
    if changes:
        grammar = with_changes(grammar, changes)
    return replace(grammar, items=tuple(_item(item, rename, reference) for item in grammar.items))


def _names_file(item: ast.Item) -> bool:
    """Whether an item uses an operation that takes the name of a file; known for those of which it
    was asked last.
    """
    if not isinstance(item, ast.Rule | ast.Start):
        return False
    known = _last_items()
    found = known.get(id(item))
    if found is None:
        if len(known) >= MOST_ITEMS:
            known.clear()
        naming = _naming()
        uses = (each for each in outer_nodes(item) if isinstance(each, ast.Module | ast.Block))
        found = known[id(item)] = item, any(each.name in naming for each in uses)
    return found[1]


@remember
def _last_items() -> dict[int, tuple[ast.Item, bool]]:
    """What `_names_file` has been asked: an edit asks it of a grammar again and again."""
    return {}


@remember
def _naming() -> frozenset[str]:
    """The operations that take the name of a file."""
    return frozenset(
        name
        for name, record in OPERATIONS.items()
        if any(param.suffixes for form in record.forms for param in form)
    )


def _item(
    item: ast.Item, rename: Callable[[str], str], reference: Callable[[str], str]
) -> ast.Item:
    match item:
        case ast.Import(path=path) if not path.startswith(STANDARD):
            bare = not path.endswith(SUFFIX)
            renamed = rename(path + SUFFIX if bare else path)
            return replace(item, path=renamed.removesuffix(SUFFIX) if bare else renamed)
        case ast.Asset() | ast.Surface() | ast.Site() | ast.Field():
            return replace(item, reference=reference(item.reference))
        case ast.Table(reference=str(text)):
            return replace(item, reference=reference(text))
        case ast.Start(place=ast.Place(kind="file", reference=str(text)) as place):
            return replace(item, place=replace(place, reference=reference(text)))
        case _:
            return item


def names_file(found: Found) -> bool:
    """Whether a parameter is the name of a file: `effect("x.parts.svg#g1")`."""
    place, expr = found
    record = OPERATIONS.get(place.operation)
    if record is None or not isinstance(expr, ast.Text):
        return False
    return any(p.suffixes and p.name == place.parameter for form in record.forms for p in form)


def file_names(grammar: ast.Grammar) -> list[str]:
    """The files that one tree names, each once, in the order of the text."""
    found: dict[str, None] = {}

    def note(name: str) -> str:
        found[name] = None
        return name

    with_file_names(grammar, note)
    return list(found)


def files_with(grammar: ast.Grammar, folder: Path, apart: Collection[str] = ()) -> dict[str, Path]:
    """All files that have to lie beside a grammar, by their names as seen from it: what it names
    and, for imports, what those name. Names in `apart` are left out and not followed.
    """
    found: dict[str, Path] = {}
    waiting = [(grammar, PurePosixPath())]
    while waiting:
        tree, inside = waiting.pop()
        for name in file_names(tree):
            key = str(inside / name)
            if key in found or key in apart:
                continue
            found[key] = folder / key
            if key.endswith(SUFFIX):
                imported, _ = parse(read_source(folder / key))
                waiting.append((imported, PurePosixPath(key).parent))
    return found
