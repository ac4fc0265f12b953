"""Solids of several terminals: what `union`, `subtract` and `intersect` make of their parts.

In go the rows that a derivation drew, with the part of a boolean that each was drawn in; out come
rows of which those of each boolean are replaced by one. Booleans within parts come first. Equal
ones are worked out once. No rule is known here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.geometry.booleans import Kind, boolean
from ipmlang.geometry.solid import GeometryError, Solid, is_closed, joined
from ipmlang.geometry.trouble import computing
from ipmlang.runtime.rows import Rows
from ipmlang.runtime.scene import SCOPE, SEGMENT
from ipmlang.runtime.scopes.joins import Joining, Met
from ipmlang.runtime.scopes.pool import Pool

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
NEAR = 1e-9  # vertices this near, as a part of the solid's size, are one
DIGITS = 9  # of places that are the same, in units of the operation's frame


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Frames of m things: position (m, 3), rotation (m, 3, 3) with axes as columns, signed scale
    (m,).
    """

    position: Floats
    rotation: Floats
    scale: Floats

    def take(self, rows: Numbers) -> Frames:
        """Some of them."""
        return Frames(self.position[rows], self.rotation[rows], self.scale[rows])


@dataclass(frozen=True, slots=True, eq=False)
class Members:
    """What parts consist of, m solids: the part, the number of the geometry (of an asset as its
    file has it: ~asset), the frame, the size (m, 3), and the row that it stands for.
    """

    part: Numbers
    geometry: Numbers
    frames: Frames
    size: Floats
    row: Numbers


def with_joined(rows: Rows, part: NDArray[np.int32], geometry: Floats, joining: Joining,
                pool: Pool) -> Rows:  # fmt: skip
    """The rows (n,) with one for each outermost boolean; `part` (n,) and `geometry` (n,): numbers
    of the innermost part and of the geometry. A row takes the pen and the label of the first one
    that its parts drew. Raises IpmError for parts that are no closed solids.
    """
    if not (part >= 0).any():
        return rows
    groups = _Groups(joining)
    members = _members(rows, part, geometry, groups)
    waiting = [members]
    done: list[Members] = []
    for depth in range(int(groups.depth.max()), -1, -1):
        every = _together(waiting)
        own = groups.depth[groups.of_part(every.part)] == depth
        made = _combined(_some(every, np.flatnonzero(own)), groups, pool)
        waiting = [_some(every, np.flatnonzero(~own)), _some(made, np.flatnonzero(made.part >= 0))]
        done.append(_some(made, np.flatnonzero(made.part < 0)))
    return _replaced(rows, part, _together(done), pool)


class _Groups:
    """All uses of booleans: `met` of each, its number there, the part around it, its depth, and
    its frame.
    """

    def __init__(self, joining: Joining) -> None:
        self.met = joining.met
        self._starts = np.array([each.first for each in self.met])
        counts = [each.count for each in self.met]
        self._begins = np.cumsum([0, *counts])
        self.of = np.repeat(np.arange(len(counts)), counts)
        self.around = np.concatenate([each.around for each in self.met])
        self.frames = _frames(*np.split(np.concatenate([m.frames for m in self.met]), (3, 7), 1))
        self.depth = np.zeros(len(self.of), np.int64)
        for number in np.flatnonzero(self.around >= 0).tolist():  # those around come before
            self.depth[number] = self.depth[self.of_part(self.around[number : number + 1])[0]] + 1

    def of_part(self, parts: Numbers) -> Numbers:
        """The group that each part belongs to."""
        met = np.searchsorted(self._starts, parts, side="right") - 1
        many = np.array([each.parts for each in self.met])[met]
        found: Numbers = self._begins[met] + (parts - self._starts[met]) // many
        return found

    def place(self, parts: Numbers) -> Numbers:
        """Which part of its group each is."""
        met = np.searchsorted(self._starts, parts, side="right") - 1
        many = np.array([each.parts for each in self.met])[met]
        found: Numbers = (parts - self._starts[met]) % many
        return found


def _frames(position: Floats, rotation: Floats, scale: Floats) -> Frames:
    from ipmlang.runtime.export.placing import rotation_matrices

    rotation = rotation / np.linalg.norm(rotation, axis=1, keepdims=True)
    return Frames(position, rotation_matrices(rotation), scale.reshape(-1))


# ------------------------------------------------------------------------------- members


