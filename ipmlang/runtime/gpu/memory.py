"""What a machine holds on the card: tables of records and terminals, and every other buffer.

Takes widths in words and rooms in rows; gives tables that never exceed one storage block, smaller
than was asked for where the card is full, and used again where that is possible. Whatever was not
handed over is released at once, however a run ended. It reads no record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.gpu.device import Device, is_full
from ipmlang.runtime.gpu.storage import Storage

Words = NDArray[np.uint32]
Floats = NDArray[np.float64]

FEWEST = 1 << 12  # rows that a new table has room for
GUESSED = 1 << 29  # bytes of a table whose need is not known yet
SPARE = 4  # tables that are kept to be used again


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


class Memory:
    """The memory of one machine."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self._held: dict[Storage, None] = {}
        self._spare: list[Rows] = []

    def most(self, width: int) -> int:
        """The most rows that a table can have room for."""
        return self.device.limits.block_bytes // (4 * width)

    def buffer(self, content: bytes | int) -> Storage:
        """A buffer with this content, or so many bytes; where the card is full, tables that wait to
        be used again go first.
        """
        try:
            made = self.device.buffer(content)
        except IpmError as error:
            if not self._spare or not is_full(error):
                raise
            self._clear()
            made = self.device.buffer(content)
        self._held[made] = None
        return made

    def rows(self, width: int, room: int, *, least: int = 1) -> Rows:
        """An empty table with so much room, or with less where a block or the card has no more, but
        `least`.
        """
        room = max(min(max(room, FEWEST), self.most(width)), least)
        for place, rows in enumerate(self._spare):
            if rows.width == width and room <= rows.room <= 4 * room:
                rows.count = 0
                return self._spare.pop(place)
        while True:
            try:
                return Rows(self.buffer(4 * width * room), width, room)
            except IpmError as error:
                if room <= least or not is_full(error):
                    raise
                room = max(room // 2, least)

    def guessed(self, width: int, room: int) -> Rows:
        """The same where nobody knows yet whether all that room is needed."""
        return self.rows(width, min(room, GUESSED // (4 * width)))

    def filling(self, tables: list[Rows], width: int, room: int) -> Rows:
        """The table that is filled now; one with so much room where there is none."""
        return tables[-1] if tables else self.another(tables, width, room)

    def another(self, tables: list[Rows], width: int, room: int) -> Rows:
        """A table with room for so many more rows, which is filled from now on."""
        if tables and not tables[-1].count:
            self.spare(tables.pop())
        ahead = min(sum(rows.count for rows in tables) // 2, GUESSED // (4 * width))
        tables.append(self.rows(width, max(int(room * 1.05), ahead)))
        return tables[-1]

    def spare(self, rows: Rows) -> None:
        """A table that nobody reads any more may be used again."""
        self._spare.append(rows)
        if len(self._spare) > SPARE:
            self._spare.sort(key=lambda each: each.room)
            self.free(self._spare.pop(0).storage)

    def free(self, storage: Storage) -> None:
        """Give a buffer back to the card."""
        del self._held[storage]
        storage.release()

    def hand_over(self, tables: list[Rows]) -> None:
        """Somebody else releases these."""
        for rows in tables:
            del self._held[rows.storage]

    def release(self) -> None:
        """Give everything back."""
        self._spare.clear()
        for storage in self._held:
            storage.release()
        self._held.clear()

    def _clear(self) -> None:
        spare, self._spare = self._spare, []
        for rows in spare:
            self.free(rows.storage)
