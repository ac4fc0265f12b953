"""Whole generations, one after the other, each from left to right: for draws noted or known.

In goes a frontier, out come its shapes derived level by level. A frontier otherwise takes what
waits in any order, as no draw hangs on it; a list of decisions has an order of its own. Nothing
here draws.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ipmlang.runtime.order import Record, ranked

if TYPE_CHECKING:
    from ipmlang.runtime.frontier import Frontier


class Levels:
    """The generations of one derivation. `_ranks`: numbers of shapes, rising from left to right
    within what one generation made; `_known`: so many records have theirs.
    """

    def __init__(self, run: Frontier) -> None:
        self._run = run
        self._ranks = np.arange(run.order.first)
        self._known = 0

    def next(self) -> None:
        """Derive the first generation that waits."""
        order = self._run.order
        records = [each for each in order.records[self._known :] if isinstance(each, Record)]
        self._known = len(order.records)
        self._ranks = ranked(records, self._ranks, self._run.shapes, self._run.drawings)
        for (symbol, generation), shapes in self._run.pending.level():
            places = np.argsort(self._ranks[shapes.numbers], kind="stable")
            self._run.derive(symbol, generation, shapes.take(places))
