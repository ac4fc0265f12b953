"""Whether two executors made the same scene of one program: keys, discrete choices, then floats.

In go the scene of the reference, which defines what the program means, and that of another back
end; out come the disagreements as sentences that name the key, the production and the field, the
first few of each field. Rows are paired by key. Whole numbers, texts and colours must be equal;
floats may differ by a bound that grows with the depth of the derivation (`Bound`). Nothing derives
here, and no bound is taken from what the other back end gave.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.geometry.solid import Solid
from ipmlang.runtime.scene import (
    OUTLINE,
    OUTLINES,
    PATH,
    SCOPE,
    SEGMENT,
    SOLID,
    Scene,
    TextureMaps,
)
from tests.agreement_solids import is_close, same_surface

Outcome: TypeAlias = "Scene | Diagnostic"
Rows: TypeAlias = NDArray[np.int64]
Column: TypeAlias = NDArray[np.generic]

STEP = 1e-12  # what a generation may add to the relative difference of two floats
PEN = 2.0**-22  # widths are f32: two numbers that round to neighbours may differ by so much
KINDS = {SEGMENT: "segment", OUTLINE: "polygon", PATH: "path", SCOPE: "scope", SOLID: "solid"}


@dataclass(frozen=True, slots=True)
class Bound:
    """How far floats may lie apart: `ratio` is 1e-12 for each generation and one more for the
    start, `length` the same times the extent of the scene, which is the largest coordinate or world
    size in it. Rotations (unit quaternions, up to sign), scales and layers are held to the ratio;
    positions, sizes in the world and corners of polygons to the length.
    """

    extent: float
    depth: int

    @property
    def ratio(self) -> float:
        """For numbers about 1, and for the relative difference of others."""
        return STEP * self.depth

    @property
    def length(self) -> float:
        """For places and sizes in the world."""
        return self.ratio * self.extent


def _same_corners(one: Column, other: Column, allowed: float) -> bool:
    """Whether outlines go through the same corners, NaN between the same parts."""
    if one.shape != other.shape or not np.array_equal(np.isnan(one), np.isnan(other)):
        return False
    return is_close(np.nan_to_num(one), np.nan_to_num(other), allowed)


def bound_of(scene: Scene) -> Bound:
    """What is allowed beside this scene."""
    rows = scene.instances
    sizes = np.abs(rows.size) * np.abs(rows.scale)[:, None]
    largest = [float(np.max(np.abs(each), initial=0.0)) for each in (rows.position, sizes)]
    return Bound(max(largest), 1 + scene.generations)


def outcome(derive: Callable[[], Scene]) -> Outcome:
    """A scene, or the error that users would read."""
    try:
        return derive()
    except IpmError as found:
        return found.diagnostics[0]


def assert_agree(wanted: Outcome, found: Outcome, told: str = "", first: int = 4) -> None:
    """Fail with what differs, and with `told`, such as the grammar's text."""
    lines = disagreements(wanted, found, first)
    assert not lines, "\n".join([*lines, told])


def disagreements(wanted: Outcome, found: Outcome, first: int = 4) -> list[str]:
    """What differs, at most `first` rows of each field; empty where all agrees."""
    match wanted, found:
        case Scene(), Scene():
            return _of_scenes(wanted, found, first)
        case Diagnostic(), Diagnostic():
            same = wanted.code == found.code
            return [] if same else [f"another error: {_error(wanted)} wanted, {_error(found)}"]
        case _:
            told = [each if isinstance(each, str) else "a scene" for each in _errors(wanted, found)]
            return [f"{told[0]} wanted, {told[1]} found"]


def _errors(*outcomes: Outcome) -> Iterator[str | Scene]:
    for each in outcomes:
        yield _error(each) if isinstance(each, Diagnostic) else each


def _error(diagnostic: Diagnostic) -> str:
    return f"error {diagnostic.code} ({diagnostic.message})"


def _of_scenes(wanted: Scene, found: Scene, first: int) -> list[str]:
    pairs = _Pairs(wanted, found, first)
    lines = [*_whole(wanted, found), *pairs.keys()]
    lines += pairs.discrete()
    lines += pairs.floats()
    if not lines:  # these lean on the rows being the same
        lines += pairs.shapes()
        lines += pairs.groups()
        lines += pairs.textures()
    return lines


