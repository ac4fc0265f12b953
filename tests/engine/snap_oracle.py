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
    """The move of a block of cuts: the most of them to lines, then the least, then the lower."""
    tiny = TINY * length
    moves: list[float] = []
    for cut in cuts:
        low = max((line for line in lines if line <= cut + tiny), default=None)
        high = min((line for line in lines if line > cut + tiny), default=None)
        for line in (low, high):
            if line is None:
                continue
            by = line - cut
            room = below if by < 0 else above
            if abs(by) < room - tiny and abs(by) <= reach + tiny:
                moves.append(by)
    best, most = 0.0, 0
    for by in sorted(moves, key=lambda each: (round(abs(each), 9), each)):
        many = sum(any(abs(line - cut - by) <= tiny for line in lines) for cut in cuts)
        if many > most:
            best, most = by, many
    return best
