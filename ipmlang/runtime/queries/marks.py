"""The shapes that queries can tell apart: labelled, named, reporting or asking, one row each.

In go columns of a batch, out come numbers of rows, which shapes carry in their state; so each row
knows the row that it stands in, and shapes find what they descend from. Keys name rows in the same
way in every pass of a derivation. Nothing is answered here.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache as remember
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops.queries import OCCLUSION
from ipmlang.runtime import keys
from ipmlang.runtime.code import Column
from ipmlang.runtime.keys import Words

Floats: TypeAlias = NDArray[np.float64]
Numbers: TypeAlias = NDArray[np.int64]
Kind = Literal[0, 1, 2, 3]

FIELD = "mark"  # of the state: the row that a shape stands in, -1 for none
PHASE = "phase"  # of the state: the phase in which what is made now is expanded
ASKING: Kind = 0  # it asks: only what descends from it matters
NAMED: Kind = 1  # its symbol's name is a label
LABELLED: Kind = 2
REPORTING: Kind = 3
ASKS = ("query", "snapped")  # instructions that ask about other shapes
FIRST = 1.0  # the phase that a derivation starts in
SEEN = ("x", "y", "z", "w", "i", "j", "k", "scale", "sx", "sy", "sz", "geo", FIELD, PHASE)


@dataclass(frozen=True, slots=True)
class Asked:
    """What a program's queries make it keep: the texts that are names of symbols, by number; which
    symbols ask; whether anything asks about geometry, and whether about all that is drawn.
    """

    named: Mapping[int, int]
    asking: frozenset[int]
    occlusion: bool
    drawn: bool


def asked(program: ir.Program) -> Asked | None:
    """What a program asks; None where it asks nothing about other shapes. Known for the program
    that was asked about last.
    """
    for each, found in tuple(_last()):
        if each is program:
            return found
    found = _asked(program)
    _last().append((program, found))
    return found


@remember
def _last() -> deque[tuple[ir.Program, Asked | None]]:
    return deque(maxlen=1)


def _asked(program: ir.Program) -> Asked | None:
    if not any(_asks(code) for code in _codes(program)):
        return None
    found = [each for code in _codes(program) for each in _all(code) if each.op in ASKS]
    texts = {text: number for number, text in enumerate(program.strings)}
    named = {
        number: texts[symbol.name]
        for number, symbol in enumerate(program.symbols)
        if symbol.name in texts and not symbol.held
    }
    asking = {
        production.symbol
        for production in (program.axiom, *program.productions)
        if any(first_query(code) for code in _parts(production))
    }
    occlusion = any(each.const in OCCLUSION for each in found)
    drawn = any(each.const in OCCLUSION and not each.args for each in found)
    return Asked(named, frozenset(asking), occlusion, drawn)


def _codes(program: ir.Program) -> Iterator[tuple[ir.Instruction, ...]]:
    for production in (program.axiom, *program.productions):
        yield from _parts(production)


def _parts(production: ir.Production) -> Iterator[tuple[ir.Instruction, ...]]:
    yield production.body
    if production.guard is not None:
        yield production.guard[0]
    if production.chance is not None:
        yield production.chance[1]


def _asks(code: tuple[ir.Instruction, ...]) -> bool:
    return any(each.op in ASKS or (each.body and _asks(each.body)) for each in code)


def _all(code: tuple[ir.Instruction, ...]) -> Iterator[ir.Instruction]:
    waiting = list(reversed(code))
    while waiting:
        each = waiting.pop()
        yield each
        waiting += reversed(each.body)


def first_query(code: Sequence[ir.Instruction]) -> ir.Instruction | None:
    """The first query of a body that is about its own shape: not in a part of it, in a copy or in a
    bracket.
    """
    depth = 0
    for each in code:
        depth += (each.op == "open") - (each.op == "close")
        if each.op == "query" and depth == 0:
            return each
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Rows that were made together; `rows` are those of the batch, None: all."""

    start: int
    count: int
    kind: Kind
    state: Mapping[str, Column]
    rows: Numbers | None


class Marks:
    """All rows of a derivation. Columns (n,): `parent` the row around each or -1, `key`, `label` a
    text's number or -1, `kind`, `phase`, `value` what is reported. `keeps`: states are kept, too.
    """

    def __init__(self, *, keeps: bool) -> None:
        self.count = 0
        self._keeps = keeps
        self.chunks: list[Chunk] = []
        self._room = 1024
        self._parent = np.zeros(self._room, np.int64)
        self._key = np.zeros(self._room, np.uint64)
        self._label = np.zeros(self._room, np.int64)
        self._kind = np.zeros(self._room, np.int8)
        self._phase = np.zeros(self._room)
        self._value = np.zeros(self._room)

    @property
    def parent(self) -> Numbers:
        """The row around each row."""
        return self._parent[: self.count]

    @property
    def key(self) -> NDArray[np.uint64]:
        """What names each row in every pass."""
        return self._key[: self.count]

    @property
    def label(self) -> Numbers:
        """The label, or the key of a report."""
        return self._label[: self.count]

    @property
    def kind(self) -> NDArray[np.int8]:
        """What each row is there for."""
        return self._kind[: self.count]

    @property
    def phase(self) -> Floats:
        """The phase of each row."""
        return self._phase[: self.count]

    @property
    def value(self) -> Floats:
        """What is reported."""
        return self._value[: self.count]

    def add(
        self,
        kind: Kind,
        count: int,
        label: Column,
        value: Column,
        state: Mapping[str, Column],
        words: tuple[Words, Words],
        rows: Numbers | None = None,
    ) -> Floats:
        """Rows for a batch, or for some rows of it, under the keys `words`; the number that each
        row of the batch stands in from now on.
        """
        parent = _full(state[FIELD], count)
        many = count if rows is None else len(rows)
        place = slice(self.count, self.count + many)
        self._grow(many)
        chosen = slice(None) if rows is None else rows
        self._parent[place] = parent[chosen]
        self._key[place] = keys.packed(*words)[chosen]
        self._label[place] = _full(label, count)[chosen]
        self._kind[place] = kind
        self._phase[place] = _full(state.get(PHASE, FIRST), count)[chosen]
        self._value[place] = _full(value, count)[chosen]
        if self._keeps and kind in (NAMED, LABELLED):
            self.chunks.append(Chunk(self.count, many, kind, state, rows))
        numbers = np.arange(self.count, self.count + many, dtype=np.float64)
        self.count += many
        if rows is None:
            return numbers
        found = parent.copy()
        found[rows] = numbers
        return found

    def _grow(self, many: int) -> None:
        if self.count + many <= self._room:
            return
        self._room = 2 * (self.count + many)
        self._parent = np.resize(self._parent, self._room)
        self._key = np.resize(self._key, self._room)
        self._label = np.resize(self._label, self._room)
        self._kind = np.resize(self._kind, self._room)
        self._phase = np.resize(self._phase, self._room)
        self._value = np.resize(self._value, self._room)

    def nearest(self, rows: Numbers, kinds: tuple[Kind, ...], label: Numbers) -> Numbers:
        """The nearest row (n,) of a kind and a label (n,) that each row is or stands in, or -1."""
        found = rows.copy()
        open_ = np.flatnonzero(found >= 0)
        while len(open_):
            own = found[open_]
            fits = np.isin(self.kind[own], kinds) & (self.label[own] == label[open_])
            open_ = open_[~fits]
            found[open_] = self.parent[found[open_]]
            open_ = open_[found[open_] >= 0]
        return found


def _full(value: Column, count: int) -> Floats:
    return np.broadcast_to(np.asarray(value, np.float64), (count,))
