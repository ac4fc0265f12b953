"""Equal rows of columns, found once: what must be computed for each that differs, and no more.

In go columns of a batch, out come the distinct rows and the kind of every row. Rows are equal up to
the noise of sums that were added in another order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.code import Column
from ipmlang.runtime.scopes.boxes import Floats, full

Numbers = NDArray[np.int64]
DIGITS = 12  # of rows that are the same


@dataclass(slots=True, eq=False)
class Table:
    """The distinct rows of some columns: `first` of each kind, and the `kind` of every row."""

    columns: tuple[Floats, ...]
    chosen: Numbers | None
    first: Numbers
    kind: Numbers

    def rows(self) -> Iterator[tuple[float, ...]]:
        """The values of each distinct row."""
        return zip(*(column[self.first].tolist() for column in self.columns), strict=True)

    def spread(self, found: Floats, blank: Floats, count: int) -> Floats:
        """What was found for each distinct row, for all rows (count, …)."""
        if self.chosen is None:
            return found[self.kind]
        out = np.tile(blank, (count, 1))
        if len(self.chosen):
            out[self.chosen] = found[self.kind]
        return out


def distinct(values: NDArray[np.generic]) -> tuple[NDArray[np.generic], Numbers]:
    """The different values (k,), ascending, and the place of each of the values (n,) among them.

    What numpy's `unique` does, without the library of masked arrays that it loads.
    """
    flat = np.asarray(values).reshape(-1)
    order = np.argsort(flat, kind="stable")
    ordered = flat[order]
    first = np.ones(len(flat), np.bool_)
    first[1:] = ordered[1:] != ordered[:-1]
    place = np.empty(len(flat), np.int64)
    place[order] = np.cumsum(first) - 1
    return ordered[first], place


def table(shown: Numbers | None, count: int, *columns: Column) -> Table:
    """The distinct rows of columns, of the rows that are shown (None: of all)."""
    wide = tuple(full(column, count) for column in columns)
    if shown is not None:
        wide = tuple(column[shown] for column in wide)
    bits = [np.round(column, DIGITS) + 0.0 for column in wide]
    order = np.lexsort(bits[::-1])
    changes = np.zeros(len(order), np.bool_)
    for column in bits:
        own = column[order]
        with np.errstate(invalid="ignore"):
            differs = (own[1:] != own[:-1]) & ~(np.isnan(own[1:]) & np.isnan(own[:-1]))
        changes[1:] |= differs
    kinds = np.cumsum(changes)
    kind = np.empty(len(order), np.int64)
    kind[order] = kinds
    starts = np.flatnonzero(changes)
    if len(order):
        starts = np.concatenate(([0], starts))
    first = order[starts] if len(order) else order
    return Table(wide, shown, first, kind)
