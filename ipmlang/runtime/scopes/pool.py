"""The geometries of one derivation: each once, in the unit box of its scope, under a number.

In go solids in the coordinates of a scope, out come numbers that shapes carry in a column, with the
box that the solid fills. Geometry that fills its scope as a box or a rectangle is marked so, since
all of its operations are arithmetic on columns. No shape is known here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import (
    Floats,
    Solid,
    alike,
    area_vectors,
    bounds,
    placed,
    reshaped,
    tagged,
    unit_box,
    unit_square,
)
from ipmlang.runtime.scene import SCOPE, SOLID
from ipmlang.runtime.scopes.tables import distinct

NOTHING, BOX = 0, 1  # numbers that are always the same: no geometry, and all of the scope
SNAP = 1e-9  # of a geometry's size: extents below are none, corners this near are the scope's
FEW = 8  # numbers that are quicker looked up one by one

Columns = tuple[NDArray[np.bool_], NDArray[np.int32], NDArray[np.bool_]]
Load = Callable[[int], Solid]
Key = object  # that two geometries have in common which are one


class Pool:
    """Numbers for solids. `load` reads the geometry of an asset, by its number."""

    def __init__(self, load: Load) -> None:
        self._load = load
        self._solids: list[Solid | None] = [None, None]
        self._numbers: dict[object, int] = {}
        self._kinds: list[int] = [SCOPE, SCOPE]
        self._boxes: list[bool] = [False, True]
        self._flat: dict[int, bool] = {}
        self._derived: dict[object, object] = {}
        self._bounds: dict[int, tuple[Floats, Floats]] = {}
        self._columns: Columns | None = None

    # ------------------------------------------------------------------------- asking

    def are_boxes(self, numbers: float | Floats) -> NDArray[np.bool_]:
        """Which geometries fill their scope, () or (n,)."""
        found: NDArray[np.bool_] = self._tables()[0][np.asarray(numbers).astype(np.int64)]
        return found

    def are_tagged(self, numbers: float | Floats) -> NDArray[np.bool_]:
        """Which geometries are boxes whose faces bear tags of their own, () or (n,)."""
        found: NDArray[np.bool_] = self._tables()[2][np.asarray(numbers).astype(np.int64)]
        return found

    def are_flat(self, numbers: float | Floats) -> NDArray[np.bool_]:
        """Which geometries are polygons across z that do not fill their scope, () or (n,)."""
        if np.size(numbers) <= FEW:
            own = np.ravel(numbers).tolist()
            few = np.array([self.is_flat(int(number)) for number in own], np.bool_)
            return few.reshape(np.shape(numbers))
        kinds, place = distinct(np.asarray(numbers))
        flat = np.array([self.is_flat(int(number)) for number in kinds.tolist()], np.bool_)
        return flat[place].reshape(np.shape(numbers))

    def is_flat(self, number: int) -> bool:
        """The same of one geometry."""
        if number not in self._flat:
            solid = self._solids[number]
            self._flat[number] = not self._boxes[number] and solid is not None and _is_across(solid)
        return self._flat[number]

    @property
    def only_boxes(self) -> bool:
        """Whether there is no geometry but what fills its scope."""
        return all(kind == SCOPE for kind in self._kinds)

    def kinds(self, numbers: Floats) -> NDArray[np.int32]:
        """What terminals of these geometries are drawn as (n,): SCOPE, SOLID or an asset."""
        found: NDArray[np.int32] = self._tables()[1][numbers.astype(np.int64)]
        return found

    def solids(self) -> tuple[Solid, ...]:
        """All geometries in unit boxes, by number."""
        blank = unit_square()
        return tuple(blank if each is None else each for each in self._solids)

    def tags(self, number: int) -> tuple[frozenset[str], ...]:
        """The tags of a box's faces, in the order of `unit_box`; none for a plain one."""
        solid = self._solids[number]
        return () if solid is None else solid.tags

    def unit(self, number: int, flat: int | None) -> Solid:
        """A geometry in its unit box; `flat`: the axis along which its scope has no extent."""
        if self._kinds[number] >= 0:
            return self._unit_asset(self._kinds[number])
        solid = self._solids[number]
        if not self._boxes[number]:
            assert solid is not None
            return solid
        made = _filling(flat)
        if solid is not None and len(solid) == len(made):
            return replace(made, tags=solid.tags)
        if solid is not None and solid.tags:
            return tagged(made, *frozenset.intersection(*solid.tags))
        return made

    def local(self, number: int, size: Floats) -> Solid:
        """A geometry in the coordinates of a scope of this size (3,)."""
        return self.all_local([number], size[None])[0]

    def all_local(self, numbers: Sequence[int], sizes: Floats) -> list[Solid]:
        """Geometries in the coordinates of scopes of these sizes (n, 3)."""
        none = sizes <= 0
        many, first = none.sum(axis=1).tolist(), none.argmax(axis=1).tolist()
        found = []
        for number, size, lost, axis in zip(numbers, sizes, many, first, strict=True):
            if lost > 1 and self._boxes[number]:
                found.append(placed(unit_square(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
                continue
            solid = self.unit(number, axis if lost else None)
            found.append(reshaped(solid, solid.vertices * size))
        return found

    def asset_bounds(self, asset: int) -> tuple[Floats, Floats]:
        """The box of an asset's geometry, as its file has it."""
        if asset not in self._bounds:
            self._bounds[asset] = bounds(self._load(asset))
        return self._bounds[asset]

    def as_file(self, asset: int) -> Solid:
        """An asset's geometry, as its file has it."""
        return self._load(asset)

    def derived(self, key: object, make: Callable[[], object]) -> object:
        """What follows from geometries, computed once."""
        if key not in self._derived:
            self._derived[key] = make()
        return self._derived[key]

    # ------------------------------------------------------------------------- adding

    def add(self, solid: Solid) -> tuple[int, Floats, Floats]:
        """The number of a solid, and the corner and size of its box."""
        low, high = bounds(solid)
        size = high - low
        size[size <= SNAP * size.max()] = 0.0
        return self.within(solid, low, size), low, size

    def within(self, solid: Solid, low: Floats, size: Floats) -> int:
        """The number of a solid whose scope is the box of this corner and size."""
        return int(self.all_within([solid], low[None], size[None])[0])

    def all_within(self, solids: Sequence[Solid], low: Floats, size: Floats) -> Floats:
        """The numbers (n,) of solids whose scopes are boxes of these corners and sizes (n, 3)."""
        units: list[tuple[Solid, Key, bool]] = [(each, b"", False) for each in solids]
        for made, places, vertices in alike(solids):
            vertices -= low[places, None]
            own = size[places, None]
            vertices /= np.where(own > 0, own, 1.0)
            for bound in (0.0, 1.0):
                vertices[np.abs(vertices - bound) <= SNAP] = bound
            vertices[np.broadcast_to(own <= 0, vertices.shape)] = 0.0
            rounded = np.round(vertices, 9)
            whole = ((vertices == 0.0) | (vertices == 1.0)).all(axis=(1, 2)).tolist()
            for row, place in enumerate(places):
                solid = solids[place]
                uv = b"" if solid.uv is None else solid.uv.tobytes()
                unit = reshaped(solid, vertices[row])
                units[place] = (unit, (rounded[row].tobytes(), made, uv), whole[row])
        sizes = zip(units, size, strict=True)
        return np.array([self._unit(*each, own) for each, own in sizes], np.float64)

    def _unit(self, unit: Solid, key: Key, at_bounds: bool, size: Floats) -> int:
        """The number of a solid in its unit box; `at_bounds`: all its vertices are at corners."""
        if not len(unit):
            return NOTHING
        box = self._as_box(unit, size) if at_bounds else None
        return self._number(key, unit, SOLID, box=False) if box is None else box

    def asset(self, asset: int) -> int:
        """The number of an asset that fills its scope."""
        return self._number(("asset", asset), None, asset, box=False)

    def box(self, tags: tuple[frozenset[str], ...]) -> int:
        """The number of a box, or of a rectangle, whose faces bear tags."""
        if not any(tags):
            return BOX
        found = self._numbers.get(("box", tags))
        if found is not None:
            return found
        made = unit_box() if len(tags) == 6 else unit_square()
        return self._number(("box", tags), replace(made, tags=tags), SCOPE, box=True)

    def _number(self, key: object, solid: Solid | None, kind: int, *, box: bool) -> int:
        found = self._numbers.get(key)
        if found is None:
            found = self._numbers[key] = len(self._solids)
            self._solids.append(solid)
            self._kinds.append(kind)
            self._boxes.append(box)
            self._columns = None
        return found

    def _as_box(self, unit: Solid, size: Floats) -> int | None:
        """The number of a solid that is a whole box or rectangle, without texture coordinates; all
        its vertices are at corners of the unit box.
        """
        flat = np.flatnonzero(size <= 0)
        shape = (len(flat), len(unit), len(unit.corners))
        if unit.uv is not None or shape not in ((1, 1, 4), (0, 6, 24)):
            return None
        if len(flat):
            return self._as_rectangle(unit, int(flat[0]))
        own = _box_faces(unit)
        if own is None:
            return None
        return self.box(tuple(unit.tags[face] for face in own))

    def _as_rectangle(self, unit: Solid, flat: int) -> int | None:
        points = unit.vertices[unit.corners].tolist()
        u, v = {0: (1, 2), 1: (0, 2), 2: (0, 1)}[flat]  # the axes of `_rectangle`, in its order
        across = [(point[u], point[v]) for point in points]
        (a, b), (c, d), (e, f), _ = across
        turn = (c - a) * (f - d) - (d - b) * (e - c)
        return self.box(unit.tags) if len(set(across)) == 4 and turn > 0.5 else None

    def _unit_asset(self, asset: int) -> Solid:
        def make() -> Solid:
            low, high = self.asset_bounds(asset)
            size = np.where(high > low, high - low, 1.0)
            return placed(self._load(asset), 1.0 / size, -low / size)

        made = self.derived(("asset", asset), make)
        assert isinstance(made, Solid)
        return made

    def _tables(self) -> Columns:
        """Of each geometry whether it fills its scope, what it is drawn as, whether it is a box
        whose faces bear tags.
        """
        if self._columns is None:
            tagged = [
                box and solid is not None and len(solid) == 6
                for box, solid in zip(self._boxes, self._solids, strict=True)
            ]
            kinds = np.array(self._kinds, np.int32)
            self._columns = (np.array(self._boxes), kinds, np.array(tagged))
        return self._columns


def _is_across(solid: Solid) -> bool:
    """Whether all faces lie across z and look up."""
    if not len(solid) or solid.vertices[:, 2].any():
        return False
    return bool((area_vectors(solid)[:, 2] > 0).all())


@cache
def _filling(flat: int | None) -> Solid:
    """What fills a scope: a box, or a rectangle where there is an axis without extent."""
    return unit_box() if flat is None else _rectangle(flat)


def _rectangle(flat: int) -> Solid:
    """The unit square across an axis: facing up, to the front (-y), or to the right (+x)."""
    square = unit_square()
    x, y, zero = square.vertices.T
    columns = {0: (zero, x, y), 1: (x, zero, y), 2: (x, y, zero)}[flat]
    return replace(square, vertices=np.stack(columns, axis=1))


def _box_faces(unit: Solid) -> list[int] | None:
    """The faces of a box in the order of `unit_box`; None if it is not one, or inside out."""
    from ipmlang.geometry.solid import normals

    expected = normals(unit_box())
    own = normals(unit)
    found = []
    for each in expected:
        facing = np.flatnonzero(own @ each > 0.5)
        if len(facing) != 1:
            return None
        found.append(int(facing[0]))
    return found
