"""What the shapes and terminals of a tree are: their names, frames and boxes, and what is in them.

In goes a derivation tree, out come answers about its units, each worked out once as long as this
lives: an edit asks the same of equal parts again and again. Nothing is written down or decided.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache as remember
from typing import Literal, TypeAlias

import numpy as np

from ipmlang.edit.buildings.placements import Maps, maps_of
from ipmlang.edit.buildings.tree import Tree
from ipmlang.inverse.frames import Floats, Frames, compose, from_matrices, identity, inverse, linear
from ipmlang.runtime.scene import SCOPE

Unit: TypeAlias = tuple[Literal["shape", "terminal"], int]
BOX = 1  # the geometry that is the whole scope
MANY = 100  # frames besides those of units, after which nothing is known any more
SQUARE = 1e-7  # how far axes may be off that are the same


@dataclass(frozen=True, slots=True, eq=False)
class Inside:
    """A part of a shape in the axes of a frame: its frame there, low corner (3,) and, along its own
    axes, its size (3,); turned (3, 3): its axes there, as columns without signs; square: it keeps
    them.
    """

    unit: Unit
    frame: Frames
    corner: Floats
    size: Floats
    turned: Floats
    square: bool


@dataclass(slots=True, eq=False)
class Measured:
    """The units of one tree. Frames that are asked about again shall be the same objects."""

    tree: Tree
    _frames: dict[Unit, Frames] = field(default_factory=dict)
    _uprights: dict[bytes, Frames] = field(default_factory=dict)
    _fills: dict[Unit, bool] = field(default_factory=dict)
    _maps: dict[int, tuple[Frames, Maps]] = field(default_factory=dict)
    _turned: dict[tuple[Unit, int], tuple[Floats, list[bool]]] = field(default_factory=dict)
    _points: dict[tuple[Unit, int], Floats] = field(default_factory=dict)
    _axes: dict[tuple[Unit, int], Floats] = field(default_factory=dict)

    def name(self, unit: Unit) -> str:
        """The symbol of a shape, the label of a terminal."""
        kind, row = unit
        return self.tree.names[row] if kind == "shape" else self.tree.terminals.labels[row]

    def owner(self, unit: Unit) -> int:
        """The shape that made a unit."""
        kind, row = unit
        return self.tree.parents[row] if kind == "shape" else self.tree.owners[row]

    def rows(self, unit: Unit) -> list[int]:
        """The terminals of a unit."""
        return [unit[1]] if unit[0] == "terminal" else self.tree.below(unit[1])

    def frame(self, unit: Unit) -> Frames:
        """The frame of a unit, one row."""
        if unit not in self._frames:
            kind, row = unit
            one = self.tree.frames if kind == "shape" else self.tree.terminals.frames
            found = self._frames[unit] = one[row : row + 1]
            self._maps[id(found)] = found, self.tree.maps[kind][row]
        return self._frames[unit]

    def maps(self, frame: Frames) -> Maps:
        """A frame as maps of points."""
        if id(frame) not in self._maps:
            self._maps[id(frame)] = frame, maps_of(frame)[0]
        return self._maps[id(frame)][1]

    def upright(self, axes: Floats) -> Frames:
        """The frame at the origin with these axes, rows of (3, 3)."""
        key = axes.tobytes()
        if key not in self._uprights:
            matrix = np.concatenate([axes.T, np.zeros((3, 1))], axis=1)
            self._uprights[key] = from_matrices(matrix[None])
        return self._uprights[key]

    def turned(self, unit: Unit, base: Frames) -> Floats:
        """(3, 3) the axes of a unit, as columns, in those of a frame, without signs."""
        return self._turn_of(unit, base)[0]

    def is_square(self, unit: Unit, base: Frames, along: Sequence[int] = (0, 1, 2)) -> bool:
        """Whether the axes of a unit are those of a frame, in whatever order and direction; or some
        of the frame's axes are among those of the unit.
        """
        square = self._turn_of(unit, base)[1]
        return all(square[k] for k in along)

    def _turn_of(self, unit: Unit, base: Frames) -> tuple[Floats, list[bool]]:
        """The axes of a unit in those of a frame, and which of the frame's are among them."""
        key = unit, id(base)
        if key not in self._turned:
            own = self.maps(self.frame(unit)).turn
            found = np.abs(self.maps(base).turn.T @ own)
            square = [abs(max(row) - 1) <= SQUARE for row in found.tolist()]
            self._turned[key] = found, square
        return self._turned[key]

    def fills(self, unit: Unit) -> bool:
        """Whether a unit is as large as its scope says."""
        if unit not in self._fills:
            kind, row = unit
            if kind == "terminal":
                found = not self.tree.is_natural(row) and not self.is_solid(row)
            else:
                symbol = int(self.tree.lineage.symbol[row])
                found = symbol >= 0 and self.tree.asking.symbol_asks(symbol) and self._has_box(row)
            self._fills[unit] = found
        return self._fills[unit]

    def box(self, unit: Unit) -> tuple[Floats, Floats]:
        """(3,) the corners of a unit in its own axes: its scope, where it fills that."""
        kind, row = unit
        if kind == "terminal":
            return self.tree.terminals.low[row], self.tree.terminals.high[row]
        if self.fills(unit):
            return np.zeros(3), self.tree.size[row]
        return self.box_in(unit, self.frame(unit))

    def box_in(self, unit: Unit, base: Frames) -> tuple[Floats, Floats]:
        """(3,) the corners of a unit in the axes of a frame, and from its origin."""
        points = self.points(unit, base)
        return points.min(axis=0), points.max(axis=0)

    def points(self, unit: Unit, base: Frames) -> Floats:
        """(k, 3) the corners of the boxes of the terminals of a unit, in a frame; of those that
        stand askew in it, what they draw. Nobody may write to them.
        """
        key = unit, id(base)
        if key not in self._points:
            own, rows = self.maps(base), self.rows(unit)
            outs = own.into @ self.tree.maps["terminal"].out[rows]
            found = self.tree.corners_of(rows) @ own.into.T
            askew = self.tree.askew(outs, rows).tolist()
            if askew:
                places = self.tree.terminals.frames.position[rows] @ own.into.T
                each = dict(enumerate(found.reshape(-1, 8, 3)))
                for k in askew:
                    each[k] = self.tree.outline(rows[k]) @ outs[k].T + places[k]
                found = np.concatenate([*each.values()])
            found += own.origin
            self._points[key] = found
        return self._points[key]

    def axes(self, unit: Unit, base: Frames) -> Floats:
        """(3k, 3) the axes of the terminals of a unit, as rows of length 1 in those of a frame;
        nobody may write to them.
        """
        key = unit, id(base)
        if key not in self._axes:
            found = self.maps(base).into @ self.tree.maps["terminal"].out[self.rows(unit)]
            rows = found.transpose(0, 2, 1).reshape(-1, 3)
            self._axes[key] = np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))
        return self._axes[key]

    def extent(self, unit: Unit) -> Floats:
        """(3,) how large a unit is along its own axes: its scope, or where that has no extent, what
        it draws.
        """
        if unit[0] == "terminal":
            return np.asarray(self.tree.extents[unit[1]])
        low, high = self.box(unit)
        size = high - low
        if (size <= 0).any():
            first, last = self.box_in(unit, self.frame(unit))
            size = np.where(size > 0, size, last - first)
        return np.asarray(size * self.frame(unit).scale[0])

    def stretched(self, unit: Unit) -> Floats:
        """(3,) how many times as large as in their files assets of a unit are at least, along its
        own axes, where they are stretched or fill scopes; 1 where there are none, or they stand
        askew.
        """
        found = self.stretches(unit)
        return np.min(found, axis=0) if len(found) else np.ones(3)

    def stretches(self, unit: Unit) -> list[Floats]:
        """The same for each asset (3,)."""
        tree, found = self.tree, []
        for each in self.rows(unit):
            number = int(tree.scene.instances.asset[each])
            part: Unit = ("terminal", each)
            if number not in tree.meshes or not self.is_square(part, self.frame(unit)):
                continue
            own = np.array(tree.scene.assets[number].stretch or (1.0, 1.0, 1.0))
            if not tree.is_natural(each):
                natural = np.ptp(tree.meshes[number].vertices, axis=0)
                size = tree.terminals.high[each] * self.frame(part).scale[0]
                own *= np.where(natural > 0, size / np.where(natural > 0, natural, 1), 1)
            axis = self.turned(part, self.frame(unit)).argmax(axis=1)
            found.append(own[axis])
        return found

    def is_solid(self, row: int) -> bool:
        """Whether a terminal has a geometry that only its rule can say."""
        number = int(self.tree.scene.instances.asset[row])
        return number < 0 and number != SCOPE

    def is_of_assets(self, unit: Unit) -> bool:
        """Whether all that a unit draws is read from files."""
        asset = self.tree.scene.instances.asset[self.rows(unit)].tolist()
        return self.tree.meshes.keys() >= set(asset)

    def reads_lot(self) -> bool:
        """Whether anything asks how large the lot is: where nothing does, the lot is but a note."""
        return self.tree.asking.body_asks(self.tree.program.axiom.body)

    def _has_box(self, row: int) -> bool:
        """Whether the geometry of a shape is all of its scope."""
        number = int(self.tree.lineage.state["geo"][row])
        return number <= BOX or len(self.tree.scene.solids[number].vertices) in (4, 8)

    # ----------------------------------------------------------------------------- parts

    def parts(self, row: int) -> list[Unit]:
        """What a shape made and drew, in the order of the derivation, if it draws anything."""
        first, count = self.tree.first, len(self.tree.owners)
        found: list[tuple[int, Unit]] = [
            (each, ("terminal", each)) for each in self.tree.drawn[row]
        ]
        found += [(int(first[each]), ("shape", each)) for each in self.tree.children[row]]
        return [unit for place, unit in sorted(found) if place < count]

    def inside(self, row: int, base: Frames, along: Sequence[int] = (0, 1, 2)) -> list[Inside]:
        """The parts of a shape in the axes of a frame, and from its origin; along: the axes along
        which they must not stand askew.
        """
        found = []
        for unit in self._square_parts(row, base, along):
            square = self.is_square(unit, base, along)
            first, last = self.box(unit) if square else self.box_in(unit, base)
            frame, out = self._within(unit, base) if square else (identity(), np.eye(3))
            corner = out @ first + frame.position[0]
            size, turned = (last - first) * frame.scale[0], np.abs(out / frame.scale[0])
            found.append(Inside(unit, frame, corner, size, turned, square))
        return found

    def _within(self, unit: Unit, base: Frames) -> tuple[Frames, Floats]:
        """The frame of a unit in another, and (3, 3) what it does to directions."""
        kind, row = unit
        if base is self.frame(("shape", self.owner(unit))):
            frames, out = self.tree.places[kind]
            return frames[row : row + 1], out[row]
        frame = compose(inverse(base), self.frame(unit))
        return frame, linear(frame)[0]

    def _square_parts(self, row: int, base: Frames, along: Sequence[int]) -> list[Unit]:
        """The parts of a shape; those of the shapes in it that stand askew, one by one."""
        found: list[Unit] = []
        for unit in self.parts(row):
            askew = unit[0] == "shape" and not self.is_square(unit, base, along)
            found += self._square_parts(unit[1], base, along) if askew else [unit]
        return found


def measured(tree: Tree) -> Measured:
    """What is known of the units of a tree, by an edit before this one if that began with it."""
    found = next((each for each in tuple(_last()) if each.tree.scene is tree.scene), None)
    if found is None or len(found._maps) > len(tree) + len(tree.owners) + MANY:
        found = Measured(tree)
        _last().append(found)
    return found


@remember
def _last() -> deque[Measured]:
    """What was asked for last."""
    return deque(maxlen=2)


__all__ = ["BOX", "SQUARE", "Inside", "Measured", "Unit", "measured"]
