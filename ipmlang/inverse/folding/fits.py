"""Stretches of rows that have all but numbers in common, as they stand in frames of their own.

Takes the rows and the numbers of each stretch; gives them in the frames in which the stretches
could be equal, with the numbers that differ, and what a rule and its calls take at least. All
frames are looked at in one go. Which numbers become parameters is decided elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.folding.lengths import RowLengths, row_lengths
from ipmlang.inverse.folding.parameters import Means, Parameters
from ipmlang.inverse.folding.pivots import about_points, may_turn
from ipmlang.inverse.folding.rows import Row
from ipmlang.inverse.folding.symbols import Given
from ipmlang.inverse.lsystem.frames import Frames, compose, identity, inverse

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
HEAD = 2  # `Name -->`
READ = 2  # tokens that a parameter must save for whoever has to find out what it does
FINE = 1e-9  # degrees or ratio: numbers that are equal
PLACES = 12  # decimals of angles and factors; those of distances follow the error
ANCHORS = 4  # rows that are tried as the place where a stretch stands
MOST = 4  # parameters that a person can tell apart


@dataclass(frozen=True, slots=True)
class Rounding:
    """error: units that two distances may be apart and still be one; places: decimals that a sum
    of distances has.
    """

    error: float
    places: int


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Rows (m,) as they stand in the places (k,) of stretches. order: of this one among all places
    that were tried; table: (k, h) numbers; hands: (m,) of the rows; errors, varying: (h,) what the
    numbers of a column may be off, and whether they are not all equal; least: tokens that the rule
    and its calls take at least.
    """

    order: int
    symbols: Given
    rows: Sequence[Row]
    lengths: RowLengths
    places: Frames
    table: Floats
    hands: NDArray[np.int8]
    errors: Floats
    varying: Flags
    placed: int
    least: int

    def means(self, most: int, room: int) -> Means:
        """What `most` parameters may take if there is room for so many tokens: each is named in the
        rule's head and an argument of each call, with brackets around all of them.
        """
        calls = len(self.table)
        brackets = 0 if self.symbols.count else 2 * (calls + 1)
        room += 2 * len(self.lengths.brackets)  # that may be no brackets if more stands in them
        return Means(most, room, brackets, calls + 1 + READ)

    def rule_tokens(self, found: Parameters) -> int:
        """Of a rule with these parameters, its head included."""
        tokens, numbers = found.words
        rows = self.lengths.of(tokens[None], numbers[None], self.hands[None])
        return _head(self.symbols.count + len(found.used)) + int(rows[0])

    def call_tokens(self, calls: Floats) -> int:
        """Of the rows that stand for the stretches, with arguments (k, p)."""
        given = _named(self.symbols.count + calls.shape[1])
        return self.placed + len(calls) * given + int((calls < 0).sum())

    def own_rows(self) -> list[Row]:
        """The rows, mirrored as they are here."""
        return [
            row if row.hand == hand else replace(row, hand=hand)
            for row, hand in zip(self.rows, self.hands.tolist(), strict=True)
        ]


def fits(symbols: Given, table: Floats, given: Rounding, most: int) -> list[Fit]:
    """The rows as they stand in each of the frames in which they could be equal, but for frames in
    which they would take more than the most tokens. table: (k, h) numbers of each stretch.
    """
    lengths = row_lengths(symbols.rows)
    begins = np.array(lengths.columns)[lengths.top]
    hands = np.array([row.hand for row in symbols.rows], np.int8)
    x, y, angle, scale = (table[:, begins + k] for k in range(4))
    stand = Frames(x, y, angle, scale, np.repeat(hands[None], len(table), axis=0))
    anchors = _anchors(symbols.rows, stand, given)
    placed = _place_tokens(anchors)
    count = len(table)
    apart = _head(symbols.count) + READ * symbols.count + count * _named(symbols.count)
    own = sum(row.least for row in symbols.rows)
    kept = np.flatnonzero(placed + apart + own <= most)
    if not len(kept):
        return []
    every, turned = _local(table, begins, compose(inverse(anchors[kept])[:, :, None], stand), given)
    errors = _errors(lengths, table.shape[1], given)
    varying = np.asarray(every.max(axis=1) - every.min(axis=1) > errors, np.bool_)
    least = apart + placed[kept] + _least(lengths, every[:, 0], varying, turned)
    turns = may_turn(every[..., begins + 2])
    made = [
        Fit(
            order,
            symbols,
            symbols.rows,
            lengths,
            anchors[order],
            every[k],
            turned[k],
            errors,
            varying[k],
            int(placed[order]),
            int(least[k]),
        )
        for k, order in enumerate(kept.tolist())
        if turns or least[k] <= most
    ]
    if not turns:
        return made
    made = [_turning(each, begins, apart, given) for each in made]
    return [each for each in made if each.least <= most]


