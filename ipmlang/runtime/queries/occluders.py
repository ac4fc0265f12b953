"""What the first pass of a derivation made, as the second one asks about it.

In go the rows and drawings of the first pass, and the scopes of shapes that ask; out come truth
values and distances. A tree of boxes gives the pairs that may meet; boxes are compared many at a
time, other geometry pair by pair. Shapes of one line of descent are never compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler.ops.queries import FAR
from ipmlang.geometry import oriented
from ipmlang.geometry.contacts import Form, contact, distance, form_of, thin
from ipmlang.geometry.hierarchy import Tree
from ipmlang.geometry.oriented import Boxes, Flags
from ipmlang.geometry.solid import Floats
from ipmlang.runtime.code import Column
from ipmlang.runtime.queries.marks import FIELD, NAMED, Marks, Numbers
from ipmlang.runtime.queries.nesting import Nesting, nesting
from ipmlang.runtime.scopes.boxes import ROTATION, SIZES, full, hand, rotated
from ipmlang.runtime.scopes.pool import BOX, NOTHING, Pool

NEIGHBOURS = 8  # of a shape, in which the nearest is looked for first


@dataclass(frozen=True, slots=True, eq=False)
class Scopes:
    """The scopes and geometries of n shapes: frames, sizes (n, 3) in the world, and numbers in a
    pool. A shape without geometry stands for its scope.
    """

    boxes: Boxes
    corner: Floats
    hand: Floats
    geometry: Numbers
    plain: Flags
    pool: Pool

    def __len__(self) -> int:
        return len(self.corner)

    def form(self, row: int) -> Form:
        """The geometry of one shape in the world."""
        size = 2 * self.boxes.half[row]
        axes = self.boxes.axes[row] * np.array((self.hand[row], 1.0, 1.0))[:, None]
        if (size > 0).sum() < 2:
            middle, along = self.boxes.middle[row], self.boxes.half[row] @ self.boxes.axes[row]
            return thin(middle - along, middle + along)
        number = int(self.geometry[row]) or BOX
        flat = tuple(size <= 0)
        key = ("form", number, flat)  # what a form holds does not depend on how it is stretched
        unit = np.where(flat, 0.0, 1.0)
        form = self.pool.derived(key, lambda: form_of(self.pool.local(number, unit)))
        assert isinstance(form, Form)
        return form.at((form.solid.vertices * size) @ axes + self.corner[row])


def scopes_of(state: Mapping[str, Column], count: int, rows: Numbers | None, pool: Pool) -> Scopes:
    """The scopes of a batch, or of some rows of it."""
    own = {name: full(state[name], count) for name in state if name != FIELD}
    if rows is not None:
        own = {name: column[rows] for name, column in own.items()}
        count = len(rows)
    rotation = tuple(own[name] for name in ROTATION)
    units = [rotated(rotation, tuple(np.eye(3)[axis])) for axis in range(3)]
    axes = np.stack([np.stack(np.broadcast_arrays(*unit), axis=1) for unit in units], axis=1)
    side = full(hand(own), count)
    scale = np.abs(full(own.get("scale", 1.0), count))
    size = np.stack([own[name] for name in SIZES], axis=1) * scale[:, None]
    corner = np.stack([own[axis] for axis in "xyz"], axis=1)
    turned = axes * np.stack([side, np.ones(count), np.ones(count)], axis=1)[:, :, None]
    middle = corner + np.einsum("nk,nkc->nc", size / 2, turned)
    geometry = own["geo"].astype(np.int64)
    plain = pool.are_boxes(own["geo"]) | (geometry == NOTHING)
    return Scopes(Boxes(middle, axes, size / 2), corner, side, geometry, plain, pool)


def joined(parts: Sequence[Scopes], pool: Pool) -> Scopes:
    """Several batches as one."""
    if not parts:
        blank = np.zeros((0, 3))
        none = np.zeros(0, np.int64)
        return Scopes(Boxes(blank, np.zeros((0, 3, 3)), blank), blank, blank[:, 0], none,
                      none.astype(np.bool_), pool)  # fmt: skip
    whole = Boxes(*(np.concatenate([getattr(each.boxes, name) for each in parts])
                    for name in ("middle", "axes", "half")))  # fmt: skip
    corner, side, geometry, plain = (
        np.concatenate([getattr(each, name) for each in parts])
        for name in ("corner", "hand", "geometry", "plain")
    )
    return Scopes(whole, corner, side, geometry, plain, pool)


@dataclass(slots=True, eq=False)
class Layer:
    """The shapes of one label: their scopes, the row of each (-1: it has none) and the row that it
    is or stands in; the tree over them.
    """

    scopes: Scopes
    row: Numbers
    around: Numbers
    tree: Tree | None = None

    def __post_init__(self) -> None:
        if len(self.scopes):
            self.tree = Tree(*_wide(self.scopes.boxes))


def _wide(boxes: Boxes) -> tuple[Floats, Floats]:
    """The bounds of boxes, wider by the distance that counts as none."""
    low, high = boxes.bounds()
    near = oriented.tolerances(boxes, boxes)[:, None] * 2
    return low - near, high + near


class Occluders:
    """All that one pass made. `drawn`: the batches that were drawn, as states with counts."""

    def __init__(
        self, marks: Marks, pool: Pool, drawn: Sequence[tuple[Mapping[str, Column], int]]
    ) -> None:
        self._marks = marks
        self._pool = pool
        self._drawn = drawn
        self._layers: dict[int, Layer] = {}
        self._order = np.argsort(marks.key, kind="stable")
        self._keys = marks.key[self._order]
        self._nesting = nesting(marks.parent)

    def answer(
        self, name: str, label: Numbers, asking: Scopes, rows: Numbers, marks: Marks
    ) -> Floats:
        """Answers (n,) to a query of shapes that stand in `rows` (n,) of `marks`, those of the
        pass that asks, about labels (n,), -1: all that is drawn or labelled.
        """
        blank = FAR if name == "distance" else 0.0
        found = np.full(len(asking), blank)
        own, first = self._known(rows, marks)
        for each in np.unique(label).tolist():
            asked = np.flatnonzero(label == each)
            layer = self._layer(each)
            if layer.tree is None:
                continue
            one = _Asking(self._nesting, layer, asking, asked, own[asked], first[asked])
            found[asked] = one.nearest() if name == "distance" else one.any(name)
        return found

    # -------------------------------------------------------------------------- who is who

    def _known(self, rows: Numbers, marks: Marks) -> tuple[Numbers, Numbers]:
        """The rows (n,) of the first pass for those that ask, -1 where it did not make them; and
        for the nearest that each is or stands in and that it made.
        """
        own = self._found(rows, marks)
        first, climbed = own.copy(), rows.copy()
        open_ = np.flatnonzero((first < 0) & (climbed >= 0))
        while len(open_):
            climbed[open_] = marks.parent[climbed[open_]]
            open_ = open_[climbed[open_] >= 0]
            first[open_] = self._found(climbed[open_], marks)
            open_ = open_[first[open_] < 0]
        return own, first

    def _found(self, rows: Numbers, marks: Marks) -> Numbers:
        if not len(self._keys):
            return np.full(len(rows), -1)
        key = marks.key[np.maximum(rows, 0)] if marks.count else np.zeros(len(rows), np.uint64)
        at = np.minimum(np.searchsorted(self._keys, key), len(self._keys) - 1)
        return np.where((rows >= 0) & (self._keys[at] == key), self._order[at], -1)

    def _layer(self, label: int) -> Layer:
        if label not in self._layers:
            self._layers[label] = self._make(label)
        return self._layers[label]

    def _make(self, label: int) -> Layer:
        scopes, rows, around = [], [], []
        for chunk in self._marks.chunks:
            if label < 0 and chunk.kind == NAMED:
                continue
            own = np.arange(chunk.start, chunk.start + chunk.count)
            fits = np.flatnonzero((label < 0) | (self._marks.label[own] == label))
            if len(fits):
                batch = fits if chunk.rows is None else chunk.rows[fits]
                many = _rows_of(chunk.state, batch)
                scopes.append(scopes_of(chunk.state, many, batch, self._pool))
                rows.append(own[fits])
                around.append(own[fits])
        for state, count in self._drawn if label < 0 else ():
            scopes.append(scopes_of(state, count, None, self._pool))
            rows.append(np.full(count, -1))
            around.append(full(state[FIELD], count).astype(np.int64))
        none = np.zeros(0, np.int64)
        standing = np.concatenate([none, *around])
        return Layer(joined(scopes, self._pool), np.concatenate([none, *rows]), standing)


def _rows_of(state: Mapping[str, Column], rows: Numbers) -> int:
    """How many rows the columns of a batch have, at least."""
    sizes = [len(each) for each in state.values() if isinstance(each, np.ndarray) and each.ndim]
    return max(sizes, default=int(rows.max()) + 1)


class _Asking:
    """One query about one label: pairs of shapes that ask (numbers among `rows`) and shapes of the
    label.
    """

    def __init__(
        self,
        nesting: Nesting,
        layer: Layer,
        asking: Scopes,
        rows: Numbers,
        own: Numbers,
        first: Numbers,
    ) -> None:
        self._nesting = nesting
        self._layer = layer
        self._scopes = asking
        self._rows = rows
        self._boxes = asking.boxes.take(rows)
        self._own = own
        self._first = first

    def any(self, name: str) -> Floats:
        """1 for each shape for which some pair is so, else 0 (n,)."""
        assert self._layer.tree is not None
        one, other = self._layer.tree.meeting(*_wide(self._boxes))
        kept = ~self._related(one, other)
        one, other = one[kept], other[kept]
        a, b = self._boxes.take(one), self._layer.scopes.boxes.take(other)
        overlap, meet = oriented.meetings(a, b)
        plain = self._plain(one, other)
        holds = {
            "overlaps": overlap,
            "touches": meet & ~overlap,
            "inside": meet & oriented.lies_within(a, b) if name == "inside" else meet,
        }[name] & plain
        found = np.zeros(len(self._rows))
        found[one[holds]] = 1.0
        for pair in np.flatnonzero(meet & ~plain).tolist():
            if not found[one[pair]]:
                found[one[pair]] = getattr(contact(*self._pair(one[pair], other[pair])), name)
        return found

    def nearest(self) -> Floats:
        """The distance to the nearest (n,)."""
        best = self._first_guess()
        assert self._layer.tree is not None
        low, high = self._boxes.bounds()
        one, other = self._layer.tree.within(low, high, best)
        kept = ~self._related(one, other)
        one, other = one[kept], other[kept]
        np.minimum.at(best, one, self._distances(one, other))
        return best

    def _first_guess(self) -> Floats:
        """The distance to one that is near (n,); FAR where there is none at all."""
        from scipy.spatial import cKDTree

        middles = self._layer.scopes.boxes.middle
        places = cKDTree(middles)
        best = np.full(len(self._rows), FAR)
        open_ = np.arange(len(self._rows))
        many = min(NEIGHBOURS, len(middles))
        while len(open_):
            near = np.atleast_2d(places.query(self._boxes.middle[open_], many)[1].reshape(-1, many))
            one, other = np.repeat(open_, many), near.reshape(-1)
            free = ~self._related(one, other).reshape(-1, many)
            rows = np.flatnonzero(free.any(axis=1))
            column = np.argmax(free[rows], axis=1)
            best[open_[rows]] = self._distances(open_[rows], near[rows, column])
            open_ = open_[~free.any(axis=1)]
            if many == len(middles):
                break
            many = min(many * 4, len(middles))
        return best

    def _distances(self, one: Numbers, other: Numbers) -> Floats:
        found = oriented.distances(self._boxes.take(one), self._layer.scopes.boxes.take(other))
        for pair in np.flatnonzero(~self._plain(one, other)).tolist():
            found[pair] = distance(*self._pair(one[pair], other[pair]))
        return found

    def _plain(self, one: Numbers, other: Numbers) -> Flags:
        """Which pairs are boxes both."""
        return self._scopes.plain[self._rows[one]] & self._layer.scopes.plain[other]

    def _pair(self, one: int, other: int) -> tuple[Form, Form]:
        return self._scopes.form(int(self._rows[one])), self._layer.scopes.form(int(other))

    def _related(self, one: Numbers, other: Numbers) -> Flags:
        """Which pairs are of one line of descent."""
        row, around = self._layer.row[other], self._layer.around[other]
        above = self._nesting.holds(row, self._first[one])
        return above | self._nesting.holds(self._own[one], around)
