"""Arithmetic on operands of generated source, and the turtle's frame written with it.

An operand is a known number or the name of a column; what is known is computed here and now, so
that code for a turtle that never tilts has no columns of zeros. Out come lines of source.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from ipmlang.runtime.code import source

Operand: TypeAlias = "str | float"
Vector: TypeAlias = tuple[Operand, Operand, Operand]
Rotation: TypeAlias = tuple[Operand, Operand, Operand, Operand]


class Source:
    """Lines of a function under construction; every result gets a name of its own."""

    def __init__(self, prefix: str = "t") -> None:
        self._prefix = prefix
        self.lines: list[str] = []
        self._count = 0
        self._known: dict[str, str] = {}
        self._factors: dict[tuple[Rotation, int, int], Operand] = {}

    def name(self) -> str:
        """A new name."""
        self._count += 1
        return f"{self._prefix}{self._count}"

    def let(self, expression: str) -> str:
        """The name of an expression, computed once."""
        if expression not in self._known:
            self._known[expression] = self.name()
            self.lines.append(f"{self._known[expression]} = {expression}")
        return self._known[expression]

    def add(self, a: Operand, b: Operand) -> Operand:
        """a + b."""
        if isinstance(a, float) and isinstance(b, float):
            return a + b
        if b == 0.0:
            return a
        return b if a == 0.0 else self.let(f"{source(a)} + {source(b)}")

    def subtract(self, a: Operand, b: Operand) -> Operand:
        """a - b."""
        if isinstance(a, float) and isinstance(b, float):
            return a - b
        return a if b == 0.0 else self.let(f"{source(a)} - {source(b)}")

    def multiply(self, a: Operand, b: Operand) -> Operand:
        """a * b."""
        if isinstance(a, float) and isinstance(b, float):
            return a * b
        if a == 0.0 or b == 0.0:
            return 0.0
        if b == 1.0:
            return a
        return b if a == 1.0 else self.let(f"{source(a)} * {source(b)}")

    def sum(self, *pairs: tuple[Operand, Operand]) -> Operand:
        """The sum of products."""
        total: Operand = 0.0
        for a, b in pairs:
            total = self.add(total, self.multiply(a, b))
        return total

    def minus(self, a: Operand) -> Operand:
        """-a."""
        return -a if isinstance(a, float) else self.let(f"-{a}")

    def unit(self, degrees: Operand) -> tuple[Operand, Operand]:
        """Cosine and sine of an angle, exact at whole quarters."""
        if isinstance(degrees, float):
            return cosine_and_sine(degrees)
        pair = self.let(f"unit({degrees})")
        return self.let(f"{pair}[0]"), self.let(f"{pair}[1]")

    def quaternion(self, axis: str, degrees: Operand, hand: Operand) -> Rotation:
        """A turn about a local axis; a mirrored frame turns about y and z the other way."""
        cosine, sine = self.unit(self.multiply(degrees, 0.5))
        if axis == "x":
            return cosine, sine, 0.0, 0.0
        sine = self.multiply(sine, hand)
        return (cosine, 0.0, sine, 0.0) if axis == "y" else (cosine, 0.0, 0.0, sine)

    def product(self, a: Rotation, b: Rotation) -> Rotation:
        """The product of two quaternions."""
        aw, ax, ay, az = a
        bw, bx, by, bz = b
        nx, ny, nz = self.minus(bx), self.minus(by), self.minus(bz)
        return (
            self.sum((aw, bw), (ax, nx), (ay, ny), (az, nz)),
            self.sum((aw, bx), (ax, bw), (ay, bz), (az, ny)),
            self.sum((aw, by), (ax, nz), (ay, bw), (az, bx)),
            self.sum((aw, bz), (ax, by), (ay, nx), (az, bw)),
        )

    def turned(self, rotation: Rotation, vector: Vector) -> Vector:
        """A vector turned by a unit quaternion."""
        return tuple(self._row(rotation, row, vector) for row in range(3))  # type: ignore[return-value]

    def _row(self, rotation: Rotation, row: int, vector: Vector) -> Operand:
        """One component: the vector's own first, then the others in their order."""
        total: Operand = 0.0
        for column in (row, *(each for each in range(3) if each != row)):
            if vector[column] != 0.0:
                factor = self._factor(rotation, row, column)
                total = self.add(total, self.multiply(vector[column], factor))
        return total

    def _factor(self, rotation: Rotation, row: int, column: int) -> Operand:
        """An entry of the matrix of a unit quaternion, written when it is first needed."""
        key = (rotation, row, column)
        if key not in self._factors:
            w, own = rotation[0], rotation[1:]
            if row == column:
                a, b = (self._doubled(own[k], own[k]) for k in range(3) if k != row)
                self._factors[key] = self.subtract(1.0, self.add(a, b))
            else:
                first, second = sorted((row, column))
                same = self._doubled(own[first], own[second])
                across = self._doubled(own[3 - row - column], w)
                join = self.add if (row - column) % 3 == 1 else self.subtract
                self._factors[key] = join(same, across)
        return self._factors[key]

    def _doubled(self, a: Operand, b: Operand) -> Operand:
        """2 * a * b."""
        return self.multiply(self.multiply(2.0, a), b)


def cosine_and_sine(degrees: float) -> tuple[float, float]:
    """Of one angle in degrees, exact at whole quarters.

    >>> cosine_and_sine(90.0), cosine_and_sine(-180.0)
    ((0.0, 1.0), (-1.0, 0.0))
    """
    if not math.isfinite(degrees):
        return math.nan, math.nan
    quarter = round(degrees / 90)
    rest = math.radians(degrees - 90 * quarter)
    cosine, sine = math.cos(rest), math.sin(rest)
    match quarter & 3:
        case 0:
            return cosine, sine + 0.0
        case 1:
            return 0.0 - sine, cosine
        case 2:
            return -cosine, 0.0 - sine
        case _:
            return sine + 0.0, -cosine
