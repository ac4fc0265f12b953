"""A grammar with what it derives: every shape and every terminal, with frames and boxes.

In goes a draft, out comes its derivation tree in numbers. Terminals have the box of their geometry,
a shape the union of what it draws; in its own axes, and in those of anything else. Nothing is
changed or judged here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ast, ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, nearest
from ipmlang.edit.buildings.asking import Asking
from ipmlang.edit.buildings.contacts import neighbours
from ipmlang.edit.buildings.placements import Maps, Terminals, maps_of, outermost
from ipmlang.edit.draft import Draft
from ipmlang.edit.symbols import Asked, taken_names
from ipmlang.inverse.frames import (
    Floats,
    Frames,
    Integers,
    compose,
    corners,
    inverse,
    linear,
)
from ipmlang.runtime.lineage import Lineage
from ipmlang.runtime.scene import AssetRef, Scene

if TYPE_CHECKING:
    from ipmlang.formats.mesh_types import Mesh


TEXTS = ("color", "fill", "stroke", "css", "material", "texture", "label")
BOUND = ("uv", "join", "effect")  # of the state: what cannot be said apart from where it was made
ASKEW = 1e-7  # of an axis, from which on it is no longer the same
UPRIGHT: Floats = np.eye(3)
PENS = frozenset({*TEXTS, *BOUND, "width", "layer"})


@dataclass(frozen=True, eq=False)
class Tree:
    """n shapes and m terminals. meshes: of the assets that are drawn, by their numbers; stamps: of
    the files beside the grammar; outlines: what `outline` found so far of meshes as they are. What
    shapes are is worked out when it is first asked for.
    """

    draft: Draft
    program: ir.Program
    scene: Scene
    lineage: Lineage
    terminals: Terminals
    meshes: Mapping[int, Mesh]
    stamps: tuple[tuple[str, int, int], ...] = ()
    outlines: dict[AssetRef, Floats] = field(default_factory=dict)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """(n,) the symbols of the shapes, as the main file writes them."""
        return _names(self.draft.grammar, self.program, self.lineage)

    @cached_property
    def frames(self) -> Frames:
        """(n,) the frames of the shapes' scopes."""
        state, count = self.lineage.state, len(self)
        scale = state.get("scale", np.ones(count))
        return Frames(
            np.stack([state[axis] for axis in "xyz"], axis=1),
            np.stack([state[axis] for axis in "wijk"], axis=1),
            np.sign(scale),
            np.abs(scale),
        )

    @cached_property
    def size(self) -> Floats:
        """(n, 3) the sizes of the shapes' scopes."""
        state, none = self.lineage.state, np.zeros(len(self))
        return np.stack([state.get(name, none) for name in ("sx", "sy", "sz")], axis=1)

    @cached_property
    def trials(self) -> dict[tuple[str | float, ...], float | None]:
        """How large things were with other numbers, where edits tried some: see `driving.py`."""
        return {}

    @cached_property
    def asked(self) -> Asked:
        """The names that the items of its grammar ask for."""
        return Asked()

    @cached_property
    def taken(self) -> frozenset[str]:
        """All names that stand in its grammar, of operations and functions, too."""
        from ipmlang.compiler.ops import FUNCTIONS, OPERATIONS

        taken = taken_names(self.draft.grammar, self.asked)
        return frozenset(taken | OPERATIONS.keys() | FUNCTIONS.keys())

    @cached_property
    def asking(self) -> Asking:
        """Which of its rules ask how large their scope is."""
        return Asking(self.program)

    @cached_property
    def extents(self) -> Floats:
        """(m, 3) the sizes of all terminals along their own axes."""
        one = self.terminals
        return np.asarray((one.high - one.low) * one.frames.scale[:, None])

    def rows_of(self, kind: str) -> dict[int, int]:
        """The shapes, or the terminals, by their keys: the first of each."""
        if kind not in self._rows_of:
            own = self.lineage.key if kind == "shape" else self.scene.instances.key
            self._rows_of[kind] = {key: row for row, key in reversed([*enumerate(own.tolist())])}
        return self._rows_of[kind]

    @cached_property
    def _rows_of(self) -> dict[str, dict[int, int]]:
        """What `rows_of` has been asked for."""
        return {}

    @cached_property
    def places(self) -> dict[str, tuple[Frames, Floats]]:
        """The frames of all shapes and of all terminals in those of the shapes that made them, and
        (…, 3, 3) what they do to directions; of the start its own.
        """
        back = inverse(self.frames)
        shapes = compose(back[np.maximum(self.parent, 0)], self.frames)
        terminals = compose(back[self.owner], self.terminals.frames)
        return {"shape": (shapes, linear(shapes)), "terminal": (terminals, linear(terminals))}

    def is_natural(self, row: int) -> bool:
        """Whether a terminal is an asset as large as it is in its file."""
        drawn = self.drawn_assets[row]
        return bool(drawn) and drawn == self.terminals.labels[row]

    @cached_property
    def drawn_assets(self) -> list[str]:
        """(m,) the names of the assets that terminals draw; "" for those that draw none."""
        numbers = self.scene.instances.asset.tolist()
        return [self.scene.assets[each].name if each >= 0 else "" for each in numbers]

    def terminals_of(self, name: str) -> list[int]:
        """The terminals of a label, or if there are none, those that draw an asset: an edit that
        fits one into a scope gives it another label.
        """
        found = [row for row, label in enumerate(self.terminals.labels) if label == name]
        return found or [row for row, own in enumerate(self.drawn_assets) if name and own == name]

    def of(self, draft: Draft) -> Tree:
        """The same of another draft that says the same, with all that was worked out of it."""
        made = replace(self, draft=draft)
        vars(made).update({**vars(self), "draft": draft})
        return made

    @cached_property
    def parent(self) -> Integers:
        """(n,) the shape that made each shape, -1 of the start."""
        return self.lineage.parent.astype(np.int64)

    @cached_property
    def owner(self) -> Integers:
        """(m,) the shape that drew each terminal."""
        return self.lineage.drawer.astype(np.int64)

    @cached_property
    def parents(self) -> list[int]:
        """The same as `parent`, to look single shapes up."""
        return self.lineage.parent.tolist()  # type: ignore[no-any-return]

    @cached_property
    def owners(self) -> list[int]:
        """The same as `owner`, to look single terminals up."""
        return self.lineage.drawer.tolist()  # type: ignore[no-any-return]

    @cached_property
    def maps(self) -> dict[str, Maps]:
        """The frames of all shapes and of all terminals as maps of points."""
        return {"shape": maps_of(self.frames), "terminal": maps_of(self.terminals.frames)}

    def __len__(self) -> int:
        return len(self.lineage)

    @cached_property
    def first(self) -> Integers:
        """(n,) the first terminal below each shape; m where it draws nothing."""
        found = np.full(len(self), len(self.owner), np.int64)
        np.minimum.at(found, self.owner, np.arange(len(self.owner)))
        for rows in self.levels[:0:-1]:
            np.minimum.at(found, self.parent[rows], found[rows])
        return found

    @cached_property
    def levels(self) -> list[Integers]:
        """The shapes by depth, the start first."""
        depth = np.zeros(len(self), np.int64)
        for row, above in enumerate(self.parents):
            if above >= 0:
                depth[row] = depth[above] + 1
        return [np.flatnonzero(depth == k) for k in range(int(depth.max(initial=0)) + 1)]

    @cached_property
    def children(self) -> list[list[int]]:
        """The shapes that each shape made."""
        found: list[list[int]] = [[] for _ in range(len(self))]
        for row, above in enumerate(self.parents):
            if above >= 0:
                found[above].append(row)
        return found

    @cached_property
    def drawn(self) -> list[list[int]]:
        """The terminals that each shape drew itself."""
        found: list[list[int]] = [[] for _ in range(len(self))]
        for row, above in enumerate(self.owners):
            found[above].append(row)
        return found

    def below(self, shape: int) -> list[int]:
        """All terminals below a shape, in the order of the derivation; nobody may write to them."""
        if shape not in self._below:
            found, waiting = [], [shape]
            while waiting:
                row = waiting.pop()
                found += self.drawn[row]
                waiting += self.children[row]
            self._below[shape] = sorted(found)
        return self._below[shape]

    @cached_property
    def told(self) -> list[str]:
        """The fields of the pen that are not the same for all shapes and terminals."""
        state, pens = self.lineage.state, self.lineage.pens
        return [
            name
            for name, column in state.items()
            if name in PENS and not _is_one(np.concatenate([column, pens[name]]))
        ]

    @cached_property
    def _below(self) -> dict[int, list[int]]:
        """What `below` has been asked for."""
        return {}

    def above(self, shape: int) -> list[int]:
        """A shape and those it comes of, the start last."""
        found = [shape]
        while self.parents[found[-1]] >= 0:
            found.append(self.parents[found[-1]])
        return found

    def boxes(self, axes: Floats) -> tuple[Floats, Floats]:
        """(m, 3) low and high corners of all terminals along axes, rows of (3, 3), around what they
        draw however they are turned; nobody may write to them.
        """
        key = axes.tobytes()
        if key not in self._boxes:
            points = self._corners @ axes.T
            found = points.min(axis=1), points.max(axis=1)
            self._tighten(axes, *found)
            for each in found:
                each.flags.writeable = False
            self._boxes[key] = found
        return self._boxes[key]

    def _tighten(self, axes: Floats, low: Floats, high: Floats) -> None:
        """The boxes (m, 3) of assets that stand askew in axes, from what they draw."""
        outs = axes @ linear(self.terminals.frames)
        places = self.terminals.frames.position @ axes.T
        for row in self.askew(outs, slice(None)).tolist():
            found = self.outline(row) @ outs[row].T + places[row]
            low[row], high[row] = found.min(axis=0), found.max(axis=0)

    def askew(self, outs: Floats, rows: Sequence[int] | slice) -> Integers:
        """(k,) which of some terminals are assets whose axes are not those that outs (r, 3, 3) take
        them to, in whatever order: their boxes say too much there.
        """
        share = np.abs(outs).max(axis=1) / np.linalg.norm(outs, axis=1)
        drawn = self.scene.instances.asset[rows] >= 0
        return np.flatnonzero(drawn & (share < 1 - ASKEW).any(axis=1))

    def outline(self, row: int) -> Floats:
        """(k, 3) points of what a terminal with an asset draws, in its own frame, such that no
        point of it lies outside of them.
        """
        number = int(self.scene.instances.asset[row])
        asset = self.scene.assets[number]
        if asset not in self.outlines:
            self.outlines[asset] = outermost(self.meshes[number].vertices)
        points = self.outlines[asset]
        if self.is_natural(row):
            return points
        if number not in self._shares:
            low, extent = points.min(axis=0), np.ptp(points, axis=0)
            self._shares[number] = (points - low) / np.where(extent > 0, extent, 1.0)
        return np.asarray(self._shares[number] * self.terminals.high[row])

    @cached_property
    def _shares(self) -> dict[int, Floats]:
        """The outlines of assets in the unit box, of those that `outline` was asked for so."""
        return {}

    @cached_property
    def _boxes(self) -> dict[bytes, tuple[Floats, Floats]]:
        """What `boxes` has been asked for."""
        return {}

    @cached_property
    def _corners(self) -> Floats:
        """(m, 8, 3) the corners of the boxes of all terminals."""
        one = self.terminals
        return corners(one.frames, one.low, one.high)

    def neighbours(self, near: float, axes: Floats = UPRIGHT) -> Integers:
        """(k, 2) the pairs of terminals whose boxes along axes share a point within `near`."""
        key = near, axes.tobytes()
        if key not in self._neighbours:
            self._neighbours[key] = neighbours(*self.boxes(axes), near)
        return self._neighbours[key]

    @cached_property
    def _neighbours(self) -> dict[tuple[float, bytes], Integers]:
        """What `neighbours` has been asked for."""
        return {}

    def unions(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """(n, 3) the boxes around what each shape draws; (m, 3) are those of terminals. Empty ones
        have their low corner at inf.
        """
        lows, highs = np.full((len(self), 3), np.inf), np.full((len(self), 3), -np.inf)
        np.minimum.at(lows, self.owner, low)
        np.maximum.at(highs, self.owner, high)
        for rows in self.levels[:0:-1]:
            np.minimum.at(lows, self.parent[rows], lows[rows])
            np.maximum.at(highs, self.parent[rows], highs[rows])
        return lows, highs

    def corners_of(self, rows: Sequence[int]) -> Floats:
        """(8k, 3) the corners of the boxes of terminals."""
        return self._corners[rows].reshape(-1, 3)


def _is_one(column: Floats) -> bool:
    """Whether all values of a column are the same, or nothing."""
    return bool((column == column[:1]).all() or np.isnan(column).all())


def _names(grammar: ast.Grammar, program: ir.Program, lineage: Lineage) -> tuple[str, ...]:
    """What the main file calls each shape's symbol: those of imports have a dot."""
    prefix = {
        item.path.rpartition("/")[2].removesuffix(".ipm"): item.alias
        or item.path.rpartition("/")[2].removesuffix(".ipm")
        for item in grammar.items
        if isinstance(item, ast.Import)
    }
    own = {item.head.name for item in grammar.items if isinstance(item, ast.Rule)}
    found = {-1: "start"}
    for number, symbol in enumerate(program.symbols):
        paths = {program.productions[each].path for each in symbol.productions}
        stem = next(iter(paths), "").replace("\\", "/").rpartition("/")[2].removesuffix(".ipm")
        bare = symbol.name in own and paths <= {program.path, ""}
        dotted = "." in symbol.name or bare or stem not in prefix
        found[number] = symbol.name if dotted else f"{prefix[stem]}.{symbol.name}"
    return tuple(found[number] for number in lineage.symbol.tolist())


def unknown(message: str, name: str, known: set[str]) -> IpmError:
    """A name that nothing bears."""
    return IpmError(
        [Diagnostic("nothing-selected", message, suggestions=nearest(name, sorted(known)))]
    )
