"""What bodies ask about scopes and their geometry: slabs, pieces, other solids, measures.

In go columns of a batch, out come columns. Scopes that their geometry fills are arithmetic on
columns; any other geometry is worked on once for each that differs, in the coordinates of its
scope. Children and drawings are not made here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.solid import GeometryError, Solid
from ipmlang.geometry.trouble import computing
from ipmlang.runtime.code import Column
from ipmlang.runtime.copying import Copying, Numbers
from ipmlang.runtime.keys import Words
from ipmlang.runtime.limits import Counted
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import AXES, ROTATION, SIZES, State, full
from ipmlang.runtime.scopes.framing import framed
from ipmlang.runtime.scopes.laying import READY, SETUP, Laying, LayingError
from ipmlang.runtime.scopes.pieces import AHEAD, Apart, Batched, apart
from ipmlang.runtime.scopes.pool import BOX, NOTHING, SNAP, Load, Pool
from ipmlang.runtime.scopes.reports import Reports
from ipmlang.runtime.scopes.reshaping import shaped
from ipmlang.runtime.scopes.shaping import FAST, Given
from ipmlang.runtime.scopes.tables import distinct, table

Floats = NDArray[np.float64]
Rows = Numbers | None  # of a batch that are there; None: all
Keys = tuple[Words, Words, int, tuple[Words, ...]]


class Scoping(Copying):
    """The part of a run that works on scopes."""

    def __init__(self, program: ir.Program, counted: Counted, load: Load) -> None:
        super().__init__(program, counted)
        self.pool = Pool(load)
        self.reports = Reports()
        self.laying = Laying()

    # -------------------------------------------------------------------------- rows

    def inner(
        self, shown: Rows, count: int, owner: Numbers, clear: NDArray[np.bool_] | None
    ) -> Rows:
        """The copies that are there, of rows that are."""
        if shown is None:
            return None if clear is None else np.flatnonzero(clear)
        found = self.mask(shown, count)[owner]
        return np.flatnonzero(found if clear is None else found & clear)

    def some(self, geometry: Column, count: int, shown: Rows) -> Rows:
        """The rows that have any geometry."""
        if geometry if isinstance(geometry, float) else np.all(geometry):
            return shown
        there = full(geometry, count) != NOTHING
        return _narrowed(shown, there)

    def drawable(self, symbol: int, geometry: Column, count: int, shown: Rows) -> Rows:
        """The rows of a terminal that have any geometry."""
        there = self.some(geometry, count, shown)
        many, left = (count if rows is None else len(rows) for rows in (shown, there))
        if left:
            self.reports.drawn.add(symbol)
        if left < many:
            self.reports.blank[symbol] = self.reports.blank.get(symbol, 0) + many - left
        return there

    def extent(self, value: Column) -> Column:
        """A size must be 0 or more."""
        if not (value >= 0 if isinstance(value, float) else np.all(np.asarray(value) >= 0)):
            raise self.counted.error("negative-size", "`size` needs extents of 0 or more")
        return value

    def risen(self, height: Column, geometry: Column, count: int) -> Column:
        """The geometries of scopes that have a height: a polygon that is given one is its prism, as
        a rectangle is a box.
        """
        if isinstance(geometry, float) and not self.pool.is_flat(int(geometry)):
            return geometry
        if not np.any(height) or not np.any(self.pool.are_flat(geometry)):
            return geometry
        numbers = full(geometry, count)
        up = (full(height, count) > 0) & self.pool.are_flat(numbers)
        kinds, place = distinct(numbers)
        prisms = np.array([self._prism(int(number)) for number in kinds.tolist()], np.float64)
        return np.where(up, prisms[place], numbers)

    def _prism(self, number: int) -> int:
        if not self.pool.are_flat(float(number)):
            return number

        def make() -> int:
            from ipmlang.geometry.raising import extrude

            return self.pool.add(extrude(self.pool.unit(number, 2), 1.0))[0]

        found = self.pool.derived(("prism", number), lambda: self._tried(make))
        assert isinstance(found, int)
        return found

    # -------------------------------------------------------------------------- slabs

    def slab(
        self,
        axis: int,
        count: int,
        low: Column,
        size: Column,
        sx: Column,
        sy: Column,
        sz: Column,
        geometry: Column,
        shown: Rows,
    ) -> tuple[Rows, Column, Column, Column]:
        """The parts between two planes across an axis (3: between two areas, along x): which rows
        have any, where they begin, how long they are, and their geometries.
        """
        extent = (sx, sy, sz)[axis if axis < 3 else 0]
        boxes_all = bool(np.all(self.pool.are_boxes(geometry)))
        if axis == 3 and boxes_all:
            whole = self.measure("area", sx, sy, sz, geometry)
            share = np.divide(extent, whole) if np.all(whole) else 0.0
            low, size = low * share, size * share
        there = np.asarray(size > SNAP * np.asarray(extent))
        if not there.all():
            self._miss(there, size, shown, count)
            shown = _narrowed(shown, np.broadcast_to(there, (count,)))
        if boxes_all:
            geometry = self._cut_boxes(axis, low, size, extent, geometry, count)
            return shown, low, size, geometry
        kinds = table(shown, count, geometry, low, size, sx, sy, sz)
        found = np.zeros((len(kinds.first), 3))
        for place, (number, begin, length, *sizes) in enumerate(kinds.rows()):
            found[place] = self._cut(axis, int(number), begin, length, np.array(sizes))
        rows = kinds.spread(found, np.array((0.0, 0.0, 0.0)), count)
        shown = _narrowed(shown, rows[:, 2] != NOTHING)
        return shown, rows[:, 0], rows[:, 1], rows[:, 2]

    def _miss(self, there: NDArray[np.bool_], size: Column, shown: Rows, count: int) -> None:
        rows = slice(None) if shown is None else shown
        missing = ~np.broadcast_to(there, (count,))[rows]
        self.missed(np.broadcast_to(np.asarray(size), (count,))[rows][missing])

    def missed(self, sizes: Floats) -> None:
        """Note parts of splits that are not made, of these sizes; that must be numbers."""
        if np.isnan(sizes).any():
            raise self.counted.error("not-a-number", "the size of a part of a split is no number")
        many = len(sizes)
        rule = self.counted.rule
        self.reports.unfit[rule] = self.reports.unfit.get(rule, 0) + many

    def _cut(
        self, axis: int, number: int, low: float, length: float, size: Floats
    ) -> tuple[float, float, float]:
        """Where a part begins, how long it is, and the number of its geometry."""
        if number == NOTHING:
            return low, length, NOTHING
        own = axis if axis < 3 else 0
        if axis == 3:
            low, length = self._between_areas(number, low, length, size)
        extent = float(size[own])
        key = ("slab", number, own, low / extent, length / extent, tuple(size <= 0))

        def make() -> int:
            from ipmlang.geometry.slabs import slab

            part = slab(self.pool.local(number, size), own, low, low + length)
            if part is None:
                return NOTHING
            corner, sizes = np.zeros(3), size.copy()
            corner[own], sizes[own] = low, length
            return self.pool.within(part, corner, sizes)

        found = self.pool.derived(key, lambda: self._tried(make))
        assert isinstance(found, int)
        return low, length, float(found)

    def _between_areas(
        self, number: int, low: float, length: float, size: Floats
    ) -> tuple[float, float]:
        """Where along x the part begins and how long it is that has so much area before it, and so
        much of its own.
        """
        from ipmlang.geometry.areas import area_cuts

        solid = self.pool.local(number, size)
        with self._telling():
            _, begin, end = area_cuts(solid, "x", (low, length)).tolist()
        return begin, end - begin

    def _cut_boxes(
        self, axis: int, low: Column, size: Column, extent: Column, geometry: Column, count: int
    ) -> Column:
        """The numbers of boxes whose faces bear tags, now that some of these are cut."""
        if not np.any(self.pool.are_tagged(geometry)):
            return geometry
        begins = np.asarray(low > SNAP * np.asarray(extent))
        ends = np.asarray(low + size < np.asarray(extent) * (1 - SNAP))
        columns = np.broadcast_arrays(np.asarray(geometry), begins, ends)
        code = columns[0].astype(np.int64) * 4 + columns[1] * 2 + columns[2]
        codes, place = distinct(code)
        made = [self.cut_box(axis, each >> 2, each & 2, each & 1) for each in codes.tolist()]
        found = np.array(made, np.float64)[place.reshape(code.shape)]
        return found if found.ndim else float(found)

    def cut_box(self, axis: int, number: int, begins: int, ends: int) -> int:
        """The number of a box that is cut across an axis, where it begins, where it ends."""
        tags = list(self.pool.tags(number))
        if len(tags) == 6:
            near, far = {0: (5, 3), 1: (2, 4), 2: (0, 1), 3: (5, 3)}[axis]
            for face, cut in ((near, begins), (far, ends)):
                if cut:
                    tags[face] = frozenset({"split.cut"})
        return self.pool.box(tuple(tags)) if tags else number

    # ------------------------------------------------------------------- other geometry

    def solid(
        self, name: str, count: int, args: Sequence[Column], state: State, shown: Rows
    ) -> State:
        """What an operation makes of scopes and geometries; the columns that it changes."""
        if not (count if shown is None else len(shown)):
            return state
        if shown is not None:
            args = [self._there(arg, shown, count) for arg in args]
        given = Given(self.program, self.pool, name, args, count)
        differing = given.texts()
        if differing:
            return self._by_text(name, differing[0], given, state, shown)
        fast = FAST.get(name)
        with self._telling():
            if fast is not None:
                made = fast(given, state)
                if made is not None:
                    return {**state, **made}
            return self._solid(given, state, shown)

    def _by_text(self, name: str, place: int, given: Given, state: State, shown: Rows) -> State:
        """The same where shapes give different words: one after the other."""
        made, own = dict(state), full(given.args[place], given.count)
        for value in distinct(own if shown is None else own[shown])[0].tolist():
            rows = np.flatnonzero(own == value)
            if shown is not None:
                rows = shown[own[shown] == value]
            args = [*given.args[:place], value, *given.args[place + 1 :]]
            part = self.solid(name, given.count, args, state, rows)
            mask = self.mask(rows, given.count)
            made = {field: np.where(mask, part[field], made[field]) for field in made}
        return made

    def _there(self, arg: Column, shown: Numbers, count: int) -> Column:
        """An argument; rows that are not there may hold anything, and take that of one that is."""
        if not isinstance(arg, np.ndarray) or not arg.ndim:
            return arg
        return np.where(self.mask(shown, count), arg, arg[shown[0]])

    def _solid(self, given: Given, state: State, shown: Rows) -> State:
        """The same where geometries must be worked on; nothing comes of nothing."""
        count = given.count
        shown = self.some(state["geo"], count, shown)
        if shown is not None and not len(shown):
            return state
        world = boxes.world_axes(state, count, given.world) if given.world else np.zeros((count, 0))
        sizes = [state[name] for name in SIZES]
        kinds = table(shown, count, state["geo"], *sizes, *world.T, *given.args)
        rows = np.stack([column[kinds.first] for column in kinds.columns], axis=1)
        ways = rows[:, 4 : 4 + world.shape[1]]
        values = [given.resolved(row) for row in rows[:, 4 + world.shape[1] :].tolist()]
        solids = self.pool.all_local(rows[:, 0].astype(int).tolist(), rows[:, 1:4])
        pieces = [
            Piece(frozenset(), each.solid, each.axes)
            for each in shaped(given.name, solids, ways, values)
        ]
        made = framed(self.pool, pieces)
        found = np.concatenate([made.corner, made.turn, made.size, made.geometry[:, None]], axis=1)
        blank = np.array((*np.zeros(3), 1.0, *np.zeros(7)))
        own = kinds.spread(found, blank, count)
        changed: State = dict(boxes.moved(state, (own[:, 0], own[:, 1], own[:, 2])))
        if given.turns:
            changed.update(boxes.turned(state, tuple(own[:, 3:7].T)))
        changed.update(zip((*SIZES, "geo"), own[:, 7:].T, strict=True))
        if shown is not None:
            there = self.mask(shown, count)
            changed.update((name, np.where(there, changed[name], state[name])) for name in SIZES)
        return {**state, **changed}

    def center(
        self, _: str, count: int, args: Sequence[Column], state: State, base: State
    ) -> State:
        """Scopes moved to the middle of others, along the axes named."""
        given = Given(self.program, self.pool, "center", args, count)
        kinds, place = distinct(np.asarray(args[0], np.float64))
        with self._telling():
            words = [str(given.resolved([each])[0]) for each in kinds.tolist()]
        middles = [
            boxes.moved(each, tuple(each[name] * 0.5 for name in SIZES))  # type: ignore[arg-type]
            for each in (state, base)
        ]
        apart = tuple(middles[1][axis] - middles[0][axis] for axis in AXES)
        w, i, j, k = (state[axis] for axis in ROTATION)
        scale = np.abs(state["scale"]) if "scale" in state else 1.0
        back = boxes.rotated((w, -i, -j, -k), apart)
        local = (back[0] * boxes.hand(state) / scale, back[1] / scale, back[2] / scale)
        chosen = ([float(axis in word) for word in words] for axis in AXES)
        shape = np.shape(args[0])
        step = tuple(
            by * (np.array(own)[place.reshape(shape)] if shape else own[0])
            for own, by in zip(chosen, local, strict=True)
        )
        return boxes.moved(state, step)  # type: ignore[arg-type]

    # ------------------------------------------------------------------------- parts

    def pieces(
        self,
        name: str,
        selectors: Sequence[ir.Const],
        count: int,
        args: Sequence[Column],
        state: State,
        keys: Keys,
        shown: Rows,
    ) -> list[Batched]:
        """The parts that an operation makes, in a batch for each selector."""
        given = Given(self.program, self.pool, name, args, count)
        if name in AHEAD:
            many = AHEAD[name](given)
            self.counted.copy(float((many if shown is None else many[shown]).sum()))
        with self._telling():
            made = apart(Apart(given, selectors, state, keys, shown))
        self.counted.copy(float(sum(len(each.owner) for each in made)))
        return made

    # ---------------------------------------------------------------------- measuring

    def measure(self, what: str, sx: Column, sy: Column, sz: Column, geometry: Column) -> Column:
        """The area, the volume or the number of sides of geometries."""
        if np.all(np.asarray(geometry) <= BOX):
            return np.where(np.asarray(geometry) > 0, _measured_box(what, sx, sy, sz), 0.0)
        count = max(np.size(each) for each in (sx, sy, sz, geometry))
        kinds = table(None, count, geometry, sx, sy, sz)
        found = np.array([
            [_measured(what, self.pool.local(int(number), np.array(size)))] if number else [0.0]
            for number, *size in kinds.rows()
        ])  # fmt: skip
        return kinds.spread(found, np.zeros(1), count)[:, 0]

    def lay(
        self,
        name: str,
        count: int,
        args: Sequence[Column],
        parent: Column,
        state: Mapping[str, Column],
        shown: Rows,
    ) -> Column:
        """How textures lie on what follows in every row of a batch; the numbers of that."""
        plane = "xy"
        if name == SETUP:
            plane = Given(self.program, self.pool, name, args, count).word(0) or plane
            args = args[1:]
        if shown is not None:  # rows that are not there may hold anything
            there = self.mask(shown, count)
            args = [np.where(there, arg, 1.0) for arg in args]
            parent = np.where(there, parent, READY)
        try:
            return self.laying.begin(name, count, args, parent, state, plane)
        except LayingError as error:
            raise self.counted.error("bad-projection", error.message, hint=error.hint) from error

    def report(self, count: int, args: Sequence[Column], shown: Rows) -> None:
        """Add to the sums under keys."""
        keys, values = full(args[0], count), full(args[1], count)
        if shown is not None:
            keys, values = keys[shown], values[shown]
        for number in distinct(keys)[0].tolist():
            key = self.program.strings[int(number)]
            self.reports.values.setdefault(key, []).append(values[keys == number])

    # ------------------------------------------------------------------------ trouble

    def _tried(self, make: Callable[[], object]) -> object:
        with self._telling():
            return make()

    @contextmanager
    def _telling(self) -> Iterator[None]:
        """Whatever geometry cannot be made is an error of the rule that asks for it."""
        try:
            with computing():
                yield
        except GeometryError as error:
            raise self._failed(error) from error

    def _failed(self, error: GeometryError) -> Exception:
        return self.counted.error("bad-geometry", error.message, hint=error.hint)


def _narrowed(shown: Rows, there: NDArray[np.bool_]) -> Rows:
    """The rows that are there, of those shown."""
    if there.all():
        return shown
    return np.flatnonzero(there) if shown is None else shown[there[shown]]


def _measured_box(what: str, sx: Column, sy: Column, sz: Column) -> Column:
    if what == "volume":
        return sx * sy * sz
    if what == "sides":
        return np.where((np.asarray(sx) > 0) & (np.asarray(sy) > 0) & (np.asarray(sz) > 0), 24, 4)
    solid = (np.asarray(sx) > 0) & (np.asarray(sy) > 0) & (np.asarray(sz) > 0)
    once = sx * sy + sy * sz + sx * sz
    return np.where(solid, 2.0 * once, once)


def _measured(what: str, solid: Solid) -> float:
    from ipmlang.geometry.solid import area, is_closed, volume

    if what == "area":
        return area(solid)
    if what == "sides":
        return float(len(solid.corners))
    return volume(solid) if is_closed(solid) else 0.0
