"""A narrow stretch of a derivation: shape by shape in plain numbers, breadth first.

In go the few shapes that wait, out come drawings and children, until much waits or nothing. A rule
that makes itself last runs as a chain: its parameters and keys in one tight loop, its frames by one
scan. Keys and order are those of the batches.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime import keys
from ipmlang.runtime.chains import Chain
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.order import Copies, Made, Record, Slot, Trace
from ipmlang.runtime.pending import FINAL, Shapes
from ipmlang.runtime.values import Batch

if TYPE_CHECKING:
    from ipmlang.runtime.frontier import Frontier

WIDE = 96  # shapes run one by one until so many wait
SHORT = 16  # a chain below this is quicker one by one

# symbol, generation, number, key words, rule, parameters, state
One = tuple[int, int, int, int, int, int, tuple[float, ...], tuple[float, ...]]


class Single:
    """A narrow stretch of a derivation, shape by shape. Bodies call `draw` and `make`."""

    def __init__(self, frontier: Frontier) -> None:
        self._frontier = frontier
        self._waiting: deque[One] = deque()
        self._rows: list[tuple[float, ...]] = []
        self._steps: list[tuple[int, tuple[int, ...]]] = []
        self._first = 0
        self._following = 0

    def run(self) -> None:
        """Derive breadth first until much waits, or nothing."""
        frontier = self._frontier
        for (symbol, generation), shapes in frontier.pending.all():
            self._waiting.extend(_ones(symbol, generation, shapes))
        self._open()
        while self._waiting and len(self._waiting) + frontier.pending.count <= WIDE:
            self._derive(self._waiting.popleft())
        self._close()
        self._release()

    def _derive(self, one: One) -> None:
        symbol, generation, number, k0, k1, rule, params, state = one
        frontier = self._frontier
        if not np.isfinite(sum(params)):
            frontier.not_finite(symbol, 1, number)
        numbers = frontier.alternatives(symbol, generation, state)
        self._following = frontier.following
        if not numbers:
            if frontier.program.symbols[symbol].meaning:
                body = frontier.compiled.meaning(symbol, single=True)
                self._steps.append((number, body(self, rule, k0, k1, *params, *state)))  # type: ignore[arg-type]
            return
        frontier.counted.one(number)
        chain = frontier.compiled.chain(symbol)
        if chain is not None and self._chained(chain, one):
            return
        try:
            taken = frontier.compiled.choose(numbers)(params, k0, k1)
        except IpmError as found:
            raise frontier.counted.traced(found, number) from found
        frontier.counted.rule = taken
        if taken < 0:
            self._keep(one)
        elif frontier.compiled.is_single(taken):
            body = frontier.compiled.body(taken, single=True)
            self._steps.append((number, body(self, taken, k0, k1, *params, *state)))  # type: ignore[arg-type]
        else:
            self._close()
            frontier.apply(taken, _shapes([one]))
            self._open()

    def _keep(self, one: One) -> None:
        symbol, _, number, k0, k1, _, params, state = one
        frontier = self._frontier
        if frontier.steps is None and self._following < FINAL:
            shapes = _shapes([one])
            batch = Batch(frontier.bound, 1, shapes.params, shapes.k0, shapes.k1)
            frontier.none(symbol, batch, shapes.numbers)
        made = self.make(symbol, keys.child_single(k0, k1, keys.CHOICE_SITE), -1, params, state)
        self._steps.append((number, (made,)))

    def _chained(self, chain: Chain, one: One) -> bool:
        """Run a chain at once, where it is long."""
        symbol, generation, number, k0, k1, _, params, state = one
        frontier = self._frontier
        counted = frontier.counted
        rule = chain.production
        room = counted.room(generation)
        columns, words0, words1, last, end0, end1 = chain.walk(room, k0, k1, *params)
        count = len(words0)
        if count < SHORT:
            return False
        self._close()
        counted.at(rule, np.array([number], np.int32))
        counted.deep(generation + count, rule)
        counted.make(count - 1)  # all rows but the first; the last row's child is begun below
        owner, counts = np.zeros(count, np.int64), np.array([count], np.int64)
        keyed = (np.array(words0, np.uint32), np.array(words1, np.uint32))
        own = [np.array(column) for column in columns]
        for column in own:
            if not np.isfinite(column).all():
                frontier.not_finite(symbol, int((~np.isfinite(column)).sum()), number)
        slots, ended = chain.body(frontier, rule, count, counts, owner, *keyed, *own, *state)
        frontier.following = self._following = generation + count
        frontier.generations = max(frontier.generations, generation + count)
        start = frontier.begin(symbol, 1)
        inner: tuple[Slot, ...] = (Copies(counts, owner, slots), Made(start, 1))  # type: ignore[arg-type]
        frontier.order.records.append(Record(np.array([number], np.int32), inner))
        final = tuple(float(np.asarray(value).reshape(-1)[-1]) for value in ended)
        self._waiting.append((symbol, generation + count, start, end0, end1, rule, last, final))
        self._open()
        return True

    def draw(self, row: tuple[float, ...]) -> int:
        """Note one drawing: rule, symbol, asset, size, state and key."""
        self._rows.append(row)
        self._frontier.counted.draw(1)
        return self._frontier.drawings + len(self._rows) - 1

    def make(
        self,
        symbol: int,
        key: tuple[int, int],
        rule: int,
        params: tuple[float, ...],
        state: tuple[float, ...],
    ) -> int:
        """One child: it waits to be derived."""
        number = self._frontier.begin(symbol, 1)
        self._waiting.append((symbol, self._following, number, *key, rule, params, state))
        return number

    def group(self, text: float, parent: float, state: Mapping[str, float]) -> float:
        """Begin one group; its number."""
        return self._frontier.grouping.begin_one(text, parent, state)

    def finite(self, value: float, name: str) -> None:
        """An argument of an operation must be a finite number."""
        self._frontier.finite(value, name)

    def factor(self, value: float) -> None:
        """A scale's factor must be above 0."""
        self._frontier.factor(value)

    def _open(self) -> None:
        """Begin a trace: its shapes are made from here on."""
        self._first = self._frontier.shapes
        self._frontier.order.open = Trace(self._first, 1 << 62, self._steps)

    def _close(self) -> None:
        """End the trace: what follows is a batch."""
        frontier = self._frontier
        frontier.order.open = None
        if self._steps:
            last = frontier.shapes
            frontier.order.records.append(Trace(self._first, last, self._steps))
            self._steps = []
        if self._rows:
            chunk = _chunk(frontier.drawings, self._rows, frontier.fields)
            self._rows = []
            frontier.check_drawn(chunk)
            frontier.note(chunk)

    def _release(self) -> None:
        """What still waits goes back to the batches."""
        kinds: dict[tuple[int, int], list[One]] = {}
        for one in self._waiting:
            kinds.setdefault(one[:2], []).append(one)
        self._waiting.clear()
        for (symbol, generation), ones in kinds.items():
            self._frontier.pending.put(symbol, generation, _shapes(ones))


