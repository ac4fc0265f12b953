"""Names in a grammar: where symbols are used, which names are taken, which items are still needed.

In go syntax trees, out come names, numbers of items, or the tree with other elements in place of
some symbols. Nothing is checked here: a tree may be half edited.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TypeAlias, assert_never, cast

from ipmlang.compiler import ast
from ipmlang.compiler.nodes import INNER, nodes, outer_nodes
from ipmlang.compiler.ops import FUNCTIONS, OPERATIONS
from ipmlang.compiler.passing import leaves, passing, symbols_taken
from ipmlang.compiler.places import SHAPE
from ipmlang.compiler.tokens import is_free_name

Elements: TypeAlias = tuple[ast.Element, ...]
# What takes the place of a module; the truth says that nothing follows it in its bracket.
Make: TypeAlias = Callable[[ast.Module, bool], Elements]
_RESERVED = frozenset({"i", "n", "r", "e", "pi", "here", "nil", "start"})


def with_modules(grammar: ast.Grammar, make: Make) -> ast.Grammar:
    """The grammar with every module of its rules and axioms put through `make`.

    >>> fork = ast.Rule(ast.Head("A"), (ast.Bracket((ast.Module("B"),)), ast.Module("B")))
    >>> forks = ast.Grammar((fork,))
    >>> len(with_modules(forks, lambda one, last: (one,) if last else (one, one)).items[0].body)
    3
    """
    return replace(grammar, items=tuple(_with_modules(item, make) for item in grammar.items))


def _with_modules(item: ast.Item, make: Make) -> ast.Item:
    match item:
        case ast.Rule():
            return replace(item, body=_elements(item.body, make, False))
        case ast.Start():
            return replace(item, axiom=_elements(item.axiom, make, True))
        case _:
            return item


def with_shapes(grammar: ast.Grammar, name: str, by: str) -> tuple[ast.Grammar, int]:
    """The grammar with another symbol where rows of tables place one, and how many rows do."""
    count = 0
    items: list[ast.Item] = []
    for item in grammar.items:
        if isinstance(item, ast.Table) and SHAPE in item.columns:
            column = item.columns.index(SHAPE)
            here = [row[column] == ast.Name(name) for row in item.rows]
            count += sum(here)
            rows = tuple(
                (*row[:column], ast.Name(by), *row[column + 1 :]) if found else row
                for row, found in zip(item.rows, here, strict=True)
            )
            item = replace(item, rows=rows)
        items.append(item)
    return replace(grammar, items=tuple(items)), count


def with_given(grammar: ast.Grammar, name: str, by: str) -> tuple[ast.Grammar, int]:
    """The grammar with another symbol where rules are given one, and how many times they are.

    >>> leaf, stem = ast.Name("leaf"), ast.Rule(ast.Head("P", (ast.Parameter("s"),)),
    ...                                         (ast.Module("s"),))
    >>> given = ast.Start((ast.Module("P", (ast.Argument(leaf),)),))
    >>> made, count = with_given(ast.Grammar((stem, given)), "leaf", "bud")
    >>> made.items[1].axiom[0].args[0].value.id, count
    ('bud', 1)
    """
    count = 0
    taken = taking(grammar)

    def given(expr: ast.Expr) -> ast.Expr:
        nonlocal count
        if isinstance(expr, ast.If):
            return replace(expr, value=given(expr.value), other=given(expr.other))
        if not isinstance(expr, ast.Name) or expr.id != name:
            return expr
        count += 1
        return replace(expr, id=by)

    def module(one: ast.Module, _: bool) -> Elements:
        places = taken.get((one.name, len(one.args)), frozenset())
        args = tuple(
            replace(each, value=given(each.value)) if place in places else each
            for place, each in enumerate(one.args)
        )
        return (replace(one, args=args) if places else one,)

    items = tuple(
        item if _hides(item, name) else _with_modules(item, module) for item in grammar.items
    )
    return replace(grammar, items=items), count


def _hides(item: ast.Item, name: str) -> bool:
    """Whether a name is a parameter in an item."""
    return isinstance(item, ast.Rule) and name in {each.name for each in item.head.parameters}


def taking(grammar: ast.Grammar) -> dict[tuple[str, int], frozenset[int]]:
    """Which arguments of the rules of a grammar are symbols, by name and number of arguments."""
    return symbols_taken(
        ((rule.head.name, len(rule.head.parameters)), passing(rule), lambda *called: called)
        for rule in grammar.items
        if isinstance(rule, ast.Rule)
    )


def placed_names(grammar: ast.Grammar) -> set[str]:
    """The symbols that bodies and axioms place, or give to rules; parameters are none."""
    taken = taking(grammar)
    found: set[str] = set()
    for item in grammar.items:
        own: set[str] = set()
        modules = (each for each in nodes(item) if isinstance(each, ast.Module))
        for module in modules:
            own.add(module.name)
            for place in taken.get((module.name, len(module.args)), ()):
                given = leaves(module.args[place].value)
                own |= {each.id for each in given if isinstance(each, ast.Name)}
        if isinstance(item, ast.Rule):
            own -= {each.name for each in item.head.parameters}
        found |= own
    return found


def _elements(elements: Elements, make: Make, closed: bool) -> Elements:
    """`closed`: nothing outside sees the state that these leave behind."""
    made: list[ast.Element] = []
    for number, each in enumerate(elements):
        if isinstance(each, ast.Module):
            made += make(each, closed and number == len(elements) - 1)
        else:
            made.append(_element(each, make))
    return tuple(made)


def _element(element: ast.Element, make: Make) -> ast.Element:
    match element:
        case ast.Bracket():
            return replace(element, body=_elements(element.body, make, True))
        case ast.Repeat():
            return replace(element, body=_elements(element.body, make, False))
        case ast.Split():
            return replace(element, parts=tuple(_split_part(each, make) for each in element.parts))
        case ast.Block() | ast.Each():
            parts = tuple(
                replace(each, body=_elements(each.body, make, False)) for each in element.parts
            )
            return replace(element, parts=parts)
        case ast.Module() | ast.Assign() | ast.Local():
            return element
        case _:
            assert_never(element)


def _split_part(part: ast.SplitPart | ast.SplitGroup, make: Make) -> ast.SplitPart | ast.SplitGroup:
    if isinstance(part, ast.SplitGroup):
        return replace(part, parts=tuple(_split_part(each, make) for each in part.parts))
    return replace(part, body=_elements(part.body, make, False))


def used_names(tree: object) -> set[str]:
    """The names that a tree asks for: symbols, values, tables, functions. Of a dotted name also the
    part before the dot, which is an import or a table's row.
    """
    return _with_stems(_asked(tree, {}))


def _with_stems(names: Iterable[str]) -> set[str]:
    found = set(names)
    return found | {name.partition(".")[0] for name in found if "." in name}


_Known: TypeAlias = dict[int, tuple[object, tuple[str, ...]]]


def _asked(tree: object, known: _Known) -> list[str]:
    """The names that a tree asks for, as often as it does; those of some parts are known."""
    found: list[str] = []
    waiting = [tree]
    while waiting:
        one = waiting.pop()
        kind = type(one)
        if kind is tuple:
            if known and id(one) in known:
                found += known[id(one)][1]
            else:  # numbers are the most of all, and they ask for nothing
                members = cast("tuple[object, ...]", one)
                waiting += [each for each in members if type(each) is not ast.Number]
            continue
        if kind is ast.Argument:
            value = cast("ast.Argument", one).value
            if type(value) is not ast.Number:
                waiting.append(value)
            continue
        name, inner = _ASKING.get(kind), INNER[kind]
        if name is not None:
            found.append(getattr(one, name))
        elif kind in (ast.Start, ast.Place):
            found += _placed_on(one)
        for each in inner or ():
            value = getattr(one, each)
            if value:
                waiting.append(value)
    return found


def _placed_on(node: object) -> tuple[str, ...]:
    """The sites or the surface that an axiom is placed on."""
    match node:
        case ast.Start(sites=sites):
            return sites
        case ast.Place(kind="surface", reference=str(name)):
            return (name,)
        case _:
            return ()


_ASKING: Mapping[type, str] = {
    ast.Name: "id", ast.Module: "name", ast.Call: "name", ast.Block: "name",
    ast.ContextModule: "name", ast.Rows: "table", ast.Residual: "table",
}  # fmt: skip


class Asked:
    """The names that trees ask for, each tree gone through once as long as this lives: an edit
    asks for those of rules that stay again and again. What was known before is known, too.

    >>> body = (ast.Module("A"), ast.Module("A"), ast.Module("roofs.Hip"))
    >>> asked = Asked()
    >>> sorted(asked.every(body)), sorted(asked.names(ast.Rule(ast.Head("B"), body)))
    (['A', 'A', 'roofs.Hip'], ['A', 'roofs', 'roofs.Hip'])
    """

    def __init__(self, before: Asked | None = None) -> None:
        self._known: _Known = {} if before is None else dict(before._known)

    def every(self, tree: object) -> tuple[str, ...]:
        """The names that a tree asks for, each as often as it does."""
        found = self._known.get(id(tree))
        if found is None:
            found = self._known[id(tree)] = tree, tuple(_asked(tree, self._known))
        return found[1]

    def names(self, tree: object) -> set[str]:
        """The same as `used_names`."""
        return _with_stems(self.every(tree))


def defined_names(item: ast.Item) -> tuple[str, ...]:
    """The names that an item gives a meaning."""
    match item:
        case ast.Rule(head=head):
            return (head.name,)
        case ast.Asset(names=names):
            return names
        case ast.Import(path=path, alias=alias):
            return (alias or path.rpartition("/")[2].removesuffix(".ipm"),)
        case ast.Table(name=name) | ast.Attr(name=name) | ast.Const(name=name):
            return (name,)
        case ast.Function(name=name) | ast.Surface(name=name) | ast.Field(name=name):
            return (name,)
        case ast.Site(name=name) | ast.Style(name=name):
            return (name,)
        case _:
            return ()


def taken_names(grammar: ast.Grammar, asked: Asked | None = None) -> set[str]:
    """Every name that stands anywhere in a grammar, parameters and counters included."""
    asked = asked or Asked()
    found: set[str] = set()
    for item in grammar.items:
        found |= asked.names(item)
        found.update(defined_names(item))
    plain = tuple(each for each in grammar.items if not isinstance(each, ast.Table))
    for node in outer_nodes(plain):
        match node:
            case ast.Parameter(name=name) | ast.Count(variable=name) | ast.Rows(variable=name):
                found.add(name)
            case _:
                pass
    return found


def free_name(grammar: ast.Grammar, wish: str) -> str:
    """A name like `wish` that nothing in the grammar bears.

    >>> free_name(ast.Grammar((ast.Start((ast.Module("leaf"),)),)), "leaf 07.b")
    'leaf_07_b'
    >>> free_name(ast.Grammar((ast.Start((ast.Module("leaf"),)),)), "leaf")
    'leaf_2'
    """
    plain = re.sub(r"\W+", "_", wish, flags=re.ASCII).strip("_") or "part"
    plain = plain if plain[0].isalpha() else f"part_{plain}"
    taken = taken_names(grammar) | set(OPERATIONS) | set(FUNCTIONS) | _RESERVED
    if plain not in taken and is_free_name(plain):
        return plain
    number = 2
    while f"{plain}_{number}" in taken:
        number += 1
    return f"{plain}_{number}"


def needed_names(grammar: ast.Grammar, asked: Asked | None = None) -> set[str]:
    """The names that the axiom leads to, and those that items without a name ask for."""
    asked = asked or Asked()
    by_name: dict[str, list[ast.Item]] = {}
    found: set[str] = set()
    for item in grammar.items:
        names = defined_names(item)
        for name in names:
            by_name.setdefault(name, []).append(item)
        if not names:
            found |= asked.names(item)
    waiting = list(found)
    while waiting:
        for item in by_name.get(waiting.pop(), ()):
            new = asked.names(item) - found
            found |= new
            waiting += new
    return found


def without_names(grammar: ast.Grammar, names: set[str]) -> ast.Grammar:
    """The grammar without the definitions of names; an asset item keeps its other names."""
    kept: list[ast.Item] = []
    for item in grammar.items:
        own = defined_names(item)
        left = tuple(name for name in own if name not in names)
        if isinstance(item, ast.Asset) and left:
            kept.append(replace(item, names=left))
        elif left or not own:
            kept.append(item)
    return replace(grammar, items=tuple(kept))
