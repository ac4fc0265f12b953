"""Scopes that their geometry fills, as columns: the faces of boxes, frames moved and turned.

In go columns of frames and extents, out come columns; nothing loops over shapes. This is what makes
a façade of a million tiles cheap: as long as a shape is a box or a rectangle, it has no vertices.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime import scan
from ipmlang.runtime.code import Column

Floats = NDArray[np.float64]
State = dict[str, Column]
AXES = ("x", "y", "z")
SIZES = ("sx", "sy", "sz")
ROTATION = ("w", "i", "j", "k")

# of each face of a box, in the order of geometry.solid.unit_box: its axes as rows in those of the
# box, the corner of the box where it begins, and the axes of the box along which it extends
FACES: tuple[tuple[tuple[tuple[int, ...], ...], tuple[int, int, int], tuple[int, int]], ...] = (
    (((1, 0, 0), (0, -1, 0), (0, 0, -1)), (0, 1, 0), (0, 1)),  # bottom
    (((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, 0, 1), (0, 1)),  # top
    (((1, 0, 0), (0, 0, 1), (0, -1, 0)), (0, 0, 0), (0, 2)),  # front
    (((0, 1, 0), (0, 0, 1), (1, 0, 0)), (1, 0, 0), (1, 2)),  # right
    (((-1, 0, 0), (0, 0, 1), (0, 1, 0)), (1, 1, 0), (0, 2)),  # back
    (((0, -1, 0), (0, 0, 1), (-1, 0, 0)), (0, 1, 0), (1, 2)),  # left
)
_SIDE = frozenset({"all", "side", "vertical"})
WORDS = (
    frozenset({"all", "bottom", "horizontal"}),
    frozenset({"all", "top", "horizontal"}),
    *(_SIDE | {word} for word in ("front", "right", "back", "left")),
)
FLAT_FACE = {0: 3, 1: 2, 2: 1}  # the face that a rectangle across an axis is


def full(value: Column, count: int) -> Floats:
    """A column with one number a row."""
    if isinstance(value, np.ndarray) and value.shape == (count,) and value.dtype == np.float64:
        return value
    return np.broadcast_to(np.asarray(value, np.float64), (count,))


def quaternion(axes: Floats) -> Floats:
    """The unit quaternions (…, 4) that turn x, y, z to the rows of axes (…, 3, 3).

    Of the four components the one that is largest is taken from the diagonal, so that nothing
    small is divided by.
    """
    flat = np.asarray(axes, np.float64).reshape(-1, 3, 3)
    xx, yy, zz = flat[:, 0, 0], flat[:, 1, 1], flat[:, 2, 2]
    squares = np.stack([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    differ = [flat[:, 1, 2] - flat[:, 2, 1], flat[:, 2, 0] - flat[:, 0, 2],
              flat[:, 0, 1] - flat[:, 1, 0]]  # fmt: skip
    add = [flat[:, 0, 1] + flat[:, 1, 0], flat[:, 2, 0] + flat[:, 0, 2],
           flat[:, 1, 2] + flat[:, 2, 1]]  # fmt: skip
    xy, zx, yz = add
    wx, wy, wz = differ
    candidates = np.stack([
        np.stack([squares[0], wx, wy, wz]),
        np.stack([wx, squares[1], xy, zx]),
        np.stack([wy, xy, squares[2], yz]),
        np.stack([wz, zx, yz, squares[3]]),
    ])  # fmt: skip
    best = np.argmax(squares, axis=0)
    found = candidates[best, :, np.arange(len(flat))]
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    found *= np.where(found[:, :1] < 0, -1.0, 1.0)
    return found.reshape(*np.shape(axes)[:-2], 4)


def _face_quaternions() -> Floats:
    """Those of FACES, without a library: all are quarters and halves of a turn."""
    half = np.sqrt(0.5)
    return np.array([
        (0.0, 1.0, 0.0, 0.0),
        (1.0, 0.0, 0.0, 0.0),
        (half, half, 0.0, 0.0),
        (0.5, 0.5, 0.5, 0.5),
        (0.0, 0.0, half, half),
        (0.5, 0.5, -0.5, -0.5),
    ])  # fmt: skip


FACE_QUATERNIONS = _face_quaternions()


def hand(state: Mapping[str, Column]) -> Column:
    """1, or -1 in mirrored frames."""
    return np.sign(state["scale"]) if "scale" in state else 1.0


def moved(state: Mapping[str, Column], step: tuple[Column, Column, Column]) -> State:
    """The places after a step along the local axes."""
    if all(isinstance(each, float) and each == 0.0 for each in step):
        return {axis: state[axis] for axis in AXES}
    scale = np.abs(state["scale"]) if "scale" in state else 1.0
    x, y, z = step
    turned = rotated(tuple(state[axis] for axis in ROTATION), (x * hand(state), y, z))
    return {axis: state[axis] + scale * by for axis, by in zip(AXES, turned, strict=True)}


def rotated(rotation: tuple[Column, ...], vector: tuple[Column, ...]) -> tuple[Column, ...]:
    """Vectors turned by unit quaternions; each part may be one number for all."""
    return scan.turned(cast("scan.Columns", rotation), cast("scan.Columns", vector))


def turned(state: Mapping[str, Column], by: tuple[Column, ...]) -> State:
    """The rotations after a turn in the local frame; a mirrored frame turns the other way."""
    side = hand(state)
    own = tuple(state[axis] for axis in ROTATION)
    local = (by[0], by[1], by[2] * side, by[3] * side)
    found = scan.quaternion_product(cast("scan.Columns", own), cast("scan.Columns", local))
    return dict(zip(ROTATION, found, strict=True))


def mirrored(state: Mapping[str, Column], axis: int) -> State:
    """The scope mirrored within itself along an axis: local x is mirrored first, so the other axes
    take half a turn.
    """
    step: list[Column] = [0.0, 0.0, 0.0]
    step[axis] = state[SIZES[axis]]
    place = moved(state, (step[0], step[1], step[2]))
    half = {0: (1.0, 0.0, 0.0, 0.0), 1: (0.0, 0.0, 0.0, 1.0), 2: (0.0, 0.0, 1.0, 0.0)}[axis]
    return {**state, **place, **turned(state, half), "scale": -state["scale"]}


def world_axes(state: Mapping[str, Column], count: int, axes: str) -> Floats:
    """The world's axes of these names in the local ones, one after the other (count, 3 * axes)."""
    w, i, j, k = (full(state[axis], count) for axis in ROTATION)
    side = full(hand(state), count)
    found = []
    for name in axes:
        unit = np.zeros((3, count))
        unit["xyz".index(name)] = 1.0
        x, y, z = rotated((w, -i, -j, -k), tuple(unit))
        found += [x * side, y, z]
    return np.stack(found, axis=1)
