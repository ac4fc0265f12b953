"""What checking gives to lowering: one flat list of items whose names mean the same everywhere.

Every file of the grammar (the main one and what it imports, directly or not) is here once. Names of
an imported file are qualified by the shortest way to it: `Hip` of `import "std/roofs"` is
`roofs.Hip`, in heads, bodies and expressions alike; parameters and the variables of repeats stay as
they are. Plain data: nothing here looks anything up or reads a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, Source
from ipmlang.compiler.ir import AssetFile
from ipmlang.compiler.ops.record import ValueType

NameKind: TypeAlias = Literal[
    "attr", "const", "function", "asset", "table", "surface", "context", "site"
]
SymbolKind: TypeAlias = Literal["rule", "asset", "site", "operation", "terminal"]


@dataclass(frozen=True, slots=True)
class Unit:
    """One item with qualified names. `offset` is where it starts in `source`, `prefix` is `""` in the
    main file and `roofs.` in an imported one, `index` its place in its own file's items."""

    item: ast.Item
    source: Source
    offset: int
    prefix: str
    index: int


@dataclass(frozen=True, slots=True)
class Definition:
    """What a top-level name stands for; `unit` indexes Checked.units. `type` is that of its value
    (of its result, for a function of `arity` parameters)."""

    name: str
    kind: NameKind
    unit: int
    type: ValueType = "any"
    arity: int = 0


@dataclass(frozen=True, slots=True)
class SymbolUse:
    """A symbol, that is a name with an arity, that some head, body or axiom mentions.

    `rules` and `interpretations` index Checked.units, in source order. A rule's name may be an
    operation's too: while rules apply it is rewritten, and what is left over has the operation's
    meaning. `kind` is what it is first of all: a rule, else an operation, an asset, a site, else a
    terminal.
    """

    name: str
    arity: int
    kind: SymbolKind
    rules: tuple[int, ...] = ()
    interpretations: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class TableContent:
    """Rows of a table: numbers and texts. `rows` is empty where the table's file was not read
    because it is missing (a diagnostic says so)."""

    name: str
    columns: tuple[str, ...]
    rows: tuple[tuple[float | str, ...], ...]


@dataclass(frozen=True, slots=True)
class NotReady:
    """An operation or query that parses and checks, but that no executor runs yet."""

    name: str
    source: Source
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Checked:
    """A whole grammar.

    `grammar`, `source`: the main file as written. `units`: items of all files that apply: all of the
    main file, then of each import its assets, tables, surfaces, contexts, attrs, consts, functions,
    sites, rules and `turtle` settings (which hold for that file's own rules; look for `prefix`).
    `names`: top-level values by qualified name. `symbols` by name and arity. `assets` and `effects`
    give the file and node of each asset name and of each `effect("file#id")` text. `not_ready`: what
    `run` must refuse. `diagnostics`: of all files, errors and warnings, in the order of the text.
    """

    grammar: ast.Grammar
    source: Source
    units: tuple[Unit, ...]
    names: Mapping[str, Definition]
    symbols: Mapping[tuple[str, int], SymbolUse]
    assets: Mapping[str, AssetFile]
    effects: Mapping[str, AssetFile]
    tables: Mapping[str, TableContent]
    not_ready: tuple[NotReady, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
