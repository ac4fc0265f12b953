"""Who is called what: every file of a program with its names, and where a name leads from there.

Units know their rules, assets, tables, attributes, constants and functions; a dotted name goes
through an import or a style. A file that is changed by a style or by who imports it is a unit of
its own (`lower/instances.py` makes them). Nothing here reads a file or makes code.
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
    """A unit and the number of one of its items: what stands there is looked up in that unit."""

    unit: Unit
    item: int


@dataclass(slots=True, eq=False)
class Unit:
    """One file as it is seen from one place. `prefix` is what the main file puts before its names
    (`roofs.`); `imports` and `styles` find other units by their names here, of `own_styles` those
    that are asked for. `rules`: the alternatives of a symbol, in their order, `interpretations`
    its `interpret` ones; `defined`: everything else that has a name.
    """

    grammar: ast.Grammar
    source: Source
    prefix: str = ""
    own_styles: frozenset[str] = frozenset()
    imports: dict[str, Unit] = field(default_factory=dict)
    styles: dict[str, Unit] = field(default_factory=dict)
    rules: dict[str, list[Place]] = field(default_factory=dict)
    interpretations: dict[str, list[Place]] = field(default_factory=dict)
    defined: dict[str, Place] = field(default_factory=dict)

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
        """Where a name of this unit, or a dotted one of another, is defined."""
        unit, rest = self.within(name)
        return unit.defined.get(rest)

    def within(self, name: str) -> tuple[Unit, str]:
        """The unit that a dotted name leads to, and the name there."""
        unit = self
        while True:
            if "." not in name:
                return unit, name
            first, dot, rest = name.partition(".")
            other = unit.imports.get(first) or unit.styles.get(first) if dot else None
            if other is None:
                return unit, name
            unit, name = other, rest

    def attribute(self, name: str) -> str:
        """What an attribute that an item of this unit defines is called from outside: without the
        style that the item belongs to, as the unit is that style.
        """
        first, dot, rest = name.partition(".")
        return self.prefix + (rest if dot and first in self.own_styles else name)

    def items(self, kind: type[Kind]) -> Iterator[tuple[int, Kind]]:
        """All items of a kind with their numbers."""
        for number, item in enumerate(self.grammar.items):
            if isinstance(item, kind):
                yield number, item

    def _offset(self, item: int) -> int:
        offsets = self.grammar.offsets
        return offsets[item] if 0 <= item < len(offsets) else 0
