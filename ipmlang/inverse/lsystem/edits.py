"""Replacements in one string that do not overlap.

Takes a string and the rows that new symbols stand for; gives the shorter string. Whether a
replacement is right is for the caller.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Frames, join, replaced
from ipmlang.inverse.lsystem.symbols import Arrangement, Integers, joined


class Edit:
    """Replacements in one string that do not overlap."""

    def __init__(self, string: Arrangement) -> None:
        self.string = string
        self.used = np.zeros(len(string) + 1, np.bool_)
        self.keep = np.ones(len(string), np.bool_)
        self.symbol = string.symbol.copy()
        self.changed = False
        self.bodies: list[Arrangement] = []
        self._new: list[tuple[Integers, Frames]] = []

    def clear(self, rows: Integers, count: int) -> NDArray[np.bool_]:
        """(k,) whether none of the `count` rows from each on is used yet."""
        free = np.ones(len(rows), np.bool_)
        if count > 2:
            return np.array([not self.used[row : row + count].any() for row in rows.tolist()])
        for offset in range(count):
            free &= ~self.used[rows + offset]
        return free

    def replace(self, rows: Integers, counts: Integers, symbol: int, lead: Frames) -> None:
        """Put one symbol in place of `counts` neighbours from each of `rows` on."""
        for row, count in zip(rows.tolist(), counts.tolist(), strict=True):
            self.used[row : row + count] = True
            self.keep[row + 1 : row + count] = False
        self.symbol[rows] = symbol
        self._new.append((rows, lead))
        self.changed = True

    def result(self) -> Arrangement:
        """The string after all replacements, new bodies at its end."""
        changed = self.string.placed
        rows = np.concatenate([each for each, _ in self._new])
        changed = replaced(changed, rows, join([lead for _, lead in self._new]))
        string = Arrangement(self.symbol, changed, self.string.start, self.string.wrap)
        return joined([string[self.keep], *self.bodies])
