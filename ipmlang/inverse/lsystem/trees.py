"""Branching structures in a string: the rules r3 and r4 of the paper as candidates.

Takes an arrangement; gives stretches of one symbol that a branching rule draws in just this order.
The structure itself is found in `recursion`; whether it pays and is exact is for the caller.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.lsystem.regular import stretches
from ipmlang.inverse.lsystem.symbols import Alphabet, Arrangement, Integers
from ipmlang.inverse.recursion.branching import Branching, find_branching

LEAST = 7  # nodes
MOST_TRIES = 3  # stretches of one round
SECONDS = 5.0  # for one of them, which hardly any takes


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """`count` symbols from row `first` on are what the structure draws from `lead`, one frame."""

    first: int
    count: int
    branching: Branching
    lead: Frames


@dataclass(slots=True, eq=False)
class TreeSearch:
    """Remembers which stretches hold no tree: (first element, elements)."""

    failed: set[tuple[int, int]] = field(default_factory=set)

    def find(
        self, alphabet: Alphabet, arrangement: Arrangement, tokens: Integers, least: float
    ) -> Iterator[Tree]:
        """Trees in the longest stretches, of those whose symbols take the `least` tokens in all;
        tokens: (n,) of each symbol's placement.
        """
        same = stretches(arrangement)
        edges = np.flatnonzero(np.diff(same, prepend=-1))
        sizes = np.diff(np.append(edges, len(same)))
        longest = np.argsort(-sizes, kind="stable")[:MOST_TRIES]
        for which in longest[sizes[longest] >= LEAST].tolist():
            first, count = int(edges[which]), int(sizes[which])
            if tokens[first : first + count].sum() < least:
                continue
            size = alphabet[int(arrangement.symbol[first])].size
            key = int(arrangement.start[first]), count * size
            if key not in self.failed:
                found = _tree(alphabet, arrangement, first, count)
                if found is None:
                    self.failed.add(key)
                else:
                    yield found


def _tree(alphabet: Alphabet, arrangement: Arrangement, first: int, count: int) -> Tree | None:
    definition = alphabet[int(arrangement.symbol[first])]
    placed = arrangement.placed[first : first + count]
    if not definition.free and _stand_alike(placed):
        return None
    found = find_branching(
        placed,
        definition.stabiliser,
        free=definition.free,
        radius=definition.radius,
        tolerance=alphabet.tolerance,
        seconds=SECONDS,
        painted=True,
    )
    if found is None:
        return None
    return Tree(first + int(found.order[0]), len(found.order), found, found.root)


def _stand_alike(placed: Frames) -> bool:
    """Whether all are only moved: branches that neither turn nor shrink run into one another."""
    alike = np.abs(placed.factor - placed.factor[0]) <= 1e-9 * placed.scale[0]
    return bool((alike & (placed.handedness == placed.handedness[0])).all())
