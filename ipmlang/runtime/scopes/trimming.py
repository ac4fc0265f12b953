"""Faces that `comp` gave, and what `trim` cuts of the shapes that came of them.

In go the pieces of a `comp`, as columns of a batch; out come numbers, which shapes carry in their
state like a pen's colour. `trim` cuts a shape by the planes between its face and those beside it,
once for each shape that differs. Nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.geometry.mitres import Edges, mitres
from ipmlang.geometry.slabs import trim
from ipmlang.geometry.solid import Solid, normals, rings_of
from ipmlang.runtime.code import Column
from ipmlang.runtime.fields import TRIM
from ipmlang.runtime.limits import Counted
from ipmlang.runtime.queries.snapping import Snapping
from ipmlang.runtime.scopes import boxes
from ipmlang.runtime.scopes.boxes import SIZES, State, full
from ipmlang.runtime.scopes.pieces import Batched
from ipmlang.runtime.scopes.pool import NOTHING, Load, Pool
from ipmlang.runtime.scopes.scoping import Keys, Rows
from ipmlang.runtime.scopes.shaping import Given

if TYPE_CHECKING:
    from ipmlang.runtime.queries.occluders import Occluders

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
FRAME = ("x", "y", "z", "w", "i", "j", "k", "scale")
DIGITS = 9  # of places that are the same


@dataclass(slots=True, eq=False)
class Trims:
    """The faces of one derivation: of each the frame (8), the size (3) and the geometry of the
    solid that it was taken from, and its own frame and size.
    """

    faces: list[Floats] = field(default_factory=list)
    count: int = 0

    def note(self, whole: Mapping[str, Column], owner: Numbers, own: Mapping[str, Column],
             count: int) -> Floats:  # fmt: skip
        """Numbers (m,) for pieces; `whole`: the scopes (count,) that they were taken from."""
        before = [np.asarray(full(whole.get(name, 1.0), count))[owner]
                  for name in (*FRAME, *SIZES, "geo")]  # fmt: skip
        after = [full(own.get(name, 1.0), len(owner)) for name in (*FRAME, *SIZES)]
        self.faces.append(np.stack([*before, *after], axis=1))
        first = self.count
        self.count += len(owner)
        return np.arange(first, self.count, dtype=np.float64)

    def table(self) -> Floats:
        """All faces (n, 23)."""
        if len(self.faces) > 1:
            self.faces = [np.concatenate(self.faces)]
        return self.faces[0]


class Trimming(Snapping):
    """The part of a run that knows which faces shapes came of."""

    def __init__(
        self,
        program: ir.Program,
        counted: Counted,
        load: Load,
        answers: Occluders | None = None,
    ) -> None:
        super().__init__(program, counted, load, answers)
        self.trims = Trims()

    def pieces(
        self,
        name: str,
        selectors: Sequence[ir.Const],
        count: int,
        args: Sequence[Column],
        state: State,
        keys: Keys,
        shown: Rows,
    ) -> list[Batched]:
        """The parts that an operation makes; of faces it is noted where they came from."""
        made = super().pieces(name, selectors, count, args, state, keys, shown)
        if TRIM in state and name == "comp":
            for each in made:
                each.state[TRIM] = self.trims.note(state, each.owner, each.state, count)
        return made

    def solid(
        self, name: str, count: int, args: Sequence[Column], state: State, shown: Rows
    ) -> State:
        """What an operation makes of scopes and geometries; the columns that it changes."""
        if name == TRIM and count:
            edges = Given(self.program, self.pool, name, args, count).word(0) if args else "all"
            chosen = cast("Edges", edges)
            return {**state, **trimmed(self.trims, self.pool, count, state, shown, chosen)}
        return super().solid(name, count, args, state, shown)


def trimmed(
    trims: Trims, pool: Pool, count: int, state: State, shown: Numbers | None, edges: Edges
) -> dict[str, Column]:
    """The places, sizes and geometries after a trim, of the rows of a batch that are there."""
    numbers = full(state[TRIM], count)
    there = (numbers >= 0) & (full(state["geo"], count) != NOTHING)
    if shown is not None:
        there = there & np.isin(np.arange(count), shown)
    rows = np.flatnonzero(there)
    unchanged = {name: state[name] for name in (*boxes.AXES, *SIZES, "geo")}
    if not len(rows):
        return unchanged
    faces = trims.table()[numbers[rows].astype(np.int64)]
    own = np.stack([full(state.get(name, 1.0), count)[rows] for name in FRAME], axis=1)
    shape = np.stack([full(state[name], count)[rows] for name in (*SIZES, "geo")], axis=1)
    into = _within(own, faces[:, :8])
    born = _within(faces[:, 12:20], faces[:, :8])
    table = np.concatenate([shape, into, faces[:, 8:12], born, faces[:, 20:23]], axis=1)
    table = np.round(table, DIGITS) + 0.0
    distinct, kind = np.unique(table, axis=0, return_inverse=True)
    found = np.stack([_one(pool, row, edges) for row in distinct])[kind.reshape(-1)]
    step = np.zeros((count, 3))
    step[rows] = found[:, :3]
    changed: dict[str, Column] = dict(boxes.moved(state, (step[:, 0], step[:, 1], step[:, 2])))
    for place, name in enumerate((*SIZES, "geo")):
        column = np.array(full(state[name], count))
        column[rows] = found[:, 3 + place]
        changed[name] = column
    return changed


def _within(own: Floats, around: Floats) -> Floats:
    """Maps (n, 12) from the coordinates of frames (n, 8) to those of others, row by row."""
    from ipmlang.runtime.export.placing import rotation_matrices

    linear = []
    for frames in (own, around):
        turn = frames[:, 3:7] / np.linalg.norm(frames[:, 3:7], axis=1, keepdims=True)
        matrix = rotation_matrices(turn) * np.abs(frames[:, 7])[:, None, None]
        matrix[:, :, 0] *= np.sign(frames[:, 7])[:, None]
        linear.append(matrix)
    back = np.linalg.inv(linear[1])
    place = np.einsum("nij,nj->ni", back, own[:, :3] - around[:, :3])
    return np.concatenate([(back @ linear[0]).reshape(-1, 9), place], axis=1)


def _one(pool: Pool, row: Floats, edges: Edges) -> Floats:
    """Corner, size and geometry (7,) of one shape after its trim."""
    size, number = row[:3], int(row[3])
    into, whole, born, extent = row[4:16], row[16:20], row[20:32], row[32:]
    key = ("trim", edges, whole.tobytes(), born.tobytes(), extent.tobytes())
    planes = pool.derived(key, lambda: _planes(pool, whole, born, extent, edges))
    assert isinstance(planes, tuple)
    linear, place = into[:9].reshape(3, 3), into[9:]
    points = np.linalg.solve(linear, (planes[0] - place).T).T
    directions = planes[1] @ linear
    solid = pool.local(number, size)
    left = trim(solid, zip(points, directions, strict=True))
    if left is None or not len(left):
        return np.zeros(7)
    if left is solid:
        return np.array([0.0, 0.0, 0.0, *size, number])
    made, low, extents = pool.add(left)
    return np.array([*low, *extents, made])


def _planes(
    pool: Pool, whole: Floats, born: Floats, extent: Floats, edges: Edges
) -> tuple[Floats, Floats]:
    """Points and normals of the planes around a face, in the coordinates of its solid."""
    solid = pool.local(int(whole[3]), whole[:3])
    if len(solid) < 2:
        return np.zeros((0, 3)), np.zeros((0, 3))
    return mitres(solid, _face(solid, born[:9].reshape(3, 3), born[9:], extent), edges)


def _face(solid: Solid, axes: Floats, origin: Floats, extent: Floats) -> int:
    """The face of a solid whose scope has these axes (as columns), this origin and this size."""
    misses = []
    looks = normals(solid) @ (axes[:, 2] / np.linalg.norm(axes[:, 2]))
    for face in range(len(solid)):
        if looks[face] < 0.999:
            misses.append(np.inf)
            continue
        outline = solid.vertices[next(rings_of(solid, face))]
        local = np.linalg.solve(axes, (outline - origin).T).T
        low, high = local.min(axis=0), local.max(axis=0)
        misses.append(float(np.abs(low).sum() + np.abs(high - extent).sum()))
    return int(np.argmin(misses))
