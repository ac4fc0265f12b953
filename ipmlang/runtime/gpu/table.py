"""What a program draws, left on the graphics card: pictures are made of that without a copy.

In go a bound program and a seed, out comes the table of terminals where the machine wrote it, with
what is needed to read it there; or nothing, where the CPU has a part in the derivation or in what
its terminals look like. Rows stand in no order. Nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime.fields import fields
from ipmlang.runtime.gpu import encode
from ipmlang.runtime.gpu.derive import GpuFrontier
from ipmlang.runtime.gpu.device import Device, device
from ipmlang.runtime.gpu.explain import reasons
from ipmlang.runtime.gpu.isa import TERMINAL
from ipmlang.runtime.gpu.machine import Made, TroubleError
from ipmlang.runtime.gpu.memory import Rows
from ipmlang.runtime.gpu.words import Calls
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.laying import FIELD as UV
from ipmlang.runtime.scopes.reports import unfit_notes
from ipmlang.runtime.strings import steps_of
from ipmlang.runtime.values import Bound

_ELSEWHERE = frozenset({JOIN, UV, "texture"})  # fields whose terminals are made what they are later


class ElsewhereError(Exception):
    """The CPU has a part in this derivation."""


@dataclass(slots=True, eq=False)
class Table:
    """Terminals on a card, in parts that each lie in one buffer. `fields` are the numbers of the
    state, in the order in which a row has them; colours and the like are numbers of texts of the
    program.
    """

    card: Device
    program: ir.Program
    fields: tuple[str, ...]
    parts: tuple[Rows, ...]
    generations: int
    shapes: int
    notes: tuple[str, ...] = ()
    backend: str = "gpu"

    def __len__(self) -> int:
        return sum(part.count for part in self.parts)

    def word(self, name: str) -> int | None:
        """The first of the two words of a row that hold a field, None where no row has it."""
        return TERMINAL + 6 + 2 * self.fields.index(name) if name in self.fields else None

    def release(self) -> None:
        """Give the memory back."""
        for part in self.parts:
            part.storage.release()


def derive_table(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Table | None:
    """The table of a program that the card alone derives and whose terminals are segments, boxes,
    rectangles and assets in space; None for any other.

    Raises IpmError where a limit is reached, and where there is no card or it fails.
    """
    initial = fields(program)
    calls = encode.calls_of(program)
    if program.flat or program.residual is not None or _ELSEWHERE & initial.keys():
        return None
    if encode.refused(program) or (calls == "threads" and reasons(program)):
        return None
    bound = Bound(program, attrs, FUNCTIONS)
    frontier = TableFrontier(calls, bound, initial, limits, steps_of(bound, seed))
    whole = False
    try:
        with np.errstate(all="ignore"):
            frontier.run(seed)
        whole = not frontier.shared and not frontier.drawings and frontier.ran
    except (ElsewhereError, TroubleError):
        return None
    finally:
        parts = frontier.parts(keep=whole)
    if not whole:
        return None
    shapes = frontier.shapes + sum(rows.count for rows in parts)
    notes = frontier.notes + unfit_notes(program, frontier.reports)
    return Table(device(), program, tuple(initial), parts, frontier.generations, shapes, notes)


class TableFrontier(GpuFrontier):
    """A frontier that leaves what the card draws where it is, and gives up where the CPU is needed:
    ElsewhereError.
    """

    ordered = False

    def __init__(self, calls: Calls, *args: object) -> None:
        super().__init__(calls, *args)
        self.tables: list[Rows] = []

    def advance(self) -> None:
        """Derive all that waits on the card."""
        if self.drawings or self.pending.has(self._left.__contains__):
            raise ElsewhereError
        super().advance()
        if self.shared:
            raise ElsewhereError

    def parts(self, *, keep: bool) -> tuple[Rows, ...]:
        """The tables that have rows, if they are kept; all others go back to the card."""
        kept = tuple(rows for rows in self.tables if keep and rows.count)
        for rows in self.tables:
            if rows not in kept:
                rows.storage.release()
        return kept

    def _take(self, made: Made, numbers: NDArray[np.int32]) -> None:
        self.tables += made.terminals
        try:
            self.generations = max(self.generations, made.generations)
            self.counted.make(made.shapes - sum(rows.count for rows in made.returned))
            self.counted.draw(sum(rows.count for rows in made.terminals))
            self._note(made.notes[: len(self.program.productions) + 1])
            for rows in made.returned:
                self._back(rows, np.zeros(rows.count, np.int64))
        finally:
            for rows in made.returned:
                rows.storage.release()
