"""What top-level names stand for: the values and symbols of a file and, dotted, of its imports.

An item is checked against a `View`, which writes down every answer it gave: while the answers stay
the same, so do the findings. Types of constants and functions are found when first asked for.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cache as remember
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.checked import Sampled, SymbolEntry, ValueEntry
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.load import File, import_name
from ipmlang.compiler.ops.record import ValueType
from ipmlang.compiler.places import shapes_of
from ipmlang.compiler.references import DRAWINGS, MESHES, PICTURES, Problem
from ipmlang.compiler.styles import names_of, styles_of
from ipmlang.compiler.types import ATTR_TYPES

MOST_HINTS = 100
_BROKEN_VALUE = ValueEntry("broken")
_BROKEN_SYMBOL = SymbolEntry("broken")
_DECLARED = re.compile(
    r"(?:(?:attr|const|fn|asset|table|surface|context|site|style|interpret)[ \t]+)?([^\W\d][\w.]*)"
)
RuleKey: TypeAlias = tuple[str, int, bool]
TypeOf: TypeAlias = Callable[["Environment", ast.Item, int], ValueEntry]


@dataclass(slots=True, eq=False)
class Environment:
    """The names of one file. `values` and `symbols` hold its own; `imports` leads to others, and in
    each of its `styles` all names are what they are without. `rules`: the items of each symbol's
    rules, `interpret` ones apart, in source order; `others`: the items that are no rules; `broken`:
    names whose item or import could not be read. `type_of` finds the type of a value's item.
    """

    file: File
    type_of: TypeOf
    values: dict[str, ValueEntry] = field(default_factory=dict)
    symbols: dict[str, SymbolEntry] = field(default_factory=dict)
    imports: dict[str, Environment] = field(default_factory=dict)
    styles: frozenset[str] = frozenset()
    steps: bool = False
    rules: dict[RuleKey, list[int]] = field(default_factory=dict)
    others: list[tuple[int, ast.Item]] = field(default_factory=list)
    broken: frozenset[str] = frozenset()
    _nearest: dict[tuple[str, str], tuple[str, ...]] = field(default_factory=dict)
    _typed: set[str] = field(default_factory=set)

    def value(self, name: str) -> ValueEntry | None:
        """What a name, dotted or not, stands for in expressions."""
        found = self.values.get(name)
        if found is None:
            alias, dot, rest = name.partition(".")
            if dot and alias in self.styles:
                return self.value(rest)
            if name in self.broken or (dot and alias in self.broken):
                return _BROKEN_VALUE
            other = self.imports.get(alias) if dot else None
            return None if other is None else other.value(rest)
        if name not in self._typed:
            self._typed.add(name)
            if found.kind in ("constant", "function", "attribute"):
                item = self.file.grammar.items[found.item]
                found = self.values[name] = self.type_of(self, item, found.item)
        return found

    def symbol(self, name: str) -> SymbolEntry | None:
        """What a name, dotted or not, stands for in successors."""
        found = self.symbols.get(name)
        if found is not None:
            return found
        alias, dot, rest = name.partition(".")
        if dot and alias in self.styles:
            return self.symbol(rest)
        if name in self.broken or (dot and alias in self.broken):
            return _BROKEN_SYMBOL
        other = self.imports.get(alias) if dot else None
        return None if other is None else other.symbol(rest)

    def answer(self, kind: str, name: str) -> object:
        """The answer to a question that a View may have put down."""
        match kind:
            case "value":
                return self.value(name)
            case "symbol":
                return self.symbol(name)
            case "import":
                return name in self.imports or name in self.styles
            case _:
                return self.file.references.node(name, DRAWINGS + MESHES + PICTURES)

    def nearest(self, topic: str, word: str, known: Iterable[str]) -> tuple[str, ...]:
        """The nearest of the names known of a topic. Looking through all names takes long, so each
        word is looked for once, and a file with very many wrong words gets no more hints.
        """
        found = self._nearest.get((topic, word))
        if found is None:
            found = nearest(word, known) if len(self._nearest) < MOST_HINTS else ()
            self._nearest[topic, word] = found
        return found

    def names(self) -> Iterable[str]:
        """All names of values, dotted ones of imports and styles included."""
        yield from self.values
        yield from (f"{style}.{name}" for style in self.styles for name in self.values)
        for alias, other in self.imports.items():
            yield from (f"{alias}.{name}" for name in other.values)

    def symbol_names(self) -> Iterable[str]:
        """All names of symbols, dotted ones of imports and styles included."""
        yield from self.symbols
        yield from (f"{style}.{name}" for style in self.styles for name in self.symbols)
        for alias, other in self.imports.items():
            yield from (f"{alias}.{name}" for name in other.symbols)


@dataclass(slots=True, eq=False)
class View:
    """An environment as one item sees it: `answers` holds every question with its answer."""

    environment: Environment
    answers: dict[tuple[str, str], object]

    def value(self, name: str) -> ValueEntry | None:
        """What a name stands for in expressions."""
        found = self.environment.value(name)
        self.answers["value", name] = found
        return found

    def symbol(self, name: str) -> SymbolEntry | None:
        """What a name stands for in successors."""
        found = self.environment.symbol(name)
        self.answers["symbol", name] = found
        return found

    def is_import(self, name: str) -> bool:
        """Whether an import or a style is called this."""
        found = name in self.environment.imports or name in self.environment.styles
        self.answers["import", name] = found
        return found

    def reference(self, reference: str) -> Problem | None:
        """What is wrong with the file and node that a text names."""
        found = self.environment.answer("reference", reference)
        self.answers["reference", reference] = found
        return found if isinstance(found, Problem) else None


def declare(environment: Environment) -> None:
    """Enter the names that a file defines; the first definition of a name stands."""
    rules = environment.rules
    environment.styles = frozenset(styles_of(environment.file.grammar))
    for index, item in enumerate(environment.file.grammar.items):
        if isinstance(item, ast.Rule):
            key = (item.head.name, len(item.head.parameters), item.interpret)
            rules.setdefault(key, []).append(index)
        else:
            environment.others.append((index, item))
    for index, item in environment.others:
        _declare(environment, index, item)
    environment.broken = _broken(environment.file)
    for name, arity, interpret in rules:
        if "." in name:  # what it redefines is declared where it leads
            continue
        before = environment.symbols.get(name)
        environment.symbols[name] = _with_rule(before, arity, interpret)


def _broken(file: File) -> frozenset[str]:
    """Names that items which could not be read seem to define, and imports that led nowhere: what
    is said about them would only repeat that.
    """
    if not file.problems:
        return frozenset()
    text = file.source.text
    heads = [_DECLARED.match(text, _item_start(text, each.start)) for each in file.problems]
    imports = [item for item in file.grammar.items if isinstance(item, ast.Import)]
    wanted = {item.alias or import_name(item.path) for item in imports}
    return frozenset({head[1] for head in heads if head} | (wanted - file.imports.keys()))


def _item_start(text: str, place: int) -> int:
    """Where the item around a place starts: in the first column of its line, or of one above."""
    start = text.rfind("\n", 0, place) + 1
    while start > 0 and text[start : start + 1].isspace():
        start = text.rfind("\n", 0, start - 1) + 1
    return start


def _declare(environment: Environment, index: int, item: ast.Item) -> None:
    if any("." in name for name in names_of(item)):
        return
    for name, entry in values_of(item, index):
        environment.values.setdefault(name, entry)
    match item:
        case ast.Asset(names):
            for name in names:
                environment.symbols.setdefault(name, SymbolEntry("asset"))
        case ast.Site(name):
            environment.symbols.setdefault(name, SymbolEntry("site", frozenset({0})))
        case ast.Start(steps=steps) if steps is not None:
            environment.steps = True
        case ast.Table(name, reference=str(reference)):
            _declare_columns(environment, name, reference)
        case ast.Field():
            _declare_channels(environment, item)
        case _:
            pass


@remember
def _with_rule(entry: SymbolEntry | None, arity: int, interpret: bool) -> SymbolEntry:
    """An entry with one more rule; equal entries are one object, so that they compare at once."""
    if entry is None or entry.kind == "asset":
        entry = SymbolEntry("rule")
    if interpret:
        return replace(entry, interpreted=entry.interpreted | {arity})
    return replace(entry, arities=entry.arities | {arity})


def _declare_columns(environment: Environment, name: str, reference: str) -> None:
    columns = environment.file.references.table(reference)
    known = None if isinstance(columns, Problem) else columns
    environment.values[name] = replace(environment.values[name], columns=known)


def _declare_channels(environment: Environment, item: ast.Field) -> None:
    channels = environment.file.references.channels(item.reference, item.kind)
    known = None if isinstance(channels, Problem) else channels
    sampled = Sampled(known, item.place is not None)
    environment.values[item.name] = replace(environment.values[item.name], sampled=sampled)


def values_of(item: ast.Item, index: int) -> Iterable[tuple[str, ValueEntry]]:
    """The names that an item defines for expressions, types of constants still open."""
    match item:
        case ast.Attr(name, given):
            yield name, ValueEntry("attribute", ATTR_TYPES.get(given or "", "any"), item=index)
        case ast.Const(name):
            yield name, ValueEntry("constant", item=index)
        case ast.Function(name, parameters):
            names = tuple(each.name for each in parameters)
            yield name, ValueEntry("function", parameters=names, item=index)
        case ast.Asset(names):
            for name in names:
                yield name, ValueEntry("asset", "asset", item=index)
        case ast.Table(name, columns=columns):
            shapes = shapes_of(item)
            yield name, ValueEntry("table", columns=columns, shapes=shapes, item=index)
        case ast.Surface(name):
            yield name, ValueEntry("surface", item=index)
        case ast.Field(name, kind=kind, nearest=exact):
            result: ValueType = "vector" if kind == "vector" else "number"
            yield name, ValueEntry("context", result, exact=exact, item=index)
        case ast.Site(name):
            yield name, ValueEntry("site", item=index)
        case _:
            pass
