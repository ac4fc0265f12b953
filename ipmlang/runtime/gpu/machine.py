"""The machine that runs bytecode on the graphics card: queues of shapes, pass after pass.

In go shapes as records, out come terminals, and the shapes that only the CPU can derive, with the
way to each. A pass runs every shape that waits, or as many as there is room for; what overflows is
found, since every thread counts what it would have written, and the pass is run again with room
for it. TroubleError on the card gives the run up: numpy tells what is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime.gpu import functions, isa
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.isa import HEADER, TERMINAL, Count, Header
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.keys import CHOICE_SITE

Words = NDArray[np.uint32]
Floats = NDArray[np.float64]

GROUP = 64  # threads of a work group
SLICE = 1 << 20  # threads of one dispatch
FEWEST = 1 << 12  # rows that a new table has room for
NARROW = 256  # shapes that make so few others are better off with a thread for each
DEEP = 64  # passes that were all so narrow, before what waits is given back
GROWTH = 1.3  # room beyond what was needed last time
SOURCES = (
    "state.glsl", "frames.glsl", "scopes.glsl", "sampling.glsl", "making.glsl", "vm.glsl",
)  # fmt: skip
BUDGET = 200_000  # instructions until a thread leaves off, and another dispatch goes on
BUDGET_SOFTWARE = 1_500  # the same where an invocation ends silently after 65,535 turns of all its
# loops, and every instruction takes a turn in each of those that it does not enter


class TroubleError(Exception):
    """The card met what only numpy can tell: bits of `isa.Trouble`, and the rule at which."""

    def __init__(self, bits: int, rule: int) -> None:
        super().__init__(bits, rule)
        self.bits = bits
        self.rule = rule


@dataclass(slots=True, eq=False)
class Rows:
    """A table on the card, column by column: `width` words a row, room for `room` rows."""

    storage: Storage
    width: int
    room: int
    count: int = 0

    def words(self, word: int) -> Words:
        """One column of words (count,)."""
        return self.storage.array(np.uint32, self.count, word * self.room * 4)

    def numbers(self, word: int) -> Floats:
        """A column of numbers (count,), the first of whose two words that is."""
        both = np.empty((self.count, 2), np.uint32)
        both[:, 0], both[:, 1] = self.words(word), self.words(word + 1)
        return both.view(np.float64)[:, 0]


@dataclass(slots=True, eq=False)
class Tree:
    """Where each record stands in the derivation: the record that made it (or NONE), in which copy,
    as which of what it made; and how deep below the first records.
    """

    parent: list[Words] = field(default_factory=list)
    copy: list[Words] = field(default_factory=list)
    sequence: list[Words] = field(default_factory=list)
    depth: list[tuple[int, int]] = field(default_factory=list)  # of so many records

    def note(self, rows: Rows, depth: int) -> None:
        """Add the records of a queue."""
        self.parent.append(rows.words(Header.PARENT))
        self.copy.append(rows.words(Header.COPY))
        self.sequence.append(rows.words(Header.SEQUENCE))
        self.depth.append((depth, rows.count))


@dataclass(slots=True, eq=False)
class Made:
    """What a run made: tables of terminals and of shapes for the CPU, the tree that they hang in,
    how many shapes were counted and how many generations, what was left out (words), and whether it
    was given back for having been narrow for long.
    """

    terminals: list[Rows]
    returned: list[Rows]
    tree: Tree
    shapes: int
    generations: int
    notes: Words
    deep: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """What all records of a program have in common: how many numbers are state, how many more there
    are, and the uniforms of the shader that say so.
    """

    state: int
    parameters: int
    uniforms: Mapping[str, int]

    @property
    def record(self) -> int:
        """Words of a record."""
        return HEADER + 2 * (self.state + self.parameters)

    @property
    def terminal(self) -> int:
        """Words of a terminal."""
        return TERMINAL + 2 * (3 + self.state)


@dataclass(slots=True, eq=False)
class _Waiting:
    """Records that wait: of a queue the copies from `begin` on; `first` is the number of the first
    record among all, `copies` how many there are in all.
    """

    rows: Rows
    first: int
    depth: int
    copies: int
    begin: int = 0
    offsets: Storage | None = None


class Machine:
    """One program on one card. `per_seed`: a child is a call, and not a record of a queue."""

    per_seed = False

    def __init__(
        self, device: Device, layout: Layout, code: Words, data: Floats, notes: int
    ) -> None:
        self.device = device
        self.layout = layout
        self._shader = device.compile(source(per_seed=self.per_seed), "vm")
        self._budget = BUDGET_SOFTWARE if device.is_software else BUDGET
        self._code = device.buffer(code.tobytes())
        self._data = device.buffer(data.tobytes())
        self._counts = device.buffer((Count.NOTES + notes) * 4)
        self.notes = notes
        self._ratio = 2.0  # records that a thread makes, as far as is known
        self._spare: list[Rows] = []

    def release(self) -> None:
        """Give all memory on the card back, but for the tables of what was made."""
        for rows in self._spare:
            rows.storage.release()
        for storage in (self._code, self._data, self._counts):
            storage.release()

    def run(self, roots: Words, copies: int, limit: int, *, ordered: bool = True) -> Made:
        """Derive records (words, n) that stand for so many copies, until none waits that runs here.
        More than `limit` shapes are trouble. Without `ordered` the tree stays empty.

        Raises TroubleError, and IpmError where the card fails or is too small.
        """
        made = Made([], [], Tree(), 0, 0, np.zeros(self.notes, np.uint32))
        first = self.rows(self.layout.record, roots.shape[1])
        first.storage.write(roots)
        first.count = first.room = roots.shape[1]
        counts = np.zeros(Count.NOTES + self.notes, np.uint32)
        waiting = [_Waiting(first, 0, 0, copies)]
        numbered, thin = first.count, 0
        if ordered:
            made.tree.note(first, 0)
        while waiting:
            each = waiting[-1]
            many = min(each.copies - each.begin, SLICE)
            rows, counts, many = self._pass(each, many, made, counts)
            each.begin += many
            if each.begin >= each.copies:
                waiting.pop()
                self._done(each)
            if int(counts[Count.SHAPES]) > limit:
                raise TroubleError(0, int(counts[Count.STOPPED]))
            thin = thin + 1 if not waiting and 0 < rows.count < NARROW else 0
            if thin > DEEP and int(rows.words(Header.ENTRY).max()) < isa.BLOCK:
                made.returned.append(rows)
                made.deep = True
            elif rows.count:
                if ordered:
                    made.tree.note(rows, each.depth + 1)
                waiting.append(_Waiting(rows, numbered, each.depth + 1, int(counts[Count.COPIES])))
                numbered += rows.count
            else:
                self._spare.append(rows)
        made.shapes = int(counts[Count.SHAPES])
        made.generations = int(counts[Count.GENERATION])
        made.notes = counts[Count.NOTES :]
        return made

    # --------------------------------------------------------------------------- passes

    def _pass(
        self, each: _Waiting, many: int, made: Made, before: Words
    ) -> tuple[Rows, Words, int]:
        """Run so many copies of what waits, or fewer where they make too much: what they made, the
        counts after them, and how many they were.
        """
        layout = self.layout
        rows = self.rows(layout.record, int(many * self._ratio * GROWTH))
        while True:
            terminals = self.table(made.terminals, layout.terminal, many)
            returned = self.table(made.returned, layout.record, 0)
            rows.count = 0
            counts = self._dispatch(each, many, rows, terminals, returned, before)
            needed = int(counts[Count.RECORDS])
            tables = ((terminals, Count.TERMINALS), (returned, Count.RETURNED))
            full = [each for each, word in tables if each.count + int(counts[word]) > each.room]
            if needed <= rows.room and not full:
                break
            halved = False
            for width, need in (
                (layout.record, needed), (layout.terminal, int(counts[Count.TERMINALS])),
                (layout.record, int(counts[Count.RETURNED])),
            ):  # fmt: skip
                if need > self._most(width):
                    halved = True
            if halved:
                if many == 1:
                    raise self.device.too_large(needed * layout.record * 4)
                many = max(many // 2, 1)
            if needed > rows.room and not halved:
                rows.storage.release()
                rows = self.rows(layout.record, int(needed * 1.05) + 1)
            if terminals in full:
                self.table(made.terminals, layout.terminal, int(counts[Count.TERMINALS]), new=True)
            if returned in full:
                self.table(made.returned, layout.record, int(counts[Count.RETURNED]), new=True)
        self._ratio = max(0.7 * self._ratio, needed / many)
        rows.count = needed
        terminals.count += int(counts[Count.TERMINALS])
        returned.count += int(counts[Count.RETURNED])
        return rows, counts, many

    def _dispatch(
        self, each: _Waiting, many: int, rows: Rows, terminals: Rows, returned: Rows, before: Words
    ) -> Words:
        """One pass; the counts after it."""
        whole = each.copies == each.rows.count
        if not whole and each.offsets is None:
            begins = np.cumsum(each.rows.words(Header.COUNT), dtype=np.uint64)
            offsets = np.concatenate([[0], begins[:-1]]).astype(np.uint32)
            each.offsets = self.device.buffer(offsets.tobytes())
        uniforms = {
            "records": each.rows.count, "queue_rows": each.rows.room, "next_rows": rows.room,
            "terminal_first": terminals.count, "terminal_rows": terminals.room,
            "returned_first": returned.count, "returned_rows": returned.room,
            "first_record": each.first, "first_thread": each.begin, "threads": many,
            "whole": int(whole),
        }  # fmt: skip
        tables = (each.rows.storage, rows.storage, terminals.storage, returned.storage)
        return self.dispatch(uniforms, tables, each.offsets or self._counts, many, before)

    def dispatch(
        self, uniforms: Mapping[str, int], tables: tuple[Storage, ...], last: Storage, many: int,
        before: Words,
    ) -> Words:  # fmt: skip
        """Run the shader once with so many threads; the counts after it."""
        counts = before.copy()
        counts[: Count.SHAPES] = 0
        counts[Count.STOPPED] = isa.NONE
        self._counts.write(counts)
        for name, value in {**self.layout.uniforms, **uniforms, "budget": self._budget}.items():
            if name in self._shader:
                self._shader[name] = value
        for binding, storage in enumerate((self._code, self._data, *tables, self._counts, last)):
            storage.bind(binding)
        self.device.dispatch(self._shader, -(-many // GROUP), "vm")
        counts = self._counts.array(np.uint32)
        if counts[Count.TROUBLE]:
            raise TroubleError(int(counts[Count.TROUBLE]), int(counts[Count.STOPPED]))
        if counts[Count.ENDED] != many:
            missing = many - int(counts[Count.ENDED])
            message = f"the graphics card ended {missing:,} of {many:,} threads before their time"
            raise fail("gpu-failed", message, hint="derive on the CPU: --backend cpu")
        return counts

    # --------------------------------------------------------------------------- tables

    def _most(self, width: int) -> int:
        """The most rows that a table can have room for."""
        return self.device.limits.block_bytes // (4 * width)

    def rows(self, width: int, room: int) -> Rows:
        """A queue, one that was used before if there is a large one."""
        room = min(max(room, FEWEST), self._most(width))
        for place, rows in enumerate(self._spare):
            if rows.width == width and room <= rows.room <= 4 * room:
                return self._spare.pop(place)
        return Rows(self.device.buffer(width * room * 4), width, room)

    def table(self, tables: list[Rows], width: int, room: int, *, new: bool = False) -> Rows:
        """The table that is filled now, a new one with room for so many rows where that is asked
        for, or where there is none.
        """
        if tables and not new:
            return tables[-1]
        if tables and not tables[-1].count:
            tables.pop().storage.release()
        seen = sum(rows.count for rows in tables)
        room = min(max(int(room * 1.05), seen // 2, FEWEST), self._most(width))
        tables.append(Rows(self.device.buffer(width * room * 4), width, room))
        return tables[-1]

    def _done(self, each: _Waiting) -> None:
        """A queue that is derived is free for another one."""
        if each.offsets is not None:
            each.offsets.release()
        self._spare.append(each.rows)
        if len(self._spare) > 4:
            self._spare.sort(key=lambda rows: rows.room)
            self._spare.pop(0).storage.release()


def source(*, per_seed: bool = False) -> str:
    """The text of the shader."""
    folder = files(__package__)
    texts = [(folder / name).read_text(encoding="utf-8") for name in SOURCES]
    kind = "#define PER_SEED\n" if per_seed else ""
    head = f"#version 430\n{kind}#define GROUP {GROUP}\n#define REGISTERS {isa.REGISTERS}\n"
    return "".join([
        head, isa.macros(), f"#define CHOICE_SITE {CHOICE_SITE}u\n", functions.source(), *texts,
    ])  # fmt: skip
