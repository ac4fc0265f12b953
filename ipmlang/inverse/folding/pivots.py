"""What turns about a point: a needle is told its angle, and not where its middle comes to lie.

Takes the numbers of rows that stretches have in common but for their values; where the places of a
row lie on a circle as its angles say, the row stands still at the middle and what it places stands
beside that. Nothing here decides what is a parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.folding.rows import STILL, Row
from ipmlang.inverse.lsystem.frames import unit
from ipmlang.inverse.numbers import shortest

Floats = NDArray[np.float64]
SURE = 3  # angles that tell a middle
TURN = 1e-3  # degrees by which they differ at least
ROOM = 4.0  # times the error of a number that a place on the circle may be off


def may_turn(angles: Floats) -> bool:
    """Whether the angles (…, k, m) of rows tell a middle, degrees."""
    return angles.shape[-2] >= SURE and bool((np.ptp(angles, axis=-2) >= TURN).any())


def about_points(
    rows: Sequence[Row], table: Floats, begins: Sequence[int], error: float
) -> tuple[tuple[Row, ...], Floats]:
    """The rows and their numbers (k, h), with four numbers more for each row that turns about a
    point: where it stands beside that. begins: the column of each row's first number.
    """
    if not may_turn(table[:, np.asarray(begins, np.int64) + 2]):
        return tuple(rows), table
    made: list[Row] = []
    columns: list[Floats] = []
    for row, begin in zip(rows, begins, strict=True):
        own = table[:, begin : begin + len(row.numbers)]
        found = _middle(own, error) if row.placed else None
        if found is None:
            made.append(row)
            columns.append(own)
            continue
        middle, beside = found
        made.append(Row(inner=(replace(row, frame=STILL),), origin=row.origin))
        still = np.tile([beside.real, beside.imag, 0.0, 1.0], (len(table), 1))
        about = np.tile([middle.real, middle.imag], (len(table), 1))
        columns.append(np.hstack([about, own[:, 2:4], still, own[:, 4:]]))
    return tuple(made), np.hstack(columns)


def _middle(numbers: Floats, error: float) -> tuple[complex, complex] | None:
    """The point that a row (k, …) turns about, and where the row's place is from there, unturned;
    None where it stays in place or turns about none.
    """
    x, y, angle, scale = numbers[:, :4].T
    place, factor = x + 1j * y, scale * unit(angle)
    if np.ptp(angle) < TURN or max(np.ptp(x), np.ptp(y)) <= error:
        return None
    spread = factor - factor.mean()
    if np.abs(spread).max() < np.deg2rad(TURN) / 2 * np.abs(factor).max():  # -180 is 180
        return None
    beside = complex(np.vdot(spread, place) / np.vdot(spread, spread))
    beside = complex(shortest(beside.real, error / 4), shortest(beside.imag, error / 4))
    middle = complex((place - factor * beside).mean())
    middle = complex(shortest(middle.real, error / 4), shortest(middle.imag, error / 4))
    off = np.abs(place - factor * beside - middle).max()
    return (middle, beside) if off <= ROOM * error else None
