"""Description length: how many tokens a placement, a rule or a sequence takes when printed.

The one measure that decides whether a rule pays. It follows `compiler.tokens`: a name, a number, a
sign, a mark or a bracket is one token. Nothing here prints or searches.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.lsystem.patterns import Pattern
from ipmlang.inverse.recursion.branching import Branching

Integers = NDArray[np.int64]

SMALL = 1e-9  # degrees or ratio: what is printed as nothing at all
HEAD = 2  # `Name -->`
COUNTED = 3  # `(n)` on a use, and as much again on the head
LOOP = 9  # `repeat(i < n) { … }`


def placement_tokens(placed: Frames, small: float) -> Integers:
    """(n,) tokens of `[at(x, y, angle, scale) mirror A]`, what is not needed left out.

    small: units, distances that are printed as 0.

    >>> from ipmlang.inverse.lsystem.frames import frames
    >>> placement_tokens(frames(np.array([0, 3 + 4j, -3j]), np.array([0.0, 0, 90])), 1e-9).tolist()
    [1, 8, 10]
    """
    x, y = _sized(placed.x, small), _sized(placed.y, small)
    turned, scaled = np.abs(placed.angle) > SMALL, np.abs(placed.scale - 1) > SMALL
    moved = (x > 1) | (y > 1) | (np.abs(placed.x) > small) | (np.abs(placed.y) > small)
    sign = placed.angle < -SMALL
    at = 3 + x + y + np.where(turned | scaled, 1 + sign, 0) + scaled
    plain = np.where(turned, 4, 0) + np.where(scaled, 4, 0)
    inside = np.where(moved, at, plain) + (placed.handedness < 0)
    return np.where(inside > 0, inside + 3, 1).astype(np.int64)


def _sized(value: NDArray[np.float64], small: float) -> Integers:
    """Tokens of a number: 2 with a sign."""
    return np.where(value < -small, 2, 1).astype(np.int64)


def sequence_tokens(pattern: Pattern) -> int:
    """Tokens of the body that makes a sequence, without its rule's head."""
    base, delta = pattern.base, pattern.delta
    inside = 4 * (abs(pattern.rest) > SMALL) + 6 * (pattern.inner != 0)
    more = 4 * sum(value != 0.0 for value in delta) + inside
    if pattern.kind == "even":
        steps = sum(abs(value) > SMALL for value in base)
        return LOOP + 3 + 4 + 2 * steps + more
    if pattern.kind == "listed":
        return LOOP + 6 + len(pattern.steps) + more
    if pattern.kind == "polar":
        further = abs(base[2]) > SMALL or pattern.rooted
        growing = 8 * (abs(base[3]) > SMALL)
        return LOOP + 3 + 6 + 4 + 4 * further + growing + 4 * pattern.upright + more
    neutral = (0.0, 0.0, 1.0, 0.0)
    used = sum(
        abs(t0 - rest) > SMALL or t1 != 0.0
        for t0, t1, rest in zip(base, delta, neutral, strict=True)
    )
    return LOOP + 3 + 4 * used + more + pattern.mirrored


def tree_tokens(branching: Branching) -> int:
    """Tokens of both rules of a branching structure, heads included."""
    total = 2 * (HEAD + COUNTED + 4) + 2
    for twig in branching.twigs:
        total += 8 + (twig.hand < 0)
        for first, slope, rest in zip(twig.first, twig.slope, (0.0, 0.0, 1.0, 0.0), strict=True):
            total += 4 * bool(abs(first - rest) > SMALL or slope) + 4 * bool(slope)
    return total
