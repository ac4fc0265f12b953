"""What a pen makes of a style: colour, width and declarations laid over what an asset has.

In goes a style of `formats.drawing` with what a row's pen sets, out comes the style to draw with.
A pen that sets nothing leaves the style as it is. No geometry here.
"""

from __future__ import annotations

import dataclasses

from ipmlang.formats.drawing import Paint, Style
from ipmlang.formats.svg.color import parse_color
from ipmlang.formats.svg.css import parse_declarations
from ipmlang.formats.svg.properties import INITIAL
from ipmlang.formats.svg.units import length, numbers
from ipmlang.runtime.export.colors import hex_color

_PAINTS = ("fill", "stroke")


def penned(style: Style, color: int, width: float, css: str) -> Style:
    """The style with a pen's colour (0: none), width (NaN: none) and declarations over it."""
    if color:
        style = _colored(style, color)
    if width == width:  # not NaN
        style = dataclasses.replace(style, stroke_width=width)
    return _declared(style, css) if css else style


def _colored(style: Style, color: int) -> Style:
    """A colour takes the place of each paint that there is."""
    paint, opacity = hex_color(color)
    changes: dict[str, Paint] = {name: paint for name in _PAINTS if getattr(style, name) != "none"}
    more = dict(style.more)
    for name in changes:
        _set(more, f"{name}-opacity", opacity)
    return _replaced(style, changes.get("fill", style.fill), changes.get("stroke"), more)


def _replaced(style: Style, fill: Paint, stroke: Paint | None, more: dict[str, str]) -> Style:
    return dataclasses.replace(
        style,
        fill=fill,
        stroke=style.stroke if stroke is None else stroke,
        more=tuple(sorted(more.items())),
    )


def _set(more: dict[str, str], name: str, opacity: float) -> None:
    if opacity < 1:
        more[name] = f"{opacity:.4g}"
    else:
        more.pop(name, None)


def _declared(style: Style, css: str) -> Style:
    """The style under SVG declarations; what cannot be read is left out, as in SVG."""
    fill, stroke = style.fill, style.stroke
    width, dashes, offset = style.stroke_width, style.dashes, style.dash_offset
    more = dict(style.more)
    for name, value, _ in parse_declarations(css):
        match name:
            case "fill":
                fill = _painted(fill, name, value, more)
            case "stroke":
                stroke = _painted(stroke, name, value, more)
            case "stroke-width":
                width = _length(value, width)
            case "stroke-dasharray":
                dashes = _dashes(value)
            case "stroke-dashoffset":
                offset = _length(value, offset)
            case _ if value == INITIAL.get(name):
                more.pop(name, None)
            case _:
                more[name] = value
    return dataclasses.replace(
        style,
        fill=fill,
        stroke=stroke,
        stroke_width=width,
        dashes=dashes,
        dash_offset=offset,
        more=tuple(sorted(more.items())),
    )


def _painted(before: Paint, name: str, value: str, more: dict[str, str]) -> Paint:
    if value == "none":
        return "none"
    found = parse_color(value)
    if found is None:
        return before
    if found[1] < 1:
        _set(more, f"{name}-opacity", found[1])
    return found[0]


def _length(value: str, before: float) -> float:
    found = length(value)
    return before if found is None else found


def _dashes(value: str) -> tuple[float, ...]:
    found, whole = numbers(value)
    if value == "none" or not whole or not any(found):
        return ()
    return tuple(found) * (2 if len(found) % 2 else 1)
