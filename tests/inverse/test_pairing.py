"""Rows that run side by side become one row of pairs, and are still drawn where they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.inverse.frames import Frames, identity, join, moved_to
from ipmlang.inverse.split.cost import scheme_tokens
from ipmlang.inverse.split.expansion import expand, placements
from ipmlang.inverse.split.facades.homes import at_home
from ipmlang.inverse.split.facades.matching import matched
from ipmlang.inverse.split.pairing import paired
from ipmlang.inverse.split.scheme import Array, Direction, Item, Place, Ring, Rule, Scheme, Terminal

SMALL = 1e-7
COLUMN, CAPITAL = (
    Terminal("Column", np.array([0.6, 0.6, 3.0]), 0),
    Terminal("Capital", np.array([0.8, 0.8, 0.3]), 1),
)


def at(*position: float) -> Frames:
    return moved_to(np.array([position]))


def scheme(*items: Item) -> Scheme:
    size = np.array([30.0, 30.0, 4.0])
    return Scheme((COLUMN, CAPITAL, Rule("", size, items)), identity())


def row(symbol: int, first: Frames, *directions: tuple[int, tuple[float, float, float]]) -> Array:
    return Array(symbol, first, tuple(Direction(n, np.array(step)) for n, step in directions))


def check(whole: Scheme, kind: type, number: int) -> None:
    """That the rows of the last rule are so many of a kind, of pairs, and draw the same."""
    found = paired(whole, SMALL)
    assert matched(expand(found), expand(whole), SMALL)
    last = found.symbols[found.axiom]
    assert isinstance(last, Rule)
    rows = [item for item in last.items if isinstance(item, kind)]
    assert len(rows) == number
    assert all(isinstance(found.symbols[each.symbol], Rule) for each in rows)


def test_columns_and_capitals_are_a_row_of_both() -> None:
    both = row(0, at(0.1, 0, 0), (9, (3, 0, 0))), row(1, at(0, 0, 3), (9, (3, 0, 0)))
    check(scheme(*both), Array, 1)


def test_rows_that_run_the_other_way_are_one() -> None:
    both = row(0, at(0.1, 0, 0), (9, (3, 0, 0))), row(1, at(24, 0, 3), (9, (-3, 0, 0)))
    check(scheme(*both), Array, 1)


def test_rings_that_begin_elsewhere_are_one() -> None:
    axis = np.array([0.0, 0, 1])
    center = np.array([15.0, 15, 0])
    one = Ring(0, at(25, 15, 0), 12, center, axis, 30.0)
    capital = Ring(1, at(25, 15, 3), 12, center, axis, 30.0)
    sixth = placements(capital)[0][1][6:7]
    check(scheme(one, replace(capital, first=sixth)), Ring, 1)


def test_a_pair_that_has_a_rule_gets_no_other() -> None:
    pair = Rule("", np.array([0.8, 0.8, 3.3]), (Place(0, at(0.1, 0.1, 0)), Place(1, at(0, 0, 3))))
    rows = row(0, at(0.1, 0.1, 0), (9, (3, 0, 0))), row(1, at(0, 0, 3), (9, (3, 0, 0)))
    single = Place(2, join([at(10, 20, 0), at(20, 20, 0)]))
    last = Rule("", np.array([30.0, 30.0, 4.0]), (*rows, single))
    found = paired(Scheme((COLUMN, CAPITAL, pair, last), identity()), SMALL)
    assert len(found.symbols) == 4
    assert sum(isinstance(item, Array) for item in found.symbols[-1].items) == 1


def test_rows_with_other_counts_stay() -> None:
    both = row(0, at(0, 0, 0), (9, (3, 0, 0))), row(1, at(0, 0, 3), (8, (3, 0, 0)))
    whole = scheme(*both)
    assert paired(whole, SMALL) is whole


def test_two_long_rows_of_few_numbers_are_not_longer_as_one() -> None:
    """A rule has to pay: one row of two parts in a rule of its own is no shorter than it was."""
    whole = scheme(row(0, at(0, 0, 0), (3, (3, 0, 0))), row(0, at(0, 5, 0), (3, (3, 0, 0))))
    found = paired(whole, SMALL)
    tokens = [scheme_tokens(at_home(each, SMALL)[0], SMALL) for each in (found, whole)]
    assert tokens[0] <= tokens[1]
