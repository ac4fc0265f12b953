"""What copies take as rows of a table or written out, counted on columns of numbers.

Takes spots, all that may come to stand in one table; gives the tokens of any of them, and the
columns of the shortest table that holds them. Prepared once, as the same spots are counted in many
groups. Nothing is printed here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.frames import Integers
from ipmlang.inverse.split.placing import Spot
from ipmlang.inverse.split.snapping import Flags
from ipmlang.inverse.split.wording import is_nothing

FEWEST = 3  # rows that are worth a table's name
HEAD = 13  # tokens of `table T() =` and of `repeat(at T) { A }`
STEP = 6  # `translate(x, y, z)` or `rotate(a, b, c)` without signs
SCALED = 4  # `*(s)`
SHIFTS, TURNS, SCALE = slice(0, 3), slice(3, 6), 6  # columns of a ledger


@dataclass(frozen=True, slots=True, eq=False)
class Ledger:
    """n spots. values (n, 7): place, turn and scale as numbers that are equal where these are;
    negative (n, 7): those with a sign; said (n, 7): those that are not nothing; mirrored (n,);
    alone (n,): tokens of each that is written out.
    """

    values: Integers
    negative: Flags
    said: Flags
    mirrored: Flags
    alone: Integers


@dataclass(frozen=True, slots=True)
class Columns:
    """What rows of a table say, by axis of the place and of the turn, and whether they say a scale;
    tokens: of the table and of the repeat that reads it.
    """

    shifts: tuple[int, ...]
    turns: tuple[int, ...]
    scaled: bool
    tokens: int


def ledger(spots: Sequence[Spot]) -> Ledger:
    """The columns of spots."""
    numbers: dict[ast.Expr | None, int] = {}
    cells = [cell for spot in spots for cell in (*spot.place, *spot.turn, spot.scale)]
    values = [numbers.setdefault(cell, len(numbers)) for cell in cells]
    sign = np.array([isinstance(each, ast.Number) and each.value < 0 for each in numbers], np.bool_)
    some = np.array([each is not None and not is_nothing(each) for each in numbers], np.bool_)
    table = np.array(values, np.int64).reshape(-1, 7)
    negative, said = sign[table], some[table]
    mirrored = np.array([spot.mirrored for spot in spots], np.bool_)
    inside = _step_tokens(negative, said, mirrored)
    return Ledger(table, negative, said, mirrored, inside + np.where(inside > 0, 3, 1))


def _step_tokens(negative: Flags, said: Flags, mirrored: Flags) -> Integers:
    """(n,) tokens of the operations that lead to spots."""
    steps = mirrored + SCALED * said[:, SCALE].astype(np.int64)
    for own in (SHIFTS, TURNS):
        signs = np.count_nonzero(negative[:, own], axis=1)
        steps = steps + np.where(said[:, own].any(axis=1), STEP + signs, 0)
    return steps


def alone(own: Ledger, rows: Integers) -> int:
    """Tokens of spots that are written out."""
    return int(own.alone[rows].sum())


def tokens_of(own: Ledger, rows: Integers) -> int:
    """Of a group, in rows or one by one."""
    apart = alone(own, rows)
    return apart if len(rows) < FEWEST else min(apart, columns(own, rows).tokens)


def pays(own: Ledger, rows: Integers) -> bool:
    """Whether a table of these spots is shorter than they are one by one."""
    return len(rows) >= FEWEST and columns(own, rows).tokens < alone(own, rows)


def columns(own: Ledger, rows: Integers) -> Columns:
    """The shorter way to say what all have in common: behind the table, or in it."""
    values, said = own.values[rows], own.said[rows]
    differ = (values != values[0]).any(axis=0)
    scaled = bool(differ[SCALE])
    turned = np.logical_or.reduce(said[:, TURNS]) & (scaled or bool(differ[TURNS].any()))
    varying, common = differ[SHIFTS], said[0, SHIFTS] & ~differ[SHIFTS]
    signs = np.count_nonzero(own.negative[rows], axis=0)
    first = int(rows[0])
    within = _columns(own, first, signs, varying | common, turned, scaled, len(rows))
    if not common.any() or scaled or (turned.any() and (common != turned).any()):
        return within
    behind = _columns(own, first, signs, varying, turned, scaled, len(rows))
    return behind if behind.tokens <= within.tokens else within


def _columns(
    own: Ledger,
    first: int,
    signs: Integers,
    shifts: Flags,
    turns: Flags,
    scaled: bool,
    count: int,
) -> Columns:
    """A table with these columns for `count` spots, the first of which has all that is not in it;
    signs (7,): how many of them have a sign.
    """
    listed = np.concatenate([shifts, turns, [scaled]])
    behind = ~listed
    behind[TURNS] &= not turns.any()
    said = own.said[first] & behind
    common = _step_tokens((own.negative[first] & behind)[None], said[None], own.mirrored[[first]])
    wide = int(np.count_nonzero(listed))
    tokens = HEAD + wide * (count + 1) + int(signs[listed].sum()) + int(common[0])
    return Columns(
        tuple(np.flatnonzero(shifts).tolist()),
        tuple(np.flatnonzero(turns).tolist()),
        scaled,
        tokens + 2 * bool(said[SCALE]),
    )
