"""Basic shapes as outlines in their own space: paths, lines, polygons, rects, ellipses.

Start points and directions are those of SVG's equivalent paths. A shape whose size is not above
zero, or that has no points, is no outline; numbers that cannot be read are noted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from ipmlang.formats.drawing import Outline
from ipmlang.formats.svg.limits import Notes
from ipmlang.formats.svg.paths import Pen, parse_path
from ipmlang.formats.svg.properties import GEOMETRY
from ipmlang.formats.svg.units import diagonal, length, numbers
from ipmlang.formats.svg.xml import Node

_ACROSS = frozenset({"x", "cx", "rx", "x1", "x2", "width"})
_DOWN = frozenset({"y", "cy", "ry", "y1", "y2", "height"})
_FULL_TURN = 4


class Measures:
    """The geometry attributes of one node, read in its viewport; style sheets come first."""

    def __init__(
        self,
        node: Node,
        own: Mapping[str, str],
        viewport: tuple[float, float],
        font_size: float,
        notes: Notes,
    ) -> None:
        self._node = node
        self._own = own
        self._viewport = viewport
        self._font_size = font_size
        self._notes = notes

    def text(self, name: str) -> str | None:
        """The attribute as text."""
        if name in GEOMETRY and name in self._own:
            return self._own[name]
        return self._node.attributes.get(name)

    def maybe(self, name: str) -> float | None:
        """A length, or None where it is absent, `auto` or cannot be read (which is noted)."""
        text = self.text(name)
        if text is None or text == "auto":
            return None
        width, height = self._viewport
        if name in _ACROSS:
            whole = width
        elif name in _DOWN:
            whole = height
        else:
            whole = diagonal(self._viewport)
        value = length(text, whole, self._font_size)
        if value is None and text.strip():
            message = f'{name}="{text[:40]}" is no length'
            self._notes.add("bad-number", message, self._node.line)
        return value

    def __getitem__(self, name: str) -> float:
        return self.maybe(name) or 0.0


def outline_of(node: Node, measures: Measures, notes: Notes) -> Outline | None:
    """The outline of a shape element, None if it draws nothing."""
    return SHAPES[node.name](node, measures, notes)


def _path(node: Node, measures: Measures, notes: Notes) -> Outline | None:
    text = measures.text("d") or ""
    if text.startswith("path("):
        text = text[5:].rstrip(") ").strip("\"' ")
    data = parse_path("" if text.strip() == "none" else text)
    if not data.whole:
        notes.add("path-data", "path data is wrong: kept up to the error", node.line)
    return data.outline


def _line(_: Node, measures: Measures, __: Notes) -> Outline | None:
    pen = Pen()
    pen.move(measures["x1"], measures["y1"])
    pen.line(measures["x2"], measures["y2"])
    return pen.outline()


def _polyline(node: Node, _: Measures, notes: Notes) -> Outline | None:
    return _through_points(node, notes).outline()


def _polygon(node: Node, _: Measures, notes: Notes) -> Outline | None:
    pen = _through_points(node, notes)
    if pen.starts:
        pen.close()
    return pen.outline()


def _through_points(node: Node, notes: Notes) -> Pen:
    values, whole = numbers(node.attributes.get("points") or "")
    if not whole or len(values) % 2:
        notes.add("points", "a list of points is wrong: kept up to the error", node.line)
    pen = Pen()
    for i in range(0, len(values) - 1, 2):
        (pen.line if i else pen.move)(values[i], values[i + 1])
    return pen


def _circle(node: Node, measures: Measures, notes: Notes) -> Outline | None:
    radius = _size(node, measures, "r", notes)
    return _whole_ellipse(measures["cx"], measures["cy"], radius, radius)


def _ellipse(node: Node, measures: Measures, notes: Notes) -> Outline | None:
    rx, ry = measures.maybe("rx"), measures.maybe("ry")
    rx, ry = (ry if rx is None else rx), (rx if ry is None else ry)
    return _whole_ellipse(measures["cx"], measures["cy"], rx or 0.0, ry or 0.0)


def _whole_ellipse(cx: float, cy: float, rx: float, ry: float) -> Outline | None:
    if not (rx > 0 and ry > 0):
        return None
    pen = Pen()
    pen.move(cx + rx, cy)
    for quarter in range(_FULL_TURN):
        pen.ellipse_part(cx, cy, rx, ry, quarter * math.pi / 2)
    pen.closed[-1] = True
    return pen.outline()


def _rect(node: Node, measures: Measures, notes: Notes) -> Outline | None:
    width = _size(node, measures, "width", notes)
    height = _size(node, measures, "height", notes)
    if not (width > 0 and height > 0):
        return None
    x, y = measures["x"], measures["y"]
    rx, ry = _corner_radii(measures, width, height)
    pen = Pen()
    if rx > 0 and ry > 0:
        _round_rect(pen, x, y, width, height, rx, ry)
    else:
        pen.move(x, y)
        pen.line(x + width, y)
        pen.line(x + width, y + height)
        pen.line(x, y + height)
        pen.line(x, y)
    pen.closed[-1] = True
    return pen.outline()


def _size(node: Node, measures: Measures, name: str, notes: Notes) -> float:
    value = measures[name]
    if value < 0:
        notes.add("negative-size", f"{name} is below zero: the shape is left out", node.line)
    return value


def _corner_radii(measures: Measures, width: float, height: float) -> tuple[float, float]:
    rx, ry = measures.maybe("rx"), measures.maybe("ry")
    rx, ry = (ry if rx is None else rx) or 0.0, (rx if ry is None else ry) or 0.0
    return min(max(rx, 0.0), width / 2), min(max(ry, 0.0), height / 2)


def _round_rect(
    pen: Pen, x: float, y: float, width: float, height: float, rx: float, ry: float
) -> None:
    """Clockwise on the page from the end of the upper left corner; no sides of length zero."""
    right, bottom = x + width, y + height
    corners = (
        (x + rx, y, right - rx, y, right - rx, y + ry),
        (right, y + ry, right, bottom - ry, right - rx, bottom - ry),
        (right - rx, bottom, x + rx, bottom, x + rx, bottom - ry),
        (x, bottom - ry, x, y + ry, x + rx, y + ry),
    )
    pen.move(x + rx, y)
    for quarter, (x0, y0, x1, y1, cx, cy) in enumerate(corners):
        pen.x, pen.y = x0, y0
        if (2 * rx if quarter % 2 == 0 else 2 * ry) < (width if quarter % 2 == 0 else height):
            pen.line(x1, y1)
        pen.ellipse_part(cx, cy, rx, ry, (quarter - 1) * math.pi / 2)


SHAPES: Mapping[str, Callable[[Node, Measures, Notes], Outline | None]] = {
    "path": _path,
    "rect": _rect,
    "circle": _circle,
    "ellipse": _ellipse,
    "line": _line,
    "polyline": _polyline,
    "polygon": _polygon,
}
"""Every element that is drawn as an outline."""
