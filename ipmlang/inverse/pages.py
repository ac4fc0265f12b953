"""Strokes as they lie on the page of a drawing, and the recursion that drew them there.

Takes segments in paint order, y up, in the units of the page; gives the recursion, or of an outline
the repeats, that draws them within the tolerance of an exact grammar, or within what the decimals
of the file's numbers moved the points by. Nothing here writes a grammar.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.recursion import Recursion, fold, fold_repeats

TOLERANCE = 4e-7  # of the diagonal: what the ends of segments may be off
MOST_DECIMALS = 7  # of coordinates that were rounded
NEAREST = 0.75  # of the last decimal: what rounding both coordinates moves a point by, and a bit
SAME = 1e-12  # of the largest coordinate: what reading a number may be off
ROUNDED = 5.0  # seconds for a recursion of rounded points
MANY = 2000  # segments beyond which what is exact is not asked for again
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Page:
    """diagonal: units; flip: y up is flip - y; bounded: whether a viewBox says where y = 0 is."""

    diagonal: float
    flip: float
    bounded: bool

    @property
    def exact(self) -> float:
        """Units that the ends of segments may be off."""
        return TOLERANCE * self.diagonal

    def decimals(self, points: Complexes) -> int | None:
        """How many decimals the coordinates of points have, where these are so few that rounding
        moved the points by more than the tolerance; None where not, or where no page says where
        y = 0 is.
        """
        if not self.bounded:
            return None
        values = np.concatenate([points.real, points.imag, [self.flip]])
        for decimals in range(MOST_DECIMALS):
            if 10.0**-decimals < self.exact:
                return None
            if np.abs(values - np.round(values, decimals)).max() <= SAME * np.abs(values).max():
                return decimals
        return None


def folded(
    page: Page,
    start: Complexes,
    end: Complexes,
    *,
    styles: Integers | None = None,
    closed: bool = False,
    repeats: bool = False,
) -> tuple[Recursion | None, int | None]:
    """The recursion that draws segments start, end (n,), and the decimals that its points were
    rounded to, None where they are exact: rules if there are any, else, with `repeats`, those of an
    outline that may be `closed`.
    """
    points = np.concatenate([start, end])
    extent = max(1e-300, abs(complex(np.ptp(points.real), np.ptp(points.imag))))
    exact, decimals = page.exact / extent, page.decimals(points)
    grain = 0.0 if decimals is None else 10.0**-decimals
    rounded = NEAREST * grain / extent
    near: Recursion | None = None
    if grain:
        near = fold(start, end, styles=styles, tolerance=rounded, grain=grain, seconds=ROUNDED)
        if near is not None and near.error > page.exact:
            return near, decimals
        if near is not None and len(start) > MANY:
            return near, None
    # Where rounding moved nothing, exact points leave less choice and shorter rules.
    found = fold(start, end, styles=styles, tolerance=exact) or near
    if found is not None or not repeats:
        return found, None
    found = fold_repeats(start, end, closed=closed, tolerance=exact)
    if found is not None or not grain:
        return found, None
    return fold_repeats(start, end, closed=closed, tolerance=rounded, grain=grain), decimals
