"""How textures lie on what is drawn, while a derivation runs: every application is a row.

In go the states in which `setupProjection`, `projectUV`, `tileUV` and their like were met, as
columns of a batch; out come numbers, which shapes carry in their state like a pen's colour, and at
the end what these come to: for each its frame, plane, tile and change. No image is known here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_rows
from ipmlang.runtime.code import Column
from ipmlang.runtime.scene import TextureMaps

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]

FIELD = "uv"  # of the pen: twice the last application, 1 more if a projection is set up; or -1
READY = -2.0  # stands for an application in rows that are not there
PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
SETUP, PROJECT, TILE, TRANSLATE, SCALE, ROTATE = (
    "setupProjection", "projectUV", "tileUV", "translateUV", "scaleUV", "rotateUV"
)  # fmt: skip
_FRAME = ("x", "y", "z", "w", "i", "j", "k", "scale")
_USUAL = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class LayingError(Exception):
    """What an application was given cannot be: why, and a hint."""

    def __init__(self, message: str, hint: str) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


@dataclass(slots=True, eq=False)
class _Met:
    """One application in a batch: `first` is the number of its first row; `parent` (n,) what held
    before; `values` (n, 2); `frame` (n, 8) where a projection was set up.
    """

    name: str
    first: int
    parent: Numbers
    values: Floats
    frame: Floats
    plane: tuple[int, int]


@dataclass(slots=True, eq=False)
class _Held:
    """What rows come to (m,): the number of the projection that was set up last and of the one that
    is applied, -1 for none; tile (m, 2), NaN for none; map (m, 2, 3).
    """

    ready: Numbers
    applied: Numbers
    tile: Floats
    map: Floats

    def of(self, rows: Numbers) -> _Held:
        """Those of some rows, to be changed; a row of -1 holds nothing."""
        none = rows < 0
        if none.all():
            return _blank(len(rows))
        found = _Held(self.ready[rows], self.applied[rows], self.tile[rows], self.map[rows])
        found.ready[none], found.applied[none] = -1, -1
        found.tile[none], found.map[none] = np.nan, np.eye(2, 3)
        return found

    def longer(self, count: int) -> _Held:
        """The same, with blank rows behind."""
        pairs = zip(_fields(self), _fields(_blank(count - len(self.ready))), strict=True)
        return _Held(*(np.concatenate(pair) for pair in pairs))


def _fields(held: _Held) -> tuple[Numbers, Numbers, Floats, Floats]:
    return held.ready, held.applied, held.tile, held.map


def _blank(count: int) -> _Held:
    """Rows that hold nothing."""
    none = np.full(count, -1, np.int64)
    return _Held(
        none, none.copy(), np.full((count, 2), np.nan), np.tile(np.eye(2, 3), (count, 1, 1))
    )


@dataclass(slots=True, eq=False)
class Laying:
    """All applications of one derivation."""

    count: int = 0
    _met: list[_Met] = field(default_factory=list)
    _known: dict[tuple[object, ...], float] = field(default_factory=dict)
    _done: int = 0  # applications that `_held` and `_setups` know already
    _held: _Held = field(default_factory=lambda: _blank(0))
    _setups: Floats = field(default_factory=lambda: np.zeros((0, 2)))

    def begin(
        self,
        name: str,
        count: int,
        args: Sequence[Column],
        parent: Column,
        state: Mapping[str, Column],
        plane: str = "xy",
    ) -> Column:
        """What shapes carry of an application, one for each row of a batch or one for all. Equal
        ones are one: that of ten thousand tiles with one projection has one number.
        """
        scale = np.abs(np.asarray(state.get("scale", 1.0))) if name in (SETUP, TILE) else 1.0
        columns = [parent, *(arg * scale for arg in args), *(0.0,) * (2 - len(args))]
        if name == SETUP:
            columns += [state.get(key, usual) for key, usual in zip(_FRAME, _USUAL, strict=True)]
        alike = all(np.ndim(column) == 0 for column in columns)
        table = np.zeros((1 if alike else count, len(columns)))
        for place, column in enumerate(columns):
            table[:, place] = column
        _check(name, table)
        first, kind = distinct_rows(table)
        numbers = self._numbers(name, table[first], plane)
        return float(numbers[0]) if alike else numbers[kind]

    def _numbers(self, name: str, rows: Floats, plane: str) -> Floats:
        """What shapes carry of different applications (m,)."""
        ready = _is_ready(rows[:, 0]) | (name == SETUP)
        numbers = np.arange(self.count, self.count + len(rows))
        found = np.asarray(2 * numbers + ready, np.float64)
        if len(rows) == 1:
            known = self._known.setdefault((name, plane, *rows[0].tolist()), float(found[0]))
            if known != found[0]:
                return np.array([known])
        before = (rows[:, 0] // 2).astype(np.int64)
        self._met.append(_Met(name, self.count, before, rows[:, 1:3], rows[:, 3:], PLANES[plane]))
        self.count += len(rows)
        return found

    def maps(self, of: NDArray[np.int32]) -> TextureMaps | None:
        """What `of` (n,), as each row carries it, comes to; None if nothing was applied."""
        if not self.count:
            return None
        own = (of // 2).astype(np.int64)
        used = np.flatnonzero(np.bincount(own + 1, minlength=self.count + 1)[1:])
        place = np.full(self.count + 1, -1, np.int32)  # the last for rows of -1
        place[used] = np.arange(len(used))
        return self._maps(place[own], used)

    def now(self, carried: Floats) -> TextureMaps:
        """What rows (n,) carry, as it stands; the map of each row is its own."""
        own = np.floor(carried / 2).astype(np.int64)
        used, place = np.unique(np.maximum(own, -1), return_inverse=True)
        return self._maps(place.reshape(-1).astype(np.int32), used)

    def _maps(self, of: NDArray[np.int32], used: Numbers) -> TextureMaps:
        held = self._resolved().of(used)
        frames = np.tile(np.array(_USUAL), (self.count + 1, 1))
        planes = np.zeros((self.count + 1, 2), np.int64)
        for each in self._met:
            if each.name == SETUP:
                frames[each.first : each.first + len(each.parent)] = each.frame
                planes[each.first : each.first + len(each.parent)] = each.plane
        projected = held.applied >= 0
        frame, plane = frames[held.applied], planes[held.applied]
        rotation = frame[:, 3:7] / np.linalg.norm(frame[:, 3:7], axis=1, keepdims=True)
        return TextureMaps(
            of, projected, plane, frame[:, :3], rotation, np.sign(frame[:, 7]), held.tile, held.map
        )

    def _resolved(self) -> _Held:
        """What all rows come to; what held before a row has a smaller number."""
        whole = self._held = self._held.longer(self.count)
        blank = np.full((self.count - len(self._setups), 2), np.nan)
        setups = self._setups = np.concatenate([self._setups, blank])
        met, self._done = self._met[self._done :], len(self._met)
        for each in met:
            rows = np.arange(each.first, each.first + len(each.parent))
            held = whole.of(each.parent)
            if each.name == SETUP:
                held.ready = rows
                setups[rows] = each.values
            elif each.name == PROJECT:
                held.applied = held.ready
                held.tile = setups[held.ready]
                held.map = np.tile(np.eye(2, 3), (len(rows), 1, 1))
            elif each.name == TILE:
                held.tile = each.values
            else:
                held.map = _changed(each.name, each.values, held.map)
            whole.ready[rows], whole.applied[rows] = held.ready, held.applied
            whole.tile[rows], whole.map[rows] = held.tile, held.map
        return whole


def _is_ready(carried: Floats) -> NDArray[np.bool_]:
    """Where a projection is set up, by what shapes carry."""
    found: NDArray[np.bool_] = (carried == READY) | ((carried >= 0) & (carried % 2 == 1))
    return found


def _check(name: str, table: Floats) -> None:
    """Refuse what an application was given: what held before, two values, perhaps a frame."""
    if not np.isfinite(table).all():
        raise LayingError(f"`{name}` is given no finite number", "check what it is given")
    if name in (SETUP, TILE) and not (table[:, 1:3] > 0).all():
        raise LayingError(
            f"`{name}` needs a width and a height above 0",
            "say how large the image is in the scope's units",
        )
    if name == PROJECT and not _is_ready(table[:, 0]).all():
        raise LayingError(
            f"`{name}` stands where no projection was set up",
            "write setupProjection(xy, 2, 1) before it, where xy is the plane and an image is "
            "2 by 1",
        )


def _changed(name: str, values: Floats, before: Floats) -> Floats:
    """Maps (n, 2, 3) with one more change after them."""
    after = before.copy()
    if name == TRANSLATE:
        after[:, :, 2] += values
    elif name == SCALE:
        after *= values[:, :, None]
    else:
        angle = np.radians(values[:, 0])
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.stack([np.stack([cos, -sin], axis=1), np.stack([sin, cos], axis=1)], axis=1)
        after = turn @ before
    return after
