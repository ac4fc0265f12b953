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
from ipmlang.runtime.code import Column
from ipmlang.runtime.grouping import FIELD, Grouping
from ipmlang.runtime.keys import Words
from ipmlang.runtime.naming import OWN
from ipmlang.runtime.rows import TEXT_FIELDS, Rows
from ipmlang.runtime.scene import OUTLINE, SCOPE, SOLID
from ipmlang.runtime.scopes.joining import with_joined
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.joins import Joining
from ipmlang.runtime.scopes.laying import FIELD as UV
from ipmlang.runtime.scopes.laying import Laying
from ipmlang.runtime.scopes.pool import NOTHING, Pool

Places = NDArray[np.int32]
BLOCK = 1 << 16  # rows that are worked on at once
SMALL = 64  # rows of a chunk whose keys are not worth a call of their own
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
    site: int | Words = OWN
    copies: tuple[Words, ...] = ()
    rows: NDArray[np.int64] | None = None

    def column(self, value: Values) -> Values:
        """A column's values for the rows that drew."""
        if self.rows is None or not isinstance(value, np.ndarray) or not value.ndim:
            return value
        return value[self.rows]  # type: ignore[return-value]  # the same kind of array

    def key(self) -> NDArray[np.uint64]:
        """The keys of what was drawn, packed."""
        words = [self.column(each) for each in (self.k0, self.k1, *self.copies)]
        if isinstance(self.site, int) and self.site == OWN:
            return keys.packed(words[0], words[1])
        return keys.packed(*keys.child(words[0], words[1], self.column(self.site), *words[2:]))


