"""What checking gives: the loaded files, what their names stand for, and all that is wrong.

Names of an imported file are qualified by the shortest way to it: `Hip` of `import "std/roofs"` is
`roofs.Hip`. Plain data: nothing here looks anything up or reads a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, Source
from ipmlang.compiler.load import Loaded
from ipmlang.compiler.ops.record import ValueType

ValueKind: TypeAlias = Literal[
    "attribute", "constant", "function", "asset", "table", "surface", "context", "site", "broken"
]
SymbolKind: TypeAlias = Literal["rule", "asset", "site", "broken", "terminal"]


@dataclass(frozen=True, slots=True)
class Sampled:
    """What is known of a context: how many channels its file has, None where unknown, and whether
    it lies over a part of the ground.
    """

    channels: int | None
    placed: bool


@dataclass(frozen=True, slots=True)
class ValueEntry:
    """What a top-level name stands for in expressions. `type` is that of its value, or of a
    function's result; `parameters` are a function's, `takes` their types; `columns` a
    table's, None where unknown, `shapes` the symbols that its rows place; `exact`: it may feed a
    guard; `item` indexes its file's items; `sampled` is what is known of a context. Of a
    broken one only the name is known: its item or its import could not be read.
    """

    kind: ValueKind
    type: ValueType = "any"
    parameters: tuple[str, ...] = ()
    columns: tuple[str, ...] | None = None
    takes: tuple[ValueType, ...] = ()
    exact: bool = True
    item: int = field(default=-1, compare=False)
    sampled: Sampled | None = None
    shapes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SymbolEntry:
    """What a name stands for in a successor: the arities of its rules (of `interpret` rules, in
    `interpreted`), or an asset or site.
    """

    kind: Literal["rule", "asset", "site", "broken"]
    arities: frozenset[int] = frozenset()
    interpreted: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True)
class SymbolUse:
    """A symbol, that is a name with an arity, that some head, body or axiom mentions. A rule's name
    may be an operation's too: while rules apply it is rewritten, what is left has its meaning.
    """

    name: str
    arity: int
    kind: SymbolKind


@dataclass(frozen=True, slots=True)
class NotReady:
    """An operation or query that parses and checks, but that no executor runs yet; offsets are in
    the whole source.
    """

    name: str
    source: Source
    start: int
    end: int


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A whole grammar. `values` and `symbols` are keyed by qualified name; `diagnostics` are of all
    files, the main one first, in the order of the text; `not_ready` is what `run` refuses.
    """

    loaded: Loaded
    values: Mapping[str, ValueEntry]
    symbols: Mapping[tuple[str, int], SymbolUse]
    not_ready: tuple[NotReady, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def grammar(self) -> ast.Grammar:
        """The main file's tree, as written."""
        return self.loaded.main.grammar

    @property
    def source(self) -> Source:
        """The main file's text."""
        return self.loaded.main.source
