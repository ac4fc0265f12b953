"""How texture coordinates run over scopes, and slabs along them.

In go columns of a batch with what says how textures lie, out come for each shape the axis of its
scope that a texture coordinate runs along, and how much it changes there a unit of length; one that
runs aslant is followed as it is. Where it does not run evenly an error says why. No image is known
here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ipmlang.geometry.solid import Solid, normals
from ipmlang.runtime.code import Column
from ipmlang.runtime.scene import TextureMaps
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import SIZES, State, full
from ipmlang.runtime.scopes.laying import FIELD
from ipmlang.runtime.scopes.pool import NOTHING, SNAP
from ipmlang.runtime.scopes.scoping import Floats, Rows, Scoping
from ipmlang.runtime.scopes.tables import distinct, table

ASLANT = 3  # stands for no axis of the scope
NEAR = 1e-6  # of a change: what is less across an axis is none
FITS = 1e-5  # of the range of a mesh's coordinates: how far off they may be where they are even
UPRIGHT = 0.9999  # the cosine from which on a face is straight on a side of the box
HINT = (
    "split one side, as comp { front: … } gives it, or lay the texture onto a plane: "
    "setupProjection(xz, 2, 1) projectUV"
)


class Unwrapping(Scoping):
    """The part of a run that knows how texture coordinates run."""

    def unwrapped(self, what: str, count: int, state: Mapping[str, Column], shown: Rows) -> Column:
        """Of the coordinate u or v: `u axis` is the number of the axis of the scope that it runs
        along, or 3 where it runs aslant; `u step` its change a unit of length there, negative where
        it runs back, and 1 for what is aslant; `u length` how far that goes; (count,).
        """
        name, wanted = what.split()
        rows = np.arange(count) if shown is None else shown
        own = {field: full(value, count)[rows] for field, value in state.items()}
        change = self._runs(name, own)
        still = np.flatnonzero(~change.any(axis=1))
        if len(still):
            raise self.counted.error(
                "no-texture-axis", f"`split {name}` stands where {name} is the same all over",
                hint="lay a texture that changes along the shape", row=int(rows[still[0]]),
            )  # fmt: skip
        axis, step = _along(change)
        found = np.zeros(count) if wanted == "axis" else np.ones(count)
        if wanted == "length":
            aslant = np.flatnonzero(axis == ASLANT)
            found[rows[aslant]] = self._lengths(
                {field: value[aslant] for field, value in own.items()}, change[aslant]
            )
        else:
            found[rows] = axis if wanted == "axis" else step
        return found

    def _runs(self, name: str, state: Mapping[str, Floats]) -> Floats:
        """How u or v changes a unit of length along the axes that scopes have an extent in (n, 3);
        along x where nothing is.
        """
        size = np.stack([state[field] for field in SIZES], axis=1)
        change = np.where(size > 0, self._changes("uv".index(name), state), 0.0)
        change[state["geo"] == NOTHING] = (1.0, 0.0, 0.0)
        return change

    def _lengths(self, state: Mapping[str, Floats], change: Floats) -> Floats:
        """From where to where a coordinate goes that changes so (n, 3) over shapes (n,)."""
        size = np.stack([state[field] for field in SIZES], axis=1)
        steps = np.abs(change) * size
        found: Floats = steps[:, 0] + steps[:, 1] + steps[:, 2]
        others = np.flatnonzero(~self.pool.are_boxes(state["geo"]) & (state["geo"] != NOTHING))
        if len(others):
            kinds = table(others, len(change), state["geo"], *size.T, *change.T)
            own = np.zeros((len(kinds.first), 1))
            for place, (number, *values) in enumerate(kinds.rows()):
                solid = self.pool.local(int(number), np.array(values[:3]))
                own[place] = np.ptp(solid.vertices @ np.array(values[3:]))
            found[others] = kinds.spread(own, np.zeros(1), len(change))[others, 0]
        return found

    def _changes(self, which: int, state: Mapping[str, Floats]) -> Floats:
        """How u or v changes a unit of length along the axes of scopes (n, 3)."""
        carried = state.get(FIELD, np.full(len(state["sx"]), -1.0))
        maps = self.laying.now(carried)
        projected = maps.projected[maps.of]
        found = np.zeros((len(projected), 3))
        for chosen, changes in ((projected, _projected), (~projected, self._on_sides)):
            rows = np.flatnonzero(chosen)
            if len(rows):
                own = {name: value[rows] for name, value in state.items()}
                base = changes(own, maps, maps.of[rows])
                map_ = maps.map[maps.of[rows], which, :2]
                found[rows] = map_[:, :1] * base[:, 0] + map_[:, 1:] * base[:, 1]
        return found

    def _on_sides(self, state: Mapping[str, Floats], maps: TextureMaps, of: np.ndarray) -> Floats:
        """How u and v change (n, 2, 3) on what has coordinates of its own, or one side."""
        size = np.stack([state[name] for name in SIZES], axis=1)
        none = size <= 0
        flat = np.where(none.any(axis=1), np.argmax(none, axis=1), -1)
        code = state["geo"].astype(np.int64) * 4 + flat + 1
        codes, kind = distinct(np.where(state["geo"] == NOTHING, NOTHING, code))
        units = [self._unit(each >> 2, (each & 3) - 1) for each in codes.tolist()]
        unit = np.stack([each for each, _ in units])[kind]
        own = np.array([each for _, each in units])[kind]
        found: Floats = unit / np.where(none, 1.0, size)[:, None, :]
        tile = maps.tile[of]
        tiled = ~np.isnan(tile[:, 0]) & ~own
        scale = np.abs(state.get("scale", np.ones(len(size))))
        lengths = unit[tiled] * scale[tiled][:, None, None] / tile[tiled][:, :, None]
        found[tiled] = lengths
        return found

    def _unit(self, number: int, flat: int) -> tuple[Floats, bool]:
        """How u and v change (2, 3) over the unit box of a geometry, and whether it brings them."""

        def make() -> tuple[Floats, bool]:
            if number == NOTHING:
                return np.zeros((2, 3)), False
            solid = self.pool.unit(number, None if flat < 0 else flat)
            if solid.uv is not None and solid.uv.any():
                return self._fitted(solid, solid.uv), True
            looks = normals(solid)[:, flat]
            if flat < 0 or (np.abs(looks) < UPRIGHT).any():
                raise self._uneven("has more than one side, and each has its own")
            if (looks < 0).any() and (looks > 0).any():
                raise self._uneven("is seen from two sides, and each has its own")
            return _side(flat, bool((looks < 0).all())), False

        found = self.pool.derived(("unwrapped", number, flat), make)
        assert isinstance(found, tuple)
        return found

    def _fitted(self, solid: Solid, uv: Floats) -> Floats:
        """How the coordinates of a mesh change over its unit box."""
        points = np.c_[solid.vertices[solid.corners], np.ones(len(solid.corners))]
        found = np.linalg.lstsq(points, uv, rcond=1e-9)[0]
        if (np.abs(points @ found - uv) > FITS * np.ptp(uv, axis=0).max()).any():
            raise self._uneven("brings some that do not run evenly")
        return np.asarray(found[:3].T, np.float64)

    def _uneven(self, why: str) -> Exception:
        message = f"`split` along texture coordinates: the shape {why}"
        return self.counted.error("no-texture-axis", message, hint=HINT)

    def slab_along(
        self,
        name: str,
        axis: Column,
        count: int,
        low: Column,
        size: Column,
        state: Mapping[str, Column],
        shown: Rows,
    ) -> tuple[Rows, State]:
        """The parts between two planes across axes that differ from row to row, or across u or v:
        which rows have any, and the places, sizes and geometries of these.
        """
        axes = full(axis, count)
        rows = np.arange(count) if shown is None else shown
        fields = (*boxes.AXES, *SIZES, "geo")
        changed = {name: np.array(full(state[name], count)) for name in fields}
        there = np.zeros(count, np.bool_)
        for number in distinct(axes[rows])[0].astype(np.int64).tolist():
            own = rows[axes[rows] == number]
            part = {name: full(value, count)[own] for name, value in state.items()}
            lows, lengths = full(low, count)[own], full(size, count)[own]
            cut = self._aslant(name, lows, lengths, part) if number == ASLANT else (
                self._across(number, lows, lengths, part)
            )  # fmt: skip
            left = cut[0]
            part.update(cut[1])
            for field in fields:
                changed[field][own] = part[field]
            there[own if left is None else own[left]] = True
        whole = shown is None and bool(there.all())
        return None if whole else np.flatnonzero(there), dict(changed)

    def _across(self, axis: int, low: Floats, size: Floats, state: State) -> tuple[Rows, State]:
        """The parts (n,) of scopes across one of their axes."""
        shown, begin, extent, geometry = self.slab(
            axis, len(low), low, size, state["sx"], state["sy"], state["sz"], state["geo"], None
        )
        step: list[Column] = [0.0, 0.0, 0.0]
        step[axis] = begin
        place = boxes.moved(state, (step[0], step[1], step[2]))
        return shown, {**place, SIZES[axis]: extent, "geo": geometry}

    def _aslant(
        self, name: str, low: Floats, size: Floats, state: Mapping[str, Floats]
    ) -> tuple[Rows, State]:
        """The parts (n,) of scopes between two values of a coordinate that runs aslant, counted
        from where it is least. Each has the box of its geometry.
        """
        change = self._runs(name, state)
        fits = size > SNAP * self._lengths(state, change)
        there = np.flatnonzero(fits)
        self.missed(size[~fits])
        sizes = [state[field] for field in SIZES]
        kinds = table(there, len(size), state["geo"], *sizes, *change.T, low, size)
        found = np.zeros((len(kinds.first), 7))
        for place, (number, *values) in enumerate(kinds.rows()):
            found[place] = self._between(int(number), np.array(values))
        own = kinds.spread(found, np.zeros(7), len(size))
        moved = boxes.moved(dict(state), (own[:, 0], own[:, 1], own[:, 2]))
        moved.update(zip((*SIZES, "geo"), own[:, 3:].T, strict=True))
        return np.flatnonzero(own[:, 6] != NOTHING), moved

    def _between(self, number: int, values: Floats) -> Floats:
        """Corner, size and geometry (7,) of the part of a geometry between two values."""

        def make() -> tuple[int, Floats, Floats]:
            from ipmlang.geometry.slicing import sliced

            solid = self.pool.local(number, values[:3])
            steep = float(np.sqrt(values[3:6] @ values[3:6]))
            x, y, z = (values[3:6] / steep).tolist()
            heights = solid.vertices @ np.array((x, y, z))
            low = float(values[6]) / steep
            planes = [low, low + float(values[7]) / steep]
            (part,) = sliced(solid, heights - heights.min(), planes, (x, y, z))
            if part is None or not len(part):
                return NOTHING, np.zeros(3), np.zeros(3)
            return self.pool.add(part)

        made = self.pool.derived(("aslant", number, values.tobytes()), lambda: self._tried(make))
        assert isinstance(made, tuple)
        geometry, corner, size = made
        return np.array([*corner, *size, geometry])


def _along(change: Floats) -> tuple[Floats, Floats]:
    """The axis (n,) that a coordinate runs along which changes so (n, 3), and its change there."""
    size = np.abs(change)
    axis = np.argmax(size, axis=1)
    step = np.take_along_axis(change, axis[:, None], axis=1)[:, 0]
    aslant = np.sort(size, axis=1)[:, 1] > NEAR * np.abs(step)
    return np.where(aslant, ASLANT, axis).astype(np.float64), np.where(aslant, 1.0, step)


def _projected(state: Mapping[str, Floats], maps: TextureMaps, of: np.ndarray) -> Floats:
    """How u and v change (n, 2, 3) along the axes of scopes, where a plane in space lays them."""
    from ipmlang.runtime.export.placing import rotation_matrices

    linear = rotation_matrices(maps.rotation[of])  # of the plane's frame: columns are its axes
    linear[:, :, 0] *= maps.hand[of][:, None]
    turn = np.stack([state[name] for name in boxes.ROTATION], axis=1)
    own = rotation_matrices(turn / np.linalg.norm(turn, axis=1, keepdims=True))
    scale = state.get("scale", np.ones(len(own)))
    own *= np.abs(scale)[:, None, None]
    own[:, :, 0] *= np.sign(scale)[:, None]
    found = np.einsum("nij,nik->njk", linear, own)  # rows: axes of the plane's frame
    rows = np.take_along_axis(found, maps.plane[of][:, :, None], axis=1)
    laid: Floats = rows / maps.tile[of][:, :, None]
    return laid


def _side(flat: int, back: bool) -> Floats:
    """How u and v change over the side of a box across an axis, as it is seen from outside."""
    from ipmlang.runtime.export.sides import side_axes

    u, v, u_back, v_back = side_axes(flat, not back)
    found = np.zeros((2, 3))
    found[0, u], found[1, v] = 1.0 - 2.0 * u_back, 1.0 - 2.0 * v_back
    return found
