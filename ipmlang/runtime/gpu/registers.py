"""The registers of one body: which are free, what instructions call them, and who reads them last.

In go elements of a body, out come numbers of registers. No instruction is written here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from ipmlang.compiler import ir
from ipmlang.runtime.gpu.isa import REGISTERS
from ipmlang.runtime.gpu.unsupported import UnsupportedError
from ipmlang.runtime.queries.questions import read_inside


class Room:
    """The registers of one body: those that are free, and the most that were in use."""

    def __init__(self, fields: Sequence[str], parameters: int, reserved: int = 0) -> None:
        self.fields = tuple(fields)
        self._first = len(fields)
        self._parameters = parameters
        self._next = self._first + parameters + reserved
        self._free: list[int] = []
        self.most = self._next

    def own(self) -> tuple[int, ...]:
        """The registers of the shape's parameters."""
        return tuple(range(self._first, self._first + self._parameters))

    def new(self) -> int:
        """A free register."""
        if self._free:
            return self._free.pop()
        if self._next >= REGISTERS:
            raise UnsupportedError("registers", f"its body holds more than {REGISTERS} numbers")
        self._next += 1
        self.most = max(self.most, self._next)
        return self._next - 1

    def free(self, registers: Iterable[int]) -> None:
        """Registers that nothing reads any more."""
        self._free += registers


@dataclass(slots=True)
class Names:
    """What instructions call things: the shape's parameters, registers of the IR, the numbers of
    the copies around, outermost first, and of how many each is one; `shown` is the register that
    says whether anything is made (None: it is).
    """

    params: tuple[int, ...]
    registers: dict[int, int] = field(default_factory=dict)
    copies: tuple[tuple[int, int], ...] = ()
    many: dict[int, int] = field(default_factory=dict)
    shown: int | None = None
    known: dict[int, float] = field(default_factory=dict)
    given: Mapping[int, float] = field(default_factory=dict)


def inside(elements: Sequence[ir.Instruction], begin: int) -> Sequence[ir.Instruction]:
    """The elements between a bracket and its end."""
    depth = 0
    for number in range(begin, len(elements)):
        depth += (elements[number].op == "open") - (elements[number].op == "close")
        if depth == 0:
            return elements[begin + 1 : number]
    return elements[begin + 1 :]


def last_uses(elements: Sequence[ir.Instruction]) -> dict[int, int]:
    """The last element that reads each register, in itself or in what it holds."""
    last: dict[int, int] = {}
    for number, each in enumerate(elements):
        for register in (*each.args, *read_inside(each.body)):
            last[register] = number
    return last


def ending(body: Sequence[ir.Instruction], closed: bool) -> ir.Instruction | None:
    """The child that a body ends with, if it does; `closed`: brackets may end after it."""
    for each in reversed(body):
        if each.op == "module":
            return each
        if not (closed and each.op == "close"):
            return None
    return None
