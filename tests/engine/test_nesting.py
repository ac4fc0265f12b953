"""Intervals of rows that stand in each other, against the way up from each."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.runtime.queries.nesting import nesting


@given(st.lists(st.integers(-1, 30), max_size=30))
def test_a_row_holds_what_stands_in_it(choices: list[int]) -> None:
    parent = [min(choice, row - 1) for row, choice in enumerate(choices)]
    found = nesting(np.array(parent, np.int64))
    for inner in range(len(parent)):
        around, row = set(), inner
        while row >= 0:
            around.add(row)
            row = parent[row]
        outer = np.arange(-1, len(parent))
        held = found.holds(outer, np.full(len(outer), inner))
        assert set(outer[held].tolist()) == around


def test_a_long_chain() -> None:
    parent = np.arange(-1, 49_999)
    found = nesting(parent)
    assert found.size[0] == 50_000
    assert found.holds(np.array([49_000, 49_999]), np.array([49_999, 49_000])).tolist() == [
        True,
        False,
    ]
