"""The largest rectangle along the axes within a convex polygon.

In goes one convex ring, out come the rectangle's bounds. Between a left and a right line the height
left free is concave in both, so the logarithm of the area is, too: for a left line the best right
one is found exactly, and the best left one by narrowing down. No other polygon is looked at here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.geometry.solid import Floats

BENT = 1e-12  # the sine by which a corner of a convex polygon may bend the wrong way
LINES = (9, 257)  # left lines that are looked at together, at least and at most
AT_ONCE = 1 << 18  # pairs of a left line and a place for the right one, looked at together
FINE = 1e-10  # the last step, as a part of the width


@dataclass(frozen=True, slots=True, eq=False)
class _Chains:
    """The lower and the upper boundary from left to right, (n, 2) and (m, 2)."""

    lower: Floats
    upper: Floats

    def heights(self, x: Floats) -> tuple[Floats, Floats]:
        """Where the boundaries are at x."""
        low, high = (np.interp(x, *chain.T) for chain in (self.lower, self.upper))
        return low, high


def is_convex(ring: Floats) -> bool:
    """Whether a ring (n, 2), counter-clockwise, turns left all along, once around."""
    along = np.roll(ring, -1, axis=0) - ring
    before = np.roll(along, 1, axis=0)
    sine = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    long = np.hypot(*along.T)
    if (sine < -BENT * long * np.roll(long, 1)).any():
        return False
    rises = np.sign(along[along[:, 0] != 0, 0])
    return int((rises != np.roll(rises, 1)).sum()) == 2


def widest_lines(ring: Floats) -> tuple[float, float]:
    """The left and the right side of the largest rectangle in a convex ring (n, 2)."""
    chains = _chains(ring)
    low, high = float(ring[:, 0].min()), float(ring[:, 0].max())
    width, best, right = high - low, low, high
    many = min(max(AT_ONCE // len(ring), LINES[0]), LINES[1])
    while high - low > FINE * width:
        left = np.linspace(low, high, many)
        areas, rights = _best_right(chains, left)
        place = int(areas.argmax())
        best, right = float(left[place]), float(rights[place])
        low, high = float(left[max(place - 1, 0)]), float(left[min(place + 1, many - 1)])
    return best, right


def _chains(ring: Floats) -> _Chains:
    """The boundaries between the leftmost and the rightmost corners."""
    onward = np.roll(ring, -1, axis=0)
    right, left = onward[:, 0] > ring[:, 0], onward[:, 0] < ring[:, 0]
    lower = np.concatenate([ring[right], onward[right]])
    upper = np.concatenate([ring[left], onward[left]])
    return _Chains(*(each[np.argsort(each[:, 0], kind="stable")] for each in (lower, upper)))


def _best_right(chains: _Chains, left: Floats) -> tuple[Floats, Floats]:
    """The largest area (k,) to the right of lines, and where its right side is.

    The free height is linear between corners and the places where it leaves the left line's own
    heights behind; in each such stretch the area is a quadratic of the right side.
    """
    floor, roof = chains.heights(left)
    stops = np.concatenate([chains.lower[:, 0], chains.upper[:, 0]])
    falling, rising = _after_top(chains.upper), _after_top(chains.lower * (1, -1)) * (1, -1)
    leaves = [
        np.interp(roof, falling[::-1, 1], falling[::-1, 0]),
        np.interp(floor, rising[:, 1], rising[:, 0]),
    ]
    places = np.concatenate(
        [np.broadcast_to(stops, (len(left), len(stops))), np.stack(leaves, axis=1)], axis=1
    )
    places = np.sort(np.maximum(places, left[:, None]), axis=1)
    low, high = chains.heights(places)
    free = np.minimum(high, roof[:, None]) - np.maximum(low, floor[:, None])
    wide = places - left[:, None]
    step, less = np.diff(places, axis=1), np.diff(free, axis=1)
    wide, free = wide[:, :-1], free[:, :-1]
    curve = -2 * step * less
    share = np.divide(step * free + wide * less, curve, out=np.ones(curve.shape), where=curve > 0)
    share = np.clip(share, 0.0, 1.0)
    areas = (wide + share * step) * (free + share * less)
    best = areas.argmax(axis=1)
    rows = np.arange(len(left))
    return areas[rows, best], (places[:, :-1] + share * step)[rows, best]


def _after_top(chain: Floats) -> Floats:
    """The part of a boundary, from left to right, that falls from its highest point on."""
    top = len(chain) - 1 - int(np.argmax(chain[::-1, 1]))
    return chain[top:]