def _ones(symbol: int, generation: int, shapes: Shapes) -> list[One]:
    """Shapes one by one."""
    count = shapes.count
    columns = [np.broadcast_to(column, (count,)).tolist() for column in shapes.params]
    states = [np.broadcast_to(column, (count,)).tolist() for column in shapes.state]
    params = list(zip(*columns, strict=True)) or [()] * count
    state = list(zip(*states, strict=True)) or [()] * count
    rule = np.broadcast_to(shapes.rule, (count,)).tolist()
    words = (shapes.k0.tolist(), shapes.k1.tolist())
    each = zip(shapes.numbers.tolist(), *words, rule, params, state, strict=True)
    return [(symbol, generation, *one) for one in each]


def _shapes(ones: list[One]) -> Shapes:
    """Shapes of one symbol as columns."""
    _, _, numbers, k0, k1, rule, params, state = zip(*ones, strict=True)
    return Shapes(
        len(ones),
        np.array(numbers, np.int32),
        np.array(k0, np.uint32),
        np.array(k1, np.uint32),
        np.array(rule, np.int32),
        tuple(np.array(column, np.float64) for column in zip(*params, strict=True)),
        tuple(np.array(column, np.float64) for column in zip(*state, strict=True)),
    )


def _chunk(start: int, rows: list[tuple[float, ...]], fields: Sequence[str]) -> Chunk:
    """Single drawings as columns."""
    rule, symbol, asset, *values, k0, k1 = zip(*rows, strict=True)
    columns = [np.array(column, np.float64) for column in values]
    return Chunk(
        start,
        len(rows),
        np.array(rule, np.int32),
        np.array(symbol, np.int32),
        np.array(asset, np.int32),
        tuple(columns[:3]),
        dict(zip(fields, columns[3:], strict=True)),
        np.array(k0, np.uint32),
        np.array(k1, np.uint32),
    )
