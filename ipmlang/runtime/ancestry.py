"""The way from the start to a module of a string, for errors: `start > Lot > Floor[3] > Tile`.

In go what the steps of a derivation rewrote, out come names. A derivation keeps what it needs to
find its places; what it does not keep, it keeps when it runs again because an error asked for the
way. Nothing here rewrites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.limits import joined_way
from ipmlang.runtime.rewrite import Block, Copies, Item, Modules
from ipmlang.runtime.scan import Whole


class ModuleError(Exception):
    """An error at a module of a string, row `row` of its symbol's table, without the way there."""

    def __init__(self, error: IpmError, symbol: int, row: int) -> None:
        super().__init__(error, symbol, row)
        self.error = error
        self.symbol = symbol
        self.row = row


@dataclass(slots=True, eq=False)
class Rewritten:
    """All modules of one symbol that a step rewrites: where they came from, what they became."""

    parts: list[Modules]
    count: int
    blocks: list[Block]


@dataclass(slots=True, eq=False)
class Grown:
    """A derivation from its start on: what each step rewrote, and at its end what is left."""

    program: ir.Program
    start: Block
    done: list[list[Rewritten]] = field(default_factory=list)
    kept: list[Modules] = field(default_factory=list)

    def labels(self, parts: Sequence[Modules], row: int) -> list[str]:
        """The names from a row of some modules of one symbol back to the start."""
        labels: list[str] = []
        part, row = _located(parts, row)
        level = len(self.done)
        while True:
            name = self.program.symbols[part.symbol].name
            above, level, copy = self._maker(part, row, level)
            labels.append(name if copy is None else f"{name}[{copy}]")
            if above is None:
                return labels
            part, row = above

    def at(self, place: int) -> tuple[Modules, int] | None:
        """The module at a place of the string."""
        for part in self.kept:
            rows = np.flatnonzero(part.place == place)
            if len(rows):
                return part, int(rows[0])
        return None

    def _maker(
        self, part: Modules, row: int, level: int
    ) -> tuple[tuple[Modules, int] | None, int, int | None]:
        """What was rewritten into a module by a step before `level`, the number of that step, and
        the module's copy in a repeat; nothing where it stands in the start.
        """
        for number in reversed(range(level)):
            for each in self.done[number]:
                for block in each.blocks:
                    found = _found(block.items, part, row)
                    if found is not None:
                        own = int(block.rows[found[0]])
                        return _located(each.parts, own), number, found[1]
        started = _found(self.start.items, part, row)
        return None, 0, None if started is None else started[1]


@dataclass(slots=True, eq=False)
class History:
    """What a string went through, kept where an error wants to know: what it was after it was
    `grown` at once, if it was, and for each step after that the place before of each place, with
    the symbols that were rewritten at which places.
    """

    program: ir.Program
    grown: Grown | None = None
    steps: list[tuple[Whole, list[tuple[int, Whole]]]] = field(default_factory=list)

    def way(self, symbol: int, place: int) -> str:
        """The way to a module of the string as it is now."""
        labels = [self.program.symbols[symbol].name]
        for back, tables in reversed(self.steps):
            place = int(back[place])
            labels += [
                self.program.symbols[each].name for each, places in tables if place in places
            ]
        if self.grown is not None:
            found = self.grown.at(place)
            if found is not None:
                labels[-1:] = self.grown.labels([found[0]], found[1])
        return way_of(labels)


def way_of(labels: Sequence[str]) -> str:
    """Names from a module back to the start as people read them."""
    return joined_way(["start", *reversed(labels)])


def told_way(error: IpmError, way: str) -> IpmError:
    """An error that says how its module came about."""
    return IpmError([replace(each, trail=way) for each in error.diagnostics])


def _located(parts: Sequence[Modules], row: int) -> tuple[Modules, int]:
    """The part that a row of several is in, and its row there."""
    for part in parts:
        if row < part.count:
            return part, row
        row -= part.count
    raise AssertionError("no part has this row")


def _found(items: Sequence[Item], part: Modules, row: int) -> tuple[int, int | None] | None:
    """The row of a body that has a module, and the number of its innermost copy."""
    for item in items:
        if item is part:
            return row, None
        if isinstance(item, Copies):
            inner = _found(item.items, part, row)
            if inner is not None:
                owner = int(item.owner[inner[0]])
                copy = inner[0] - int(item.counts[:owner].sum())
                return owner, copy if inner[1] is None else inner[1]
    return None
