"""How texture coordinates run over scopes, and slabs along them.

In go columns of a batch with what says how textures lie, out come for each shape the axis of its
scope that a texture coordinate runs along, and how much it changes there a unit of length. Where
there is no such axis an error says why. No image is known here.
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
from ipmlang.runtime.scopes.pool import NOTHING
from ipmlang.runtime.scopes.scoping import Floats, Rows, Scoping
from ipmlang.runtime.scopes.tables import distinct

NEAR = 1e-6  # of a change: what is less across an axis is none
FITS = (
    1e-5  # of the range of a mesh's texture coordinates: they are even if no corner is further off
)
UPRIGHT = 0.9999  # the cosine from which on a face is straight on a side of the box
HINT = (
    "split one side, as comp { front: … } gives it, or lay the texture onto a plane: "
    "setupProjection(xz, 2, 1) projectUV"
)


class Unwrapping(Scoping):
    """The part of a run that knows how texture coordinates run."""

    def unwrapped(self, what: str, count: int, state: Mapping[str, Column], shown: Rows) -> Column:
        """Of the coordinate u or v: `u axis` is the number of the axis of the scope that it runs
        along, `u step` its change a unit of length there, negative where it runs back; (count,).
        """
        name, wanted = what.split()
        rows = np.arange(count) if shown is None else shown
        own = {field: full(value, count)[rows] for field, value in state.items()}
        change = self._changes("uv".index(name), own)
        size = np.stack([own[field] for field in SIZES], axis=1)
        change = np.where(size > 0, change, 0.0)
        change[own["geo"] == NOTHING] = (1.0, 0.0, 0.0)  # nothing is cut there
        axis = np.argmax(np.abs(change), axis=1)
        step = np.take_along_axis(change, axis[:, None], axis=1)[:, 0]
        self._check_axis(name, change, step, rows)
        found = np.zeros(count) if wanted == "axis" else np.ones(count)
        found[rows] = axis if wanted == "axis" else step
        return found

    def _check_axis(self, name: str, change: Floats, step: Floats, rows: Rows) -> None:
        """Stop at a coordinate that does not change, or not along one axis alone."""
        assert rows is not None
        still = np.flatnonzero(~(np.abs(step) > 0))
        if len(still):
            raise self.counted.error(
                "no-texture-axis", f"`split {name}` stands where {name} is the same all over",
                hint="lay a texture that changes along the shape", row=int(rows[still[0]]),
            )  # fmt: skip
        across = np.sort(np.abs(change), axis=1)[:, 1] > NEAR * np.abs(step)
        if across.any():
            raise self.counted.error(
                "no-texture-axis",
                f"`split {name}` stands where {name} runs aslant over the scope",
                hint="turn the scope along the texture, or the texture along the scope",
                row=int(rows[np.argmax(across)]),
            )

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
        axis: Column,
        count: int,
        low: Column,
        size: Column,
        state: Mapping[str, Column],
        shown: Rows,
    ) -> tuple[Rows, State]:
        """The parts between two planes across axes that differ from row to row: which rows have
        any, and the places, sizes and geometries of these.
        """
        axes = full(axis, count)
        rows = np.arange(count) if shown is None else shown
        fields = (*boxes.AXES, *SIZES, "geo")
        changed = {name: np.array(full(state[name], count)) for name in fields}
        there = np.zeros(count, np.bool_)
        for number in distinct(axes[rows])[0].astype(np.int64).tolist():
            own = rows[axes[rows] == number]
            part = {name: full(value, count)[own] for name, value in state.items()}
            left, begin, extent, geometry = self.slab(
                number, len(own), full(low, count)[own], full(size, count)[own],
                part["sx"], part["sy"], part["sz"], part["geo"], None,
            )  # fmt: skip
            step: list[Column] = [0.0, 0.0, 0.0]
            step[number] = begin
            part.update(boxes.moved(part, (step[0], step[1], step[2])))
            part.update({SIZES[number]: extent, "geo": geometry})
            for name in fields:
                changed[name][own] = part[name]
            there[own if left is None else own[left]] = True
        whole = shown is None and bool(there.all())
        return None if whole else np.flatnonzero(there), dict(changed)


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
