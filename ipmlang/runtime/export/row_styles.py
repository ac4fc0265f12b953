"""The styles and sources of the rows of a scene, each distinct one made once.

In go rows of an instance table and the style of what they draw, out come one style and one source a
row. Equal rows share one object. No geometry here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import Style
from ipmlang.runtime.export.pens import penned
from ipmlang.runtime.scene import Scene

Effects = Sequence[tuple[str, ...]]


class RowStyles:
    """The styles of a scene's rows; `effects` names what each group is wrapped in, outermost
    first.
    """

    def __init__(self, scene: Scene, effects: Effects) -> None:
        table = scene.instances
        groups = np.full(len(table), -1) if scene.groups is None else scene.groups.of
        columns = (table.style, table.color, table.width.view(np.int32), groups)
        self._scene = scene
        self._effects = effects
        self._looks, self._look_of = _distinct([each.astype(np.int64) for each in columns])
        self._sources = [(label,) for label in scene.labels]
        self._made: dict[Style, dict[int, Style]] = {}

    def of(self, rows: NDArray[np.intp], base: Style) -> list[Style]:
        """The style of each of some rows that draw what has a style of its own."""
        looks = self._look_of[rows].tolist()
        made = self._made.setdefault(base, {})
        for look in set(looks) - made.keys():
            made[look] = _style(self._scene, self._looks[look], base, self._effects)
        return [made[look] for look in looks]

    def sources(self, rows: NDArray[np.intp]) -> list[tuple[str, ...]]:
        """The label of each row, as hints for names."""
        return [self._sources[label] for label in self._scene.instances.label[rows].tolist()]


def _distinct(
    columns: Sequence[NDArray[np.int64]],
) -> tuple[list[tuple[int, ...]], NDArray[np.int64]]:
    """The distinct rows of columns (n,), and (n,) which of them each row is."""
    number = np.zeros(len(columns[0]), np.int64)
    for column in columns:
        if len(column) and (column != column[0]).any():
            values, which = np.unique(column, return_inverse=True)
            number = np.unique(number * len(values) + which, return_inverse=True)[1]
    first = np.unique(number, return_index=True)[1]
    rows = np.stack([column[first] for column in columns], axis=1).tolist()
    return [tuple(row) for row in rows], number


def _style(scene: Scene, columns: Sequence[int], base: Style, effects: Effects) -> Style:
    number, color, bits, group = columns
    pen = scene.styles[number]
    width = float(str(np.array(bits, np.int32).view(np.float32)))  # the shortest such decimal
    style = penned(base, color, width, pen.css)
    outer = effects[group] if group >= 0 else ()
    return dataclasses.replace(style, effects=outer + style.effects) if outer else style