def rows(
    program: ir.Program,
    chunks: Sequence[Chunk],
    places: Places,
    initial: dict[str, float],
    grouping: Grouping,
    laying: Laying,
    joining: Joining,
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
    part = columns.field(JOIN, np.int32, -1)
    asset = columns.filled(np.int32, lambda chunk: chunk.asset)
    shape = constant(-1, count, np.int32)
    geometry = constant(0.0, count, np.float64)
    if "geo" in initial:
        geometry = columns.field("geo", np.float64, 0.0)
        outlined = asset == OUTLINE
        if outlined.any():
            shape = np.where(outlined, geometry, -1).astype(np.int32)
            geometry = np.where(outlined, NOTHING, geometry)
        if not pool.only_boxes:
            asset = np.where(asset == SCOPE, pool.kinds(geometry), asset)
            shape = np.where(asset == SOLID, geometry, shape).astype(np.int32)
    position = columns.table([*("xy" if "angle" in initial else "xyz")], 3)
    rotation = _rotation(columns, count, "angle" in initial)
    size = columns.sizes()
    made = Rows(
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
    return with_joined(made, part, geometry, joining, pool) if joining.met else made


def _rotation(columns: _Columns, count: int, planar: bool) -> NDArray[np.float64]:
    if not planar:
        rotation = columns.table(["w", "i", "j", "k"], 4)
        if not rotation.flags.writeable:  # it is the same for all
            own = rotation[:1] / np.linalg.norm(rotation[:1])
            return np.broadcast_to(own, (count, 4))
        for start in range(0, count, BLOCK):
            part = rotation[start : start + BLOCK]
            part /= np.sqrt(np.einsum("ij,ij->i", part, part))[:, None]
        return rotation
    angle = np.empty(count)
    columns.write(angle, lambda chunk: chunk.state.pop("angle"))
    rotation = np.zeros((count, 4))
    for start in range(0, count, BLOCK):
        rotation[start : start + BLOCK] = scan.about_z(angle[start : start + BLOCK])
    return rotation


class _Columns:
    """Writes one column after the other."""

    def __init__(self, chunks: Sequence[Chunk], places: Places) -> None:
        self._chunks = chunks
        self._places = places.astype(np.int64)  # what numpy would make of them each time

    def keys(self) -> NDArray[np.uint64]:
        """The keys of all drawings; those of chunks of a few rows are hashed together."""
        out = np.empty(len(self._places), np.uint64)
        small: dict[int, list[Chunk]] = {}
        for chunk in self._chunks:
            if chunk.count > SMALL or not isinstance(chunk.site, int) or chunk.site == OWN:
                out[self._places[self._rows_of(chunk)]] = chunk.key()
            elif chunk.count:
                small.setdefault(len(chunk.copies), []).append(chunk)
        for chunks in small.values():
            found = _keys_of(chunks)
            rows = np.concatenate([self._places[self._rows_of(chunk)] for chunk in chunks])
            out[rows] = found
        return out

    def _rows_of(self, chunk: Chunk) -> slice:
        return slice(chunk.start, chunk.start + chunk.count)

    def write(
        self,
        out: NDArray[np.generic],
        value: Callable[[Chunk], float | NDArray[np.generic]],
    ) -> None:
        """Put a column of all chunks into place: of many small ones as one column."""
        many = len(self._places) < SMALL * len(self._chunks)
        whole = np.empty(len(self._places), out.dtype) if many else None
        for chunk in self._chunks:
            if chunk.count:
                rows, found = self._rows_of(chunk), chunk.column(value(chunk))
                if whole is None:
                    out[self._places[rows]] = found
                else:
                    whole[rows] = found
        if whole is not None:
            out[self._places] = whole

    def table(self, names: Sequence[str], width: int) -> NDArray[np.float64]:
        """A table (n, width) of fields of the state, a column each; the others are 0. One that is
        the same in all rows cannot be written to.
        """
        return self._stacked(
            [[chunk.state.pop(name) for chunk in self._chunks] for name in names], width
        )

    def sizes(self) -> NDArray[np.float64]:
        """The table (n, 3) of all sizes."""
        return self._stacked([[chunk.size[axis] for chunk in self._chunks] for axis in range(3)], 3)

    def _stacked(self, parts: Sequence[Sequence[Column]], width: int) -> NDArray[np.float64]:
        """Columns, each given chunk by chunk, lie one after the other in memory: each is written
        at once.
        """
        count = len(self._places)
        same = [_the_same(chunks) for chunks in parts]
        if all(each is not None for each in same):
            row = np.array([*same, *([0.0] * (width - len(parts)))], np.float64)
            return np.broadcast_to(row, (count, width))
        out = np.zeros((width, count))
        for column, chunks, value in zip(out, parts, same, strict=False):
            if value is None:
                waiting = iter([each for each, own in zip(chunks, self._chunks, strict=True)
                                if own.count])  # fmt: skip
                self.write(column, lambda chunk, waiting=waiting: next(waiting))  # type: ignore[misc]
            elif value:
                column[:] = value
        return out.T

    def filled(
        self, kind: type[Scalar], value: Callable[[Chunk], float | NDArray[np.generic]]
    ) -> NDArray[Scalar]:
        """A new column."""
        values = [value(chunk) for chunk in self._chunks if chunk.count]
        if values and all(isinstance(each, int | float) and each == values[0] for each in values):
            return constant(float(values[0]), len(self._places), kind)
        out = np.empty(len(self._places), kind)
        waiting = iter(values)
        self.write(out, lambda chunk: next(waiting))
        return out

    def field(self, name: str, kind: type[Scalar], default: float) -> NDArray[Scalar]:
        """A new column of a field of the state, which may not be there."""
        if not any(name in chunk.state for chunk in self._chunks):
            return constant(default, len(self._places), kind)
        return self.filled(kind, lambda chunk: chunk.state.pop(name))


def _keys_of(chunks: Sequence[Chunk]) -> NDArray[np.uint64]:
    """The keys of chunks with equally many copies around them and one site each, one chunk after
    the other.
    """
    words = [map(chunk.column, (chunk.k0, chunk.k1, *chunk.copies)) for chunk in chunks]
    k0, k1, *copies = (np.concatenate(column) for column in zip(*words, strict=True))
    sites = np.array([chunk.site for chunk in chunks], np.uint32)
    site = np.repeat(sites, [chunk.count for chunk in chunks])
    return keys.packed(*keys.child(k0, k1, site, *copies))


def constant(value: float, count: int, kind: type[Scalar]) -> NDArray[Scalar]:
    """A column of one number, which takes no memory and cannot be written to."""
    return np.broadcast_to(np.array(value).astype(kind), (count,))


def _the_same(values: Sequence[Column]) -> float | None:
    """The number that a column is in all chunks, if it is one."""
    if not values:
        return 0.0
    first = values[0]
    if any(isinstance(each, np.ndarray) or each != first for each in values):
        return None
    return float(first)
