"""Many numbers as text at once, for the formats that hold numbers as decimal text.

Takes arrays and a number of decimals; gives the shortest fixed-point strings that keep them: no
exponents, no trailing zeros and no minus zero, the same in every process. Never decides how
precise a file has to be.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray


def decimal_texts(values: NDArray[np.float64], decimals: int) -> list[str]:
    """Each number of a flat array, rounded to so many places after the point (at least 1).

    >>> decimal_texts(np.array([10.0, -0.0, 0.5, -1e-9, 1234567.125]), 3)
    ['10', '0', '0.5', '0', '1234567.125']
    """
    # One format operation for all is twice as fast as one for each number.
    rounded = np.round(values, decimals) + 0.0
    texts = (f"%.{max(decimals, 1)}f " * len(rounded)) % tuple(rounded.tolist())
    return [text.rstrip("0").rstrip(".") if text[-1] == "0" else text for text in texts.split()]


def decimal_text(value: float, digits: int = 15) -> str:
    """One number with so many significant digits, as fixed-point text.

    >>> decimal_text(0.1 + 0.2), decimal_text(-1e-7), decimal_text(4.0)
    ('0.3', '-0.0000001', '4')
    """
    if value == 0 or not math.isfinite(value):
        return "0"
    return np.format_float_positional(float(f"{value:.{digits}g}"), trim="-")


def without_zero(text: str) -> str:
    """A decimal text without a zero before its point, as SVG reads it too.

    >>> without_zero("0.5"), without_zero("-0.25"), without_zero("0"), without_zero("10.5")
    ('.5', '-.25', '0', '10.5')
    """
    if text.startswith("0."):
        return text[1:]
    return "-" + text[2:] if text.startswith("-0.") else text


def decimals_for(extent: float, share: float = 1e-10) -> int:
    """How many decimals keep the rounding below `share` of an extent, 1 to 17.

    >>> decimals_for(1000.0), decimals_for(0.0), decimals_for(1e30)
    (7, 10, 1)
    """
    if not math.isfinite(extent) or extent <= 0:
        extent = 1.0
    return min(17, max(1, math.ceil(-math.log10(extent * share) - 1e-9)))


def joined(values: Iterable[float]) -> str:
    """A short list of numbers, blank between, with 15 significant digits each."""
    return " ".join(decimal_text(value) for value in values)
