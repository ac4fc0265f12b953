"""The styles and sources of rows that share one base style, each distinct one made once.

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


def row_styles(scene: Scene, rows: NDArray[np.intp], base: Style, effects: Effects) -> list[Style]:
    """The style of each row; `effects` names what each group is wrapped in, outermost first."""
    table = scene.instances
    columns = np.stack(
        [
            table.style[rows].astype(np.int64),
            table.color[rows].astype(np.int64),
            table.width[rows].view(np.int32).astype(np.int64),
            np.full(len(rows), -1) if scene.groups is None else scene.groups.of[rows],
        ],
        axis=1,
    )
    if len(rows) and (columns == columns[0]).all():
        distinct, number = columns[:1], np.zeros(len(rows), np.intp)
    else:
        distinct, number = np.unique(columns, axis=0, return_inverse=True)
    made = [_style(scene, each, base, effects) for each in distinct.tolist()]
    return [made[index] for index in number.reshape(-1).tolist()]


def row_sources(scene: Scene, rows: NDArray[np.intp]) -> list[tuple[str, ...]]:
    """The label of each row, as hints for names."""
    labels = scene.labels
    return [(labels[index],) for index in scene.instances.label[rows].tolist()]


def _style(scene: Scene, columns: Sequence[int], base: Style, effects: Effects) -> Style:
    number, color, bits, group = columns
    pen = scene.styles[number]
    width = float(str(np.array(bits, np.int32).view(np.float32)))  # the shortest such decimal
    style = penned(base, color, width, pen.css)
    outer = effects[group] if group >= 0 else ()
    return dataclasses.replace(style, effects=outer + style.effects) if outer else style
