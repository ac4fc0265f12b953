"""Fits whose largest deviation is the smallest, of many points as of few."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.inverse.least_largest import least_largest, least_largest_of_few


@pytest.mark.parametrize("slope", [6.2347, 1 / 3, 5.0])
def test_many_points_are_fitted_as_one_program_over_all_would(slope: float) -> None:
    i, j = (each.ravel().astype(float) for each in np.mgrid[0:40, 0:30])
    columns = np.stack([np.ones(len(i)), i, j, j % 2, np.zeros(len(i))], axis=1)
    target = np.round(3 + slope * i + 0.0123 * j, 2)
    found, whole = least_largest(columns, target), least_largest_of_few(columns, target)
    assert found is not None and whole is not None
    assert np.abs(columns @ found - target).max() == pytest.approx(whole[1], abs=1e-9)