def _whole(wanted: Scene, found: Scene) -> Iterator[str]:
    """What a scene says beside its rows."""
    for name in ("flat", "canvas", "canvas_size", "up", "generations", "shapes", "seed"):
        yield from _unequal(name, getattr(wanted, name), getattr(found, name))
    for note in wanted.notes:
        if note not in found.notes:  # another back end may say more, such as what it left to this
            yield f"a note is missing: {note}"
    counts = [{key: count for key, (_, count) in each.reports.items()} for each in (wanted, found)]
    yield from _unequal("counts of reports", *counts)
    bound = bound_of(wanted).ratio
    for key, (total, count) in wanted.reports.items():
        other = found.reports.get(key, (total, count))[0]
        if not abs(total - other) <= bound * max(1.0, abs(total)) * max(count, 1):
            yield f"the report `{key}` is {total!r}, not {other!r}"


def _unequal(name: str, wanted: object, found: object) -> Iterator[str]:
    if wanted != found:
        yield f"{name}: {wanted!r} wanted, {found!r} found"


class _Pairs:
    """Rows of two scenes with the same keys: the k-th of a key with the k-th of that key."""

    def __init__(self, wanted: Scene, found: Scene, first: int) -> None:
        self.scenes = wanted, found
        self.first = first
        self.bound = bound_of(wanted)
        self.lone: tuple[Rows, Rows]
        self.rows: tuple[Rows, Rows]
        self.rows, self.lone = _paired(wanted.instances.key, found.instances.key)

    # ---------------------------------------------------------------------- telling

    def _told(self, row: int, side: int = 0) -> str:
        """A row by key, terminal and production."""
        scene = self.scenes[side]
        rows = scene.instances
        asset = int(rows.asset[row])
        kind = KINDS.get(asset, "asset")
        rule = scene.rules[rows.rule[row]]
        return (
            f"key {int(rows.key[row]):#018x}: {kind} `{scene.labels[rows.label[row]]}` "
            f"of rule `{rule.rule}` (line {rule.line}), row {row}"
        )

    def _differing(
        self, name: str, bad: NDArray[np.bool_], values: tuple[Column, Column]
    ) -> Iterator[str]:
        """The first rows that are bad in a field."""
        places = np.flatnonzero(bad)
        for place in places[: self.first]:
            one, other = (column[place] for column in values)
            yield (
                f"{self._told(int(self.rows[0][place]))}: {name} is "
                f"{_shown(one)}, not {_shown(other)}{_apart(one, other)}"
            )
        if len(places) > self.first:
            yield f"... {name} differs in {len(places)} of {len(bad)} terminals"

    def _column(self, name: str) -> tuple[Column, Column]:
        one, other = (
            getattr(scene.instances, name)[rows]
            for scene, rows in zip(self.scenes, self.rows, strict=True)
        )
        return one, other

    # ------------------------------------------------------------------------- rows

    def keys(self) -> Iterator[str]:
        """Terminals of one scene alone, and rows in another order."""
        for side, what in enumerate(("is missing", "should not be there")):
            lone = self.lone[side]
            for row in lone[: self.first]:
                yield f"{self._told(int(row), side)} {what}"
            if len(lone) > self.first:
                yield f"... {len(lone)} of {len(self.scenes[side].instances)} {what}"
        if not any(map(len, self.lone)):
            moved = np.flatnonzero(self.rows[0] != self.rows[1])
            if len(moved):
                row = int(self.rows[0][moved].min())
                yield f"{len(moved)} rows are in another order, first {self._told(row)}"

    def discrete(self) -> Iterator[str]:
        """What must be equal: terminal, production, pen."""
        for name, field in (("label", "labels"), ("rule", "rules"), ("style", "styles")):
            values = self._of_texts(name, *(getattr(scene, field) for scene in self.scenes))
            yield from self._differing(name, values[0] != values[1], values)
        values = self._of_texts("asset", *(scene.assets for scene in self.scenes))
        yield from self._differing("asset", values[0] != values[1], values)
        values = self._column("color")
        yield from self._differing("color", values[0] != values[1], values)

    def _of_texts(
        self, name: str, wanted: Sequence[object], found: Sequence[object]
    ) -> tuple[Column, Column]:
        """A column of indices as what they stand for; negative ones stand for kinds."""
        columns = []
        for numbers, meanings in zip(self._column(name), (wanted, found), strict=True):
            known = np.empty(len(meanings) + len(KINDS) + 1, object)
            known[: len(meanings)] = meanings
            for code, kind in KINDS.items():
                known[code] = kind
            columns.append(known[numbers.astype(np.int64)])
        return columns[0], columns[1]

    def floats(self) -> Iterator[str]:
        """Frames, sizes and pens, within the bound; what is no number agrees with nothing."""
        bound = self.bound
        scale = self._column("scale")
        world = np.abs(scale[0].astype(np.float64))[:, None]
        yield from self._near("position", self._column("position"), bound.length)
        yield from self._near("scale", scale, bound.ratio * np.abs(scale[0]))
        sizes = self._column("size")
        yield from self._near("size", (sizes[0] * world, sizes[1] * world), bound.length)
        one, other = self._column("rotation")
        aligned = np.where(np.sum(one * other, axis=1, keepdims=True) < 0, -other, other)
        yield from self._near("rotation", (one, aligned), bound.ratio)
        layers = self._column("layer")
        yield from self._near("layer", layers, bound.ratio * np.maximum(1, np.abs(layers[0])))
        yield from self._widths()

    def _near(
        self, name: str, values: tuple[Column, Column], allowed: float | NDArray[np.float64]
    ) -> Iterator[str]:
        apart = np.abs(values[0] - values[1])
        if apart.ndim == 2:
            apart = np.max(apart, axis=1, initial=0.0)
        yield from self._differing(name, ~(apart <= allowed), values)

    def _widths(self) -> Iterator[str]:
        one, other = (column.astype(np.float64) for column in self._column("width"))
        unset = np.isnan(one) & np.isnan(other)
        bad = ~(np.abs(one - other) <= PEN * np.abs(one)) & ~unset
        yield from self._differing("width", bad, (one, other))

    # --------------------------------------------------------------- what rows point at

    def shapes(self) -> Iterator[str]:
        """Corners of polygons and paths, and solids."""
        numbers = self._column("shape")
        assets = self._column("asset")[0]
        seen = 0
        for place in np.flatnonzero(np.isin(assets, OUTLINES)):
            one, other = (s.polygons[n[place]] for s, n in zip(self.scenes, numbers, strict=True))
            if seen < self.first and not _same_corners(one, other, self.bound.length):
                seen += 1
                yield f"{self._told(int(self.rows[0][place]))}: its corners differ"
        solids = np.flatnonzero(assets == SOLID)
        pairs = np.stack([column[solids].astype(np.int64) for column in numbers], axis=1)
        _, where = np.unique(pairs, axis=0, return_index=True)
        for place in solids[np.sort(where)]:
            one, other = (s.solids[n[place]] for s, n in zip(self.scenes, numbers, strict=True))
            what = "" if seen >= self.first else self._solid_fault(int(place), one, other)
            if what:
                seen += 1
                yield f"{self._told(int(self.rows[0][place]))}: {what}"

    def _solid_fault(self, place: int, one: Solid, other: Solid) -> str:
        """How two solids differ; their vertices are in the unit box of a scope."""
        row = int(self.rows[0][place])
        rows = self.scenes[0].instances
        size = np.max(rows.size[row]) * abs(rows.scale[row])
        allowed = self.bound.ratio + (self.bound.length / size if size > 0 else 0.0)
        apart = same_surface(one, other, allowed)
        if apart:
            return f"the {apart} of its solid differ"
        if (one.uv is None) != (other.uv is None):
            return "one of its solids has no texture coordinates"
        return ""

    def groups(self) -> Iterator[str]:
        """What `effect` wraps, from the innermost group of each row outward."""
        one, other = (scene.groups for scene in self.scenes)
        if one is None or other is None:
            yield from _unequal("groups", one is None, other is None)
            return
        yield from _unequal("number of groups", len(one), len(other))
        own = one.of[self.rows[0]], other.of[self.rows[1]]
        while np.any(own[0] >= 0) or np.any(own[1] >= 0):
            if np.any((own[0] >= 0) != (own[1] >= 0)) or not _one_to_one(*own):
                yield "other terminals are in groups"
                return
            both = np.unique(np.stack(own, axis=1)[own[0] >= 0], axis=0)
            for a, b in both[: self.first * 50]:
                frames = (
                    is_close(one.position[a], other.position[b], self.bound.length)
                    and is_close(one.rotation[a], other.rotation[b], self.bound.ratio, signed=False)
                    and is_close(one.scale[a], other.scale[b], self.bound.ratio * abs(one.scale[a]))
                    and is_close(one.layer[a], other.layer[b], self.bound.ratio)
                )
                if one.effects[one.effect[a]] != other.effects[other.effect[b]] or not frames:
                    yield f"group {a} differs in effect, frame or layer from group {b}"
            own = _outer(own[0], one.parent), _outer(own[1], other.parent)

    def textures(self) -> Iterator[str]:
        """How textures lie on what is drawn."""
        one, other = (_laid(scene.texture_maps) for scene in self.scenes)
        if one is None or other is None:
            yield from _unequal("texture maps", one is None, other is None)
            return
        ways = one.of[self.rows[0]], other.of[self.rows[1]]
        if np.any((ways[0] >= 0) != (ways[1] >= 0)):
            yield "textures lie in other ways"
            return
        laid = ways[0] >= 0
        scale = max(1.0, self.bound.extent)
        for field in fields(one):
            if field.name != "of":
                a = getattr(one, field.name)[ways[0][laid]].astype(np.float64)
                b = getattr(other, field.name)[ways[1][laid]].astype(np.float64)
                a, b = (np.nan_to_num(each, nan=-1.0) for each in (a, b))
                signed = field.name != "rotation"
                if not is_close(a, b, self.bound.ratio * scale, signed):
                    yield f"textures lie otherwise: {field.name}"


