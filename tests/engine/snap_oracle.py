"""Cuts moved to lines by hand: block by block, every cut against every line.

Written from what the reference says of `snap:`, not from how the engine finds lines: the pieces
come from the oracle of splits, and only what lies between two pieces that give way moves.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from tests.engine.split_oracle import Part, Parts, pieces

TINY = 1e-9


def snapped(
    parts: Parts, length: float, lines: Sequence[float], reach: float = float("inf")
) -> list[tuple[float, float]]:
    """Where each piece begins and how long it is, once its cuts are at the lines."""
    found = [(part, low, size) for part, _, low, size in pieces(parts, length)]
    lows = [low for _, low, _ in found]
    highs = [low + size for _, low, size in found]
    giving = [number for number, (part, _, _) in enumerate(found) if _gives(part)]
    for left, right in itertools.pairwise(giving):
        cuts = [found[number][1] for number in range(left + 1, right + 1)]
        by = _least(cuts, lines, found[left][2] / 2, found[right][2] / 2, reach, length)
        for number in range(left + 1, right + 1):
            lows[number] += by
            highs[number - 1] = lows[number]
    return [(low, high - low) for low, high in zip(lows, highs, strict=True)]


def _gives(part: Part) -> bool:
    return part.kind != "absolute"


def _least(
    cuts: Sequence[float],
    lines: Sequence[float],
    below: float,
    above: float,
    reach: float,
    length: float,
) -> float:
    """The move of a block of cuts: the least one, of the lowest cut, to the lower line."""
    best = None
    for cut in cuts:
        for line in sorted(lines):
            by = line - cut
            if abs(by) >= (below if by < 0 else above) - TINY * length:
                continue
            if abs(by) > reach + TINY * length:
                continue
            if best is None or abs(by) < abs(best) - TINY * length:
                best = by
    return 0.0 if best is None else best
