"""Kinds of rows, found by hashing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.formats import distinct

NUMBERS = st.sampled_from([0.0, -0.0, 1.0, 2.0, -1e300, 0.5])


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=30))
def test_kinds_are_those_of_equality(rows: list[tuple[float, float]]) -> None:
    """In the order of their first rows; -0 is 0."""
    first, kind = distinct.distinct_rows(np.array(rows).reshape(-1, 2))
    wanted = list(dict.fromkeys(tuple(each) for each in rows))
    assert [rows.index(each) for each in wanted] == first.tolist()
    assert [wanted.index(each) for each in rows] == kind.tolist()


def test_equal_hashes_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows are compared after all."""
    monkeypatch.setattr(distinct, "_hashes", lambda table: np.zeros(len(table), np.uint64))
    first, kind = distinct.distinct_rows(np.array([[3.0], [1.0], [3.0], [2.0]]))
    assert (first.tolist(), kind.tolist()) == ([0, 1, 3], [0, 1, 0, 2])