def _members(rows: Rows, part: NDArray[np.int32], geometry: Floats, groups: _Groups) -> Members:
    """What the rows within booleans are."""
    own = np.flatnonzero(part >= 0)
    asset = rows.asset[own]
    if (asset == SEGMENT).any():
        row = int(np.argmax(asset == SEGMENT))
        where = groups.met[groups.of[groups.of_part(part[own[row : row + 1]].astype(np.int64))[0]]]
        raise fail(
            "bad-geometry",
            f"{where.where}: a segment of the turtle is no solid",
            hint="write a cylinder in its place: size(…) cylinder",
        )
    numbers = geometry[own].astype(np.int64)
    as_is = (asset >= 0) & (rows.size[own] == 0).all(axis=1)
    numbers[as_is] = ~asset[as_is].astype(np.int64)
    size = np.where(as_is[:, None], 1.0, rows.size[own])
    frames = _frames(rows.position[own], rows.rotation[own], rows.scale[own])
    return Members(part[own].astype(np.int64), numbers, frames, size, own)


def _some(members: Members, chosen: Numbers) -> Members:
    return Members(
        members.part[chosen],
        members.geometry[chosen],
        members.frames.take(chosen),
        members.size[chosen],
        members.row[chosen],
    )


def _together(parts: Sequence[Members]) -> Members:
    def column(of: Callable[[Members], NDArray[np.generic]]) -> NDArray[np.generic]:
        return np.concatenate([of(each) for each in parts])

    frames = Frames(
        cast("Floats", column(lambda each: each.frames.position)),
        cast("Floats", column(lambda each: each.frames.rotation)),
        cast("Floats", column(lambda each: each.frames.scale)),
    )
    return Members(
        cast("Numbers", column(lambda each: each.part)),
        cast("Numbers", column(lambda each: each.geometry)),
        frames,
        cast("Floats", column(lambda each: each.size)),
        cast("Numbers", column(lambda each: each.row)),
    )


# ------------------------------------------------------------------------------ combining


def _combined(members: Members, groups: _Groups, pool: Pool) -> Members:
    """One solid for each group, in its frame; groups of which nothing is left have none."""
    order = np.lexsort((members.row, members.part))
    members = _some(members, order)
    group = groups.of_part(members.part)
    maps = _maps(members, groups.frames.take(group))
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    spans = zip(begins.tolist(), [*begins[1:].tolist(), len(group)], strict=True)
    numbers, rows, lows, sizes, own = [], [], [], [], []
    for begin, end in spans:
        met = groups.met[int(groups.of[group[begin]])]
        parts = groups.place(members.part[begin:end])
        found = _made(met, parts, members.geometry[begin:end], maps[begin:end],
                      members.size[begin:end], pool)  # fmt: skip
        if found is None:
            continue
        number, low, size = found
        numbers.append(number)
        rows.append(int(members.row[begin:end].min()))
        lows.append(low)
        sizes.append(size)
        own.append(int(group[begin]))
    chosen = np.array(own, np.int64)
    frames = groups.frames.take(chosen)
    low = np.array(lows).reshape(-1, 3)
    moved = frames.position + np.einsum("nij,nj->ni", _linear(frames), low)
    return Members(
        groups.around[chosen],
        np.array(numbers, np.int64),
        Frames(moved, frames.rotation, frames.scale),
        np.array(sizes).reshape(-1, 3),
        np.array(rows, np.int64),
    )


def _linear(frames: Frames) -> Floats:
    """The maps (m, 3, 3) of frames without their places."""
    found = frames.rotation * np.abs(frames.scale)[:, None, None]
    found[:, :, 0] *= np.sign(frames.scale)[:, None]
    return found


def _maps(members: Members, into: Frames) -> Floats:
    """The maps (m, 3, 4) from the members' own coordinates to those of other frames."""
    back = np.linalg.inv(_linear(into))
    linear = back @ _linear(members.frames)
    place = np.einsum("nij,nj->ni", back, members.frames.position - into.position)
    return np.concatenate([linear, place[:, :, None]], axis=2)


Made = tuple[int, Floats, Floats]


