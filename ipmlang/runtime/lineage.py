"""Where every shape of a derivation came from: its parent, its place in the text, its scope.

A recorder is handed to a derivation and told of each batch that is made, rewritten or drawn; at the
end out come columns, one row a shape, in the order in which shapes were made, so that parents stand
before their children. Without a recorder nothing of this is kept. Nothing here derives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime import keys
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.keys import Words
from ipmlang.runtime.order import Copies, Drawn, Order, Record, Slot
from ipmlang.runtime.pending import Shapes

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Lineage:
    """n shapes whose symbols have rules, the first shapes included, and who drew each terminal.

    symbol (n,): into Program.symbols, -1 of the first shapes; production (n,): the one that was
    taken, -1 the axiom's, -2 none; parent (n,): a row before, -1 of the first shapes; site (n,):
    the call site in the parent's production; key (n,) u64; state: the fields of the shape's state
    as it was made, (n,) each; arguments: of each shape. drawer (m,), drawn_at (m,): of each row of
    the scene the shape that drew it, and the call site there; pens: the fields of the state that
    it was drawn with, (m,) each.
    """

    symbol: Integers
    production: Integers
    parent: Integers
    site: Integers
    key: NDArray[np.uint64]
    state: Mapping[str, Floats]
    arguments: tuple[tuple[float, ...], ...]
    drawer: Integers
    drawn_at: Integers
    pens: Mapping[str, Floats]

    def __len__(self) -> int:
        return len(self.symbol)

    def of_drawn(self, rows: NDArray[np.int64]) -> Lineage:
        """The same of a scene that shows these (k,) of all that was drawn: booleans join parts."""
        pens = {name: column[rows] for name, column in self.pens.items()}
        return replace(self, drawer=self.drawer[rows], drawn_at=self.drawn_at[rows], pens=pens)


@dataclass(slots=True, eq=False)
class Recorder:
    """What a derivation tells while it runs."""

    batches: list[tuple[int, int, Shapes]] = field(default_factory=list)
    taken: list[tuple[int, NDArray[np.int32]]] = field(default_factory=list)
    drawings: list[tuple[int | Words, Chunk]] = field(default_factory=list)

    def made(self, symbol: int, site: int, shapes: Shapes) -> None:
        """Shapes of a symbol were made at a call site."""
        self.batches.append((symbol, site, shapes))

    def applied(self, production: int, numbers: NDArray[np.int32]) -> None:
        """Shapes took a production."""
        self.taken.append((production, numbers))

    def drew(self, site: int | Words, chunk: Chunk) -> None:
        """Terminals were drawn at a call site, or at one each."""
        self.drawings.append((site, chunk))

    def lineage(
        self, order: Order, fields: Sequence[str], shapes: int, places: NDArray[np.int32]
    ) -> Lineage:
        """All of it, once the order is known; `places` (m,) are the rows of drawings."""
        symbol, site = np.full(shapes, -1, np.int32), np.full(shapes, -1, np.int32)
        key, state = np.zeros(shapes, np.uint64), {name: np.zeros(shapes) for name in fields}
        arguments: list[tuple[float, ...]] = [()] * shapes
        for own, where, batch in self.batches:
            rows = batch.numbers
            symbol[rows], site[rows] = own, where
            key[rows] = keys.packed(batch.k0, batch.k1)
            for name, column in zip(fields, batch.state, strict=True):
                state[name][rows] = column
            for row, values in zip(rows.tolist(), _arguments(batch), strict=True):
                arguments[row] = values
        production = np.full(shapes, -2, np.int32)
        for number, numbers in self.taken:
            production[numbers] = number
        parent, drawer = np.full(shapes, -1, np.int32), np.full(len(places), -1, np.int32)
        for record in order.records:
            assert isinstance(record, Record)
            _follow(record.slots, record.shapes, parent, drawer)
        at, pens = self._drawn(fields, len(places))
        rows = np.empty_like(places)
        rows[places] = np.arange(len(places))
        return Lineage(
            symbol,
            production,
            parent,
            site,
            key,
            state,
            tuple(arguments),
            drawer[rows],
            at[rows],
            {name: column[rows] for name, column in pens.items()},
        )

    def _drawn(self, fields: Sequence[str], count: int) -> tuple[Integers, dict[str, Floats]]:
        """The call site of each drawing, and what its pen held."""
        at = np.full(count, -1, np.int32)
        pens = {name: np.zeros(count) for name in fields}
        for where, chunk in self.drawings:
            rows = slice(chunk.start, chunk.start + chunk.count)
            at[rows] = chunk.column(where)
            for name in fields:
                pens[name][rows] = chunk.column(chunk.state[name])
        return at, pens


def _arguments(batch: Shapes) -> list[tuple[float, ...]]:
    if not batch.params:
        return [()] * batch.count
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
