"""What bodies and guards ask about other shapes, and the phases that they wait for.

In go columns of a batch, out come columns; labels, reports and shapes that ask are noted, so that
later phases and the second pass of the derivation can be told of them. Geometry is compared
elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.ops.queries import FAR, OCCLUSION
from ipmlang.runtime import keys as path
from ipmlang.runtime.code import Column
from ipmlang.runtime.limits import Counted
from ipmlang.runtime.naming import OWN
from ipmlang.runtime.queries.marks import ASKING, FIELD, FIRST, NAMED, SEEN, Kind, Marks, asked
from ipmlang.runtime.scene import OUTLINES, SEGMENT
from ipmlang.runtime.scopes.pool import Load
from ipmlang.runtime.scopes.scoping import Keys, Rows
from ipmlang.runtime.scopes.unwrapping import Unwrapping

if TYPE_CHECKING:
    from ipmlang.runtime.queries.occluders import Occluders
    from ipmlang.runtime.queries.totals import Totals


class Asking(Unwrapping):
    """The part of a run that knows other shapes. `answers`: what an earlier pass made;
    `first_pass`: this is the earlier pass.
    """

    def __init__(
        self, program: ir.Program, counted: Counted, load: Load, answers: Occluders | None
    ) -> None:
        super().__init__(program, counted, load)
        self.asked = asked(program)
        self.first_pass = self.asked is not None and self.asked.occlusion and answers is None
        self.marks = Marks(keeps=self.first_pass)
        self.phase = FIRST
        self.answers = answers
        self._totals: Totals | None = None

    # --------------------------------------------------------------------------- noting

    def mark(
        self,
        kind: Kind,
        count: int,
        label: Column,
        value: Column,
        state: Mapping[str, Column],
        keys: Keys,
        shown: Rows,
    ) -> Column:
        """Note the shapes of a batch; the rows that what follows stands in."""
        k0, k1, site, copies = keys
        words = (k0, k1) if site == OWN else path.child(k0, k1, site, *copies)
        kept = {name: state[name] for name in SEEN if name in state}
        return self.marks.add(kind, count, label, value, kept, words, shown)

    def later(self, number: Column, before: Column) -> Column:
        """The phase that shapes are expanded in from now on."""
        values = np.asarray(number)
        if not np.all((values >= 1) & (values == np.floor(values))):
            raise self.counted.error("not-a-phase", "phases are the whole numbers from 1 on")
        return np.maximum(number, np.maximum(before, FIRST))

    def enter(self, phase: float) -> None:
        """Begin a phase: all of those before it are done."""
        self.phase = phase
        self._totals = None

    # ------------------------------------------------------------------------- answering

    def ask(
        self,
        name: str,
        count: int,
        args: Sequence[Column],
        state: Mapping[str, Column],
        shown: Rows,
    ) -> Column:
        """The answers to a query for every row of a batch, or for those shown; NaN to one that asks
        about NaN.
        """
        if name in OCCLUSION and self.answers is None:
            return FAR if name == "distance" else 0.0
        rows = np.arange(count) if shown is None else shown
        columns = [np.broadcast_to(np.asarray(arg, np.float64), (count,))[rows] for arg in args]
        unknown = np.isnan(np.sum(columns, axis=0)) if columns else np.zeros(len(rows), np.bool_)
        columns = [np.where(unknown, -1.0, column) for column in columns]
        marks = np.broadcast_to(np.asarray(state[FIELD]), (count,))[rows].astype(np.int64)
        none = np.full(len(rows), -1.0)
        label = (columns[0] if columns else none).astype(np.int64)
        if self.answers is not None and name in OCCLUSION:
            from ipmlang.runtime.queries.occluders import scopes_of

            asking = scopes_of(state, count, shown, self.pool)
            own = self.answers.answer(name, label, asking, marks, self.marks)
        else:
            whole = columns.pop(1) if name == "share" else none
            within = (columns[1] if len(columns) > 1 else none).astype(np.int64)
            own = self._before().answer(name, marks, label, whole, within)
        own = np.where(unknown, np.nan, own)
        if shown is None:
            return own
        found = np.zeros(count)
        found[shown] = own
        return found

    def _before(self) -> Totals:
        from ipmlang.runtime.queries.totals import Totals

        if self._totals is None:
            self._totals = Totals(self.marks, self.phase)
        return self._totals

    # -------------------------------------------------------------------------- symbols

    def marks_of(self, symbol: int) -> tuple[Kind, float] | None:
        """How the shapes of a symbol are noted: by its name, or because they ask."""
        if self.asked is None:
            return None
        if symbol in self.asked.named:
            return NAMED, float(self.asked.named[symbol])
        return (ASKING, -1.0) if symbol in self.asked.asking else None

    def note_drawn(
        self, count: int, symbol: int, asset: int, state: Mapping[str, Column], keys: Keys,
        shown: Rows,
    ) -> None:  # fmt: skip
        """Note terminals whose symbol's name some query may ask for."""
        if self.asked is None or symbol not in self.asked.named or asset in (SEGMENT, *OUTLINES):
            return
        self.mark(NAMED, count, float(self.asked.named[symbol]), 0.0,
                  self.with_asset(asset, state), keys, shown)  # fmt: skip

    def with_asset(self, asset: int, state: Mapping[str, Column]) -> Mapping[str, Column]:
        """The scope of what is drawn: an asset brings its own."""
        if asset < 0:
            return state
        from ipmlang.runtime.scopes.boxes import SIZES, moved

        low, high = self.pool.asset_bounds(asset)
        place = moved(state, (float(low[0]), float(low[1]), float(low[2])))
        size = dict(zip(SIZES, (high - low).tolist(), strict=True))
        return {**state, **place, **size, "geo": float(self.pool.asset(asset))}
