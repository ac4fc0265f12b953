"""Code and data under construction: instructions, constants, lists of registers, blocks.

In go instructions, out come words as `isa` lays them out. Lists follow the code, so that a place in
them is known when the code is. No program is walked here.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, MutableSequence, Sequence
from dataclasses import dataclass, replace
from typing import Literal, cast

from ipmlang.compiler import ir
from ipmlang.runtime.gpu.isa import Op
from ipmlang.runtime.gpu.sampling import MOST, Sample
from ipmlang.runtime.gpu.unsupported import UnsupportedError

Mark = tuple[int, ...]
Calls = Literal["none", "forks", "threads"]
"""What becomes of a child: a record, a call that leaves the state alone, a call that changes it."""


@dataclass(frozen=True, slots=True)
class Faces:
    """One part of an operation that takes the faces of boxes: all its selectors, which of them it
    is, and the word of the code that says where in the data its table begins.
    """

    selectors: tuple[ir.Const, ...]
    place: int
    word: int


class Words:
    """What is written so far. `production` is the one that is being written, -1 the axiom."""

    def __init__(
        self,
        program: ir.Program,
        fields: tuple[str, ...],
        attrs: int,
        texels: Sequence[int] = (),
        calls: Calls = "none",
    ) -> None:
        self.program = program
        self.calls = calls
        self.fields = fields
        self.production = -1
        self.data: list[float] = [0.0] * attrs
        self.widest = 0  # numbers that a record must carry beside its state
        self.registers = 0  # that some body needs beside the state
        self.resumable = False  # whether a body may be broken off
        self.extrusion = -1
        self._code: list[int] = []
        self._lists: list[int] = []
        self._relative: list[int] = []  # words of the code that count from where the lists begin
        self._blocks: list[tuple[int, int]] = []
        self._faces: list[Faces] = []
        self._samples: list[Sample] = []
        self._texels = texels  # of each context, where they are known
        self._constants: dict[bytes, int] = {}
        self._columns: dict[tuple[int, int], int] = {}
        self.put(Op.END)  # at 0, where calls return that have nothing to do

    # --------------------------------------------------------------------------- code

    @property
    def here(self) -> int:
        """Where the next instruction stands."""
        return len(self._code)

    def put(
        self, op: Op, out: int = 0, a: int = 0, b: int = 0, c: int = 0, d: int = 0, n: int = 0,
        z: int = 0, w: int = 0,
    ) -> int:  # fmt: skip
        """Append an instruction; where it stands."""
        at = self.here
        self._code += [
            int(op) | out << 8 | a << 16 | b << 24, c | d << 8 | n << 24,
            z & 0xFFFFFFFF, w & 0xFFFFFFFF,
        ]  # fmt: skip
        return at

    def need(self, registers: int) -> None:
        """A body, or a block of copies, holds so many numbers beside the state."""
        self.registers = max(self.registers, registers)

    def patch(self, at: int, word: int) -> None:
        """Let a jump of the instruction at a place lead to here."""
        self._code[at + word] = self.here

    def call(self, function: int, out: int, args: Sequence[int]) -> None:
        """Append a call of a function with up to three arguments."""
        a, b, c = (*args, 0, 0, 0)[:3]
        self.put(Op.CALL, out=out, a=a, b=b, c=c, z=function)

    def choose(self, symbol: int, bodies: Sequence[tuple[int, int]]) -> None:
        """Append the jump to what was taken: the code and the number of each production."""
        at = self.put(
            Op.CHOOSE, z=self._listed([word for each in bodies for word in each]), w=symbol
        )
        self._relative.append(at + 2)

    def pick(self, out: int, uniform: int, values: Sequence[int]) -> None:
        """Append a choice among registers."""
        at = self.put(Op.PICK, out=out, a=uniform, n=len(values), z=self._listed(values))
        self._relative.append(at + 2)

    def child(self, symbol: int, args: Sequence[int], *, last: bool) -> None:
        """Append a child of a symbol; `last`: nothing comes after it that the body needs."""
        at = self.put(Op.CHILD, d=last, n=len(args), z=symbol, w=self._listed(args))
        self._relative.append(at + 3)

    def copies(self, count: int, given: Sequence[int]) -> tuple[int, int]:
        """Append copies of a new block, which are given registers; its number, and the jump over
        its code, which comes next.
        """
        block = len(self._blocks)
        at = self.put(Op.RANGE, a=count, n=len(given), z=block, w=self._listed(given))
        self._relative.append(at + 3)
        self.widest = max(self.widest, len(given))
        jump = self.put(Op.JUMP)
        self._blocks.append((self.here, len(self.fields) + len(given)))
        return block, jump

    def faces(self, selectors: tuple[ir.Const, ...], place: int) -> int:
        """The word that says where the table of a part is, counted from where the lists begin."""
        word = self._listed([0])
        self._faces.append(Faces(selectors, place, word))
        return word

    def put_faces(self, op: Op, table: int, **rest: int) -> None:
        """Append an instruction that reads such a table."""
        self._relative.append(self.put(op, z=table, **rest) + 2)

    def fetch(self, out: int, context: int, channel: int, x: int, y: int) -> None:
        """Append what a channel of a context is at registers x and y."""
        sample = Sample(context, channel, self._listed([0]))
        self._samples.append(sample)
        asked = {(each.context, each.channel) for each in self._samples}
        if self._texels and sum(self._texels[each] for each, _ in asked) > MOST:
            raise UnsupportedError("fetch", f"its contexts have more than {MOST:,} texels")
        self._relative.append(self.put(Op.FETCH, out=out, a=x, b=y, z=sample.word) + 2)

    def _listed(self, words: Sequence[int]) -> int:
        at = len(self._lists)
        self._lists += words
        return at

    # --------------------------------------------------------------------------- data

    def constant(self, value: float) -> int:
        """Where in the data a number stands."""
        bits = struct.pack("<d", value)
        if bits not in self._constants:
            self._constants[bits] = self.numbers([value])
        return self._constants[bits]

    def numbers(self, values: Iterable[float]) -> int:
        """Where in the data some numbers stand, one after the other."""
        at = len(self.data)
        self.data += values
        return at

    def extruded(self) -> int:
        """Where the number of the box stands that `extrude` makes, known when a run starts."""
        if self.extrusion < 0:
            self.extrusion = self.numbers([0.0])
        return self.extrusion

    def column(self, table: int, column: int) -> tuple[int, int]:
        """Where a column of a table stands, and how many rows it has."""
        rows = self.program.tables[table].rows
        if (table, column) not in self._columns:
            self._columns[table, column] = self.numbers([row[column] for row in rows] or [0.0])
        return self._columns[table, column], max(len(rows), 1)

    # ------------------------------------------------------------------------- the whole

    def mark(self) -> Mark:
        """What is written so far, to go back to."""
        return tuple(len(part) for part in self._parts())

    def back(self, mark: Mark) -> None:
        """Take back what was written since."""
        for part, length in zip(self._parts(), mark, strict=True):
            del part[length:]

    def _parts(self) -> tuple[MutableSequence[object], ...]:
        parts = (
            self._code, self._lists, self._relative, self._blocks, self._faces, self._samples,
        )  # fmt: skip
        return cast("tuple[MutableSequence[object], ...]", parts)

    def finished(
        self, entries: Sequence[int]
    ) -> tuple[list[int], int, int, tuple[Faces, ...], tuple[Sample, ...]]:
        """All words, where the entries of symbols and those of blocks begin, the faces and what is
        sampled.
        """
        code = list(self._code)
        base = len(code)
        for word in self._relative:
            code[word] += base
        code += self._lists
        symbols = len(code)
        code += entries
        blocks = len(code)
        code += [word for block in self._blocks for word in block]
        faces = tuple(Faces(each.selectors, each.place, base + each.word) for each in self._faces)
        samples = tuple(replace(each, word=base + each.word) for each in self._samples)
        return code, symbols, blocks, faces, samples
