"""What the machine must know of geometries that fill their scopes: how cuts change them, and which
faces the parts of an operation take.

In go the numbers of the geometries that shapes bear, out come tables of numbers for the data of the
machine. Geometries that follow from these, by cuts and as faces, are described with them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime.gpu.words import Faces
from ipmlang.runtime.scopes.pieces import faces_taken
from ipmlang.runtime.scopes.pool import BOX, Pool

Floats = NDArray[np.float64]
Cut = Callable[[int, int, int, int], int]  # axis, geometry, begins later, ends earlier

WIDTH = 16  # numbers of a geometry: what it is, then what cuts across x, y and z make of it
FACE_WIDTH = 13  # numbers of a kind of box: how many faces, which, and their geometries
MOST = 4096  # geometries that are described; a shape with another one is the CPU's


class Geometries:
    """The tables of one derivation, which grow with its geometries."""

    def __init__(self, pool: Pool, cut: Cut) -> None:
        self._pool = pool
        self._cut = cut
        self._rows: dict[int, list[float]] = {}
        self._taken: dict[tuple[tuple[ir.Const, ...], int], Floats] = {}

    def __len__(self) -> int:
        """How many are described."""
        return len(self._rows)

    def describe(self, numbers: Iterable[int]) -> None:
        """Add geometries, and all that follow from them."""
        waiting = {BOX, *numbers} - self._rows.keys()
        while waiting and len(self._rows) < MOST:
            number = waiting.pop()
            if not bool(self._pool.are_boxes(float(number))):
                continue
            self._rows[number] = row = self._described(number)
            waiting |= {int(each) for each in row[1:13]} - self._rows.keys()
            waiting |= set(self._faces(number)) - self._rows.keys()

    def table(self) -> Floats:
        """One row (n, WIDTH) for every number up to the largest; zeros where it fills no scope."""
        made = np.zeros((max(self._rows) + 1, WIDTH))
        for number, row in self._rows.items():
            made[number] = row
        return made

    def faces(self, part: Faces) -> Floats:
        """What a part takes (n * 4, FACE_WIDTH) of each geometry: whole, then flat in x, y, z."""
        made = np.zeros((max(self._rows) + 1, 4, FACE_WIDTH))
        for number in self._rows:
            key = (part.selectors, number)
            if key not in self._taken:
                self._taken[key] = self._all_taken(*key)
            made[number] = self._taken[key][:, part.place]
        return made.reshape(-1, FACE_WIDTH)

    def _all_taken(self, selectors: tuple[ir.Const, ...], number: int) -> Floats:
        """The same of one geometry (4, parts, FACE_WIDTH)."""
        made = np.zeros((4, len(selectors), FACE_WIDTH))
        for flat in range(4):
            found = faces_taken(self._pool, selectors, number * 4 + flat)
            for place, (faces, geometry) in enumerate(found):
                made[flat, place, 0] = len(faces)
                made[flat, place, 1 : 1 + len(faces)] = faces
                made[flat, place, 7 : 7 + len(faces)] = geometry
        return made

    def _described(self, number: int) -> list[float]:
        if not bool(self._pool.are_tagged(float(number))):
            return [1.0, *[float(number)] * 12, 0.0, 0.0, 0.0]
        cuts = [
            float(self._cut(axis, number, begins, ends))
            for axis in range(3) for begins in (0, 1) for ends in (0, 1)
        ]  # fmt: skip
        return [3.0, *cuts, 0.0, 0.0, 0.0]

    def _faces(self, number: int) -> Sequence[int]:
        """The geometries of all faces."""
        found: list[int] = []
        for flat in range(4):
            found += faces_taken(self._pool, (("all",),), number * 4 + flat)[0][1]
        return found
