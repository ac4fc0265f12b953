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
from ipmlang.runtime.code import Column
from ipmlang.runtime.drawings import Chunk
from ipmlang.runtime.fields import fields
from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.gpu import isa, sampling
from ipmlang.runtime.gpu.device import device
from ipmlang.runtime.gpu.encode import Encoded, calls_of, encode
from ipmlang.runtime.gpu.geometries import Geometries
from ipmlang.runtime.gpu.isa import FINAL, HEADER, NONE, ON_CPU, TERMINAL, Entry, Header, Terminal
from ipmlang.runtime.gpu.leaves import places
from ipmlang.runtime.gpu.machine import Layout, Machine, Made, Rows, TroubleError
from ipmlang.runtime.gpu.seeds import Seeds
from ipmlang.runtime.gpu.words import Calls
from ipmlang.runtime.numpy_backend import derived
from ipmlang.runtime.order import Copies, Drawn, Record, Slot
from ipmlang.runtime.order import Made as MadeShapes
from ipmlang.runtime.pending import FINAL as LAST
from ipmlang.runtime.pending import Shapes
from ipmlang.runtime.scene import SCOPE, Scene
from ipmlang.runtime.scopes.shaping import EXTRUDED

Words = NDArray[np.uint32]
ENTRY = len(Entry)


