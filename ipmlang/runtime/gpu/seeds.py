"""One thread for each first shape, on a stack of its own: strings whose turtles thread, and chains.

In go records, out come terminals in the order in which each thread drew them. A thread leaves off
when it has run long, when its stack is full or when there is no room to draw; the next dispatch
goes on where it stopped, so nothing is derived twice. The stacks lie side by side, word by word.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.gpu import machine
from ipmlang.runtime.gpu.device import is_full
from ipmlang.runtime.gpu.isa import HEADER, Count, Trouble
from ipmlang.runtime.gpu.machine import Machine, Made, Tree, TroubleError, check, limits
from ipmlang.runtime.gpu.memory import Rows
from ipmlang.runtime.gpu.storage import Storage
from ipmlang.runtime.limits import Bounds

Words = NDArray[np.uint32]

SLOTS = 16  # frames that a stack has room for at first
FRAME = 8  # words of a frame before its numbers
STATUS = 2  # words of a stack before its frames


@dataclass(slots=True, eq=False)
class _Threads:
    """Threads that run side by side: their records, the number of the first, how many frames each
    stack has room for, and the stacks.
    """

    rows: Rows
    first: int
    slots: int
    stack: Storage


class Seeds(Machine):
    """The same machine, whose children are calls."""

    per_seed = True

    def run(self, roots: Words, bounds: Bounds, *, ordered: bool = True) -> Made:
        """Derive records (words, n) whole; more than the bounds allow is trouble.

        Raises TroubleError, and IpmError where the card fails or is too small.
        """
        made = Made([], [], Tree(), 0, 0, np.zeros(self.notes, np.uint32))
        counts = np.zeros(Count.NOTES + self.notes, np.uint32)
        begin, many = 0, min(machine.SLICE, self._room())
        while begin < roots.shape[1]:
            part = roots[:, begin : begin + many]
            marks = _mark(made.terminals), _mark(made.returned)
            try:
                rows, counts = self._part(part, begin, made, counts, bounds)
            except TroubleError as found:
                if found.bits != Trouble.STACK or part.shape[1] == 1:
                    raise
                self._back(made.terminals, marks[0])
                self._back(made.returned, marks[1])
                many = part.shape[1] // 2
                continue
            if ordered:
                made.tree.note(rows, 0)
            self.memory.spare(rows)
            begin += part.shape[1]
        return self._finished(made, counts)

    def _room(self) -> int:
        """How many threads one block has room for."""
        words = max(self._stack_words(SLOTS), self.layout.record)
        return max(1, self.memory.most(words))

    def _stack_words(self, slots: int) -> int:
        """Words of the stack of one thread."""
        return STATUS + (slots + 1) * self._frame

    @property
    def _frame(self) -> int:
        return FRAME + 2 * (self.layout.uniforms["registers"] + self.layout.state)

    def _part(
        self, part: Words, begin: int, made: Made, counts: Words, bounds: Bounds
    ) -> tuple[Rows, Words]:
        """Run some threads to their end: their records, and the counts after them."""
        many = part.shape[1]
        rows = self.memory.rows(self.layout.record, many, least=many)
        rows.storage.write(part)
        rows.count = rows.room = many
        unused = self.memory.rows(HEADER, 1)
        stack = self._stack(many, SLOTS)
        threads = _Threads(rows, begin, SLOTS, stack)
        try:
            counts = self._whole(threads, unused, made, counts, bounds)
        finally:
            self.memory.free(threads.stack)
            self.memory.spare(unused)
        return rows, counts

    def _whole(
        self, threads: _Threads, unused: Rows, made: Made, counts: Words, bounds: Bounds
    ) -> Words:
        """Run threads until none has to go on; the counts after them."""
        resuming = 0
        while True:
            kept = (made.terminals, Count.TERMINALS), (made.returned, Count.RETURNED)
            fills = self._fills(made, threads.rows.count, unused)
            uniforms = {**limits(bounds, made), "resuming": resuming}
            counts = self._once(threads, fills, counts, uniforms)
            full = [
                (tables, rows)
                for rows, (tables, word) in zip(fills[1:], kept, strict=True)
                if _is_filled(rows, int(counts[word]))
            ]
            check(bounds, counts, made)
            if not counts[Count.RECORDS]:
                return counts
            for tables, rows in full:
                self.memory.another(tables, rows.width, rows.room)
            if counts[Count.COPIES]:
                self._grow(threads)
            resuming = 1

    def _once(
        self, threads: _Threads, fills: tuple[Rows, Rows, Rows], before: Words,
        more: Mapping[str, int],
    ) -> Words:  # fmt: skip
        """Run each thread for a while; the counts after it."""
        rows, many = threads.rows, threads.rows.count
        _, terminals, returned = fills
        uniforms = {
            **more, "stack_slots": threads.slots, "frame_words": self._frame,
            "records": many, "queue_rows": rows.room, "first_record": threads.first,
            "first_thread": 0, "threads": many, "whole": 1,
            "terminal_first": terminals.count, "terminal_rows": terminals.room,
            "returned_first": returned.count, "returned_rows": returned.room,
        }  # fmt: skip
        storages = (rows.storage, *(each.storage for each in fills))
        return self.dispatch(uniforms, storages, threads.stack, many, before)

    # --------------------------------------------------------------------------- stacks

    def _stack(self, many: int, slots: int) -> Storage:
        """Stacks with room for so many frames; there is trouble where the card has no room."""
        try:
            return self.memory.buffer(4 * many * self._stack_words(slots))
        except IpmError as error:
            if not is_full(error):
                raise
            raise TroubleError(Trouble.STACK) from error

    def _grow(self, threads: _Threads) -> None:
        """Make room for more frames."""
        slots = 2 * threads.slots
        larger = self._stack(threads.rows.count, slots)
        threads.stack.copy_to(larger, threads.stack.size)
        self.memory.free(threads.stack)
        threads.stack, threads.slots = larger, slots

    def _back(self, tables: list[Rows], mark: tuple[int, int]) -> None:
        """Forget the rows that were added since a mark: who made them runs again."""
        while len(tables) > max(mark[0], 1):
            self.memory.spare(tables.pop())
        if tables:
            tables[-1].count = mark[1]


def _mark(tables: list[Rows]) -> tuple[int, int]:
    """How many tables there are, and how many rows the last one has."""
    return len(tables), tables[-1].count if tables else 0


def _is_filled(rows: Rows, more: int) -> bool:
    """Note so many more rows of a table; whether there was no room for all of them."""
    wanted = rows.count + more
    rows.count = min(wanted, rows.room)
    return wanted > rows.room
