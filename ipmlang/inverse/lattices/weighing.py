"""What placements weigh by themselves, in the rule of a lattice, and in another grammar.

Takes an arrangement, and what is known of a grammar that says the same; gives tokens. Numbers are
weighed by their digits, so that a row with small residuals is shorter than the same row of places,
though both have as many numbers. Nothing here looks for lattices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.formula import OFF, LatticeRule
from ipmlang.inverse.lattices.spared import Said
from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.score import AROUND, DIGITS, TABLE, TABLE_ROWS

RULE = 34.0  # tokens of a lattice's rule, usually
CHANGE = 8.0  # more of one that turns about a centre, of turns and of growth
CLEARLY = 8.0  # more that a rule with residuals must save: each takes about as much as a place
RESIDUALS = CLEARLY + 18.0  # of `with r in T`, of what reads them, and of `table T(x, y) =`
PRINTED = 1 / 30  # of the tolerance: what printed numbers may be off
PLACES = 9  # decimals that are counted
LEAST_DIGITS = 0.5  # of a number
SURELY = 2.0  # times as far as a residual needs: no other numbers bring all members nearer
LAYER = 1.2  # of each member that is painted among others


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
        return self._member_tokens(members) - self._ruled_tokens(rule, members)

    def placed_tokens(self, rows: Integers) -> float:
        """Tokens of placements, at most: what a rule of all of them could save."""
        return float(self._alone[rows].sum())

    @property
    def _fine(self) -> float:
        """Units that printed numbers may be off."""
        return PRINTED * self.alphabet.tolerance

    @cached_property
    def _beside(self) -> Floats:
        """(n,) tokens of a placement beside its numbers, if its whole run goes with it: long runs
        are tables, where each row has its share of what the table itself takes.
        """
        sizes = runs(self.string)
        return np.asarray(_beside_numbers(sizes) / np.maximum(sizes, 1))

    def _run_tokens(self, members: Integers) -> float:
        """Tokens that members take beside their numbers: of each run that they leave, what it takes
        now, less what is left of it does, which is in two pieces where a rule stands instead.
        """
        begin = np.flatnonzero(np.diff(self.string.symbol, prepend=-1))
        size = np.diff(np.append(begin, len(self.string)))
        run, gone = np.unique(np.searchsorted(begin, members, "right") - 1, return_counts=True)
        first = int(members.min()) - begin[run[0]]
        before = np.where(np.arange(len(run)) == 0, first, 0)
        after = size[run] - gone - before
        pieces = (_beside_numbers(each) for each in (size[run], before, after))
        whole, left, right = (float(each.sum()) for each in pieces)
        return whole - left - right

    @cached_property
    def _written(self) -> Floats:
        """(4, n) digits of the numbers of each placement: x, y, angle and scale."""
        placed, fine = self.string.placed, self._fine
        reach = np.maximum(self.alphabet.radii[self.string.symbol], fine)
        values = np.stack([placed.x, placed.y, placed.angle, placed.scale])
        error = np.stack([np.full(len(reach), fine)] * 2 + [np.rad2deg(fine / reach), fine / reach])
        return _digits(values, error)

    @cached_property
    def _alone(self) -> Floats:
        """(n,) tokens of each placement."""
        return np.asarray(self._written.sum(axis=0) / DIGITS + self._beside)

    def _spared(self, rival: Said, rows: Integers) -> Floats:
        """(k,) what each of some rows of one symbol would spare in the other grammar, if that no
        longer drew any of them.
        """
        size = self.alphabet[int(self.string.symbol[rows[0]])].size
        elements = self.string.start[rows][:, None] + np.arange(size)
        gone = np.zeros(rival.count, np.bool_)
        gone[elements] = True
        return np.asarray(rival.spared(gone)[elements].sum(axis=1))

    def most(self, lattice: Lattice, members: Integers) -> float:
        """Tokens that the rule of a lattice saves at most: numbers need not be rounded to know that
        some members will be off, since those fitted come nearest to all of them.
        """
        saved = self._member_tokens(members) - RULE
        usual = np.hypot(*lattice.residual[:, :2].T)
        if np.sqrt(np.mean(usual**2) / 2) <= SURELY * OFF * self.alphabet.tolerance:
            return saved
        return saved - RESIDUALS - LEAST_DIGITS / DIGITS * len(members)

    def _member_tokens(self, members: Integers) -> float:
        """Tokens of members without a rule."""
        placed, written = self.string.placed, self._written[:, members]
        digits = float(written[:2].sum())
        for column, value in ((2, placed.angle[members]), (3, placed.scale[members])):
            digits += float(written[column].sum()) if np.ptp(value) else 0.0
        before = digits / DIGITS + self._run_tokens(members)
        if self.rival is None:
            return before
        return min(before, float(self._spared(self.rival, members).sum()))

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
            after += RESIDUALS + len(rule.holes)
        return after


def runs(string: Arrangement) -> Integers:
    """(n,) how long the run of one symbol is in which each placement stands."""
    sizes = np.diff(np.flatnonzero(np.diff(string.symbol, prepend=-1, append=-1)))
    return np.repeat(sizes, sizes)


def _beside_numbers(sizes: Integers) -> Floats:
    """(k,) tokens of runs of placements of one symbol beside their numbers."""
    return np.where(sizes >= TABLE_ROWS, TABLE, AROUND * sizes)


def layering(members: Integers) -> float:
    """What it takes to keep the paint order of members that do not follow each other: a cell of a
    table for each, and about as much for what is painted among them.
    """
    together = bool((np.diff(members) == 1).all())
    return 0.0 if together else LAYER * len(members)


def _digits(values: Floats, error: Floats | float) -> Floats:
    """(n,) digits of the shortest decimals within an error.

    >>> _digits(np.array([30.0, -0.25, 1.23456, 0.0]), 1e-3).tolist()
    [2.0, 2.0, 4.0, 0.5]
    """
    left = np.abs(values).ravel()
    room = np.broadcast_to(error, values.shape).ravel()
    digits = np.log10(left * 10.0**PLACES + 1.0)
    longer = np.arange(len(left))
    for places in range(PLACES):
        tens = np.round(left * 10.0**places)
        near = np.abs(left - tens / 10.0**places) <= room
        digits[longer[near]] = np.floor(np.log10(np.maximum(tens[near], 0.1))) + 1
        longer, left, room = longer[~near], left[~near], room[~near]
        if not len(longer):
            break
    return np.asarray(np.maximum(LEAST_DIGITS, digits)).reshape(values.shape)
