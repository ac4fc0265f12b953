"""Where every shape of a derivation came from: its parent, its place in the text, its scope.

A recorder is handed to a derivation and told of each batch that is made, rewritten or drawn; at the
end out come columns, one row a shape, in the order in which shapes were made, so that parents stand
before their children. Without a recorder nothing of this is kept. Nothing here derives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime import keys
from ipmlang.runtime.code import Column
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.keys import Words
from ipmlang.runtime.order import Copies, Drawn, Order, Record, Slot, Trace
from ipmlang.runtime.pending import Shapes

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]
Kind = TypeVar("Kind", bound=np.generic)
Made: TypeAlias = tuple[int, int, Shapes]  # a symbol, the call site, what was made there


class Lineage:
    """n shapes whose symbols have rules, the first shapes included, and who drew each terminal: m
    rows of the scene. Columns are worked out when they are first asked for. `shown`: the scene
    shows these (m,) of all that was drawn, None: all.
    """

    def __init__(
        self,
        told: Recorder,
        records: Sequence[Record | Trace],
        fields: Sequence[str],
        shapes: int,
        places: Integers,
        shown: NDArray[np.int64] | None = None,
    ) -> None:
        self._told = told
        self._records = records
        self._fields = tuple(fields)
        self._count = shapes
        self._places = places
        self._shown = shown

    def __len__(self) -> int:
        return self._count

    def of_drawn(self, rows: NDArray[np.int64]) -> Lineage:
        """The same of a scene that shows these (k,) of all that was drawn: booleans join parts."""
        told = (self._told, self._records, self._fields, self._count, self._places)
        return Lineage(*told, rows)

    @cached_property
    def symbol(self) -> Integers:
        """(n,) into Program.symbols, -1 of the first shapes."""
        return self._column(np.full(self._count, -1, np.int32), lambda batch: batch[0])

    @cached_property
    def site(self) -> Integers:
        """(n,) the call site in the parent's production."""
        return self._column(np.full(self._count, -1, np.int32), lambda batch: batch[1])

    @cached_property
    def key(self) -> NDArray[np.uint64]:
        """(n,) what names each shape in every derivation."""
        return self._column(
            np.zeros(self._count, np.uint64), lambda batch: keys.packed(batch[2].k0, batch[2].k1)
        )

    @cached_property
    def state(self) -> Mapping[str, Floats]:
        """The fields of each shape's state as it was made, (n,) each."""
        state = {name: np.zeros(self._count) for name in self._fields}
        for _, _, batch in self._told.batches:
            for name, column in zip(self._fields, batch.state, strict=True):
                state[name][batch.numbers] = column
        return state

    @cached_property
    def arguments(self) -> tuple[tuple[float, ...], ...]:
        """(n,) the arguments of each shape."""
        arguments: list[tuple[float, ...]] = [()] * self._count
        for _, _, batch in self._told.batches:
            if batch.params:
                for row, values in zip(batch.numbers.tolist(), _arguments(batch), strict=True):
                    arguments[row] = values
        return tuple(arguments)

    @cached_property
    def production(self) -> Integers:
        """(n,) the one that was taken, -1 the axiom's, -2 none."""
        production = np.full(self._count, -2, np.int32)
        for number, numbers in self._told.taken:
            production[numbers] = number
        return production

    @cached_property
    def parent(self) -> Integers:
        """(n,) a row before, -1 of the first shapes."""
        return self._makers[0]

    @cached_property
    def drawer(self) -> Integers:
        """(m,) of each row of the scene the shape that drew it."""
        return self._makers[1][self._rows]

    @cached_property
    def drawn_at(self) -> Integers:
        """(m,) the call site where it was drawn."""
        at = np.full(len(self._places), -1, np.int32)
        for where, chunk, _ in self._told.drawings:
            at[chunk.start : chunk.start + chunk.count] = chunk.column(where)
        return at[self._rows]

    @cached_property
    def pens(self) -> Mapping[str, Floats]:
        """The fields of the state that it was drawn with, (m,) each."""
        pens = {name: np.zeros(len(self._places)) for name in self._fields}
        for _, chunk, state in self._told.drawings:
            rows = slice(chunk.start, chunk.start + chunk.count)
            for name in self._fields:
                pens[name][rows] = chunk.column(state[name])
        return {name: column[self._rows] for name, column in pens.items()}

    @cached_property
    def _rows(self) -> NDArray[np.int64]:
        """(m,) the drawing that each row of the scene is."""
        rows = np.empty(len(self._places), np.int64)
        rows[self._places] = np.arange(len(self._places))
        return rows if self._shown is None else rows[self._shown]

    @cached_property
    def _makers(self) -> tuple[Integers, Integers]:
        """Who made each shape, and who drew each drawing."""
        parent = np.full(self._count, -1, np.int32)
        drawer = np.full(len(self._places), -1, np.int32)
        for record in self._records:
            assert isinstance(record, Record)
            _follow(record.slots, record.shapes, parent, drawer)
        return parent, drawer

    def _column(
        self, out: NDArray[Kind], value: Callable[[Made], int | NDArray[np.uint64]]
    ) -> NDArray[Kind]:
        """A column with what each batch has for its shapes."""
        for batch in self._told.batches:
            out[batch[2].numbers] = value(batch)
        return out


@dataclass(slots=True, eq=False)
class Recorder:
    """What a derivation tells while it runs. drawings: call sites, what was drawn there, and the
    fields of the state then.
    """

    batches: list[Made] = field(default_factory=list)
    taken: list[tuple[int, NDArray[np.int32]]] = field(default_factory=list)
    drawings: list[tuple[int | Words, Chunk, Mapping[str, Column]]] = field(default_factory=list)

    def made(self, symbol: int, site: int, shapes: Shapes) -> None:
        """Shapes of a symbol were made at a call site."""
        self.batches.append((symbol, site, shapes))

    def applied(self, production: int, numbers: NDArray[np.int32]) -> None:
        """Shapes took a production."""
        self.taken.append((production, numbers))

    def drew(self, site: int | Words, chunk: Chunk) -> None:
        """Terminals were drawn at a call site, or at one each."""
        self.drawings.append((site, chunk, dict(chunk.state)))

    def lineage(
        self, order: Order, fields: Sequence[str], shapes: int, places: Integers
    ) -> Lineage:
        """All of it, once the order is known; `places` (m,) are the rows of drawings."""
        return Lineage(self, tuple(order.records), fields, shapes, places)


def _arguments(batch: Shapes) -> list[tuple[float, ...]]:
    columns = [np.broadcast_to(each, (batch.count,)).tolist() for each in batch.params]
    return list(zip(*columns, strict=True))


def _follow(slots: Sequence[Slot], owner: Integers, parent: Integers, drawer: Integers) -> None:
    """Note whose children and drawings the slots of a body hold; `owner` (n,) has each row's."""
    for slot in slots:
        if isinstance(slot, Copies):
            _follow(slot.slots, owner[slot.owner], parent, drawer)
            continue
        column = drawer if isinstance(slot, Drawn) else parent
        rows = owner if slot.rows is None else owner[slot.rows]
        column[slot.start : slot.start + slot.count] = rows[: slot.count]
