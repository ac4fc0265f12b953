"""The batched frontier: shapes that expand independently, many at a time.

In go a bound program whose modules do not thread, out come its drawings and the order of all
applications. Wide work runs in numpy batches; while little waits, shapes run one by one in plain
numbers, breadth first, and a rule that makes itself last runs as a chain. All three give the same
keys.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import keys
from ipmlang.runtime.bind import varied
from ipmlang.runtime.choose import Choice, ShapeError, module, told
from ipmlang.runtime.code import Column
from ipmlang.runtime.compiled import Compiled
from ipmlang.runtime.copying import Around
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.fields import LAG
from ipmlang.runtime.grouping import Grouping
from ipmlang.runtime.keys import Words
from ipmlang.runtime.levels import Levels
from ipmlang.runtime.limits import Counted, Trail
from ipmlang.runtime.naming import OWN, Setting
from ipmlang.runtime.order import Drawn, Made, Order, Record
from ipmlang.runtime.pending import FINAL, Pending, Shapes, taken
from ipmlang.runtime.queries.marks import FIELD as MARK
from ipmlang.runtime.queries.marks import PHASE, SEEN
from ipmlang.runtime.scene import OUTLINES, SEGMENT
from ipmlang.runtime.scopes.ground import first_keys, standing
from ipmlang.runtime.scopes.growing import grow
from ipmlang.runtime.scopes.joins import Joining
from ipmlang.runtime.scopes.solids import AssetSolids
from ipmlang.runtime.scopes.trimming import Trimming
from ipmlang.runtime.single import Single
from ipmlang.runtime.values import Batch, Bound, Scope

if TYPE_CHECKING:
    from ipmlang.runtime.lineage import Recorder
    from ipmlang.runtime.queries.occluders import Occluders
    from ipmlang.runtime.replay import Recording, Replay

NARROW = 24  # so few shapes run one by one
PLACES = ("x", "y", "z")
TURNED = ("angle", "w", "i", "j", "k", "scale")
FLAT = (SEGMENT, *OUTLINES)  # what a turtle draws has no scope

NOTHING = Made(0, 0, np.zeros(0, np.int64))


class Frontier(Trimming):
    """One derivation. Bodies call `draw` and `make`, and what `Asking` has for other shapes and
    `Scoping` for parts.
    """

    def __init__(
        self,
        bound: Bound,
        initial: dict[str, float],
        limits: ir.Limits,
        steps: int | None,
        answers: Occluders | None = None,
        recorder: Recorder | None = None,
        draws: Replay | Recording | None = None,
    ) -> None:
        counted = Counted(bound.program, limits)
        super().__init__(bound.program, counted, AssetSolids(bound.program), answers)
        self.bound = bound
        self._recorder = recorder
        self.draws = draws
        self._initial = initial
        self.fields = tuple(initial)
        self._lag = self.fields.index(LAG) if LAG in initial else None
        self.steps = steps
        self.compiled = Compiled(Setting(bound.program, self.fields, bound.attrs, bound.data))
        self.pending = Pending()
        self._later: dict[float, Pending] = {}  # what waits for other phases
        self.following = 0  # the generation of the shapes that are made now
        self.generations = 0
        self.order = Order()
        self.chunks: list[Chunk] = []
        self.drawings = 0
        self.grouping = Grouping()
        self.joining = Joining()
        self.polygons: tuple[NDArray[np.float64], ...] = ()
        self.notes: tuple[str, ...] = ()
        self._single = Single(self)
        self._sound: dict[int, Column] = {}  # columns of the batch that were found to be finite

    @property
    def shapes(self) -> int:
        """How many shapes there are, the axiom included."""
        return self.counted.shapes

    def run(self, seed: int) -> None:
        """Derive everything."""
        self.names_begin()
        self.apply(-1, self.axiom(seed))
        levels = None if self.draws is None else Levels(self)
        while self.pending.count or self._later:
            if not self.pending.count:
                self.enter(min(self._later))
                self.pending = self._later.pop(self.phase)
            if levels is not None:
                levels.next()
            elif self.is_narrow():
                self._single.run()
            else:
                self.advance()

    def names_begin(self) -> None:
        """Begin to note what shapes are called, for the way to one of them."""
        self.counted.trail = Trail(self.order, self.names)
        self._names = [(0, "start")]

    def is_narrow(self) -> bool:
        """Whether so little waits that shapes are derived one by one."""
        few = self.pending.count <= NARROW
        return few and not self.program.scoped and self._recorder is None

    def advance(self) -> None:
        """Derive some of what waits."""
        (symbol, generation), shapes = self.pending.next()
        self.derive(symbol, generation, shapes)

    def names(self) -> list[tuple[int, str]]:
        """Where in the numbers of shapes those of each name begin."""
        return self._names

    def axiom(self, seed: int) -> Shapes:
        """The first shapes: one, or those that the start stands on."""
        state: dict[str, Column] = dict(self._initial)
        count = 1
        params: tuple[Column, ...] = ()
        k0, k1 = (np.full(1, word, np.uint32) for word in keys.root(seed))
        if self.program.scoped:
            found = standing(self.program, self.bound.attrs, seed, self.pool)
            count = len(found.size)
            k0, k1 = first_keys(seed, found)
            params = tuple(map(_column, map(np.atleast_1d, varied(self.program, k0, k1))))
            names = (*"xyz", *"wijk", "sx", "sy", "sz")
            columns = (*found.position.T, *found.rotation.T, *found.size.T)
            state.update(zip(names, map(_column, columns), strict=True))
            state["geo"] = _column(found.geometry)
            self.counted.shapes = self.order.first = count
            self.notes = found.notes
        numbers = np.arange(count, dtype=np.int32)
        first = Shapes(count, numbers, k0, k1, -1, params, tuple(state.values()))
        if self._recorder is not None:
            self._recorder.made(-1, -1, first)
        return self._noted(-1, first)

    # ------------------------------------------------------------------ batches

    def derive(self, symbol: int, generation: int, shapes: Shapes) -> None:
        """Rewrite or interpret a batch of shapes of one symbol."""
        self._check(symbol, shapes)
        if self.program.symbols[symbol].apart and generation < FINAL:
            grow(self, symbol, generation, shapes)
            return
        numbers = self.alternatives(symbol, generation, shapes.state)
        if not numbers:
            self._apply_meaning(symbol, shapes)
            return
        batch = Batch(self.bound, shapes.count, shapes.params, shapes.k0, shapes.k1)
        if self.program.scoped:
            batch.scope = Scope(dict(zip(self.fields, shapes.state, strict=True)), self)
        first = self.compiled.production(numbers[0])
        if first.guard is None and first.chance is None:
            self.apply(numbers[0], shapes)
            return
        self.counted.now = shapes.numbers
        try:
            if self.draws is None:
                found, rest = Choice(batch, numbers, None).walk()
            else:  # the shapes stand from left to right
                found, rest = self.draws.choose(batch, numbers, None, np.arange(shapes.count))
        except ShapeError as wrong:
            shape = int(shapes.numbers[wrong.row])
            raise self.counted.traced(wrong.error, shape) from wrong
        if len(rest):
            self._keep(symbol, generation, shapes.take(rest), batch.take(rest))
        for each in found:
            whole = len(each.rows) == shapes.count
            self.apply(each.production, shapes if whole else shapes.take(each.rows))

    def alternatives(
        self, symbol: int, generation: int, state: tuple[Column, ...]
    ) -> tuple[int, ...]:
        """The productions that apply now to shapes in some states; notes the generation of what
        they make. What the rows of a chain made waits in one generation, and carries by how much
        it is too early.
        """
        own = self.program.symbols[symbol]
        if generation < FINAL:
            if own.productions and (self.steps is None or generation < self.steps):
                self.following = generation + 1
                lag = 0.0 if self._lag is None else state[self._lag]
                late = int(lag.max() if isinstance(lag, np.ndarray) else lag)
                self.generations = max(self.generations, generation + 1 + late)
                self.counted.deep(generation + 1 + late, own.productions[0])
                return own.productions
            if own.interpretation:
                self.following = FINAL
                return own.interpretation
        return ()

    def apply(self, number: int, shapes: Shapes) -> None:
        self.counted.at(number, shapes.numbers)
        if self._recorder is not None:
            self._recorder.applied(number, shapes.numbers)
        body = self.compiled.body(number)
        slots = body(
            self, number, shapes.count, shapes.k0, shapes.k1, *shapes.params, *shapes.state
        )
        self.order.records.append(Record(shapes.numbers, slots))  # type: ignore[arg-type]

    def _apply_meaning(self, symbol: int, shapes: Shapes) -> None:
        if not self.program.symbols[symbol].meaning:
            return
        body = self.compiled.meaning(symbol)
        slots = body(
            self, shapes.rule, shapes.count, shapes.k0, shapes.k1, *shapes.params, *shapes.state
        )
        self.order.records.append(Record(shapes.numbers, slots))  # type: ignore[arg-type]

    def _keep(self, symbol: int, generation: int, shapes: Shapes, batch: Batch) -> None:
        """Shapes that no production takes: they stay, with a key of their own, or are an error; in
        a first pass, where no answer is known, they end.
        """
        if self.steps is None and self.following < FINAL and self.first_pass:
            return
        if self.steps is None and self.following < FINAL:
            self.none(symbol, batch, shapes.numbers)
        slot = self.make(
            shapes.count, symbol, -1, shapes.params, shapes.state, shapes.k0, shapes.k1,
            keys.CHOICE_SITE, (), None,
        )  # fmt: skip
        self.order.records.append(Record(shapes.numbers, (slot,)))

    def none(self, symbol: int, batch: Batch, numbers: NDArray[np.int32]) -> None:
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
        self._sound.clear()
        for column in (*shapes.params, *shapes.state[: 3 if self.program.flat else 7]):
            if _is_finite(column):
                self._sound[id(column)] = column
                continue
            wrong = np.flatnonzero(~np.isfinite(np.broadcast_to(column, (shapes.count,))))
            if len(wrong):
                self.not_finite(symbol, len(wrong), int(shapes.numbers[wrong[0]]))

    def not_finite(self, symbol: int, count: int, shape: int) -> None:
        name = self.program.symbols[symbol].name
        shapes = f"{count:,} shapes of {name} have" if count > 1 else f"a shape of {name} has"
        raise self.counted.error(
            "not-a-number",
            f"{shapes} an argument or a place that is not a finite number",
            shape=shape,
        )

    # --------------------------------------------------------------- what bodies call

    def draw(
        self,
        count: int,
        rule: int | NDArray[np.int32],
        symbol: int | NDArray[np.int32],
        asset: int | NDArray[np.int32],
        size: tuple[Column, ...],
        state: tuple[Column, ...],
        k0: Words,
        k1: Words,
        site: int | Words,
        copies: tuple[Words, ...],
        rows: NDArray[np.int64] | None,
        around: Around = (),
    ) -> Drawn:
        """Note what every row of a batch, or some rows, draw."""
        whole, count = count, count if rows is None else len(rows)
        own = dict(zip(self.fields, state, strict=True))
        chunk = Chunk(
            self.drawings, count, rule, symbol, asset, size, own, k0, k1, site, copies, rows
        )
        self.counted.draw(count)
        self.check_drawn(chunk, around)
        if self._recorder is not None:
            self._recorder.drew(site, chunk)
        if self.asked is not None:
            # Only in programs without scopes, where nobody asks, are many symbols drawn at once.
            assert isinstance(symbol, int) and isinstance(asset, int) and isinstance(site, int)
            self.note_drawn(whole, symbol, asset, own, (k0, k1, site, copies), rows)
        return self.note(chunk)

    def check_drawn(self, chunk: Chunk, around: Around = ()) -> None:
        """Stop at a size, a place, a turn or a scale that is not finite."""
        places = (*chunk.size, *_some(chunk, PLACES))
        self._check_columns(chunk, places, "a size, or in a place,", around)
        self._check_columns(chunk, _some(chunk, TURNED), "a turn, or a scale,", around)

    def _check_columns(
        self, chunk: Chunk, columns: Iterable[Column], said: str, around: Around
    ) -> None:
        for column in columns:
            if id(column) in self._sound or _is_finite(column) or not chunk.count:
                continue
            wrong = np.flatnonzero(~np.isfinite(np.atleast_1d(chunk.column(column))))
            if len(wrong):
                count = chunk.count if np.ndim(column) == 0 else len(wrong)
                what = "something of" if count == 1 else f"{count:,} things of"
                raise self.counted.error(
                    "not-a-number",
                    f"it would draw {what} {said} that is not a finite number",
                    row=int(wrong[0] if chunk.rows is None else chunk.rows[wrong[0]]),
                    around=around,
                )

    def note(self, chunk: Chunk) -> Drawn:
        """Keep a chunk of drawings."""
        self.chunks.append(chunk)
        self.drawings += chunk.count
        return Drawn(chunk.start, chunk.count, chunk.rows)

    def occluders(self) -> Occluders:
        """What this derivation made, for another one to ask about."""
        from ipmlang.runtime.queries.occluders import Occluders

        drawn: list[tuple[Mapping[str, Column], int]] = []
        for chunk in self.chunks if self.asked is not None and self.asked.drawn else ():
            if isinstance(chunk.asset, int) and chunk.asset not in FLAT and chunk.count:
                seen = [name for name in SEEN if name in chunk.state]
                own = {name: chunk.column(chunk.state[name]) for name in seen}
                drawn.append((self.with_asset(chunk.asset, own), chunk.count))
        return Occluders(self.marks, self.pool, drawn)

    def group(
        self, count: int, text: Column, parent: Column, state: Mapping[str, Column]
    ) -> NDArray[np.float64]:
        """Begin a group in every row of a batch; their numbers."""
        return self.grouping.begin(count, text, parent, state)

    def join(
        self, kind: str, parts: int, count: int, around: Column, state: Mapping[str, Column]
    ) -> NDArray[np.float64]:
        """Begin a boolean in every row of a batch; the numbers of its first parts."""
        rule = self.compiled.production(self.counted.rule)
        where = told(self.program, rule)
        return self.joining.begin(kind, parts, count, around, state, where)

    def make(
        self,
        count: int,
        symbol: int,
        rule: int,
        params: tuple[Column, ...],
        state: tuple[Column, ...],
        k0: Words,
        k1: Words,
        site: int,
        copies: tuple[Words, ...],
        rows: NDArray[np.int64] | None,
    ) -> Made:
        """Children of every row of a batch, or of some rows: they wait to be derived, unless
        nothing can come of them.
        """
        if self.is_barren(symbol):
            self.counted.make(count if rows is None else len(rows))
            return NOTHING
        plain = Shapes(
            count, np.zeros(0, np.int32), k0, k1, int(rule), columns(params), columns(state)
        )
        if rows is not None:
            count = len(rows)
            copies = tuple(each[rows] for each in copies)
            plain = Shapes(
                count, plain.numbers, k0[rows], k1[rows], plain.rule,
                tuple(taken(column, rows) for column in plain.params),
                tuple(taken(column, rows) for column in plain.state),
            )  # fmt: skip
        words = keys.child(plain.k0, plain.k1, site, *copies)
        return self.born(symbol, site, plain, words, rows)

    def born(
        self,
        symbol: int,
        site: int,
        plain: Shapes,
        words: tuple[Words, Words],
        rows: NDArray[np.int64] | None = None,
    ) -> Made:
        """New shapes, as `plain` ones say but for their numbers and keys, wait to be derived."""
        count = plain.count
        start = self.begin(symbol, count)
        numbers = np.arange(start, start + count, dtype=np.int32)
        made = Shapes(count, numbers, *words, plain.rule, plain.params, plain.state)
        if self._recorder is not None:
            self._recorder.made(symbol, site, made)
        self._wait(symbol, made if site == keys.CHOICE_SITE else self._noted(symbol, made))
        return Made(start, count, rows)

    def _noted(self, symbol: int, shapes: Shapes) -> Shapes:
        """Shapes that queries can tell apart, or that ask, stand in rows of their own."""
        noted = self.marks_of(symbol)
        if noted is None:
            return shapes
        own = dict(zip(self.fields, shapes.state, strict=True))
        words = (shapes.k0, shapes.k1, OWN, ())
        own[MARK] = self.mark(noted[0], shapes.count, noted[1], 0.0, own, words, None)
        return replace(shapes, state=tuple(own.values()))

    def _wait(self, symbol: int, shapes: Shapes) -> None:
        """Put shapes where their phase is waited for."""
        if PHASE not in self.fields or not shapes.count:
            self.pending.put(symbol, self.following, shapes)
            return
        phase = shapes.state[self.fields.index(PHASE)]
        for each in np.unique(phase).tolist():
            own = shapes if np.ndim(phase) == 0 else shapes.take(np.flatnonzero(phase == each))
            waits = self.pending if each <= self.phase else self._later.setdefault(each, Pending())
            waits.put(symbol, self.following, own)

    def is_barren(self, symbol: int) -> bool:
        """Whether the shapes of a symbol that are made now will never draw nor be rewritten."""
        own = self.program.symbols[symbol]
        if own.meaning or (own.interpretation and self.following < FINAL):
            return False
        if not own.productions or self.following >= FINAL:
            return True
        return self.steps is not None and self.following >= self.steps

    def begin(self, symbol: int, count: int) -> int:
        """The first number of so many new shapes."""
        start = self.counted.make(count)
        name = self.program.symbols[symbol].name
        if self._names[-1][1] != name:
            self._names.append((start, name))
        return start


def _is_finite(column: Column) -> bool:
    """Whether a column has no number that is none; too large a sum is looked at closer."""
    return math.isfinite(column if isinstance(column, float) else np.add.reduce(column, axis=None))


def _column(values: NDArray[np.float64]) -> Column:
    """A column; one number where it is the same for all rows."""
    return float(values[0]) if len(values) == 1 else np.ascontiguousarray(values)


def columns(values: Sequence[Column]) -> tuple[Column, ...]:
    """Columns of which those of one row are numbers."""
    return tuple(
        float(value) if isinstance(value, np.ndarray) and not value.ndim else value
        for value in values
    )


def _some(chunk: Chunk, names: Iterable[str]) -> list[Column]:
    """Those of these fields that a chunk has."""
    return [chunk.state[name] for name in names if name in chunk.state]
