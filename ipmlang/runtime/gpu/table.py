"""What a program draws, left on the graphics card: pictures are made of that without a copy.

In go a bound program and a seed, out comes the table of terminals where the machine wrote it, with
what is needed to read it there, and beside it a scene of what the CPU drew; or nothing, where that
is not all that a picture needs. Rows stand in no order. Nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import drawings
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.fields import fields
from ipmlang.runtime.gpu import encode
from ipmlang.runtime.gpu.derive import GpuFrontier
from ipmlang.runtime.gpu.device import Device, device, is_of_card
from ipmlang.runtime.gpu.isa import TERMINAL
from ipmlang.runtime.gpu.machine import Made, TroubleError
from ipmlang.runtime.gpu.memory import Rows
from ipmlang.runtime.gpu.words import Calls
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.laying import FIELD as UV
from ipmlang.runtime.scopes.reports import unfit_notes
from ipmlang.runtime.strings import steps_of
from ipmlang.runtime.values import Bound

_ELSEWHERE = frozenset({JOIN, UV, "texture"})  # -1 in what no picture needs more for


@dataclass(slots=True, eq=False)
class Table:
    """Terminals on a card, in parts that each lie in one buffer, and what else there is: `rest`,
    which the CPU drew. `fields` are the numbers of the state, in the order in which a row has them;
    colours and the like are numbers of texts of the program. Several may hold the same rows, each
    by a table of its own; the memory goes back with the last.
    """

    card: Device
    program: ir.Program
    fields: tuple[str, ...]
    parts: tuple[Rows, ...]
    generations: int
    shapes: int
    rest: Scene | None
    notes: tuple[str, ...]
    backend: str
    _holders: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self._holders.add(id(self))

    def __len__(self) -> int:
        return sum(part.count for part in self.parts)

    def word(self, name: str) -> int | None:
        """The first of the two words of a row that hold a field, None where no row has it."""
        return TERMINAL + 6 + 2 * self.fields.index(name) if name in self.fields else None

    def lend(self) -> Table:
        """The same rows for somebody else, who releases them when it likes."""
        return replace(self)

    def release(self) -> None:
        """Give the memory back, once nobody else holds it; a second time does nothing."""
        if id(self) not in self._holders:
            return
        self._holders.remove(id(self))
        if not self._holders:
            for part in self.parts:
                part.storage.release()


def derive_table(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Table | None:
    """The table of a program in space whose terminals on the card are segments, boxes, rectangles
    and assets; None for any other, where nothing of it runs there, and where something is wrong
    that `derive_gpu` tells better.

    Raises IpmError where there is no card or it fails.
    """
    initial = fields(program)
    calls = encode.calls_of(program)
    if program.flat or program.residual is not None:
        return None
    if encode.refused(program):
        return None
    bound = Bound(program, attrs, FUNCTIONS)
    frontier = TableFrontier(calls, bound, initial, limits, steps_of(bound, seed))
    enough = False
    try:
        with np.errstate(all="ignore"):
            frontier.run(seed)
        enough = frontier.ran and not _needs_more(frontier)
    except IpmError as error:
        if is_of_card(error):
            raise
        return None  # who derives all of it knows the way to where it went wrong
    except TroubleError:  # all of it is the CPU's
        return None
    finally:
        parts = frontier.parts(keep=enough)
    if not enough:
        return None
    drawn = None if not frontier.drawings else _drawn_elsewhere(frontier, seed)
    shapes = frontier.shapes + frontier.drawings + sum(rows.count for rows in parts)
    notes = frontier.notes + frontier.snap_notes() + unfit_notes(program, frontier.reports)
    return Table(
        device(), program, tuple(initial), parts, frontier.generations, shapes, drawn, notes,
        "gpu+cpu" if frontier.shared else "gpu",
    )  # fmt: skip


def _needs_more(frontier: TableFrontier) -> bool:
    """Whether some terminal on the card is made what it is later: joined with others, textured."""
    words = [
        TERMINAL + 6 + 2 * place for place, name in enumerate(frontier.fields) if name in _ELSEWHERE
    ]
    tables = [rows for rows in frontier.tables if rows.count]
    return any((rows.numbers(word) >= 0).any() for rows in tables for word in words)


def _drawn_elsewhere(frontier: TableFrontier, seed: int) -> Scene:
    """The scene of what the CPU drew, in no order."""
    program = frontier.program
    rows = drawings.rows(
        program, frontier.chunks, np.arange(frontier.drawings, dtype=np.int32), fields(program),
        frontier.grouping, frontier.laying, frontier.joining, frontier.pool,
    )  # fmt: skip
    made = scene(
        program, rows, frontier.polygons,
        seed=seed, generations=frontier.generations, shapes=frontier.shapes,
    )  # fmt: skip
    made.solids = frontier.pool.solids()
    return made


class TableFrontier(GpuFrontier):
    """A frontier that leaves what the card draws where it is."""

    ordered = False

    def __init__(self, calls: Calls, *args: object) -> None:
        super().__init__(calls, *args)
        self.tables: list[Rows] = []

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
