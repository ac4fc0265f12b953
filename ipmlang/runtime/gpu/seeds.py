"""One thread for each first shape, on a stack of its own: strings whose turtles thread, and chains.

In go records, out come terminals in the order in which each thread drew them. A thread leaves off
when it has run long, when its stack is full or when there is no room to draw; the next dispatch
goes on where it stopped, so nothing is derived twice. The stacks lie side by side, word by word.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.gpu.isa import HEADER, Count
from ipmlang.runtime.gpu.machine import Machine, Made, Rows, Tree, TroubleError
from ipmlang.runtime.gpu.storage import Storage

Words = NDArray[np.uint32]

SLOTS = 16  # frames that a stack has room for at first
FRAME = 8  # words of a frame before its numbers
STATUS = 2  # words of a stack before its state


class Seeds(Machine):
    """The same machine, whose children are calls."""

    per_seed = True

    def run(self, roots: Words, copies: int, limit: int, *, ordered: bool = True) -> Made:
        """Derive records (words, n) whole. More than `limit` shapes are trouble.

        Raises TroubleError, and IpmError where the card fails or is too small.
        """
        made = Made([], [], Tree(), 0, 0, np.zeros(self.notes, np.uint32))
        counts = np.zeros(Count.NOTES + self.notes, np.uint32)
        most = max(1, self.device.limits.block_bytes // (4 * self._stack_words(SLOTS)))
        for begin in range(0, roots.shape[1], most):
            part = np.ascontiguousarray(roots[:, begin : begin + most])
            rows = self.rows(self.layout.record, part.shape[1])
            rows.room = rows.count = part.shape[1]
            rows.storage.write(part)
            if ordered:
                made.tree.note(rows, 0)
            counts = self._whole(rows, begin, made, counts, limit)
            rows.storage.release()
        made.shapes = int(counts[Count.SHAPES])
        made.generations = int(counts[Count.GENERATION])
        made.notes = counts[Count.NOTES :]
        return made

    def _stack_words(self, slots: int) -> int:
        """Words of the stack of one thread."""
        return STATUS + 2 * self.layout.state + (slots + 1) * self._frame

    @property
    def _frame(self) -> int:
        layout = self.layout
        state = layout.state if layout.uniforms["forks"] else 0
        return FRAME + 2 * (layout.uniforms["registers"] + state)

    def _whole(self, rows: Rows, first: int, made: Made, counts: Words, limit: int) -> Words:
        """Run some threads to their end; the counts after it."""
        slots, many = SLOTS, rows.count
        stack = self.device.buffer(4 * many * self._stack_words(slots))
        unused = self.rows(HEADER, 1)
        more = {"stack_slots": slots, "frame_words": self._frame, "resuming": 0}
        while True:
            terminals = self.table(made.terminals, self.layout.terminal, many)
            returned = self.table(made.returned, self.layout.record, 0)
            uniforms = {
                **more, "records": many, "queue_rows": rows.room, "first_record": first,
                "first_thread": 0, "threads": many, "whole": 1,
                "terminal_first": terminals.count, "terminal_rows": terminals.room,
                "returned_first": returned.count, "returned_rows": returned.room,
            }  # fmt: skip
            tables = (rows.storage, unused.storage, terminals.storage, returned.storage)
            counts = self.dispatch(uniforms, tables, stack, many, counts)
            full = [
                self._filled(table, int(counts[word]))
                for table, word in ((terminals, Count.TERMINALS), (returned, Count.RETURNED))
            ]
            if int(counts[Count.SHAPES]) > limit:
                raise TroubleError(0, int(counts[Count.STOPPED]))
            if not counts[Count.RECORDS]:
                break
            if full[0]:
                self.table(made.terminals, self.layout.terminal, terminals.room, new=True)
            if full[1]:
                self.table(made.returned, self.layout.record, returned.room, new=True)
            if counts[Count.COPIES]:
                slots *= 2
                stack = self._grown(stack, many, slots)
            more = {"stack_slots": slots, "frame_words": self._frame, "resuming": 1}
        stack.release()
        unused.storage.release()
        return counts

    def _filled(self, table: Rows, more: int) -> bool:
        """Note so many more rows of a table; whether there was no room for all of them."""
        wanted = table.count + more
        table.count = min(wanted, table.room)
        return wanted > table.room

    def _grown(self, stack: Storage, many: int, slots: int) -> Storage:
        """The same stacks with room for more frames."""
        larger = self.device.buffer(4 * many * self._stack_words(slots))
        stack.copy_to(larger, stack.size)
        stack.release()
        return larger
