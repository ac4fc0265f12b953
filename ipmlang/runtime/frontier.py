"""The batched frontier: shapes that expand independently, many at a time.

In go a bound program whose modules do not thread, out come its drawings and the order of all
applications. Wide work runs in numpy batches; while little waits, shapes run one by one in plain
numbers, breadth first, and a rule that makes itself last runs as a chain. All three give the same
keys.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime import keys
from ipmlang.runtime.bodies import Setting
from ipmlang.runtime.choose import Choice, module, told
from ipmlang.runtime.code import Column
from ipmlang.runtime.compiled import Chain, Compiled
from ipmlang.runtime.copying import Copying
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.keys import Words
from ipmlang.runtime.limits import Counted, Trail
from ipmlang.runtime.order import Copies, Drawn, Made, Order, Record, Slot, Trace
from ipmlang.runtime.pending import Pending, Shapes
from ipmlang.runtime.values import Batch, Bound

NARROW = 24  # so few shapes run one by one
WIDE = 96  # until so many wait
SHORT = 16  # a chain below this is quicker one by one
FINAL = 1 << 40  # the generation of what only its meaning is left of

One = tuple[int, int, int, int, int, int, tuple[float, ...], tuple[float, ...]]


class Frontier(Copying):
    """One derivation. Bodies call `draw` and `make`, and what `Copying` has for repeats."""

    def __init__(
        self, bound: Bound, initial: dict[str, float], limits: ir.Limits, steps: int | None
    ) -> None:
        super().__init__(bound.program, Counted(bound.program, limits))
        self._bound = bound
        self._initial = initial
        self._fields = tuple(initial)
        self._steps = steps
        self._compiled = Compiled(Setting(bound.program, self._fields, bound.attrs))
        self._pending = Pending()
        self._following = 0  # the generation of the shapes that are made now
        self.generations = 0
        self.order = Order()
        self.chunks: list[Chunk] = []
        self.drawings = 0
        self._single = _Single(self)

    @property
    def shapes(self) -> int:
        """How many shapes there are, the axiom included."""
        return self.counted.shapes

    def run(self, seed: int) -> None:
        """Derive everything."""
        first, second = keys.root(seed)
        self.counted.trail = Trail(self.order, self.names)
        self._names = [(0, "start")]
        self._apply(-1, self._axiom(first, second))
        while self._pending.count:
            if self._pending.count <= NARROW:
                self._single.run()
            else:
                (symbol, generation), shapes = self._pending.next()
                self._derive(symbol, generation, shapes)

    def names(self) -> list[tuple[int, str]]:
        """Where in the numbers of shapes those of each name begin."""
        return self._names

    def _axiom(self, k0: int, k1: int) -> Shapes:
        words = (np.array([k0], np.uint32), np.array([k1], np.uint32))
        state = tuple(self._initial.values())
        return Shapes(1, np.zeros(1, np.int32), *words, -1, (), state)

    # ------------------------------------------------------------------ batches

    def _derive(self, symbol: int, generation: int, shapes: Shapes) -> None:
        """Rewrite or interpret a batch of shapes of one symbol."""
        self._check(symbol, shapes)
        numbers = self._alternatives(symbol, generation)
        if not numbers:
            self._apply_meaning(symbol, shapes)
            return
        batch = Batch(self._bound, shapes.count, shapes.params, shapes.k0, shapes.k1)
        first = self._compiled.production(numbers[0])
        if first.guard is None and first.chance is None:
            self._apply(numbers[0], shapes)
            return
        self.counted.now = shapes.numbers
        taken, rest = Choice(batch, numbers, None).walk()
        if len(rest):
            self._keep(symbol, generation, shapes.take(rest), batch.take(rest))
        for each in taken:
            whole = len(each.rows) == shapes.count
            self._apply(each.production, shapes if whole else shapes.take(each.rows))

    def _alternatives(self, symbol: int, generation: int) -> tuple[int, ...]:
        """The productions that apply now, and the generation of what they make."""
        own = self.program.symbols[symbol]
        if generation < FINAL:
            if own.productions and (self._steps is None or generation < self._steps):
                self._following = generation + 1
                self.generations = max(self.generations, generation + 1)
                self.counted.deep(generation + 1, own.productions[0])
                return own.productions
            if own.interpretation:
                self._following = FINAL
                return own.interpretation
        return ()

    def _apply(self, number: int, shapes: Shapes) -> None:
        self.counted.at(number, shapes.numbers)
        body = self._compiled.body(number)
        slots = body(
            self, number, shapes.count, shapes.k0, shapes.k1, *shapes.params, *shapes.state
        )
        self.order.records.append(Record(shapes.numbers, slots))  # type: ignore[arg-type]

    def _apply_meaning(self, symbol: int, shapes: Shapes) -> None:
        if not self.program.symbols[symbol].meaning:
            return
        body = self._compiled.meaning(symbol)
        slots = body(
            self, shapes.rule, shapes.count, shapes.k0, shapes.k1, *shapes.params, *shapes.state
        )
        self.order.records.append(Record(shapes.numbers, slots))  # type: ignore[arg-type]

    def _keep(self, symbol: int, generation: int, shapes: Shapes, batch: Batch) -> None:
        """Shapes that no production takes: they stay, with a key of their own, or are an error."""
        if self._steps is None and self._following < FINAL:
            self._none(symbol, batch, shapes.numbers)
        slot = self.make(
            shapes.count, symbol, -1, shapes.params, shapes.state, shapes.k0, shapes.k1,
            keys.CHOICE_SITE, (), None,
        )  # fmt: skip
        self.order.records.append(Record(shapes.numbers, (slot,)))

    def _none(self, symbol: int, batch: Batch, numbers: NDArray[np.int32]) -> None:
        name = self.program.symbols[symbol].name
        more = f", nor of {batch.count - 1:,} more" if batch.count > 1 else ""
        raise self.counted.error(
            "no-production",
            f"no production of {module(batch, symbol, 0)} applies{more}",
            hint=f"write `{name} : else --> nil` to end silently",
            shape=int(numbers[0]),
        )

    def _check(self, symbol: int, shapes: Shapes) -> None:
        """Stop at a parameter or a state that is not finite."""
        for column in (*shapes.params, *shapes.state[: 3 if self.program.flat else 7]):
            if np.isfinite(np.sum(column)):
                continue
            wrong = np.flatnonzero(~np.isfinite(np.broadcast_to(column, (shapes.count,))))
            if len(wrong):
                self._not_finite(symbol, len(wrong), int(shapes.numbers[wrong[0]]))

    def _not_finite(self, symbol: int, count: int, shape: int) -> None:
        name = self.program.symbols[symbol].name
        shapes = f"{count:,} shapes of {name} have" if count > 1 else f"a shape of {name} has"
        raise self.counted.error(
            "not-a-number",
            f"{shapes} an argument or a place that is not a finite number",
            shape=shape,
        )

    # --------------------------------------------------------------- what bodies call

    def draw(
        self, count: int, rule: int | NDArray[np.int32], symbol: int, asset: int,
        size: tuple[Column, ...], state: tuple[Column, ...], k0: Words, k1: Words, site: int,
        copies: tuple[Words, ...], rows: NDArray[np.int64] | None,
    ) -> Drawn:
        """Note what every row of a batch, or some rows, draw."""
        count = count if rows is None else len(rows)
        own = dict(zip(self._fields, state, strict=True))
        chunk = Chunk(
            self.drawings, count, rule, symbol, asset, size, own, k0, k1, site, copies, rows
        )
        self.counted.draw(count)
        return self.note(chunk)

    def note(self, chunk: Chunk) -> Drawn:
        """Keep a chunk of drawings."""
        self.chunks.append(chunk)
        self.drawings += chunk.count
        return Drawn(chunk.start, chunk.count, chunk.rows)

    def make(
        self, count: int, symbol: int, rule: int, params: tuple[Column, ...],
        state: tuple[Column, ...], k0: Words, k1: Words, site: int, copies: tuple[Words, ...],
        rows: NDArray[np.int64] | None,
    ) -> Made:
        """Children of every row of a batch, or of some rows: they wait to be derived."""
        plain = Shapes(
            count, np.zeros(0, np.int32), k0, k1, int(rule), _columns(params), _columns(state)
        )
        if rows is not None:
            count = len(rows)
            copies = tuple(each[rows] for each in copies)
            plain = Shapes(
                count, plain.numbers, k0[rows], k1[rows], plain.rule,
                tuple(_chosen(column, rows) for column in plain.params),
                tuple(_chosen(column, rows) for column in plain.state),
            )  # fmt: skip
        start = self.begin(symbol, count)
        k0, k1 = keys.child(plain.k0, plain.k1, site, *copies)
        numbers = np.arange(start, start + count, dtype=np.int32)
        made = Shapes(count, numbers, k0, k1, plain.rule, plain.params, plain.state)
        self._pending.put(symbol, self._following, made)
        return Made(start, count, rows)

    def begin(self, symbol: int, count: int) -> int:
        """The first number of so many new shapes."""
        start = self.counted.make(count)
        name = self.program.symbols[symbol].name
        if self._names[-1][1] != name:
            self._names.append((start, name))
        return start


def _columns(values: Sequence[Column]) -> tuple[Column, ...]:
    return tuple(
        float(value) if isinstance(value, np.ndarray) and not value.ndim else value
        for value in values
    )


def _chosen(column: Column, rows: NDArray[np.int64]) -> Column:
    return column[rows] if isinstance(column, np.ndarray) else column


class _Single:
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
        for (symbol, generation), shapes in frontier._pending.all():
            self._waiting.extend(_ones(symbol, generation, shapes))
        self._first = frontier.shapes
        while self._waiting and len(self._waiting) + frontier._pending.count <= WIDE:
            self._derive(self._waiting.popleft())
        self._close()
        self._release()

    def _derive(self, one: One) -> None:
        symbol, generation, number, k0, k1, rule, params, state = one
        frontier = self._frontier
        if not np.isfinite(sum(params)):
            frontier._not_finite(symbol, 1, number)
        numbers = frontier._alternatives(symbol, generation)
        self._following = frontier._following
        if not numbers:
            if frontier.program.symbols[symbol].meaning:
                body = frontier._compiled.meaning(symbol, single=True)
                self._steps.append((number, body(self, rule, k0, k1, *params, *state)))  # type: ignore[arg-type]
            return
        frontier.counted.one(number)
        chain = frontier._compiled.chain(symbol)
        if chain is not None and self._chained(chain, one):
            return
        taken = frontier._compiled.choose(numbers)(params, k0, k1)
        frontier.counted.rule = taken
        if taken < 0:
            self._keep(one)
        elif frontier._compiled.is_single(taken):
            body = frontier._compiled.body(taken, single=True)
            self._steps.append((number, body(self, taken, k0, k1, *params, *state)))  # type: ignore[arg-type]
        else:
            self._close()
            frontier._apply(taken, _shapes([one]))

    def _keep(self, one: One) -> None:
        symbol, generation, number, k0, k1, _, params, state = one
        frontier = self._frontier
        if frontier._steps is None and self._following < FINAL:
            shapes = _shapes([one])
            batch = Batch(frontier._bound, 1, shapes.params, shapes.k0, shapes.k1)
            frontier._none(symbol, batch, shapes.numbers)
        made = self.make(symbol, keys.child_single(k0, k1, keys.CHOICE_SITE), -1, params, state)
        self._steps.append((number, (made,)))

    def _chained(self, chain: Chain, one: One) -> bool:
        """Run a chain at once, where it is long."""
        symbol, generation, number, k0, k1, _, params, state = one
        frontier = self._frontier
        counted = frontier.counted
        rule = chain.production
        room = counted.room(generation)
        columns, words0, words1, last, end0, end1 = chain.loop(room, k0, k1, *params)
        count = len(words0)
        if count < SHORT:
            return False
        self._close()
        counted.at(rule, np.array([number], np.int32))
        counted.deep(generation + count, rule)
        counted.make(count)
        owner, counts = np.zeros(count, np.int64), np.array([count], np.int64)
        keyed = (np.array(words0, np.uint32), np.array(words1, np.uint32))
        own = [np.array(column) for column in columns]
        for column in own:
            if not np.isfinite(column).all():
                frontier._not_finite(symbol, int((~np.isfinite(column)).sum()), number)
        slots, ended = chain.body(
            frontier, rule, count, counts, owner, *keyed, *own, *state
        )
        frontier._following = self._following = generation + count
        frontier.generations = max(frontier.generations, generation + count)
        start = frontier.begin(symbol, 1)
        inner: tuple[Slot, ...] = (Copies(counts, owner, slots), Made(start, 1))  # type: ignore[arg-type]
        frontier.order.records.append(Record(np.array([number], np.int32), inner))
        final = tuple(float(np.asarray(value).reshape(-1)[-1]) for value in ended)  # type: ignore[arg-type]
        self._waiting.append((symbol, generation + count, start, end0, end1, rule, last, final))
        self._first = frontier.shapes
        return True

    def draw(self, row: tuple[float, ...]) -> int:
        """Note one drawing: rule, symbol, asset, size, state and key."""
        self._rows.append(row)
        self._frontier.counted.draw(1)
        return self._frontier.drawings + len(self._rows) - 1

    def make(
        self, symbol: int, key: tuple[int, int], rule: int, params: tuple[float, ...],
        state: tuple[float, ...],
    ) -> int:
        """One child: it waits to be derived."""
        number = self._frontier.begin(symbol, 1)
        self._waiting.append((symbol, self._following, number, *key, rule, params, state))
        return number

    def factor(self, value: float) -> None:
        """A scale's factor must be above 0."""
        self._frontier.factor(value)

    def _close(self) -> None:
        """End the trace: what follows is a batch."""
        frontier = self._frontier
        if self._steps:
            last = frontier.shapes
            frontier.order.records.append(Trace(self._first, last, self._steps))
            self._steps = []
        if self._rows:
            frontier.note(_chunk(frontier.drawings, self._rows, frontier._fields))
            self._rows = []
        self._first = frontier.shapes

    def _release(self) -> None:
        """What still waits goes back to the batches."""
        kinds: dict[tuple[int, int], list[One]] = {}
        for one in self._waiting:
            kinds.setdefault(one[:2], []).append(one)
        self._waiting.clear()
        for (symbol, generation), ones in kinds.items():
            self._frontier._pending.put(symbol, generation, _shapes(ones))


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
