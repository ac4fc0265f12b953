"""What generated bodies call things: the names of one batch, and what all bodies of a run share.

Names are texts of Python source. Nothing is written or run here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ipmlang.compiler import ir
from ipmlang.runtime.algebra import Operand
from ipmlang.runtime.code import Data

_LENGTH = "length"
OWN = -1  # the site of what is drawn under the shape's own key


@dataclass(frozen=True, slots=True)
class Scope:
    """The names of one batch: its row count, keys, parameters, the numbers of copies around it, the
    registers, the rows that draw (None: all; what it names may be None, too), how many pieces there
    are of each operation around it, and for copies the rows around that they belong to.
    """

    count: str
    k0: str
    k1: str
    params: tuple[Operand, ...]
    registers: dict[int, Operand]
    copies: tuple[tuple[int, str], ...] = ()
    shown: str | None = None
    many: Mapping[int, str] = field(default_factory=dict)
    owners: tuple[str, ...] = ()

    @property
    def around(self) -> str:
        """The rows that the copies belong to, from the innermost ones outward, as one argument."""
        return f"({', '.join(self.owners)},)" if self.owners else "()"

    @property
    def numbers(self) -> str:
        """The copies' numbers, as arguments."""
        return "".join(f", {name}" for _, name in self.copies)

    @property
    def tuple(self) -> str:
        """The copies' numbers, as one argument."""
        return f"({self.numbers[2:]},)" if self.copies else "()"


@dataclass(frozen=True, slots=True)
class Setting:
    """What all bodies of a run share: the program, its fields, the values of its attributes, and
    what code reads besides its registers.
    """

    program: ir.Program
    fields: tuple[str, ...]
    attrs: tuple[float, ...]
    data: Data


def length_name(place: int) -> str:
    """What source calls one of the numbers of a body that have names."""
    return f"{_LENGTH}{place}"


def is_named_length(operand: Operand) -> bool:
    """Whether an operand is such a number: the same for all shapes."""
    return isinstance(operand, str) and operand.startswith(_LENGTH)
