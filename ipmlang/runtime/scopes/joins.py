"""Booleans while a derivation runs: every use of `union`, `subtract` or `intersect` is a row.

In go the states in which such an operation was met, as columns of a batch; out come numbers of its
parts, which shapes carry in their state like a pen's colour. What the parts draw is made one solid
when all is drawn, elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.code import Column

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
FIELD = "join"  # of the pen: the number of the innermost part of a boolean, -1 outside all
FRAME = ("x", "y", "z", "w", "i", "j", "k", "scale")


@dataclass(frozen=True, slots=True, eq=False)
class Met:
    """One operation in a batch of `count` shapes, `parts` for each: the number of the first part,
    the part around each shape, and the frames (count, 8).
    """

    kind: str
    first: int
    parts: int
    count: int
    around: Numbers
    frames: Floats
    where: str


@dataclass(slots=True, eq=False)
class Joining:
    """The booleans of one derivation."""

    met: list[Met] = field(default_factory=list)
    parts: int = 0

    def begin(
        self, kind: str, parts: int, count: int, around: Column, state: Mapping[str, Column],
        where: str,
    ) -> Floats:  # fmt: skip
        """The numbers (count,) of the first parts of an operation, one for each row of a batch;
        those of the other parts follow.
        """
        columns = [state.get(name, 1.0) for name in FRAME]
        frames = np.stack([np.broadcast_to(each, (count,)) for each in columns], axis=1)
        own = np.broadcast_to(np.asarray(around, np.int64), (count,))
        first = self.parts
        self.met.append(Met(kind, first, parts, count, own, frames.astype(np.float64), where))
        self.parts += parts * count
        return first + parts * np.arange(count, dtype=np.float64)
