"""What a list of copies takes: written out one by one, or as the rows of a table.

Takes placements of one symbol; gives tokens, of all or of some of them, as `tables` prints them.
Prepared once, so that the search can ask what is left of a list costs. Nothing is printed here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Frames, Integers
from ipmlang.inverse.split.placing import euler_angles
from ipmlang.inverse.split.snapping import label_rows, members

FEWEST = 3  # rows that are worth a table
TABLE = 24  # tokens of `table T(x, y) =` and of `repeat(r in T) { [translate(r.x, r.y, 0) a] }`
TURNED = 6  # `rotate(0, 0, r.rz)`
DEGREE = 1e-4  # angles nearer than this are one


@dataclass(frozen=True, slots=True, eq=False)
class Listing:
    """n placements: values (n, 7) labels of place, angles and scale, equal where the values are;
    signs (n, 7) where they are negative; alone (n,) tokens one by one; hand (n,), turn (n,) labels.
    """

    values: Integers
    signs: Integers
    alone: Integers
    hand: Integers
    turn: Integers
    turned: Integers


def listing(frames: Frames, alone: Integers, small: float) -> Listing:
    """Placements made ready; alone: (n,) tokens of each; small: units that are nothing."""
    angles = np.round(euler_angles(frames.rotation) / DEGREE) * DEGREE
    steps = np.array([max(small, 1e-12)] * 3 + [DEGREE] * 3 + [1e-9])
    raw = np.concatenate([frames.position, angles, frames.scale[:, None]], axis=1)
    values = np.round(raw / steps).astype(np.int64)
    signs = (values < 0).astype(np.int64)
    turned = (values[:, 3:6] != 0).any(axis=1).astype(np.int64)
    hand = (frames.hand < 0).astype(np.int64)
    turn = label_rows(np.concatenate([hand[:, None], values[:, 3:]], axis=1))[0]
    return Listing(values, signs, alone + signs[:, 3:].sum(axis=1), hand, turn, turned)


def list_tokens(own: Listing, rows: Integers) -> int:
    """Tokens of these placements, in the shortest tables."""
    total = 0
    for mirrored in (0, 1):
        alike = rows[own.hand[rows] == mirrored]
        if len(alike) == 0:
            continue
        label, count = label_rows(own.turn[alike][:, None])
        apart = sum(_group(own, alike[each]) for each in members(label, len(count)))
        total += apart if len(count) == 1 else min(apart, _group(own, alike))
    return total


def _group(own: Listing, rows: Integers) -> int:
    alone = int(own.alone[rows].sum())
    if len(rows) < FEWEST:
        return alone
    values = own.values[rows]
    differ = (values != values[0]).any(axis=0)
    signs = int(own.signs[rows][:, differ].sum())
    turned = TURNED * bool(own.turned[rows].any() or own.hand[rows[0]])
    columns = int(differ.sum())
    return min(alone, TABLE + columns + len(rows) * (columns + 2) + signs + turned)


def every_token(frames: Frames, alone: Integers, small: float) -> int:
    """Tokens of all of a list."""
    if len(frames) < FEWEST and not frames.rotation[:, 1:].any():
        return int(alone.sum())
    return list_tokens(listing(frames, alone, small), np.arange(len(frames)))
