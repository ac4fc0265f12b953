"""What placements weigh by themselves, in the rule of a lattice, and in another grammar.

Takes an arrangement, and what is known of a grammar that says the same; gives tokens. Numbers are
weighed by their digits, so that a row with small residuals is shorter than the same row of places,
though both have as many numbers. Nothing here looks for lattices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipmlang.inverse.lattices.formula import LatticeRule
from ipmlang.inverse.lattices.spared import Said
from ipmlang.inverse.lsystem.frames import Floats, Frames
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.score import AROUND, DIGITS, INLINE_ROWS, TABLE, TABLE_ROWS

RULE = 34.0  # tokens of a lattice's rule, usually
CHANGE = 8.0  # more of one that turns about a centre, of turns and of growth
CLEARLY = 8.0  # more that a rule with residuals must save: each takes about as much as a place
RESIDUAL = 10.0  # of what reads a table of residuals
HEADER = 8.0  # of `table T(x, y) =`
PRINTED = 1 / 30  # of the tolerance: what printed numbers may be off
PLACES = 9  # decimals that are counted
LAYER = 1.2  # of each member that is painted among others
BETWEEN = 2.0  # of what stands between the numbers of a row of a table in the text


@dataclass(frozen=True, eq=False)
class Weighing:
    """A string, and what another grammar says of the same elements, if that is known."""

    alphabet: Alphabet
    string: Arrangement
    rival: Said | None

    def limits(self) -> tuple[dict[int, float], dict[int, float]]:
        """What lattices of each symbol could spare at most: painted in any order, and painted one
        after the other.
        """
        string = self.string
        apart = dict.fromkeys(np.unique(string.symbol).tolist(), 0.0)
        together = dict(apart)
        plain = np.flatnonzero(string.wrap == string.wrap[0])
        plain = plain[np.argsort(string.symbol[plain], kind="stable")]
        ends = np.flatnonzero(np.diff(string.symbol[plain])) + 1
        for rows in np.split(plain, ends):
            symbol = int(string.symbol[rows[0]])
            apart[symbol] = together[symbol] = self.placed_tokens(rows)
            if self.rival is not None and apart[symbol] > RULE:
                share = self._spared(self.rival, rows)
                begins = np.flatnonzero(np.diff(rows, prepend=-2) != 1)
                together[symbol] = float(np.add.reduceat(share, begins).max())
                each = float(np.maximum(share - LAYER, 0.0).sum())
                apart[symbol] = max(together[symbol], each)
        return apart, together

    def gain(self, rule: LatticeRule, members: Integers) -> float:
        """Tokens that a rule saves of what members take by themselves, or in the other grammar."""
        before = self._member_tokens(rule, members)
        if self.rival is not None:
            before = min(before, float(self._spared(self.rival, members).sum()))
        return before - self._ruled_tokens(rule, members)

    def placed_tokens(self, rows: Integers) -> float:
        """Tokens of placements of one symbol, at most: what a rule of all of them could save."""
        return float(self._placed_digits[rows].sum()) / DIGITS + float(self._beside[rows].sum())

    @property
    def _fine(self) -> float:
        """Units that printed numbers may be off."""
        return PRINTED * self.alphabet.tolerance

    @cached_property
    def _placed_digits(self) -> Floats:
        """(n,) digits of the four numbers of each placement."""
        fine, symbols = self._fine, self.string.symbol
        radius = np.array([each.radius for each in self.alphabet.definitions])
        columns = _columns(self.string.placed, fine, np.maximum(radius[symbols], fine))
        return np.asarray(sum(_digits(value, error) for value, error, _ in columns))

    @cached_property
    def _beside(self) -> Floats:
        """(n,) tokens of a placement beside its numbers: less in runs long enough for a table,
        where each row has its share of what the table itself takes.
        """
        sizes = runs(self.string)
        tabled = np.where(sizes <= INLINE_ROWS, BETWEEN, 0.0) + TABLE / np.maximum(sizes, 1)
        return np.where(sizes >= TABLE_ROWS, np.minimum(tabled, AROUND), AROUND)

    def _spared(self, rival: Said, rows: Integers) -> Floats:
        """(k,) what each of some rows of one symbol would spare in the other grammar, if that no
        longer drew any of them.
        """
        size = self.alphabet[int(self.string.symbol[rows[0]])].size
        elements = self.string.start[rows][:, None] + np.arange(size)
        gone = np.zeros(rival.count, np.bool_)
        gone[elements] = True
        return np.asarray(rival.spared(gone)[elements].sum(axis=1))

    def _member_tokens(self, rule: LatticeRule, members: Integers) -> float:
        """Tokens of members without a rule."""
        fine = self._fine
        reach = max(self.alphabet[rule.part].radius, fine)
        columns = _columns(self.string.placed[members], fine, reach)
        digits = sum(
            _digits(value, error).sum() for value, error, rest in columns if np.ptp(value) or rest
        )
        return float(digits / DIGITS + self._beside[members].sum())

    def _ruled_tokens(self, rule: LatticeRule, members: Integers) -> float:
        """Tokens of a lattice's rule."""
        fine, formula = self._fine, rule.formula
        reach = max(self.alphabet[rule.part].radius, fine)
        after = RULE + 2.0 * len(rule.holes)
        after += CHANGE * (bool(formula.growth.any()) + bool(formula.turn.any()))
        after += CHANGE * (formula.polar is not None)
        inside = {"x": fine, "y": fine, "angle": np.rad2deg(fine / reach), "scale": fine / reach}
        for name in rule.columns:
            after += float(_digits(getattr(rule.residual, name), inside[name]).sum()) / DIGITS
        if rule.columns:
            # Rows of residuals take as much as the rows of places that they stand for.
            rows = BETWEEN * len(members) if formula.count <= INLINE_ROWS else 0.0
            after += CLEARLY + RESIDUAL + HEADER + rows + len(rule.holes)
        return after