def derive_gpu(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Scene | None:
    """Derive a program with the graphics card; None where none of its rules can run there.

    Raises IpmError as the frontier does, and where there is no card or it fails.
    """
    calls = calls_of(program)
    names = tuple(fields(program))
    if calls == "threads" and encode(program, names, len(attrs), calls=calls).reasons:
        return None
    kept: list[GpuFrontier] = []

    def begin(*args: object) -> GpuFrontier:
        kept.append(GpuFrontier(calls, *args))
        return kept[-1]

    scene = derived(program, attrs, seed, limits, begin=begin)
    if scene is None or not any(each.ran for each in kept):
        return None
    scene.backend = "gpu+cpu" if kept[-1].shared else "gpu"
    return scene


class GpuFrontier(Frontier):
    """A frontier that hands batches to the card. `ran`: it did; `shared`: some rules are the CPU's,
    the start aside.
    """

    def __init__(self, calls: Calls, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        self.ran = self.shared = False
        self._calls = calls
        texels = sampling.extents(self.bound.data.contexts)
        count = len(self.bound.attrs)
        self._encoded = encode(self.program, self.fields, count, texels, calls)
        self._capable = set(self._encoded.capable)
        self._geometries = Geometries(self.pool, self.cut_box)
        self._machine: Machine | None = None
        self._layout = Layout(0, 0, {})

    def run(self, seed: int) -> None:
        """Derive everything."""
        if self._calls == "none":
            super().run(seed)
            return
        self.names_begin()
        first = self.axiom(seed)
        assert self._encoded.axiom is not None
        self._machine = self._built()
        roots = self._roots([((isa.RESUME | self._encoded.axiom, 0), first)])
        try:
            made = self._machine.run(roots, first.count, self.counted.most())
        except TroubleError:
            self.shared = True
            return
        finally:
            self.release()
        self._take(made, first.numbers)
        self.ran = True

    def advance(self) -> None:
        """Derive some of what waits for the CPU; where nothing does, all that the card can."""
        if self.pending.has(self._is_left):
            self.shared = self.shared or self.ran
            (symbol, generation), shapes = self.pending.next(self._is_left)
            self.derive(symbol, generation, shapes)
            return
        batches = self.pending.take(self._capable.__contains__)
        try:
            self._run(batches)
            self.ran = True
        except TroubleError as found:
            self._learn(found)
            for (symbol, generation), shapes in batches:
                self.pending.put(symbol, generation, shapes)

    def _is_left(self, symbol: int) -> bool:
        """Whether the CPU derives a symbol."""
        return symbol not in self._capable

    def is_narrow(self) -> bool:
        """Never: the card takes few shapes as it takes many."""
        return False

    def release(self) -> None:
        """Give what it holds on the card back."""
        if self._machine is not None:
            self._machine.release()
            self._machine = None

    def _learn(self, found: TroubleError) -> None:
        """The CPU derives the symbol that met trouble from now on, or all of them."""
        self.release()
        self.shared = True
        if found.rule < len(self.program.productions):
            self._capable.discard(self.program.productions[found.rule].symbol)
        else:
            self._capable.clear()
        if found.bits != isa.Trouble.GEOMETRY:
            self._capable.clear()

    # ----------------------------------------------------------------------- going there

    def _run(self, batches: Sequence[tuple[tuple[int, int], Shapes]]) -> None:
        self._prepare(batches)
        assert self._machine is not None
        roots = self._roots(batches)
        numbers = np.concatenate([shapes.numbers for _, shapes in batches])
        symbols = (self.program.symbols[symbol] for (symbol, _), _ in batches)
        rules = [rule for each in symbols for rule in each.productions or each.interpretation]
        self.counted.at(min(rules, default=-1), numbers)
        made = self._machine.run(roots, len(numbers), self.counted.most())
        self._take(made, numbers)

    def _prepare(self, batches: Sequence[tuple[tuple[int, int], Shapes]]) -> None:
        """A machine that knows the geometries of these shapes."""
        new = False
        if "geo" in self.fields:
            slot = self.fields.index("geo")
            found = {self.pool.box(EXTRUDED)}
            for _, shapes in batches:
                found |= {int(each) for each in np.unique(shapes.state[slot]).tolist()}
            new = self._geometries.describe(found)
        if self._machine is None or new:
            self.release()
            self._machine = self._built()

    def _built(self) -> Machine:
        encoded = self._encoded
        code = np.array(encoded.code, np.uint32)
        for symbol in encoded.capable - self._capable:
            code[encoded.symbols + symbol * ENTRY + Entry.FLAGS] = ON_CPU
        data = [np.array(encoded.data, np.float64)]
        data[0][: len(self.bound.attrs)] = self.bound.attrs
        geometries = 0
        base = len(encoded.data)
        if "geo" in self.fields:
            if encoded.extruded >= 0:
                data[0][encoded.extruded] = self.pool.box(EXTRUDED)
            table = self._geometries.table()
            geometries = len(table)
            data.append(table.ravel())
            place = base + table.size
            for part in encoded.faces:
                faces = self._geometries.faces(part)
                code[part.word] = place
                place += faces.size
                data.append(faces.ravel())
        data += self._sampled(code, sum(map(len, data)))
        self._layout = self._laid(encoded, base, geometries)
        notes = len(self.program.productions) + 1 + len(self.program.symbols)
        kind = Machine if self._calls == "none" else Seeds
        return kind(device(), self._layout, code, np.concatenate(data), notes)

    def _sampled(self, code: Words, place: int) -> list[NDArray[np.float64]]:
        """The contexts that are fetched, to stand in the data from a place on."""
        found: list[NDArray[np.float64]] = []
        places: dict[tuple[int, int], int] = {}
        for each in self._encoded.samples:
            key = (each.context, each.channel)
            if key not in places:
                places[key] = place
                found.append(sampling.numbers(self.bound.data.contexts[each.context], each.channel))
                place += len(found[-1])
            code[each.word] = places[key]
        return found

    def _laid(self, encoded: Encoded, base: int, geometries: int) -> Layout:
        slots = {name: number for number, name in enumerate(self.fields)}
        mirrors = any(
            each.op == "mirror" or (each.op == "solid" and each.const == "mirrorScope")
            for symbol in self.program.symbols
            for each in symbol.meaning or ()
        )
        uniforms = {
            "symbols": encoded.symbols,
            "blocks": encoded.blocks,
            "productions": len(self.program.productions),
            "geometries": geometries,
            "geometry_base": base,
            "steps": NONE if self.steps is None else min(self.steps, FINAL - 1),
            "state_size": len(self.fields),
            "param_size": encoded.parameters,
            "planar": int("angle" in slots),
            "slot_scale": slots.get("scale", NONE),
            "slot_size": slots.get("sx", NONE),
            "slot_geometry": slots.get("geo", NONE),
            "mirrors": int(mirrors),
            "registers": encoded.registers,
            "resumable": int(encoded.resumable or self._calls != "none"),
            "forks": int(self._calls == "forks"),
        }
        return Layout(len(self.fields), encoded.parameters, uniforms)

    def _roots(self, batches: Sequence[tuple[tuple[int, int], Shapes]]) -> Words:
        """Shapes as records, column by column."""
        layout = self._layout
        count = sum(shapes.count for _, shapes in batches)
        out = np.zeros((layout.record, count), np.uint32)
        out[Header.PARENT] = NONE
        out[Header.SEQUENCE] = np.arange(count)
        out[Header.COUNT] = 1
        begin = 0
        for (symbol, generation), shapes in batches:
            rows = slice(begin, begin + shapes.count)
            out[Header.ENTRY, rows] = symbol
            out[Header.GENERATION, rows] = min(generation, FINAL)
            out[Header.KEY0, rows], out[Header.KEY1, rows] = shapes.k0, shapes.k1
            out[Header.RULE, rows] = np.asarray(shapes.rule, np.int32).astype(np.uint32)
            for place, column in enumerate((*shapes.state, *shapes.params)):
                both = np.broadcast_to(np.asarray(column, np.float64), (shapes.count,))
                words = np.ascontiguousarray(both).view(np.uint32).reshape(-1, 2)
                out[HEADER + 2 * place : HEADER + 2 * place + 2, rows] = words.T
            begin += shapes.count
        return out

    # ----------------------------------------------------------------------- coming back

    def _take(self, made: Made, numbers: NDArray[np.int32]) -> None:
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
            rows.storage.release()
        back = sum(rows.count for rows in made.returned)
        self.counted.make(made.shapes - back)
        for rows in made.returned:
            slots += self._back(rows, order[begin : begin + rows.count])
            begin += rows.count
            rows.storage.release()
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
