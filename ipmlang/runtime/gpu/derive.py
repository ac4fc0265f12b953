"""A derivation whose shapes are derived on the graphics card, as far as it has bodies for them.

In go what waits on the frontier; what the card can derive goes there together, with all that
follows from it, and comes back as drawings and as shapes that only the CPU can derive. Keys, order
and limits are those of the frontier, which ends what the card begins.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.code import Column
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.gpu import isa
from ipmlang.runtime.gpu.device import is_of_card
from ipmlang.runtime.gpu.encode import calls_of
from ipmlang.runtime.gpu.geometries import Geometries
from ipmlang.runtime.gpu.isa import FINAL, HEADER, TERMINAL, Header, Terminal
from ipmlang.runtime.gpu.leaves import places
from ipmlang.runtime.gpu.loading import Batch, Loading
from ipmlang.runtime.gpu.machine import Made, TroubleError
from ipmlang.runtime.gpu.memory import Rows
from ipmlang.runtime.gpu.words import Calls
from ipmlang.runtime.numpy_backend import derived
from ipmlang.runtime.order import Copies, Drawn, Record, Slot
from ipmlang.runtime.order import Made as MadeShapes
from ipmlang.runtime.pending import FINAL as LAST
from ipmlang.runtime.pending import Shapes
from ipmlang.runtime.scene import SCOPE, Scene

Words = NDArray[np.uint32]

FEW = 256  # shapes that are derived whole, each by one thread, after long and narrow growth


def derive_gpu(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Scene | None:
    """Derive a program with the graphics card; None where none of its rules can run there.

    Raises IpmError where there is no card, or it fails.
    """
    calls = calls_of(program)
    kept: list[GpuFrontier] = []

    def begin(*args: object) -> GpuFrontier:
        kept.append(GpuFrontier(calls, *args))
        return kept[-1]

    try:
        scene = derived(program, attrs, seed, limits, begin=begin)
    except TroubleError:  # all of it is the CPU's
        return None
    except IpmError as error:  # numpy finds the error that users know, among those there may be
        if is_of_card(error):
            raise
        return None
    if scene is None or not any(each.ran for each in kept):
        return None
    scene.backend = "gpu+cpu" if kept[-1].shared else "gpu"
    return scene


class GpuFrontier(Frontier):
    """A frontier that hands batches to the card. `ran`: it did; `shared`: some rules are the CPU's,
    the start aside.
    """

    ordered = True  # whether it matters in which order things are made

    def __init__(self, calls: Calls, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.ran = self.shared = False
        self._geometries = Geometries(self.pool, self.cut_box)
        self._kinds: dict[Calls, Loading] = {}
        self._calls = calls
        self._left = set(range(len(self.program.symbols)))
        self._left -= self._kind(calls).encoded.capable
        self._is_deep = False  # what waits is narrow, and was so for long

    def run(self, seed: int) -> None:
        """Derive everything."""
        try:
            if self._calls == "none":
                super().run(seed)
            else:
                self._run_whole(seed)
        finally:
            self._release()

    def _run_whole(self, seed: int) -> None:
        """A program whose modules thread: one call of the start, or trouble where not all of it
        can run.
        """
        kind = self._kind(self._calls)
        if kind.encoded.reasons or kind.encoded.axiom is None:
            raise TroubleError(0)
        self.names_begin()
        first = self.axiom(seed)
        batches = [((isa.RESUME | kind.encoded.axiom, 0), first)]
        machine = kind.machine(batches, ())
        made = machine.run(kind.roots(batches), self.counted.bounds(), ordered=self.ordered)
        self._take(made, first.numbers)
        self.ran = True

    def advance(self) -> None:
        """Derive some of what waits for the CPU; where nothing does, all that the card can."""
        if self.pending.has(self._left.__contains__):
            self.shared = self.shared or self.ran
            (symbol, generation), shapes = self.pending.next(self._left.__contains__)
            self.derive(symbol, generation, shapes)
            return
        batches = self.pending.take(lambda symbol: symbol not in self._left)
        try:
            self._run(batches)
            self.ran = True
        except TroubleError as found:
            self._learn(found)
            for (symbol, generation), shapes in batches:
                self.pending.put(symbol, generation, shapes)

    def is_narrow(self) -> bool:
        """Never: the card takes few shapes as it takes many."""
        return False

    def _release(self) -> None:
        """Give what it holds on the card back."""
        for each in self._kinds.values():
            each.release()

    def _learn(self, found: TroubleError) -> None:
        """The CPU derives the symbol that met trouble from now on. Raises it where it is no
        symbol's own, or no symbol is left: then numpy begins again, and knows what to say.
        """
        productions, symbols = self.program.productions, len(self.program.symbols)
        symbol = found.blamed - len(productions) - 1
        if found.blamed < len(productions):
            symbol = productions[found.blamed].symbol
        own = 0 <= symbol < symbols and symbol not in self._left
        if found.bits != isa.Trouble.GEOMETRY or not own or len(self._left) == symbols - 1:
            raise found
        self._left.add(symbol)
        self._release()
        self.shared = True

    # ----------------------------------------------------------------------- going there

    def _kind(self, calls: Calls) -> Loading:
        if calls not in self._kinds:
            self._kinds[calls] = Loading(self, self._geometries, calls)
        return self._kinds[calls]

    def _run(self, batches: Sequence[Batch]) -> None:
        numbers = np.concatenate([shapes.numbers for _, shapes in batches])
        symbols = (self.program.symbols[symbol] for (symbol, _), _ in batches)
        rules = [rule for each in symbols for rule in each.productions or each.interpretation]
        self.counted.at(min(rules, default=-1), numbers)
        kind = self._kind(self._calls)
        if self._is_deep and len(numbers) < FEW:
            deep = self._kind("forks")
            if all(symbol in deep.encoded.capable for (symbol, _), _ in batches):
                kind = deep
        machine = kind.machine(batches, self._left)
        made = machine.run(kind.roots(batches), self.counted.bounds(), ordered=self.ordered)
        self._is_deep = made.deep
        self._take(made, numbers)

    # ----------------------------------------------------------------------- coming back

    def _take(self, made: Made, numbers: NDArray[np.int32]) -> None:
        """Note what a run made, and give its tables back to the card."""
        try:
            self._place(made, numbers)
        finally:
            for rows in (*made.terminals, *made.returned):
                rows.storage.release()

    def _place(self, made: Made, numbers: NDArray[np.int32]) -> None:
        """Note what a run made: drawings, shapes for the CPU, and where all of it stands."""
        if made.generations:
            self.generations = max(self.generations, made.generations)
            self.counted.deep(made.generations, self.counted.rule)
        tree = made.tree
        leaves = [
            np.concatenate([
                *(rows.words(word) for rows in made.terminals),
                *(rows.words(word + Header.PARENT) for rows in made.returned),
                np.zeros(0, np.uint32),
            ])
            for word in range(3)
        ]  # fmt: skip
        depth = np.repeat(*np.array(tree.depth, np.int64).T)
        order, weights = places(
            np.concatenate(tree.parent), np.concatenate(tree.copy),
            np.concatenate(tree.sequence), depth, (leaves[0], leaves[1], leaves[2]),
        )  # fmt: skip
        drawn = sum(rows.count for rows in made.terminals)
        slots: list[Slot] = []
        begin = 0
        for rows in made.terminals:
            if rows.count:
                slots.append(self._drawn(rows, order[begin : begin + rows.count]))
            begin += rows.count
        back = sum(rows.count for rows in made.returned)
        self.counted.make(made.shapes - back)
        for rows in made.returned:
            slots += self._back(rows, order[begin : begin + rows.count])
            begin += rows.count
        assert begin == drawn + back
        owner = np.repeat(np.arange(len(numbers)), weights)
        self.order.records.append(Record(numbers, (Copies(weights, owner, slots),)))
        self._note(made.notes)

    def _drawn(self, rows: Rows, order: NDArray[np.int64]) -> Drawn:
        """The drawings of a table, which stand in these places."""
        symbols = rows.words(Terminal.SYMBOL).astype(np.int32)
        asset = rows.words(Terminal.ASSET).view(np.int32)
        rule = rows.words(Terminal.RULE).view(np.int32)
        size = tuple(rows.numbers(TERMINAL + 2 * axis) for axis in range(3))
        state: dict[str, Column] = {
            name: rows.numbers(TERMINAL + 6 + 2 * place) for place, name in enumerate(self.fields)
        }
        words = rows.words(Terminal.KEY0), rows.words(Terminal.KEY1)
        self.counted.draw(rows.count)
        chunk = Chunk(self.drawings, rows.count, rule, symbols, asset, size, state, *words)
        if self.program.scoped:
            self.reports.drawn |= set(np.unique(symbols[asset == SCOPE]).tolist())
        noted = self.note(chunk)
        return Drawn(noted.start, noted.count, order)

    def _back(self, rows: Rows, order: NDArray[np.int64]) -> list[Slot]:
        """Shapes that the CPU derives: they wait there."""
        slots: list[Slot] = []
        entry = rows.words(Header.ENTRY)
        generation = rows.words(Header.GENERATION).astype(np.int64)
        rule = rows.words(Header.RULE).view(np.int32)
        words = rows.words(Header.KEY0), rows.words(Header.KEY1)
        state = [rows.numbers(HEADER + 2 * place) for place in range(len(self.fields))]
        for symbol in np.unique(entry).tolist():
            arity = self.program.symbols[symbol].arity
            first = HEADER + 2 * len(self.fields)
            params = [rows.numbers(first + 2 * place) for place in range(arity)]
            for own in np.unique(generation[entry == symbol]).tolist():
                at = np.flatnonzero((entry == symbol) & (generation == own))
                start = self.begin(symbol, len(at))
                shapes = Shapes(
                    len(at), np.arange(start, start + len(at), dtype=np.int32),
                    words[0][at], words[1][at], rule[at],
                    tuple(column[at] for column in params), tuple(column[at] for column in state),
                )  # fmt: skip
                self.pending.put(symbol, LAST if own >= FINAL else own, shapes)
                slots.append(MadeShapes(start, len(at), order[at]))
        return slots

    def _note(self, notes: Words) -> None:
        """Parts of splits that had no room, and shapes that have nothing to draw."""
        productions = len(self.program.productions)
        for number in np.flatnonzero(notes).tolist():
            many = int(notes[number])
            if number <= productions:
                rule = -1 if number == productions else number
                self.reports.unfit[rule] = self.reports.unfit.get(rule, 0) + many
            else:
                symbol = number - productions - 1
                self.reports.blank[symbol] = self.reports.blank.get(symbol, 0) + many
