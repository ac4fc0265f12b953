"""Which lattices are worth a rule: those that take fewer digits than the placements they explain.

Takes an arrangement; gives lattice rules and the rows that are left. Numbers are weighed by their
digits, so that a row with small residuals is shorter than the same row of places, though both have
as many numbers. Nothing here prints.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.find import find_lattices
from ipmlang.inverse.lattices.formula import LatticeRule, lattice_rule
from ipmlang.inverse.lsystem.frames import Floats, Frames, compose, inverse
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, joined
from ipmlang.inverse.score import AROUND, DIGITS, INLINE_ROWS, TABLE, TABLE_ROWS

LEAST = 4  # placements of one symbol among which anything is looked for
NOISE = 0.015  # of the step: what members may be off and still belong
ROUNDS = 4  # of looking again at what is left of one symbol
RULE = 34.0  # tokens of a lattice's rule, usually
CHANGE = 8.0  # more of one that turns about a centre, of turns and of growth
CLEARLY = 8.0  # more that a rule with residuals must save: each takes about as much as a place
RESIDUAL = 10.0  # of what reads a table of residuals
HEADER = 8.0  # of `table T(x, y) =`
PRINTED = 1 / 30  # of the tolerance: what printed numbers may be off
PLACES = 9  # decimals that are counted
BETWEEN = 2.0  # of what stands between the numbers of a row of a table in the text


Memory: TypeAlias = "dict[bytes, list[Lattice]]"


def with_lattices(
    alphabet: Alphabet,
    string: Arrangement,
    scattered: bool,
    known: Memory,
    noise: float = NOISE,
) -> Arrangement:
    """The string with a symbol in place of the members of each lattice that pays, where the first
    of them is painted. scattered: members need not be painted one after the other; known: what was
    found among the same placements before, which is added to.
    """
    chosen, left = choose_lattices(alphabet, string, scattered, known, noise)
    made = [left]
    for rule in chosen:
        lead = rule.formula.lead
        places = compose(inverse(lead), string.placed[rule.rows])
        symbol = alphabet.add_lattice(rule, places)
        start = np.array([int(rule.drawn.min())], np.int64)
        made.append(
            Arrangement(np.array([symbol], np.int64), lead, start, string.wrap[rule.rows[:1]])
        )
    every = joined(made)
    return every[np.argsort(every.start, kind="stable")]


def choose_lattices(
    alphabet: Alphabet,
    string: Arrangement,
    scattered: bool,
    known: Memory,
    noise: float = NOISE,
) -> tuple[list[LatticeRule], Arrangement]:
    """Lattices that pay, and the string without their members."""
    left = np.ones(len(string), np.bool_)
    chosen: list[LatticeRule] = []
    plain = string.wrap == string.wrap[0] if len(string) else left
    if not scattered:  # what is not painted one after the other need not be looked at
        plain &= _runs(string) >= LEAST
    beside = _beside_numbers(string)
    for symbol in np.unique(string.symbol).tolist():
        for _ in range(ROUNDS):
            rows = np.flatnonzero((string.symbol == symbol) & left & plain)
            if _placed_tokens(string, rows, beside, alphabet) <= RULE:
                break
            found = _lattices(alphabet, string, symbol, rows, noise, known)
            made = list(_of_symbol(alphabet, string, symbol, rows, found, beside, scattered))
            if not made:
                break
            chosen += made
            left[np.concatenate([each.rows for each in made])] = False
    return chosen, string[left]


def _lattices(
    alphabet: Alphabet,
    string: Arrangement,
    symbol: int,
    rows: Integers,
    noise: float,
    known: Memory,
) -> list[Lattice]:
    """What is found among these rows of the string, looked for once."""
    if len(rows) < LEAST:
        return []
    definition, placed = alphabet[symbol], string.placed[rows]
    group = definition.stabiliser
    columns = (placed.x, placed.y, placed.angle, placed.scale, placed.handedness, group.angle)
    sizes = np.array([definition.radius, alphabet.tolerance, noise, definition.free])
    key = b"".join(each.tobytes() for each in (*columns, string.start[rows], sizes))
    if key not in known:
        known[key] = find_lattices(
            placed,
            group,
            definition.free,
            definition.radius,
            2 * alphabet.tolerance,
            noise,
            string.start[rows],
        )
    return known[key]


def _of_symbol(
    alphabet: Alphabet,
    string: Arrangement,
    symbol: int,
    rows: Integers,
    found: list[Lattice],
    beside: Floats,
    scattered: bool,
) -> Iterator[LatticeRule]:
    """Lattices of one symbol that share no member, best first; `rows` are rows of the string;
    beside: (n,) tokens of each row of the string beside its numbers.
    """
    definition = alphabet[symbol]
    used = np.zeros(len(string), np.bool_)
    for lattice in found:
        rule = lattice_rule(
            symbol, lattice, string.start[rows], definition.radius, alphabet.tolerance
        )
        if rule is None:
            continue
        members = rows[rule.rows]
        together = bool((np.diff(members) == 1).all())
        if not (scattered or together):
            continue
        if not used[members].any() and _gain(rule, string, members, beside, alphabet) > 0:
            used[members] = True
            yield rule.of(members)


def _beside_numbers(string: Arrangement) -> Floats:
    """(n,) tokens of a placement beside its numbers: less in runs long enough for a table, where
    each row has its share of what the table itself takes.
    """
    sizes = _runs(string)
    tabled = np.where(sizes <= INLINE_ROWS, BETWEEN, 0.0) + TABLE / np.maximum(sizes, 1)
    return np.where(sizes >= TABLE_ROWS, np.minimum(tabled, AROUND), AROUND)


def _runs(string: Arrangement) -> Integers:
    """(n,) how long the run of one symbol is in which each placement stands."""
    sizes = np.diff(np.flatnonzero(np.diff(string.symbol, prepend=-1, append=-1)))
    return np.repeat(sizes, sizes)


def _gain(
    rule: LatticeRule,
    string: Arrangement,
    members: Integers,
    beside: Floats,
    alphabet: Alphabet,
) -> float:
    """Tokens saved, numbers weighed by their digits."""
    placed, fine = string.placed[members], PRINTED * alphabet.tolerance
    reach = max(alphabet[rule.part].radius, fine)
    columns = _columns(placed, fine, reach)
    before = sum(
        _digits(value, error).sum() for value, error, rest in columns if np.ptp(value) or rest
    )
    before = before / DIGITS + float(beside[members].sum())
    formula = rule.formula
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
    return float(before - after - _layering(members))


def _placed_tokens(
    string: Arrangement, rows: Integers, beside: Floats, alphabet: Alphabet
) -> float:
    """Tokens of placements of one symbol, at most: what a rule of all of them could save."""
    if not len(rows):
        return 0.0
    fine = PRINTED * alphabet.tolerance
    reach = max(alphabet[int(string.symbol[rows[0]])].radius, fine)
    columns = _columns(string.placed[rows], fine, reach)
    digits = sum(float(_digits(value, error).sum()) for value, error, _ in columns)
    return digits / DIGITS + float(beside[rows].sum())


def _columns(placed: Frames, fine: float, reach: float) -> list[tuple[Floats, float, bool]]:
    turn, factor = float(np.rad2deg(fine / reach)), fine / reach
    return [
        (placed.x, fine, True),
        (placed.y, fine, True),
        (placed.angle, turn, False),
        (placed.scale, factor, False),
    ]


def _layering(members: Integers) -> float:
    """What it takes to keep the paint order of members that do not follow each other: a cell of a
    table for each, and about as much for what is painted among them.
    """
    together = bool((np.diff(members) == 1).all())
    return 0.0 if together else 1.2 * len(members)


def _digits(values: Floats, error: float) -> Floats:
    """(n,) digits of the shortest decimals within an error.

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
