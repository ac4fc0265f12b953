"""Snap lines, and splits whose cuts move to lines of earlier phases.

In go columns of a batch, out come the pieces of splits as columns. Lines are collected until a
phase begins that asks for them, so that no order of derivation matters. How lengths are shared out
is not known here: pieces are noted where the split's arithmetic has them, and cut where they end
up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.ops.record import NOT_GIVEN
from ipmlang.runtime.choose import told
from ipmlang.runtime.code import Column
from ipmlang.runtime.limits import Counted
from ipmlang.runtime.queries.asking import Asking
from ipmlang.runtime.queries.lines import Axes, Floats, Made, Numbers, Standing, joined
from ipmlang.runtime.queries.marks import FIELD, FIRST, PHASE
from ipmlang.runtime.queries.totals import LABELS
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import AXES, SIZES, State, full
from ipmlang.runtime.scopes.cuts import Beside, Pieces, moved, together
from ipmlang.runtime.scopes.pieces import Batched
from ipmlang.runtime.scopes.pool import SNAP, Load
from ipmlang.runtime.scopes.scoping import Rows
from ipmlang.runtime.scopes.shaping import Given
from ipmlang.runtime.scopes.tables import distinct

if TYPE_CHECKING:
    from ipmlang.runtime.queries.occluders import Occluders

PLACES = {"start": (0.0,), "middle": (0.5,), "end": (1.0,), "both": (0.0, 1.0)}
MANY = 2**40  # more than there are rows of marks


class Snapping(Asking):
    """The part of a run that knows snap lines."""

    def __init__(
        self, program: ir.Program, counted: Counted, load: Load, answers: Occluders | None
    ) -> None:
        super().__init__(program, counted, load, answers)
        self._lines: list[Made] = []
        self._standing: dict[int, Standing | None] = {}
        self._pieces: dict[int, list[Pieces]] = {}  # by the number of the split in its rule
        self._asked: set[tuple[int, float, int]] = set()  # rules, phases and names of lines

    def enter(self, phase: float) -> None:
        """Begin a phase: all of those before it are done."""
        super().enter(phase)
        self._standing.clear()

    # -------------------------------------------------------------------------- lines

    def snap(
        self, count: int, args: Sequence[Column], state: Mapping[str, Column], shown: Rows
    ) -> None:
        """Make a line in every row of a batch: across an axis, where the scope begins, or in its
        middle, or where it ends.
        """
        rows = np.arange(count) if shown is None else shown
        given = Given(self.program, self.pool, "snap", args, count)
        names, axes, places = (full(each, count) for each in args)
        places = np.where(places == NOT_GIVEN, -1.0, places)
        pairs = np.unique(np.stack([axes[rows], places[rows]], axis=1), axis=0)
        for axis, place in pairs.tolist():
            own = rows[(axes[rows] == axis) & (places[rows] == place)]
            with self._telling():
                _, word, where = given.resolved([0.0, axis, NOT_GIVEN if place < 0 else place])
            for share in PLACES[str(where or "start")]:
                self._snap(AXES.index(str(word)), share, names, own, state)

    def _snap(
        self, axis: int, share: float, names: Floats, rows: Numbers, state: Mapping[str, Column]
    ) -> None:
        own = {name: full(value, len(names))[rows] for name, value in state.items()}
        origin, along, scale = _axis(own, axis)
        point = origin + along * (scale * own[SIZES[axis]] * share)[:, None]
        mark = own[FIELD].astype(np.int64) if FIELD in own else np.full(len(rows), -1)
        phase = own.get(PHASE, np.full(len(rows), FIRST))
        self._lines.append(Made(names[rows].astype(np.int64), mark, phase, point, along))

    def _seen_within(self, label: int) -> Standing | None:
        """The lines of earlier phases, told apart by the shapes of a label (-1: none) that they
        stand in; None if there are none.
        """
        if label not in self._standing:
            lines = joined(self._lines)
            lines = lines.take(lines.phase < self.phase)
            group = self._groups(lines.mark, label)
            lines, group = lines.take(group >= 0), group[group >= 0]
            family = lines.name * MANY + group
            self._standing[label] = Standing(lines, family) if len(family) else None
        return self._standing[label]

    def _groups(self, mark: Numbers, label: int) -> Numbers:
        """The shapes of a label (-1: none) that rows of marks stand in, -1 for none."""
        if label < 0:
            return np.zeros(len(mark), np.int64)
        return self.marks.nearest(mark, LABELS, np.full(len(mark), label))

    def snap_notes(self) -> tuple[str, ...]:
        """A note for each rule whose splits snap to lines that are not there in time."""
        lines = joined(self._lines)
        last = {(rule, name): phase for rule, phase, name in sorted(self._asked)}
        found = []
        for (rule, name), phase in last.items():
            own = lines.phase[lines.name == name]
            if not (own < phase).any():
                which = f"all {len(own):,} are of phase {min(own, default=0):g} or later"
                found.append(
                    f"{self._rule(rule)}: a split of phase {phase:g} finds no snap line "
                    f'"{self.program.strings[name]}" of an earlier phase: '
                    f"{which if len(own) else 'there are none'}"
                )
        return tuple(found)

    def _rule(self, rule: int) -> str:
        program = self.program
        return told(program, program.axiom if rule < 0 else program.productions[rule])

    # ------------------------------------------------------------------------- splits

    def piece(
        self,
        what: tuple[int, int, bool],
        count: int,
        shape: Column,
        low: Column,
        size: Column,
        shown: Rows,
    ) -> None:
        """Note one piece of a split in every row of a batch: of which split of the rule and which
        part of it, and whether it gives way.
        """
        number, part, gives = what
        columns = [full(each, count) for each in (shape, low, size)]
        if shown is not None:
            columns = [each[shown] for each in columns]
        row = columns[0].astype(np.int64)
        own = Pieces(row, columns[1], columns[2], np.full(len(row), part), np.full(len(row), gives))
        self._pieces.setdefault(number, []).append(own)

    def snapped(
        self,
        axis: int,
        number: int,
        parts: int,
        count: int,
        args: Sequence[Column],
        state: State,
        shown: Rows,
    ) -> list[Batched]:
        """The pieces of a split, in a batch for each of its parts, once each cut is at the line
        that it snaps to.
        """
        extent = full(state[SIZES[axis]], count)
        pieces = together(self._pieces.pop(number, []))
        there = pieces.size > SNAP * extent[pieces.row]
        self.missed(pieces.size[~there])
        pieces = pieces.ordered(there)
        names, within, reach = (full(each, count) for each in args)
        rows = np.arange(count) if shown is None else shown
        self._check_snap(names[rows], reach[rows])
        own = {name: full(value, count) for name, value in state.items()}
        beside = self._beside(axis, names, within, own)
        reach = np.where(reach == NOT_GIVEN, np.inf, reach)
        low, size = moved(pieces, beside, reach[pieces.row], extent[pieces.row])
        index, many = _numbered(pieces.row)
        found = []
        for part in range(parts):
            chosen = np.flatnonzero(pieces.part == part)
            found.append(self._part(axis, pieces.row[chosen], low[chosen], size[chosen], own,
                                    index[chosen], many[chosen]))  # fmt: skip
        return found

    def _check_snap(self, names: Floats, reach: Floats) -> None:
        """Splits that snap stand in later phases; they reach no less than nowhere."""
        known = distinct(names)[0].astype(np.int64).tolist()
        asked = [name for name in known if self.program.strings[name]]
        if asked and self.phase <= FIRST:
            raise self.counted.error(
                "first-phase",
                "a split snaps to lines of earlier phases, and this is the first one",
                hint="let the shape that splits wait for those that make the lines: phase(2) Floor",
            )
        if ((reach < 0) & (reach != NOT_GIVEN)).any():
            raise self.counted.error("out-of-range", "`reach` of `split` must be 0 or more")
        self._asked.update((self.counted.rule, self.phase, name) for name in asked)

    def _beside(
        self, axis: int, names: Floats, within: Floats, state: Mapping[str, Floats]
    ) -> Beside:
        """Who knows the lines next to places along an axis of scopes, in their coordinates."""
        origin, along, scale = _axis(state, axis)
        mark = state[FIELD].astype(np.int64)
        labels = np.where(within == NOT_GIVEN, -1, within).astype(np.int64)
        known: list[tuple[int, Standing, Axes]] = []
        for label in map(int, distinct(labels)[0].tolist()):
            standing = self._seen_within(label)
            if standing is not None:
                group = self._groups(mark, label)
                family = np.where(group >= 0, names.astype(np.int64) * MANY + group, -1)
                known.append((label, standing, Axes(family, origin, along)))

        def beside(row: Numbers, at: Floats) -> tuple[Floats, Floats]:
            below, above = np.full(len(at), -np.inf), np.full(len(at), np.inf)
            for label, standing, axes in known:
                own = np.flatnonzero(labels[row] == label)
                size = scale[row[own]]
                found = standing.beside(axes, row[own], at[own] * size)
                below[own], above[own] = found[0] / size, found[1] / size
            return below, above

        return beside

    def _part(
        self,
        axis: int,
        owner: Numbers,
        low: Floats,
        size: Floats,
        state: Mapping[str, Floats],
        index: Numbers,
        many: Floats,
    ) -> Batched:
        """The pieces of one part: slabs of the scopes that they belong to."""
        own: State = {name: value[owner] for name, value in state.items()}
        sizes = [own[name] for name in (*SIZES, "geo")]
        shown, begin, extent, geometry = self.slab(
            axis, len(owner), low, size, sizes[0], sizes[1], sizes[2], sizes[3], None
        )
        step: list[Column] = [0.0, 0.0, 0.0]
        step[axis] = begin
        own.update(boxes.moved(own, (step[0], step[1], step[2])))
        own.update({SIZES[axis]: extent, "geo": geometry})
        rows = np.arange(len(owner)) if shown is None else shown
        own = {name: full(value, len(owner))[rows] for name, value in own.items()}
        counts = np.bincount(owner[rows], minlength=len(state[FIELD]))
        return Batched(counts, owner[rows], index[rows].astype(np.uint32), many[rows], own)


def _axis(state: Mapping[str, Floats], axis: int) -> tuple[Floats, Floats, Floats]:
    """Where scopes begin (n, 3), the unit vectors (n, 3) along one of their axes, and their scales
    (n,).
    """
    origin = np.stack([state[name] for name in AXES], axis=1)
    unit: list[Column] = [0.0, 0.0, 0.0]
    unit[axis] = boxes.hand(state) if axis == 0 else 1.0
    turn = tuple(state[name] for name in boxes.ROTATION)
    along = np.stack(
        [full(each, len(origin)) for each in boxes.rotated(turn, (unit[0], unit[1], unit[2]))],
        axis=1,
    )
    scale = np.abs(state["scale"]) if "scale" in state else np.ones(len(origin))
    return origin, along, scale


def _numbered(row: Numbers) -> tuple[Numbers, Floats]:
    """The number of each piece in its split, and how many that has; pieces stand by row."""
    begin = np.searchsorted(row, row)
    end = np.searchsorted(row, row, side="right")
    return np.arange(len(row)) - begin, (end - begin).astype(np.float64)
