"""Who is called what: every file of a program with its names, and where a name leads from there.

In go parsed files, out come units that know their rules, assets, tables, attributes, constants and
functions; a dotted name goes through an import. Nothing here reads a file or makes code.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, Source

Kind = TypeVar("Kind", bound=ast.Item)


@dataclass(frozen=True, slots=True)
class Place:
    """A unit and the number of one of its items."""

    unit: Unit
    item: int


@dataclass(slots=True, eq=False)
class Unit:
    """One parsed file. `prefix` is what the main file puts before its names (`roofs.`); `imports`
    finds the units it imports by their names there.
    """

    grammar: ast.Grammar
    source: Source
    prefix: str = ""
    imports: dict[str, Unit] = field(default_factory=dict)
    rules: dict[str, list[int]] = field(default_factory=dict)
    interpretations: dict[str, list[int]] = field(default_factory=dict)
    defined: dict[str, int] = field(default_factory=dict)

    @property
    def folder(self) -> Path:
        """Where relative references start."""
        return Path(self.source.path).parent

    def line(self, item: int) -> int:
        """The line, from 1, on which an item starts, comments above it apart."""
        items = self.grammar.items
        lead = items[item].span.start if 0 <= item < len(items) else 0
        return self.source.place(self._offset(item) + lead)[0]

    def diagnostic(
        self, item: int, span: ast.Span, code: str, message: str, hint: str | None = None
    ) -> Diagnostic:
        """An error about a place within an item."""
        begin = self._offset(item)
        return Diagnostic(
            code,
            message,
            source=self.source,
            start=begin + span.start,
            end=begin + span.end,
            hint=hint,
        )

    def error(
        self, item: int, span: ast.Span, code: str, message: str, hint: str | None = None
    ) -> IpmError:
        """That error alone, ready to raise."""
        return IpmError([self.diagnostic(item, span, code, message, hint)])

    def find(self, name: str) -> Place | None:
        """Where a name of this unit, or a dotted one of an import, is defined."""
        if name in self.defined:
            return Place(self, self.defined[name])
        unit, rest = self.within(name)
        return None if unit is self else unit.find(rest)

    def within(self, name: str) -> tuple[Unit, str]:
        """The unit that a dotted name leads to, and the name there."""
        alias, dot, rest = name.partition(".")
        return (self.imports[alias], rest) if dot and alias in self.imports else (self, name)

    def items(self, kind: type[Kind]) -> Iterator[tuple[int, Kind]]:
        """All items of a kind with their numbers."""
        for number, item in enumerate(self.grammar.items):
            if isinstance(item, kind):
                yield number, item

    def _offset(self, item: int) -> int:
        offsets = self.grammar.offsets
        return offsets[item] if 0 <= item < len(offsets) else 0


def unit(grammar: ast.Grammar, source: Source, prefix: str = "") -> Unit:
    """A file with its own names found; its imports are for the caller to fill in."""
    made = Unit(grammar, source, prefix)
    for number, item in enumerate(grammar.items):
        match item:
            case ast.Rule():
                named = made.interpretations if item.interpret else made.rules
                named.setdefault(item.head.name, []).append(number)
            case ast.Asset():
                made.defined.update(dict.fromkeys(item.names, number))
            case ast.Table() | ast.Attr() | ast.Const() | ast.Function():
                made.defined[item.name] = number
            case _:
                pass
    return made
