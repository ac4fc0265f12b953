"""What an operation that takes a shape apart gives: parts, and the words that select each.

A part keeps the coordinates of the scope it was cut from; whoever asked gives it a scope of its
own. Which part a rule takes is not decided here.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.geometry.solid import Floats, Solid


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