def runs(string: Arrangement) -> Integers:
    """(n,) how long the run of one symbol is in which each placement stands."""
    sizes = np.diff(np.flatnonzero(np.diff(string.symbol, prepend=-1, append=-1)))
    return np.repeat(sizes, sizes)


def _columns(
    placed: Frames, fine: float, reach: float | Floats
) -> list[tuple[Floats, float | Floats, bool]]:
    """Numbers of placements, what each may be off, and whether it is always said; reach: units, of
    all symbols or of each.
    """
    turn, factor = np.rad2deg(fine / reach), fine / reach
    return [
        (placed.x, fine, True),
        (placed.y, fine, True),
        (placed.angle, turn, False),
        (placed.scale, factor, False),
    ]


def layering(members: Integers) -> float:
    """What it takes to keep the paint order of members that do not follow each other: a cell of a
    table for each, and about as much for what is painted among them.
    """
    together = bool((np.diff(members) == 1).all())
    return 0.0 if together else LAYER * len(members)


def _digits(values: Floats, error: float | Floats) -> Floats:
    """(n,) digits of the shortest decimals within an error, that of all numbers or of each.

    >>> _digits(np.array([30.0, -0.25, 1.23456, 0.0]), 1e-3).tolist()
    [2.0, 2.0, 4.0, 0.5]
    """
    digits = np.full(values.shape, np.nan)
    for places in range(PLACES):
        tens = np.abs(np.round(values * 10.0**places))
        near = np.isnan(digits) & (np.abs(np.abs(values) - tens / 10.0**places) <= error)
        digits[near] = np.floor(np.log10(np.maximum(tens[near], 0.1))) + 1
    long = np.log10(np.abs(values) * 10.0**PLACES + 1.0)
    return np.asarray(np.maximum(0.5, np.where(np.isnan(digits), long, digits)))
