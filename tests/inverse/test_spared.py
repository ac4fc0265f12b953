"""What a grammar would no longer say: a placement goes only with all that its copies draw."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.inverse.lattices.spared import Said, layers_weight


def said() -> Said:
    """A motif of two elements, drawn twice: its first member, its second one, both placements."""
    return Said(
        begin=np.array([0, 2, 4, 5]),
        item=np.array([0, 0, 1, 1, 2, 3]),
        start=np.array([0, 2, 1, 3, 0, 2]),
        size=np.array([1, 1, 1, 1, 2, 2]),
        share=np.array([4.0, 4.0, 5.0, 5.0, 3.0, 3.0]),
        count=4,
        least=0.0,
        needed=0.0,
    )


@pytest.mark.parametrize(
    ("gone", "spared"),
    [
        ([1, 0, 0, 0], [0, 0, 0, 0]),
        ([1, 0, 1, 0], [4, 0, 4, 0]),
        ([1, 1, 0, 0], [3, 3, 0, 0]),
        ([1, 1, 1, 1], [7, 8, 7, 8]),
    ],
    ids=["one copy", "both copies of a member", "one placement", "all"],
)
def test_what_is_spared(gone: list[int], spared: list[float]) -> None:
    assert said().spared(np.array(gone, np.bool_)).tolist() == spared


def test_layers_weigh_by_their_digits() -> None:
    assert layers_weight(1) == 0.5
    assert layers_weight(12) == pytest.approx(0.5 + 9 * 2 / 3 + 2 * 4 / 3)
