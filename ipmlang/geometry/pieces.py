"""What an operation that takes a shape apart gives: parts, and the words that select each.

A part keeps the coordinates of the scope it was cut from; whoever asked gives it a scope of its
own. Which part a rule takes is not decided here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ipmlang.geometry.solid import Floats, Indices, Solid


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """One part that an operation makes.

    words: the labels and tags that select it; solid: its geometry in the coordinates of the scope
    it was cut from; axes (3, 3): the unit x, y, z of its own scope as rows in those coordinates,
    or None where it keeps those of the scope it was cut from.
    """

    words: frozenset[str]
    solid: Solid
    axes: Floats | None = None


@lru_cache(maxsize=512)
def numbered_rings(ends: tuple[int, ...]) -> tuple[Indices, Indices, Indices]:
    """Corners, rings and faces of one face whose rings end there, whose vertices are numbered in
    the order of its corners; parts share them.
    """
    found = (np.arange(ends[-1]), np.array([0, *ends]), np.array([0, len(ends)]))
    for each in found:
        each.setflags(write=False)
    return found
