"""What a list of copies takes: written out one by one, or as the rows of a table.

Takes placements of one symbol; gives tokens, of all or of some of them, as `tables` prints them.
Prepared once, so that the search can ask what is left of a list costs. Nothing is printed here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, Integers
from ipmlang.inverse.split.placing import euler_angles
from ipmlang.inverse.split.snapping import Flags, label_rows, members

FEWEST = 3  # rows that are worth a table
TABLE = 24  # tokens of `table T(x, y) =` and of `repeat(r in T) { [translate(r.x, r.y, 0) a] }`
TURNED = 6  # `rotate(0, 0, r.rz)`
DEGREE = 1e-4  # angles nearer than this are one


@dataclass(frozen=True, slots=True, eq=False)
class Listing:
    """n placements: values (n, 7) labels of place, angles and scale, equal where the values are;
    signs (n, 7) where they are negative; alone (n,) tokens one by one; hand (n,): mirrored ones;
    turn (n,) labels; turned (n,): those with any angle.
    """

    values: Integers
    signs: Flags
    alone: Integers
    hand: Flags
    turn: Integers
    turned: Flags


def listing(frames: Frames, alone: Integers, small: float) -> Listing:
    """Placements made ready; alone: (n,) tokens of each; small: units that are nothing."""
    values = np.empty((len(frames), 7), np.int64)
    values[:, :3] = np.rint(frames.position / max(small, 1e-12))
    values[:, 3:6] = _degrees(frames)
    values[:, 6] = np.rint(frames.scale / 1e-9)
    signs = values < 0
    turned = np.asarray(values[:, 3:6].any(axis=1))
    hand = frames.hand < 0
    turn = np.zeros(len(frames), np.int64)
    if (values[1:, 3:] != values[:-1, 3:]).any():
        turn = label_rows(values[:, 3:])[0]
    return Listing(values, signs, alone + signs[:, 3:].sum(axis=1), hand, turn, turned)


def _degrees(frames: Frames) -> Floats:
    """(n, 3) angles as whole numbers of the least that tells two apart."""
    return np.asarray(np.rint(euler_angles(frames.rotation) / DEGREE))


def list_tokens(own: Listing, rows: Integers) -> int:
    """Tokens of these placements, in the shortest tables."""
    mirrored = own.hand[rows]
    if mirrored.all() or not mirrored.any():
        return _alike(own, rows)
    return _alike(own, rows[~mirrored]) + _alike(own, rows[mirrored])


def _alike(own: Listing, rows: Integers) -> int:
    """Tokens of placements of one hand: in a table, or in one for each way they are turned."""
    whole = _group(own, rows)
    turn = own.turn[rows]
    if len(rows) < FEWEST or not (turn != turn[0]).any():
        return whole
    label, count = label_rows(turn[:, None])
    return min(sum(_group(own, rows[each]) for each in members(label, len(count))), whole)


def _group(own: Listing, rows: Integers) -> int:
    alone = int(own.alone[rows].sum())
    if len(rows) < FEWEST:
        return alone
    values = own.values[rows]
    differ = (values[1:] != values[0]).any(axis=0)
    columns = int(np.count_nonzero(differ))
    least = TABLE + columns + len(rows) * (columns + 2)
    if least >= alone:
        return alone
    signs = int(np.count_nonzero(own.signs[rows] & differ))
    turned = TURNED * bool(own.turned[rows].any() or own.hand[rows[0]])
    return min(alone, least + signs + turned)


def every_token(frames: Frames, alone: Integers, small: float, lists: int = 1) -> Integers:
    """(l,) tokens of all of a list; of several lists of equal length one after the other."""
    count = len(frames) // lists
    if count >= FEWEST:
        own = listing(frames, alone, small)
        rows = np.arange(len(frames)).reshape(lists, count)
        return np.array([list_tokens(own, each) for each in rows], np.int64)
    return np.asarray(singly_tokens(frames, alone).reshape(lists, count).sum(axis=1))


def singly_tokens(frames: Frames, alone: Integers) -> Integers:
    """(n,) tokens of placements that are in no table; alone (n,): without the signs of angles."""
    if frames.rotation[:, 1:].any():
        return np.asarray(alone + (_degrees(frames) < 0).sum(axis=1))
    return alone