def _paired(
    wanted: NDArray[np.uint64], found: NDArray[np.uint64]
) -> tuple[tuple[Rows, Rows], tuple[Rows, Rows]]:
    """Rows with the same key, in the order of `wanted`, and the rows of either that have none."""
    ranks = [_ranked(keys) for keys in (wanted, found)]
    _, both, theirs = np.intersect1d(*ranks, return_indices=True)
    order = np.argsort(both, kind="stable")
    rows = both[order].astype(np.int64), theirs[order].astype(np.int64)
    lone = [np.setdiff1d(np.arange(len(ranks[side])), rows[side]) for side in (0, 1)]
    return rows, (lone[0], lone[1])


def _ranked(keys: NDArray[np.uint64]) -> NDArray[np.void]:
    """Each key with how many rows before it have the same."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    new = np.ones(len(keys), bool)
    new[1:] = ordered[1:] != ordered[:-1]
    begin = np.maximum.accumulate(np.where(new, np.arange(len(keys)), 0))
    made = np.zeros(len(keys), [("key", np.uint64), ("rank", np.int64)])
    made["key"] = keys
    made["rank"][order] = np.arange(len(keys)) - begin
    return made


def _laid(maps: TextureMaps | None) -> TextureMaps | None:
    """The maps, if something is drawn on which textures lie by them."""
    return maps if maps is not None and np.any(maps.of >= 0) else None


def _one_to_one(one: NDArray[np.int32], other: NDArray[np.int32]) -> bool:
    pairs = np.unique(np.stack((one, other), axis=1), axis=0)
    return len(pairs) == len(np.unique(one)) == len(np.unique(other))


def _outer(own: NDArray[np.int32], parent: NDArray[np.int32]) -> NDArray[np.int32]:
    """The group around each, -1 where there is none."""
    return np.where(own >= 0, parent[own], np.int32(-1)) if len(parent) else own


def _shown(value: object) -> str:
    return np.array2string(value, separator=", ") if isinstance(value, np.ndarray) else repr(value)


def _apart(one: object, other: object) -> str:
    if isinstance(one, np.ndarray | np.floating) and isinstance(other, np.ndarray | np.floating):
        return f" (apart by {np.max(np.abs(one - other)):.3g})"
    return ""