def _made(
    met: Met, parts: Numbers, geometry: Numbers, maps: Floats, size: Floats, pool: Pool
) -> Made | None:
    """The number, the corner and the size of what an operation makes of solids; each is made once
    where the same solids stand in the same places.
    """
    key = (
        "boolean", met.kind, met.parts, parts.tobytes(), geometry.tobytes(),
        (np.round(maps, DIGITS) + 0.0).tobytes(), (np.round(size, DIGITS) + 0.0).tobytes(),
    )  # fmt: skip

    def make() -> Made | None:
        solids = [_placed(*each, pool) for each in zip(geometry.tolist(), size, maps, strict=True)]
        own = [
            [solid for solid, place in zip(solids, parts.tolist(), strict=True) if place == number]
            for number in range(met.parts)
        ]
        found = _boolean(cast("Kind", met.kind), own)
        return None if found is None or not len(found) else pool.add(found)

    try:
        with computing():
            return cast("Made | None", pool.derived(key, make))
    except GeometryError as error:
        message = f"{met.where}: {error.message}"
        raise fail("bad-geometry", message, hint=error.hint) from error


def _placed(number: int, size: Floats, matrix: Floats, pool: Pool) -> Solid:
    """A member's geometry in the coordinates of the operation."""
    solid = pool.as_file(~number) if number < 0 else pool.local(number, size)
    vertices = solid.vertices @ matrix[:, :3].T + matrix[:, 3]
    moved = replace(solid, vertices=vertices, uv=None)
    if np.linalg.det(matrix[:, :3]) < 0:
        from ipmlang.geometry.converting import reversed_normals

        return reversed_normals(moved)
    return moved


def _boolean(kind: Kind, parts: Sequence[Sequence[Solid]]) -> Solid | None:
    """What is made of parts that consist of solids each, in the order of the parts."""
    own = [_whole(kind, number, solids) for number, solids in enumerate(parts, 1)]
    there = [each for each in own if each is not None]
    if (kind == "subtract" and own[0] is None) or (kind == "intersect" and len(there) < len(own)):
        return None
    return boolean(there, kind)


def _whole(kind: Kind, number: int, solids: Sequence[Solid]) -> Solid | None:
    """The solid of one part: all its solids united, or the one that its faces close."""
    if not solids:
        return None
    welded = [_welded(each) for each in solids]
    if all(map(is_closed, welded)):
        return welded[0] if len(welded) == 1 else boolean(welded, "union")
    whole = _welded(joined(welded))
    if not is_closed(whole):
        raise GeometryError(
            f"`{kind}` needs closed solids, and what its part {number} draws has open edges",
            "give polygons a thickness first, as with extrude(0.2); a part that takes a solid "
            "apart must draw all of it",
        )
    return whole


def _welded(solid: Solid) -> Solid:
    from ipmlang.geometry.sharing import first_at_place

    if is_closed(solid):
        return solid
    near = NEAR * float(np.ptp(solid.vertices, axis=0).max(initial=0.0))
    return replace(solid, corners=first_at_place(solid.vertices, near)[solid.corners])


# ------------------------------------------------------------------------------ replacing


def _replaced(rows: Rows, part: NDArray[np.int32], made: Members, pool: Pool) -> Rows:
    """The rows outside booleans, and those that the booleans made."""
    keep = part < 0
    keep[made.row] = True
    chosen = np.flatnonzero(keep)
    position, size = np.array(rows.position), np.array(rows.size)
    scale, rotation = np.array(rows.scale), np.array(rows.rotation)
    asset, shape = np.array(rows.asset), np.array(rows.shape)
    position[made.row] = made.frames.position
    size[made.row], scale[made.row] = made.size, made.frames.scale
    rotation[made.row] = _quaternions(made.frames.rotation)
    asset[made.row] = pool.kinds(made.geometry.astype(np.float64))
    shape[made.row] = np.where(asset[made.row] == SCOPE, -1, made.geometry)
    groups, maps = rows.groups, rows.texture_maps
    return Rows(
        position[chosen],
        rotation[chosen],
        scale[chosen],
        size[chosen],
        asset[chosen],
        shape[chosen],
        rows.width[chosen],
        rows.color[chosen],
        {name: column[chosen] for name, column in rows.texts.items()},
        rows.layer[chosen],
        rows.symbol[chosen],
        rows.rule[chosen],
        rows.key[chosen],
        None if groups is None else replace(groups, of=groups.of[chosen]),
        None if maps is None else replace(maps, of=maps.of[chosen]),
        chosen,
    )


def _quaternions(rotation: Floats) -> Floats:
    from ipmlang.runtime.scopes.boxes import quaternion

    return quaternion(rotation.transpose(0, 2, 1))
