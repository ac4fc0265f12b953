"""Which of many values are the same, where numbers are only nearly equal.

In go values, out come whole numbers that can be compared. Values with no gap between them are one.
"""

from __future__ import annotations

import numpy as np

from ipmlang.inverse.frames import Floats, Integers


def numbered(values: Floats, small: float) -> Integers:
    """(n,) numbers for values (n,) in their order: the same for those with no gap between them.

    >>> numbered(np.array([3.0, 1.0, 1.0000001, 9.0]), 1e-6).tolist()
    [1, 0, 0, 2]
    """
    order = values.argsort(kind="stable")
    ordered = values[order]
    number = np.zeros(len(values), np.int64)
    number[order[1:]] = (ordered[1:] - ordered[:-1] > small).cumsum()
    return number
