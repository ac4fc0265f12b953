"""Tokens that rows take, for many ways at once to say their numbers.

Takes rows; for each of many ways to say all their numbers, what each number takes and whether it is
one that need not be said. Gives what the rows take in each way, as `Row.tokens` counts it. Nothing
here knows what the numbers mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.folding.rows import Row, element_tokens
from ipmlang.inverse.lsystem.frames import Floats

Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class _Bracket:
    """A row that holds others, which are numbered as all rows are; bare: tokens of the symbol that
    is all that turns about a point, -1 where that is not all that it does.
    """

    number: int
    inner: list[int]
    bare: int


@dataclass(slots=True, eq=False)
class RowLengths:
    """What rows take but for their numbers, those in brackets too, each after its bracket.

    columns: of each row's first number; begins: tokens of what it begins with besides; things: of
    what it places; args: the numbers that this is given, by row; others: rows that are taken as
    they are; top: the rows that are in no bracket.
    """

    columns: list[int] = field(default_factory=list)
    begins: list[int] = field(default_factory=list)
    things: list[int] = field(default_factory=list)
    args: list[tuple[int, slice]] = field(default_factory=list)
    others: list[int] = field(default_factory=list)
    brackets: list[_Bracket] = field(default_factory=list)
    top: list[int] = field(default_factory=list)

    def of(self, tokens: Integers, numbers: Floats, hands: NDArray[np.int8]) -> Integers:
        """(a,) tokens in all; tokens, numbers: (a, h) what every number takes and is, nan for an
        expression; hands: (a, m) of the rows that are in no bracket.
        """
        start = self._starts(tokens, numbers)
        start[:, self.top] += hands < 0
        made = start + 2 * (start > 0) + np.array(self.things)
        for number, given in self.args:
            made[:, number] += tokens[:, given].sum(axis=1)
        if self.others:
            made[:, self.others] = np.array(self.things)[self.others]
        for bracket in reversed(self.brackets):
            inner = made[:, bracket.inner].sum(axis=1)
            turning = (inner > bracket.bare) if bracket.bare >= 0 else False
            made[:, bracket.number] = 2 + start[:, bracket.number] + inner - 2 * turning
        return np.asarray(made[:, self.top].sum(axis=1), np.int64)

    def _starts(self, tokens: Integers, numbers: Floats) -> Integers:
        """(a, rows) what stands in a bracket before the thing that is placed."""
        x, y, angle, scale = (np.array(self.columns) + k for k in range(4))
        moved = (numbers[:, x] != 0) | (numbers[:, y] != 0)
        turned, scaled = numbers[:, angle] != 0, numbers[:, scale] != 1
        at = 3 + tokens[:, x] + tokens[:, y] + tokens[:, angle] * (turned | scaled)
        # A turn by less than nothing is one to the other side, and has no sign.
        turn = 3 + np.where(np.isnan(numbers[:, angle]), tokens[:, angle], 1)
        grown = tokens[:, scale] * scaled
        start = np.where(moved, at, turn * turned + 3 * scaled) + grown
        return np.asarray(start + np.array(self.begins), np.int64)


def row_lengths(rows: Sequence[Row]) -> RowLengths:
    """What rows take but for their numbers; whether they are mirrored counts for those in brackets
    alone.
    """
    made = RowLengths()
    column = 0
    for row in rows:
        made.top.append(len(made.columns))
        column = _add(made, row, column, inside=False)
    return made


def _add(made: RowLengths, row: Row, column: int, inside: bool) -> int:
    """Add a row whose numbers begin at a column; the column after them."""
    number, end = len(made.columns), column + 4 + len(row.args)
    made.columns.append(column)
    made.begins.append(sum(map(element_tokens, row.pens)) + (inside and row.hand < 0))
    given = len(row.symbols) + 2 * bool(row.args or row.symbols)
    made.things.append(1 + given if row.other is None else element_tokens(row.other))
    if row.other is not None:
        made.others.append(number)
    if row.args:
        made.args.append((number, slice(column + 4, end)))
    if row.inner:
        bracket = _Bracket(number, [], row.inner[0].bare if row.turning else -1)
        made.brackets.append(bracket)
        for each in row.inner:
            bracket.inner.append(len(made.columns))
            end = _add(made, each, end, inside=True)
    return end
