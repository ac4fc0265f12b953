"""What a turtle does that depends on where it heads: levelling, and bending under a tropism.

In go the states before a step and what its rows do (a turn, a levelling, a segment that bends), out
come the states after it, for columns of turtles and, with the same meaning, for one turtle in plain
numbers: narrow trees walk quicker that way. These steps are not associative, so no scan cuts them.
"""

from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt
from typing import TypeAlias

import numpy as np

from ipmlang.runtime import scan
from ipmlang.runtime.scan import Columns, Real

# w, x, y, z of the rotation, what the row does (TURN, LEVEL or BEND), the handedness it finds
State: TypeAlias = tuple[float, ...]

TURN, LEVEL, BEND = 0.0, 1.0, 2.0
NEAR = 1e-12  # a heading this close to the vertical, or to the tropism vector, stays


class Bending:
    """Steps under a tropism (x, y, z, elasticity), or under none."""

    def __init__(self, tropism: tuple[float, float, float, float] | None) -> None:
        self._tropism = tropism or (0.0, 0.0, 0.0, 0.0)

    def columns(self, before: Columns, row: Columns) -> Columns:
        """States after a step, from columns w, x, y, z, kind and handedness."""
        rotation = scan.quaternion_product(before[:4], row[:4])
        kind, hand = row[4], row[5]
        for flag in (LEVEL, BEND):
            rows = np.flatnonzero(kind == flag)
            if len(rows):
                found = tuple(column[rows] for column in rotation)
                side = hand[rows]
                level = flag == LEVEL
                changed = levelled(found, side) if level else self._bent(found, side)
                for column, values in zip(rotation, scan.normalised(changed), strict=True):
                    column[rows] = values
        return (*rotation, kind, hand)

    def _bent(self, rotation: Columns, hand: Real) -> Columns:
        """Turned by e |H x T| radians about H x T (ABOP, p. 58)."""
        tx, ty, tz, elasticity = self._tropism
        zero = np.zeros_like(hand)
        hx, hy, hz = scan.turned(rotation, (hand, zero, zero))
        ax, ay, az = hy * tz - hz * ty, hz * tx - hx * tz, hx * ty - hy * tx
        length = np.sqrt(ax * ax + ay * ay + az * az)
        half = elasticity * length / 2
        factor = np.divide(np.sin(half), length, out=zero, where=length > NEAR)
        turn = (np.cos(half), ax * factor, ay * factor, az * factor)
        return scan.quaternion_product(turn, rotation)

    def single(self, before: State, row: State) -> State:
        """What `columns` gives, for one turtle."""
        turn = _product(before, row)
        kind, hand = row[4], row[5]
        if kind == TURN:
            return (*turn, kind, hand)
        changed = _levelled(turn, hand) if kind == LEVEL else self._bent_one(turn, hand)
        w, x, y, z = changed
        length = sqrt(w * w + x * x + y * y + z * z)
        return w / length, x / length, y / length, z / length, kind, hand

    def _bent_one(self, rotation: State, hand: float) -> State:
        tx, ty, tz, elasticity = self._tropism
        hx, hy, hz = _turned(rotation, hand, 0.0, 0.0)
        ax, ay, az = hy * tz - hz * ty, hz * tx - hx * tz, hx * ty - hy * tx
        length = sqrt(ax * ax + ay * ay + az * az)
        if length <= NEAR:
            return rotation
        half = elasticity * length / 2
        factor = sin(half) / length
        return _product((cos(half), ax * factor, ay * factor, az * factor), rotation)


def levelled(rotation: Columns, hand: Real) -> Columns:
    """Rolled about the heading until the local left is horizontal; a vertical heading stays."""
    zero, one = np.zeros_like(hand), np.ones_like(hand)
    hx, hy, _ = scan.turned(rotation, (hand, zero, zero))
    left = scan.turned(rotation, (zero, one, zero))
    up = scan.turned(rotation, (zero, zero, one))
    length = np.hypot(hx, hy)
    safe = np.where(length > NEAR, length, 1)
    # the wanted left is the world's up x heading, on the side that a mirrored frame has it
    wx, wy = -hy / safe * hand, hx / safe * hand
    cosine = wx * left[0] + wy * left[1]
    sine = wx * up[0] + wy * up[1]
    half = np.where(length > NEAR, np.arctan2(sine, cosine), 0) / 2
    return scan.quaternion_product(rotation, (np.cos(half), np.sin(half), zero, zero))


def _levelled(rotation: State, hand: float) -> State:
    hx, hy, _ = _turned(rotation, hand, 0.0, 0.0)
    length = hypot(hx, hy)
    if length <= NEAR:
        return rotation
    left, up = _turned(rotation, 0.0, 1.0, 0.0), _turned(rotation, 0.0, 0.0, 1.0)
    wx, wy = -hy / length * hand, hx / length * hand
    half = atan2(wx * up[0] + wy * up[1], wx * left[0] + wy * left[1]) / 2
    return _product(rotation, (cos(half), sin(half), 0.0, 0.0))


def _product(before: State, after: State) -> State:
    aw, ax, ay, az = before[:4]
    bw, bx, by, bz = after[:4]
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def _turned(rotation: State, x: float, y: float, z: float) -> tuple[float, float, float]:
    w, i, j, k = rotation
    tx, ty, tz = 2 * (j * z - k * y), 2 * (k * x - i * z), 2 * (i * y - j * x)
    return (
        x + w * tx + (j * tz - k * ty),
        y + w * ty + (k * tx - i * tz),
        z + w * tz + (i * ty - j * tx),
    )
