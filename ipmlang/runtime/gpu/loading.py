"""A program on the card: its code and numbers as one machine, and its shapes as records.

In go shapes as the frontier has them, out come records for the machine, which is built again where
geometries are met that it does not know. What a run makes is read elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.gpu import sampling
from ipmlang.runtime.gpu.device import device
from ipmlang.runtime.gpu.encode import kept
from ipmlang.runtime.gpu.geometries import Geometries
from ipmlang.runtime.gpu.isa import FINAL, HEADER, NONE, ON_CPU, Entry, Header
from ipmlang.runtime.gpu.machine import Layout, Machine
from ipmlang.runtime.gpu.seeds import Seeds
from ipmlang.runtime.gpu.words import Calls
from ipmlang.runtime.pending import Shapes
from ipmlang.runtime.scopes.shaping import EXTRUDED

Words = NDArray[np.uint32]
Batch = tuple[tuple[int, int], Shapes]  # symbol (or another entry) and generation, shapes
ENTRY = len(Entry)


class Loading:
    """The program of a frontier, for one of the two kinds of machine. `left`: symbols that it has
    code for and that the CPU is to derive all the same.
    """

    def __init__(self, frontier: Frontier, geometries: Geometries, calls: Calls) -> None:
        self._frontier = frontier
        self._geometries = geometries
        self._calls = calls
        self._described = -1
        texels = sampling.extents(frontier.bound.data.contexts)
        count = len(frontier.bound.attrs)
        self.encoded = kept(frontier.program, frontier.fields, count, texels, calls)
        self._machine: Machine | None = None
        self._layout = self._laid(0, 0)

    def machine(self, batches: Sequence[Batch], left: Collection[int]) -> Machine:
        """A machine that knows the geometries of these shapes."""
        frontier = self._frontier
        if "geo" in frontier.fields:
            slot = frontier.fields.index("geo")
            found = {frontier.pool.box(EXTRUDED)}
            for _, shapes in batches:
                found |= {int(each) for each in np.unique(shapes.state[slot]).tolist()}
            self._geometries.describe(found)
        if self._machine is None or self._described != len(self._geometries):
            self.release()
            self._machine = self._built(left)
            self._described = len(self._geometries)
        return self._machine

    def release(self) -> None:
        """Give what it holds on the card back."""
        if self._machine is not None:
            self._machine.release()
            self._machine = None

    def _built(self, left: Collection[int]) -> Machine:
        frontier, encoded = self._frontier, self.encoded
        code = encoded.code.copy()
        for symbol in encoded.capable.intersection(left):
            code[encoded.symbols + symbol * ENTRY + Entry.FLAGS] = ON_CPU
        data = [encoded.data.copy()]
        data[0][: len(frontier.bound.attrs)] = frontier.bound.attrs
        geometries = 0
        base = len(encoded.data)
        if "geo" in frontier.fields:
            if encoded.extruded >= 0:
                data[0][encoded.extruded] = frontier.pool.box(EXTRUDED)
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
        self._layout = self._laid(base, geometries)
        notes = len(frontier.program.productions) + 1 + len(frontier.program.symbols)
        kind = Machine if self._calls == "none" else Seeds
        return kind(device(), self._layout, code, np.concatenate(data), notes)

    def _sampled(self, code: Words, place: int) -> list[NDArray[np.float64]]:
        """The contexts that are fetched, to stand in the data from a place on."""
        frontier = self._frontier
        found: list[NDArray[np.float64]] = []
        places: dict[tuple[int, int], int] = {}
        for each in self.encoded.samples:
            key = (each.context, each.channel)
            if key not in places:
                places[key] = place
                found.append(
                    sampling.numbers(frontier.bound.data.contexts[each.context], each.channel)
                )
                place += len(found[-1])
            code[each.word] = places[key]
        return found

    def _laid(self, base: int, geometries: int) -> Layout:
        frontier, encoded = self._frontier, self.encoded
        slots = {name: number for number, name in enumerate(frontier.fields)}
        mirrors = any(
            each.op == "mirror" or (each.op == "solid" and each.const == "mirrorScope")
            for symbol in frontier.program.symbols
            for each in symbol.meaning or ()
        )
        uniforms = {
            "symbols": encoded.symbols,
            "blocks": encoded.blocks,
            "productions": len(frontier.program.productions),
            "geometries": geometries,
            "geometry_base": base,
            "steps": NONE if frontier.steps is None else min(frontier.steps, FINAL - 1),
            "state_size": len(frontier.fields),
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
        return Layout(len(frontier.fields), encoded.parameters, uniforms)

    def roots(self, batches: Sequence[Batch]) -> Words:
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
