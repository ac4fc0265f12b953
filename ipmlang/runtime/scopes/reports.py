"""What a derivation tells besides what it draws: sums of reports, and notes on what is missing.

In go numbers as they are met, out come sums by key, and sentences about parts that had no room and
symbols that had nothing to draw. Nothing is computed of shapes here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime.queries.marks import asked

Floats = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Reports:
    """What was reported by key; how many parts of splits did not fit, by production; how many
    terminals had nothing to draw, by symbol, and which symbols had something.
    """

    values: dict[str, list[Floats]] = field(default_factory=dict)
    unfit: dict[int, int] = field(default_factory=dict)
    blank: dict[int, int] = field(default_factory=dict)
    drawn: set[int] = field(default_factory=set)

    def sums(self) -> dict[str, tuple[float, int]]:
        """The sum of each key, in whatever order it was reported, and how many did."""
        return {
            key: (math.fsum(chain(*parts)), sum(map(len, parts)))
            for key, parts in sorted(self.values.items())
        }


def unfit_notes(program: ir.Program, reports: Reports) -> tuple[str, ...]:
    """A note for each rule whose splits left parts out: of no size, or without room."""
    notes = []
    for rule, many in sorted(reports.unfit.items()):
        if not many:
            continue
        production = program.axiom if rule < 0 else program.productions[rule]
        name = "start" if production.symbol < 0 else program.symbols[production.symbol].name
        what = "1 part of a split was" if many == 1 else f"{many:,} parts of splits were"
        where = f" ({production.path}:{production.line})" if production.line else ""
        notes.append(
            f"rule {name}{where}: {what} not made, since no room was left or its size is 0"
        )
    return (*notes, *_blank_notes(program, reports))


def _blank_notes(program: ir.Program, reports: Reports) -> Iterator[str]:
    """A note for each symbol that has nothing to draw anywhere; where queries ask, it may stand for
    a place.
    """
    if asked(program) is not None:
        return
    for symbol, many in sorted(reports.blank.items()):
        if symbol not in reports.drawn:
            shapes = "its one shape has" if many == 1 else f"its {many:,} shapes have"
            yield (
                f"{program.symbols[symbol].name} draws nothing: {shapes} no geometry, as points "
                "have none; insert an asset, or give a size and a geometry: size(1, 1, 1) cube"
            )
