"""How much of a model a scheme explains: parts that stand under something that repeats.

Takes a scheme and the parts it was found for; gives counts. A part counts as explained that is
drawn by a rule that is drawn twice or more, or by a row, a grid, a ring or repeated cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.frames import Floats
from ipmlang.inverse.parts.observation import Parts
from ipmlang.inverse.split.expansion import placements
from ipmlang.inverse.split.scheme import Array, Item, Octant, Ring, Rule, Scheme, Split


@dataclass(frozen=True, slots=True)
class Counts:
    """rules: besides the axiom; twice: of these, drawn twice or more; explained: share of all
    parts; repeated: parts that have a twin; explained_repeated: share of these.
    """

    rules: int
    twice: int
    explained: float
    repeated: int
    explained_repeated: float


def count_explained(scheme: Scheme, parts: Parts, families: Sequence[Sequence[int]] = ()) -> Counts:
    """The counts of a scheme; families: symbols that are printed as one rule."""
    drawn = _drawn_as_printed(scheme, families)
    rules = [k for k, each in enumerate(scheme.symbols[:-1]) if isinstance(each, Rule)]
    members = np.bincount(parts.shape, minlength=len(parts.classes))
    shares = _terminals(scheme, drawn, len(members))
    twins = members >= 2
    explained = np.minimum(shares, members)
    return Counts(
        len(rules),
        sum(bool(drawn[k] >= 2) for k in rules),
        float(explained.sum() / max(1, members.sum())),
        int(members[twins].sum()),
        float(explained[twins].sum() / max(1, members[twins].sum())),
    )


def times_drawn(scheme: Scheme) -> Floats:
    """(n,) how often each symbol is drawn."""
    drawn = np.zeros(len(scheme.symbols))
    drawn[scheme.axiom] = 1
    for number in range(scheme.axiom, -1, -1):
        symbol = scheme.symbols[number]
        if isinstance(symbol, Rule):
            for item in symbol.items:
                for inner, frames in placements(item):
                    drawn[inner] += drawn[number] * len(frames)
    return drawn


def _drawn_as_printed(scheme: Scheme, families: Sequence[Sequence[int]]) -> Floats:
    """(n,) how often the rule of each symbol is drawn."""
    drawn = times_drawn(scheme)
    for each in families:
        drawn[list(each)] = drawn[list(each)].sum()
    return drawn


def _terminals(scheme: Scheme, drawn: Floats, size: int) -> Floats:
    """How many parts of each of so many classes are drawn below something that repeats; drawn (n,):
    how often the rule of each symbol is.
    """
    whole: list[Floats] = []  # terminals below each symbol
    under: list[Floats] = []  # of these, those below something that repeats
    for number, symbol in enumerate(scheme.symbols):
        every, told = np.zeros(size), np.zeros(size)
        if isinstance(symbol, Rule):
            for item in symbol.items:
                for inner, frames in placements(item):
                    every += len(frames) * whole[inner]
                    repeats = _repeats(item) and len(frames) > 1
                    told += len(frames) * (whole[inner] if repeats else under[inner])
            if drawn[number] >= 2:
                told = every
        else:
            every[symbol.part] = 1
        whole.append(every)
        under.append(told)
    return under[scheme.axiom]


def _repeats(item: Item) -> bool:
    return isinstance(item, Array | Ring | Split | Octant)
