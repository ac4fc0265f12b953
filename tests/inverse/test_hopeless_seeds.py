"""What is told of many seeds at once is what growing each of them shows."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.inverse.lattices.cloud import cloud
from ipmlang.inverse.lattices.hopeless import hopeless
from ipmlang.inverse.lattices.seeds import BENT, _bend_seeds, _bent

EXACT, LOOSE = 1e-4, 0.015


@pytest.mark.parametrize("share", [0.0, LOOSE])
def test_nothing_grows_from_hopeless_seeds(share: float) -> None:
    random = np.random.default_rng(3)
    clutter = random.uniform(0, 300, 60) + 1j * random.uniform(0, 300, 60)
    ring = 90 + 80j + 50 * np.exp(0.4j * np.arange(11))
    spiral = 210 + 190j + 20 * np.exp((0.05 + 0.5j) * np.arange(16))
    noise = share * random.normal(0, 2, 87) * np.exp(1j * random.uniform(0, 7, 87))
    known = cloud(np.concatenate([clutter, ring, spiral]) + noise, EXACT, LOOSE)
    used = np.zeros(len(known), np.bool_)
    used[::17] = True
    rows = _bend_seeds(known, used, share, np.full(len(known), -1)).rows[:60]
    rows = np.stack([row for row in rows if len(set(row[row >= 0])) == (row >= 0).sum()])
    none = hopeless(known, used, share, rows, BENT)
    grown = np.zeros_like(none)
    for number, row in enumerate(rows):
        index = np.flatnonzero(row >= 0)
        for column, kind in enumerate(BENT):
            chain = _bent(known, kind, index, row[index], used, share)
            grown[number, column] = chain is not None
    assert not (none & grown).any()
    assert grown.any()
    assert (none | grown).mean() > 0.6
