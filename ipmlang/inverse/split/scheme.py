"""What a model is made of, said shortly: symbols that place other symbols.

A scheme is what inference looks for, what edits change and what is printed. Every symbol has
coordinates of its own and a scope from (0, 0, 0) to its size; what it draws may stand out of that.
Nothing here searches or prints.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, identity


@dataclass(frozen=True, slots=True, eq=False)
class Terminal:
    """A shape that no rule makes: the class of parts with this index. Its scope is its box, which
    begins at `low` (3,) in its own coordinates. form: the same for shapes that only differ in what
    they are made of, which have one's coordinates; the class's = pose(these), one row.
    """

    name: str
    size: Floats
    part: int
    low: Floats = field(default_factory=lambda: np.zeros(3))
    form: int = -1
    pose: Frames = field(default_factory=identity)


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """A symbol at each of n frames, for which there is no rule.

    stretch: (n, 3) the sizes its scope is stretched to, None where it keeps its own. margins:
    (n, 3) for sizes that follow the scope of the rule, by how much they are less than it along
    each axis, not a number where they do not; only beside `stretch`. anchors: the axes along which
    it keeps its distance from the far end of the rule's scope.
    """

    symbol: int
    frames: Frames
    stretch: Floats | None = None
    margins: Floats | None = None
    anchors: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True, eq=False)
class Direction:
    """One axis of an array: `count` members, each `step` (3,) beyond the one before it; or, where
    `steps` are given (count - 1,), as many times a unit `step` beyond it; or, where there is an
    `angle`, on a circle: `step` is the arm from its center to the first, and each next one stands
    as many degrees on about the `axis` (3,), turned as the first is; such a one is its array's only
    one.
    """

    count: int
    step: Floats
    steps: tuple[float, ...] = ()
    angle: float = 0.0
    axis: Floats = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True, eq=False)
class Array:
    """A symbol in a row, a grid or a block of up to three directions (not necessarily along axes).

    first: one frame, of the member with all digits 0; holes: digits of members that are missing.
    """

    symbol: int
    first: Frames
    directions: tuple[Direction, ...]
    holes: frozenset[tuple[int, ...]] = frozenset()


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A symbol again and again about an axis: rings, fans, spiral stairs, spirals; with an angle of
    0: rows whose members grow.

    first: one frame, of the first member; center, axis: (3,) a point and the unit direction of the
    axis; angle: degrees a step; rise: units a step along the axis; growth: factor a step of size
    and of distance from the center; gain: what is added to that factor a step, beside a growth of
    1; holes: indices that are missing.
    """

    symbol: int
    first: Frames
    count: int
    center: Floats
    axis: Floats
    angle: float
    rise: float = 0.0
    growth: float = 1.0
    holes: frozenset[int] = frozenset()
    gain: float = 0.0

    @property
    def grows(self) -> bool:
        """Whether members differ in size."""
        return self.growth != 1.0 or self.gain != 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """A part of a split: `count` cells of `length` along the axis, one behind the other, with a
    symbol in each (None: nothing). elastic: `~length`, takes its share of what is left over.

    The symbol's coordinates are the cell's: origin in its low corner, as wide as the parent.
    """

    length: float
    symbol: int | None
    count: int = 1
    elastic: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """The scope of the rule cut along an axis (0 x, 1 y, 2 z) into cells that fill it."""

    axis: int
    cells: tuple[Cell, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """A point split (Demir and Aliaga 2016, equation 1): of the eight parts around `point` (3,) the
    one of this number, 1 + [beyond in x] + 2 [beyond in y] + 4 [beyond in z].
    """

    point: Floats
    octant: int


@dataclass(frozen=True, slots=True, eq=False)
class Octant:
    """The paper's own form: cuts, each in the coordinates of what the one before left, take a box
    of `size` (3,) out of the rule's scope; `counts` cells fill it (`subdivide`, 1, 1, 1: one), and
    in each the symbol stands in the frame `inner`, one row, with a scope of its own size.
    """

    symbol: int
    cuts: tuple[Cut, ...]
    size: Floats
    inner: Frames
    counts: tuple[int, int, int] = (1, 1, 1)


Item: TypeAlias = Place | Array | Ring | Split | Octant


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """A symbol that draws items, each in the rule's own coordinates; size (3,): its scope.

    name: what a person would call it, empty where nothing says so. note: its documentation.
    """

    name: str
    size: Floats
    items: tuple[Item, ...]
    note: str = ""


Symbol: TypeAlias = Terminal | Rule


@dataclass(frozen=True, slots=True, eq=False)
class Scheme:
    """Symbols, each before those that place it; the axiom is the last. frame: one row, the
    axiom's coordinates in the world: turned, where the building stands askew to the world's axes.
    """

    symbols: tuple[Symbol, ...]
    frame: Frames

    @property
    def axiom(self) -> int:
        """The index of the symbol that stands for everything."""
        return len(self.symbols) - 1
