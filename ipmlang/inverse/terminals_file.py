"""The parts file of a drawing: its terminals by their names, as short as exactness allows.

Takes terminals with where each lies about its origin, effects and tables; gives the text. A point
may be off by a share of the diagonal wherever the terminal is drawn, at its largest too. Never
decides what becomes a terminal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ipmlang.formats.drawing import Effect
from ipmlang.formats.svg.parts import write_parts
from ipmlang.inverse.lsystem.frames import Frames
from ipmlang.inverse.terminals import Instanced, Terminal, asset_elements, asset_space

SHARE = 1e-8  # of the diagonal: what a point of a terminal may be off

Shown = Mapping[str, tuple[int, Frames | None]]
"""Terminals by their names: their numbers, and where each lies about its origin."""


def terminals_file(
    instanced: Instanced,
    diagonal: float,
    shown: Shown,
    effects: Mapping[str, tuple[str | None, Effect]],
    tables: Sequence[str],
) -> str:
    """The text of the file with what is shown; diagonal: of the drawing, units."""
    largest = _largest_scales(instanced)
    known: dict[str, tuple[Terminal, Frames | None]] = {
        name: (instanced.terminals[number], place) for name, (number, place) in shown.items()
    }
    spaces = {name: asset_space(*each) for name, each in known.items()}
    elements = asset_elements(list(known.values()))
    return write_parts(
        {name: [each] for name, each in zip(known, elements, strict=True)},
        effects=effects,
        tables=tables,
        allowed={
            name: SHARE * diagonal * _size(place) / largest[number]
            for name, (number, place) in shown.items()
        },
        spaces={name: space for name, space in spaces.items() if space is not None},
    )


def _largest_scales(instanced: Instanced) -> list[float]:
    """How much larger than its asset each terminal is drawn at most, at least 1."""
    found = np.ones(len(instanced.terminals))
    seen = instanced.seen
    rows = np.flatnonzero(seen.terminal < len(found))  # the rest are effects
    np.maximum.at(found, seen.terminal[rows], np.abs(seen.arm[rows, 0]))
    return list(found.tolist())


def _size(place: Frames | None) -> float:
    return 1.0 if place is None else float(place.scale[0])
