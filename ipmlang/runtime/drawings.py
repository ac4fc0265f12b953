"""What a derivation draws, kept by reference until all places are known.

In go drawings as columns of a batch or as single rows; out come rows in derivation order. Keys and
rotations are made only then; each column is written into its place chunk by chunk and let go.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import keys, scan
from ipmlang.runtime.assemble import TEXT_FIELDS, Rows
from ipmlang.runtime.bodies import OWN
from ipmlang.runtime.code import Column
from ipmlang.runtime.grouping import FIELD, Grouping
from ipmlang.runtime.keys import Words
from ipmlang.runtime.laying import FIELD as UV
from ipmlang.runtime.laying import Laying
from ipmlang.runtime.pool import Pool
from ipmlang.runtime.scene import SCOPE, SOLID

Places = NDArray[np.int32]
Values = TypeVar("Values", bound="float | NDArray[np.generic]")
Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(slots=True, eq=False)
class Chunk:
    """Drawings `start` .. `start + count`. Columns are one number or one a row of the batch that
    drew; `rows` are those of the batch that did (None: all). The key of each is the child of (k0,
    k1) at `site`, in the copies, or those words themselves.
    """

    start: int
    count: int
    rule: int | NDArray[np.int32]
    symbol: int | NDArray[np.int32]
    asset: int | NDArray[np.int32]
    size: tuple[Column, ...]
    state: dict[str, Column]
    k0: Words
    k1: Words
    site: int = OWN
    copies: tuple[Words, ...] = ()
    rows: NDArray[np.int64] | None = None

    def column(self, value: Values) -> Values:
        """A column's values for the rows that drew."""
        if self.rows is None or not isinstance(value, np.ndarray):
            return value
        return value[self.rows]  # type: ignore[return-value]  # the same kind of array

    def key(self) -> NDArray[np.uint64]:
        """The keys of what was drawn, packed."""
        words = [self.column(each) for each in (self.k0, self.k1, *self.copies)]
        if self.site == OWN:
            return keys.packed(words[0], words[1])
        return keys.packed(*keys.child(words[0], words[1], self.site, *words[2:]))


def rows(
    program: ir.Program,
    chunks: Sequence[Chunk],
    places: Places,
    initial: dict[str, float],
    grouping: Grouping,
    laying: Laying,
    pool: Pool,
) -> Rows:
    """All drawings in the order of their places (n,); `initial` are the state's fields,
    `pool` has the geometries.
    """
    columns = _Columns(chunks, places)
    count = len(places)
    key = columns.keys()
    for chunk in chunks:
        chunk.k0 = chunk.k1 = np.zeros(0, np.uint32)
        chunk.copies = ()
    width = columns.field("width", np.float32, np.nan)
    layer = columns.field("layer", np.float64, 0.0)
    scale = columns.field("scale", np.float64, 1.0)
    texts = {name: columns.field(name, np.int32, -1) for name in TEXT_FIELDS if name in initial}
    color = columns.field("color", np.int32, -1)
    group = columns.field(FIELD, np.int32, -1)
    way = columns.field(UV, np.int32, -1)
    asset = columns.filled(np.int32, lambda chunk: chunk.asset)
    shape = np.full(count, -1, np.int32)
    if "geo" in initial:
        geometry = columns.field("geo", np.float64, 0.0)
        asset = np.where(asset == SCOPE, pool.kinds(geometry), asset)
        shape[asset == SOLID] = geometry[asset == SOLID]
    position = np.zeros((count, 3))
    axes = "xy" if "angle" in initial else "xyz"
    columns.rows(position, lambda chunk: [chunk.state.pop(name) for name in axes])
    rotation = _rotation(columns, count, "angle" in initial)
    size = np.zeros((count, 3))
    columns.rows(size, _size)
    return Rows(
        position,
        rotation,
        scale,
        size,
        asset,
        shape,
        width,
        color,
        texts,
        layer,
        columns.filled(np.int32, lambda chunk: chunk.symbol),
        columns.filled(np.int32, lambda chunk: chunk.rule),
        key,
        grouping.groups(program, group),
        laying.maps(way),
    )


def _rotation(columns: _Columns, count: int, planar: bool) -> NDArray[np.float64]:
    rotation = np.zeros((count, 4))
    if not planar:
        columns.rows(rotation, lambda chunk: [chunk.state.pop(name) for name in "wijk"])
        for start in range(0, count, 1 << 16):
            part = rotation[start : start + (1 << 16)]
            part /= np.sqrt(np.einsum("ij,ij->i", part, part))[:, None]
        return rotation
    angle = np.empty(count)
    columns.write(angle, lambda chunk: chunk.state.pop("angle"))
    for start in range(0, count, 1 << 16):
        rotation[start : start + (1 << 16)] = scan.about_z(angle[start : start + (1 << 16)])
    return rotation


class _Columns:
    """Writes one column after the other."""

    def __init__(self, chunks: Sequence[Chunk], places: Places) -> None:
        self._chunks = chunks
        self._places = places

    def keys(self) -> NDArray[np.uint64]:
        """The keys of all drawings."""
        out = np.empty(len(self._places), np.uint64)
        for chunk in self._chunks:
            if chunk.count:
                out[self._places[chunk.start : chunk.start + chunk.count]] = chunk.key()
        return out

    def write(
        self,
        out: NDArray[np.generic],
        value: Callable[[Chunk], float | NDArray[np.generic]],
    ) -> None:
        """Put a column of all chunks into place."""
        for chunk in self._chunks:
            if chunk.count:
                found = chunk.column(value(chunk))
                out[self._places[chunk.start : chunk.start + chunk.count]] = found

    def rows(self, out: NDArray[np.float64], values: Callable[[Chunk], Sequence[Column]]) -> None:
        """Put the first columns of a table of all chunks into place, a whole row at a time."""
        for chunk in self._chunks:
            if not chunk.count:
                continue
            found = [chunk.column(value) for value in values(chunk)]
            places = self._places[chunk.start : chunk.start + chunk.count]
            if len(found) == 1:
                out[places, 0] = found[0]
                continue
            block = np.zeros((chunk.count, out.shape[1]))
            for axis, column in enumerate(found):
                block[:, axis] = column
            out[places] = block

    def filled(
        self, kind: type[Scalar], value: Callable[[Chunk], float | NDArray[np.generic]]
    ) -> NDArray[Scalar]:
        """A new column."""
        values = [value(chunk) for chunk in self._chunks if chunk.count]
        if values and all(isinstance(each, int | float) and each == values[0] for each in values):
            return np.full(len(self._places), values[0], kind)
        out = np.empty(len(self._places), kind)
        waiting = iter(values)
        self.write(out, lambda chunk: next(waiting))
        return out

    def field(self, name: str, kind: type[Scalar], default: float) -> NDArray[Scalar]:
        """A new column of a field of the state, which may not be there."""
        if not any(name in chunk.state for chunk in self._chunks):
            return np.full(len(self._places), default, kind)
        return self.filled(kind, lambda chunk: chunk.state.pop(name))


def _size(chunk: Chunk) -> Sequence[Column]:
    """The sizes that are not 0 throughout, from the first axis on."""
    plain = all(isinstance(value, float) and value == 0.0 for value in chunk.size[1:])
    return chunk.size[:1] if plain else chunk.size