def _anchors(rows: Sequence[Row], stand: Frames, given: Rounding) -> Frames:
    """(a, k) frames in which the stretches could be equal: those of one of their rows (k, m), of
    rows that keep their places to each other the first; as they are where something cannot be
    moved.
    """
    if not all(row.placed for row in rows):
        return identity(len(stand))[None, :]
    from_first = np.concatenate([stand.x - stand.x[0], stand.y - stand.y[0]])
    steps = from_first.round(max(0, given.places - 2)) + 0.0
    turns = np.concatenate([stand.angle, stand.scale]).round(9)
    known: dict[bytes, int] = {}
    for column, key in enumerate(np.concatenate([steps, turns]).T.copy()):
        known.setdefault(key.tobytes(), column)
        if len(known) == ANCHORS:
            break
    tried = np.array(list(known.values()))
    own = stand[:, tried]
    turned = (np.ptp(own.angle, axis=0) > FINE) | (np.ptp(own.scale, axis=0) > FINE)
    return Frames(
        own.x.T,
        own.y.T,
        np.where(turned, own.angle, 0.0).T,
        np.where(turned, own.scale, 1.0).T,
        np.where(turned, own.handedness, np.int8(1)).T,
    )


def _local(
    table: Floats, begins: Integers, local: Frames, given: Rounding
) -> tuple[Floats, NDArray[np.int8]]:
    """(a, k, h) the numbers (k, h) of rows that stand (a, k, m) beside their anchors, and (a, m)
    how they are mirrored; begins: (m,) the column of each row's first number.
    """
    every = np.repeat(table[None], len(local), axis=0)
    for k, column in enumerate((local.x, local.y, local.angle, local.scale)):
        every[..., begins + k] = column.round(given.places if k < 2 else PLACES) + 0.0
    return every, local.handedness[:, 0]


def _errors(lengths: RowLengths, columns: int, given: Rounding) -> Floats:
    """(h,) what a number may be off: no error of distances holds for angles and factors."""
    errors = np.full(columns, given.error)
    frame = np.array(lengths.columns)
    errors[frame + 2] = errors[frame + 3] = FINE
    return errors


def _least(lengths: RowLengths, first: Floats, varying: Flags, hands: NDArray[np.int8]) -> Integers:
    """(a,) tokens of the rows at least, whose numbers are those of the first stretch (a, h), or
    some that vary.
    """
    tokens = np.where(varying, 1, 1 + (first < 0))
    return lengths.of(tokens, np.where(varying, np.nan, first), hands)


def _turning(fit: Fit, begins: Integers, apart: int, given: Rounding) -> Fit:
    """With rows that turn about a point where they do."""
    rows, table = about_points(fit.own_rows(), fit.table, begins.tolist(), given.error)
    if table.shape == fit.table.shape:
        return fit
    lengths = row_lengths(rows)
    errors = _errors(lengths, table.shape[1], given)
    varying = np.asarray(table.max(axis=0) - table.min(axis=0) > errors, np.bool_)
    hands = np.array([row.hand for row in rows], np.int8)
    own = _least(lengths, table[:1], varying[None], hands[None])
    return replace(
        fit,
        rows=rows,
        lengths=lengths,
        table=table,
        hands=hands,
        errors=errors,
        varying=varying,
        least=apart + fit.placed + int(own[0]),
    )


# ------------------------------------------------------------------------ tokens


def _head(given: int) -> int:
    """Tokens of a rule's head with so many parameters."""
    return HEAD + (2 + given if given else 0)


def _named(given: int) -> int:
    """Tokens of a call with so many arguments, its place and signs apart."""
    return 1 + (2 + given if given else 0)


def _place_tokens(places: Frames) -> Integers:
    """(a,) of the places (a, k) of calls, with the brackets that they need."""
    moved, turned = (places.x != 0) | (places.y != 0), places.angle != 0
    scaled = places.scale != 1
    at = 5 + (places.x < 0) + (places.y < 0) + scaled
    at = at + np.where(turned | scaled, 1 + (places.angle < 0), 0)
    start = np.where(moved, at, 4 * turned + 4 * scaled) + (places.handedness < 0)
    return np.asarray((start + 2 * (start > 0)).sum(axis=1), np.int64)
