"""Which lattices are worth a rule: those that take fewer digits than the placements they explain.

Takes an arrangement; gives lattice rules and the rows that are left. Where it is known what another
grammar makes of the same drawing, a lattice must spare more of that too, and what could not is not
looked for. Nothing here prints.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ipmlang.inverse.lattices.build import Lattice
from ipmlang.inverse.lattices.find import Memory, lattices_once
from ipmlang.inverse.lattices.formula import LatticeRule, lattice_rule
from ipmlang.inverse.lattices.spared import Said
from ipmlang.inverse.lattices.weighing import LAYER, RULE, Weighing, layering, runs
from ipmlang.inverse.lsystem.frames import compose, inverse
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers, joined

LEAST = 4  # placements of one symbol among which anything is looked for
NOISE = 0.015  # of the step: what members may be off and still belong
ROUNDS = 4  # of looking again at what is left of one symbol


def with_lattices(
    alphabet: Alphabet,
    string: Arrangement,
    scattered: bool,
    known: Memory,
    rival: Said | None = None,
) -> Arrangement:
    """The string with a symbol in place of the members of each lattice that pays, where the first
    of them is painted. scattered: members need not be painted one after the other; known: what was
    found among the same placements before, which is added to; rival: what says the same without
    lattices, of which they must spare more than they take.
    """
    chosen, left = choose_lattices(alphabet, string, scattered, known, rival)
    if not chosen:
        return string
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
    rival: Said | None,
) -> tuple[list[LatticeRule], Arrangement]:
    """Lattices that pay, and the string without their members."""
    if not len(string):
        return [], string
    given = Weighing(alphabet, string, rival)
    apart, together = given.limits()
    ways = [(apart, True, rival.needed if rival else 0.0)] if scattered else []
    ways.append((together, False, rival.least if rival else 0.0))
    found: list[LatticeRule] = []
    for most, anyhow, needed in ways:
        found = _chosen(given, most, anyhow, known, needed)
        if found:
            break
    left = np.ones(len(string), np.bool_)
    for rule in found:
        left[rule.rows] = False
    return found, string[left]


def _chosen(
    given: Weighing, most: Mapping[int, float], scattered: bool, known: Memory, needed: float
) -> list[LatticeRule]:
    """Lattices that pay, none where all of them save no more than is needed; most: what those of
    each symbol could save.
    """
    hope = {each: saved - RULE for each, saved in most.items() if saved > RULE}
    if sum(hope.values()) <= needed:
        return []
    if scattered:  # gains are without what the paint order takes, limits are with it
        symbols, often = np.unique(given.string.symbol, return_counts=True)
        sizes = dict(zip(symbols.tolist(), often.tolist(), strict=True))
        hope = {each: saved + LAYER * sizes[each] for each, saved in hope.items()}
    made: dict[int, list[LatticeRule]] = {}
    gained, left = 0.0, sum(hope.values())
    for symbol in sorted(hope, key=lambda each: -hope[each]):
        if gained + left <= needed:
            return []
        rules = list(_in_turn(given, symbol, scattered, known))
        gained, left = gained + sum(gain for _, gain in rules), left - hope[symbol]
        made[symbol] = [rule for rule, _ in rules]
    return [rule for symbol in sorted(made) for rule in made[symbol]] if gained > needed else []


def _in_turn(
    given: Weighing, symbol: int, scattered: bool, known: Memory
) -> Iterator[tuple[LatticeRule, float]]:
    """Lattices of one symbol that pay, best first, and what each saves; what these leave is looked
    at again.
    """
    string = given.string
    left = (string.symbol == symbol) & (string.wrap == string.wrap[0])
    if not scattered:  # what is not painted one after the other need not be looked at
        left &= runs(string) >= LEAST
    for _ in range(ROUNDS):
        rows = np.flatnonzero(left)
        if given.placed_tokens(rows) <= RULE:
            break
        found = _lattices(given.alphabet, string, symbol, rows, known)
        made = list(_of_symbol(given, symbol, rows, found, scattered))
        if not made:
            break
        yield from made
        left[np.concatenate([rule.rows for rule, _ in made])] = False


def _lattices(
    alphabet: Alphabet,
    string: Arrangement,
    symbol: int,
    rows: Integers,
    known: Memory,
) -> list[Lattice]:
    """What is found among these rows of the string, looked for once."""
    if len(rows) < LEAST:
        return []
    definition, placed = alphabet[symbol], string.placed[rows]
    return lattices_once(
        known,
        placed,
        definition.stabiliser,
        definition.free,
        definition.radius,
        2 * alphabet.tolerance,
        NOISE,
        string.start[rows],
    )


def _of_symbol(
    given: Weighing, symbol: int, rows: Integers, found: list[Lattice], scattered: bool
) -> Iterator[tuple[LatticeRule, float]]:
    """Lattices of one symbol that share no member, best first, and what each saves without what the
    paint order takes; `rows` are rows of the string.
    """
    string, tolerance = given.string, given.alphabet.tolerance
    radius = given.alphabet[symbol].radius
    used = np.zeros(len(string), np.bool_)
    for lattice in found:
        members = np.sort(rows[lattice.rows])
        together = bool((np.diff(members) == 1).all())
        if used[members].any() or not (scattered or together):
            continue
        if given.most(lattice, rows[lattice.rows]) <= layering(members):
            continue
        rule = lattice_rule(symbol, lattice, string.start[rows], radius, tolerance)
        if rule is None:
            continue
        members = rows[rule.rows]
        if not (scattered or (np.diff(members) == 1).all()):
            continue
        gain = given.gain(rule, members)
        if gain > layering(members):
            used[members] = True
            yield rule.of(members), gain
