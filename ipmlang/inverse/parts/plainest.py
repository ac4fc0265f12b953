"""Of the many maps that put a symmetric shape in its place, the one that a person would write.

Takes maps and the shape's symmetry; gives the plainest of each map's equals: none at all, then
quarter turns about the vertical, then other turns about it, then mirrors, then the rest. The choice
is the same on every run.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, Integers

_BATCH = 200_000  # maps compared at a time
_TIES = np.array([0.0713, -0.0279, 0.0131, 1.0, 0.0337, -0.143, 0.0173, 0.317, 0.0531])
"""Weights of a map's entries that tell equally plain ones apart: turns to the left come first."""

_PLAIN_TURN = np.pi / 24


def plainest(linear: Floats, symmetry: Floats, near: float) -> tuple[Floats, Integers]:
    """For each map (k, 3, 3) the plainest of its products with the symmetry (s, 3, 3), and which
    that is (k,). near: entries less than this apart are equal.
    """
    best, which = linear.copy(), np.zeros(len(linear), np.int64)
    if len(symmetry) == 1:
        return best, which
    step = max(1, _BATCH // len(symmetry))
    for begin in range(0, len(linear), step):
        part = slice(begin, begin + step)
        maps = linear[part, None] @ symmetry[None]
        cost = _effort(maps.reshape(-1, 3, 3), near).reshape(maps.shape[:2])
        which[part] = np.argmin(cost, axis=1)
        best[part] = maps[np.arange(len(maps)), which[part]]
    return best, which


def _effort(maps: Floats, near: float) -> Floats:
    """How much there is to write for each map: its kind, then its angle, then a fixed order."""
    hand = np.sign(np.linalg.det(maps))
    turn = maps.copy()
    turn[:, :, 0] *= hand[:, None]
    near = min(max(near, 1e-7), 0.02)
    upright = np.abs(turn[:, 2, 2] - 1) < near
    square = np.abs(turn - np.rint(turn)).max(axis=(1, 2)) < near
    none = np.abs(turn - np.eye(3)).max(axis=(1, 2)) < near
    plain = hand > 0
    kinds = [none & plain, upright & square & plain, upright & plain, upright & square, upright,
             square & plain, square, plain]  # fmt: skip
    kind = np.select(kinds, np.arange(len(kinds)), len(kinds))
    angle = np.round(3 - np.trace(turn, axis1=1, axis2=2), 4)
    order = np.round(np.rint(maps * 1e3).reshape(-1, 9) @ _TIES, 3)
    return np.asarray(kind * 10 + angle - order * 1e-9)


def snapped(linear: Floats, near: float) -> Floats:
    """Maps with entries that are whole numbers where all of them nearly are."""
    whole = np.rint(linear)
    close = np.abs(linear - whole).max(axis=(1, 2)) < max(near, 1e-9)
    proper = np.abs(np.abs(np.linalg.det(whole)) - 1) < 0.5
    return np.where((close & proper)[:, None, None], whole, linear)


def turned_plainly(linear: Floats, near: float) -> Floats:
    """Maps whose turns are about an axis by a multiple of 7.5 degrees where they nearly are."""
    hand = np.sign(np.linalg.det(linear))
    turn = linear.copy()
    turn[:, :, 0] *= hand[:, None]
    plain = linear.copy()
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        angle = np.arctan2(turn[:, two, one], turn[:, one, one])
        angle = np.rint(angle / _PLAIN_TURN) * _PLAIN_TURN
        made = np.zeros_like(turn)
        made[:, axis, axis] = 1.0
        made[:, one, one] = made[:, two, two] = np.cos(angle)
        made[:, two, one], made[:, one, two] = np.sin(angle), -np.sin(angle)
        close = np.abs(made - turn).max(axis=(1, 2)) < max(near, 1e-9)
        made[:, :, 0] *= hand[:, None]
        plain = np.where(close[:, None, None], made, plain)
    return plain
