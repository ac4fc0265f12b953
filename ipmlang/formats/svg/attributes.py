"""What the tag of one drawn element says beside its path: the attributes of its style.

Takes a style and where it is written; gives names and values in a fixed order, for all that differs
from SVG's initial values. A style may be written in a space of its own, which the tag's transform
leads back from. Never looks at groups.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np

from ipmlang.formats.drawing import ARC, Outline, Paint, Style
from ipmlang.formats.numbers import decimal_text
from ipmlang.formats.svg.definitions import Definitions, matrix_text
from ipmlang.formats.svg.transforms import IDENTITY, Matrix, inverse, is_usable, multiply

Linear = tuple[float, float, float, float]

# Properties that SVG knows only in style sheets, not as attributes.
_CSS_ONLY = frozenset({"mix-blend-mode", "isolation", "transform-box", "white-space"})


def style_attributes(style: Style, definitions: Definitions) -> list[tuple[str, str]]:
    """Names and values, these as they stand in XML."""
    back: Matrix = IDENTITY
    parts: list[tuple[str, str]] = []
    if style.stroke_matrix is not None:
        space: Matrix = (*style.stroke_matrix, 0.0, 0.0)
        if is_usable(space):
            back = inverse(space)
            parts.append(("transform", matrix_text(space)))
    if style.fill != "#000000":
        parts.append(("fill", _paint_text(style.fill, back, definitions)))
    if style.stroke != "none":
        parts.append(("stroke", _paint_text(style.stroke, back, definitions)))
    if style.stroke_width != 1.0:
        parts.append(("stroke-width", decimal_text(style.stroke_width, 12)))
    if style.dashes:
        dashes = ",".join(decimal_text(dash, 12) for dash in style.dashes)
        parts.append(("stroke-dasharray", dashes))
    if style.dash_offset:
        parts.append(("stroke-dashoffset", decimal_text(style.dash_offset, 12)))
    parts += [(name, escape(value)) for name, value in style.more if name not in _CSS_ONLY]
    declared = ";".join(f"{name}:{value}" for name, value in style.more if name in _CSS_ONLY)
    return [*parts, ("style", escape(declared))] if declared else parts


def attributes_text(pairs: Iterable[tuple[str, str]]) -> str:
    """The attributes as they stand in a tag, a blank before each."""
    return "".join(f' {name}="{value}"' for name, value in pairs)


def in_space(outline: Outline, linear: Linear) -> Outline:
    """The outline in a space whose map to the drawing's is `linear`: where a slanted pen is round,
    or where numbers are short. The outline itself where there is no way back.
    """
    space = (*linear, 0.0, 0.0)
    if not is_usable(space):
        return outline
    back = inverse(space)
    coords = outline.coords.copy()
    turned = np.array([[back[0], back[1]], [back[2], back[3]]])
    coords[:, :3] = coords[:, :3] @ turned
    others = outline.kind != ARC
    coords[others, 3] = coords[others, 3] @ turned
    return Outline(outline.kind, coords, outline.starts, outline.closed)


def _paint_text(paint: Paint, back: Matrix, definitions: Definitions) -> str:
    if isinstance(paint, str):
        return escape(paint)
    matrix = paint.matrix if back == IDENTITY else multiply(back, paint.matrix)
    return definitions.paint(paint, matrix)
