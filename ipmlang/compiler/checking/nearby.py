"""Terminals that nothing defines and whose name is one letter off a name that something has, or
several one-letter names without the blanks between them.

Names are compared by what is left when one letter is taken out, so that the time is linear in the
length of all names; what is longer than a person types is not compared. Names that differ in a
digit (`leaf_1`, `leaf_2`) are meant to differ.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

SHORTEST, LONGEST = 4, 100


def near_misses(terminals: Iterable[str], known: Iterable[str]) -> Mapping[str, str]:
    """For each terminal that is one letter off a known name, that name."""
    wanted = [name for name in terminals if SHORTEST <= len(name) <= LONGEST]
    if not wanted:
        return {}
    index: dict[str, list[str]] = {}
    for name in wanted:
        for left in _without_one(name):
            index.setdefault(left, []).append(name)
    near: dict[str, set[str]] = {}
    for other in known:
        if SHORTEST <= len(other) <= LONGEST:
            for left in index.keys() & _without_one(other):
                for name in index[left]:
                    near.setdefault(name, set()).add(other)
    found: dict[str, str] = {}
    for name in wanted:
        close = [each for each in near.get(name, ()) if each != name and is_slip(name, each)]
        if close:
            found[name] = min(close)
    return found


def glued(names: Iterable[str], known: Iterable[str]) -> Mapping[str, str]:
    """For each name that is nothing but known one-letter symbols in a row, as books and other
    programs write them, how it is written with blanks.

    >>> glued(["FF", "FX", "Fence"], ["F", "X"])
    {'FF': 'F F', 'FX': 'F X'}
    """
    letters = {name for name in known if len(name) == 1}
    return {name: " ".join(name) for name in names if len(name) > 1 and letters.issuperset(name)}


@lru_cache(maxsize=4096)
def _without_one(name: str) -> frozenset[str]:
    """A name, and what is left of it without one of its letters."""
    return frozenset([name, *(name[:place] + name[place + 1 :] for place in range(len(name)))])


def is_slip(first: str, second: str) -> bool:
    """Whether two names differ by one letter left out, added, changed, or swapped with its
    neighbour, and that letter is no digit.
    """
    start = 0
    while start < min(len(first), len(second)) and first[start] == second[start]:
        start += 1
    end = 0
    most = min(len(first), len(second)) - start
    while end < most and first[-1 - end] == second[-1 - end]:
        end += 1
    left, right = first[start : len(first) - end], second[start : len(second) - end]
    if any(char.isdigit() for char in left + right):
        return False
    swapped = len(left) == 2 and left == right[::-1]
    return swapped or max(len(left), len(right)) == 1
