"""The machine that runs bytecode on the graphics card: queues of shapes, pass after pass.

In go shapes as records, out come terminals, and the shapes that only the CPU can derive, with the
way to each. A pass runs every shape that waits, or as many as there is room for; what overflows is
found, since every thread counts what it would have written, and the pass is run again with room
for it. TroubleError on the card gives the run up: numpy tells what is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime.gpu import functions, isa
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.gpu.isa import HEADER, TERMINAL, Count, Header, Trouble
from ipmlang.runtime.gpu.memory import Memory, Rows
from ipmlang.runtime.gpu.prefix import prefix_sums
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.keys import CHOICE_SITE
from ipmlang.runtime.limits import DRAWING_BYTES, SHAPE_BYTES, Bounds

Words = NDArray[np.uint32]

GROUP = 64  # threads of a work group
SLICE = 1 << 20  # threads of one dispatch
NARROW = 256  # shapes that make so few others are better off with a thread for each
DEEP = 64  # passes that were all so narrow, before what waits is given back
GROWTH = 1.3  # room beyond what was needed last time
MARGIN = 1.05  # room beyond what is known to be needed
MOST = 1 << 31  # of what is counted in 32 bits, with all that threads add before they stop
SOURCES = (
    "state.glsl", "frames.glsl", "scopes.glsl", "sampling.glsl", "making.glsl", "vm.glsl",
)  # fmt: skip
FILLED = (Count.RECORDS, Count.TERMINALS, Count.RETURNED)  # the counts of what passes fill
BUDGET = 200_000  # instructions until a thread leaves off, and another dispatch goes on
BUDGET_SOFTWARE = 1_500  # the same where an invocation ends silently after 65,535 turns of all its
# loops, and every instruction takes a turn in each of those that it does not enter


class TroubleError(Exception):
    """The card met what only numpy can tell: bits of `isa.Trouble`, and who is to blame: a
    production, beyond those and one more a symbol, or NONE.
    """

    def __init__(self, bits: int, blamed: int = isa.NONE) -> None:
        super().__init__(bits, blamed)
        self.bits = bits
        self.blamed = blamed


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
        self, device: Device, layout: Layout, code: Words, data: NDArray[np.float64], notes: int
    ) -> None:
        self.device = device
        self.layout = layout
        self.notes = notes
        self.memory = Memory(device)
        self._shader = device.compile(source(per_seed=self.per_seed), "vm")
        self._budget = BUDGET_SOFTWARE if device.is_software else BUDGET
        self._ratio = 2.0  # records that a thread makes, as far as is known
        try:
            self._code = self.memory.buffer(code.tobytes())
            self._data = self.memory.buffer(data.tobytes())
            self._counts = self.memory.buffer((Count.NOTES + notes) * 4)
        except BaseException:
            self.release()
            raise

    def release(self) -> None:
        """Give all memory on the card back, but for the tables of what was made."""
        self.memory.release()

    def run(self, roots: Words, bounds: Bounds, *, ordered: bool = True) -> Made:
        """Derive records (words, n) until none waits that runs here; more than the bounds allow is
        trouble. Without `ordered` the tree stays empty. Whoever gets the tables releases them.

        Raises TroubleError, and IpmError where the card fails or is too small.
        """
        made = Made([], [], Tree(), 0, 0, np.zeros(self.notes, np.uint32))
        counts = np.zeros(Count.NOTES + self.notes, np.uint32)
        waiting = self._roots(roots, made.tree if ordered else None)
        numbered, thin = roots.shape[1], 0
        while waiting:
            each = waiting[-1]
            rows, counts, many = self._pass(each, min(each.copies - each.begin, SLICE), made,
                                            counts, bounds)  # fmt: skip
            check(bounds, counts, made)
            each.begin += many
            if each.begin >= each.copies:
                waiting.pop()
                self._done(each)
            thin = thin + 1 if not waiting and 0 < rows.count < NARROW else 0
            if thin > DEEP and int(rows.words(Header.ENTRY).max()) < isa.BLOCK:
                made.returned.append(rows)
                made.deep = True
                break
            if not rows.count:
                self.memory.spare(rows)
                continue
            if ordered:
                made.tree.note(rows, each.depth + 1)
            waiting.append(_Waiting(rows, numbered, each.depth + 1, int(counts[Count.COPIES])))
            numbered += rows.count
            if numbered > MOST:
                raise TroubleError(Trouble.COUNT)
        return self._finished(made, counts)

    def _roots(self, roots: Words, tree: Tree | None) -> list[_Waiting]:
        """The first records, in as many queues as it takes."""
        waiting: list[_Waiting] = []
        most = self.memory.most(self.layout.record)
        for begin in range(0, roots.shape[1], most):
            part = roots[:, begin : begin + most]
            rows = self.memory.rows(self.layout.record, part.shape[1], least=part.shape[1])
            rows.storage.write(part)
            rows.count = rows.room = part.shape[1]
            if tree is not None:
                tree.note(rows, 0)
            copies = int(part[Header.COUNT].sum(dtype=np.uint64))
            waiting.append(_Waiting(rows, begin, 0, copies))
        return waiting

    def _finished(self, made: Made, counts: Words) -> Made:
        made.shapes = int(counts[Count.SHAPES])
        made.generations = int(counts[Count.GENERATION])
        made.notes = counts[Count.NOTES :]
        self.memory.hand_over([*made.terminals, *made.returned])
        return made

    # --------------------------------------------------------------------------- passes

    def _pass(
        self, each: _Waiting, many: int, made: Made, before: Words, bounds: Bounds
    ) -> tuple[Rows, Words, int]:
        """Run so many copies of what waits, or fewer where they make too much: what they made, the
        counts after them, and how many they were.
        """
        room, exact = int(many * self._ratio * GROWTH), False
        while True:
            queue = self.memory.rows if exact else self.memory.guessed
            rows = queue(self.layout.record, room)
            fills = self._fills(made, many, rows)
            counts = self._dispatch(each, many, fills, before, limits(bounds, made))
            needs = tuple(int(counts[word]) for word in FILLED)
            pairs = tuple(zip(fills, needs, strict=True))
            short = [pair for pair in pairs if pair[0].count + pair[1] > pair[0].room]
            if not short:
                break
            self.memory.spare(rows)
            if exact or any(need > self.memory.most(table.width) for table, need in short):
                if many == 1:
                    raise self._too_small(short)
                many, exact = many // 2, False
                room = int(needs[0] / 2 * GROWTH)
                continue
            room, exact = int(needs[0] * MARGIN) + 1, True
            for tables, pair in zip((made.terminals, made.returned), pairs[1:], strict=True):
                if pair in short:
                    self.memory.another(tables, pair[0].width, pair[1])
        self._ratio = max(0.7 * self._ratio, needs[0] / many)
        for table, need in pairs:
            table.count += need
        return rows, counts, many

    def _fills(self, made: Made, many: int, rows: Rows) -> tuple[Rows, Rows, Rows]:
        """What so many threads fill: records, terminals, returned shapes."""
        terminals = self.memory.filling(made.terminals, self.layout.terminal, many)
        return rows, terminals, self.memory.filling(made.returned, self.layout.record, 0)

    def _too_small(self, short: Sequence[tuple[Rows, int]]) -> IpmError:
        """The error of one copy that makes more than a table can have."""
        return self.device.too_large(max(4 * rows.width * need for rows, need in short))

    def _dispatch(
        self, each: _Waiting, many: int, fills: tuple[Rows, Rows, Rows], before: Words,
        bounded: Mapping[str, int],
    ) -> Words:  # fmt: skip
        """One pass; the counts after it."""
        whole = each.copies == each.rows.count
        if not whole and each.offsets is None:
            each.offsets = prefix_sums(
                self.device, each.rows.storage, Header.COUNT * each.rows.room, each.rows.count,
                self.memory.buffer, self.memory.free,
            )  # fmt: skip
        rows, terminals, returned = fills
        uniforms = {
            "records": each.rows.count, "queue_rows": each.rows.room, "next_rows": rows.room,
            "terminal_first": terminals.count, "terminal_rows": terminals.room,
            "returned_first": returned.count, "returned_rows": returned.room,
            "first_record": each.first, "first_thread": each.begin, "threads": many,
            "whole": int(whole), **bounded,
        }  # fmt: skip
        storages = (each.rows.storage, *(table.storage for table in fills))
        return self.dispatch(uniforms, storages, each.offsets or self._counts, many, before)

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

    def _done(self, each: _Waiting) -> None:
        """A queue that is derived is free for another one."""
        if each.offsets is not None:
            self.memory.free(each.offsets)
        self.memory.spare(each.rows)


def limits(bounds: Bounds, made: Made) -> dict[str, int]:
    """What the bounds leave, as threads check it: how many shapes in all, how many terminals in one
    dispatch, how many generations.
    """
    drawn = sum(rows.count for rows in made.terminals)
    terminals = min(bounds.drawn, bounds.memory // DRAWING_BYTES) - drawn
    return {
        "most_shapes": min(bounds.shapes, bounds.memory // SHAPE_BYTES, MOST),
        "most_terminals": min(max(terminals, 0), MOST),
        "most_generations": min(bounds.generations, isa.FINAL - 1),
    }


def check(bounds: Bounds, counts: Words, made: Made) -> None:
    """Trouble where shapes and drawings together are more than the bounds allow."""
    shapes = int(counts[Count.SHAPES])
    drawn = sum(rows.count for rows in made.terminals)
    memory = shapes * SHAPE_BYTES + drawn * DRAWING_BYTES
    if shapes > bounds.shapes or shapes + drawn > bounds.drawn or memory > bounds.memory:
        raise TroubleError(Trouble.LIMIT)


def source(*, per_seed: bool = False) -> str:
    """The text of the shader."""
    folder = files(__package__)
    texts = [(folder / name).read_text(encoding="utf-8") for name in SOURCES]
    kind = "#define PER_SEED\n" if per_seed else ""
    head = f"#version 430\n{kind}#define GROUP {GROUP}\n#define REGISTERS {isa.REGISTERS}\n"
    return "".join([
        head, isa.macros(), f"#define CHOICE_SITE {CHOICE_SITE}u\n", functions.source(), *texts,
    ])  # fmt: skip
