"""Path data as text in, an outline in the path's own space out.

Everything up to the first error is kept, as SVG says. Relative commands add up in f64 from the
current point, which closing a subpath sets back to its start exactly. Arcs stay arcs: endpoints
become a centre with two radii vectors, radii that are too small are scaled up.
"""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from operator import add

import numpy as np

from ipmlang.formats.drawing import ARC, CUBIC, LINE, QUADRATIC, Outline
from ipmlang.formats.svg.units import NUMBER

_SPACE = r"[ \t\r\n\f]*+"
_READABLE = re.compile(
    rf"{_SPACE}[MmZzLlHhVvCcSsQqTtAa]{_SPACE}(?:{NUMBER}{_SPACE},?+{_SPACE})*", re.ASCII
)
_COMMANDS = re.compile(r"([MmZzLlHhVvCcSsQqTtAa])([^MmZzLlHhVvCcSsQqTtAa]*+)")
_NUMBERS = re.compile(NUMBER, re.ASCII)
_SEPARATOR = rf"{_SPACE},?+{_SPACE}"
_ARC = re.compile(
    _SPACE
    + _SEPARATOR.join([rf"({NUMBER})"] * 3 + ["([01])"] * 2 + [rf"({NUMBER})"] * 2)
    + _SEPARATOR,
    re.ASCII,
)
_TAKES = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}
_MANY = 4
"""So many segments of one kind are drawn at once."""
_STORED = 8
"""Numbers of a segment."""
_SAME_PLACE = 1e-11
"""A subpath whose end is this near to its start (relative to the coordinates) has come back."""


class Pen:
    """Collects segments; knows the current point (x, y) and where the subpath began."""

    __slots__ = ("closed", "kinds", "left", "numbers", "starts", "top", "x", "y")

    def __init__(self) -> None:
        self.kinds = bytearray()
        self.numbers = array("d")
        self.starts: list[int] = []
        self.closed: list[bool] = []
        self.x = self.y = self.left = self.top = 0.0

    def move(self, x: float, y: float) -> None:
        """Begin a subpath; it counts once it has a segment."""
        self.left = self.x = x
        self.top = self.y = y
        self._lift()

    def _lift(self) -> None:
        if not self.starts or self.starts[-1] != len(self.kinds):
            self.starts.append(len(self.kinds))
            self.closed.append(False)

    def line(self, x: float, y: float) -> None:
        """A straight segment to (x, y)."""
        self.kinds.append(LINE)
        self.numbers.extend((self.x, self.y, x, y, 0.0, 0.0, 0.0, 0.0))
        self.x, self.y = x, y

    def quadratic(self, x1: float, y1: float, x: float, y: float) -> None:
        """A parabola with one control point to (x, y)."""
        self.kinds.append(QUADRATIC)
        self.numbers.extend((self.x, self.y, x1, y1, x, y, 0.0, 0.0))
        self.x, self.y = x, y

    def cubic(self, x1: float, y1: float, x2: float, y2: float, x: float, y: float) -> None:
        """A cubic with two control points to (x, y)."""
        self.kinds.append(CUBIC)
        self.numbers.extend((self.x, self.y, x1, y1, x2, y2, x, y))
        self.x, self.y = x, y

    def run(self, kind: int, values: Sequence[float], relative: bool) -> None:
        """Lines or curves one after the other, through as many points each as their kind takes."""
        size = 2 * kind
        segments = array("d", bytes(8 * _STORED * (len(values) // size)))
        last = []
        for axis, start in enumerate((self.x, self.y)):
            ends = values[size - 2 + axis :: size]
            places = list(accumulate(ends, initial=start)) if relative else [start, *ends]
            segments[axis::_STORED] = array("d", places[:-1])
            for column in range(axis, size - 2, 2):
                points: Iterable[float] = values[column::size]
                if relative:
                    points = map(add, places, points)
                segments[2 + column :: _STORED] = array("d", points)
            segments[size + axis :: _STORED] = array("d", places[1:])
            last.append(places[-1])
        self.kinds.extend(bytes([kind]) * (len(values) // size))
        self.numbers.extend(segments)
        self.x, self.y = last

    def arc(
        self, rx: float, ry: float, degrees: float, large: bool, sweep: bool, x: float, y: float
    ) -> None:
        """An elliptical arc to (x, y), as the implementation notes of SVG (9.5, B.2) say."""
        if x == self.x and y == self.y:
            return
        if rx == 0.0 or ry == 0.0 or not all(map(math.isfinite, (rx, ry, degrees, x, y))):
            self.line(x, y)
            return
        self.numbers.extend(arc_of(self.x, self.y, abs(rx), abs(ry), degrees, large, sweep, x, y))
        self.kinds.append(ARC)
        self.x, self.y = x, y

    def ellipse_part(self, cx: float, cy: float, rx: float, ry: float, start: float) -> None:
        """A quarter of an axis-parallel ellipse, from angle `start`, growing (radians)."""
        self.kinds.append(ARC)
        self.numbers.extend((cx, cy, rx, 0.0, 0.0, ry, start, math.pi / 2))

    def close(self) -> None:
        """Back to where the subpath began, by a line of its own unless it is there already."""
        size = abs(self.x) + abs(self.y) + abs(self.left) + abs(self.top)
        gap = abs(self.x - self.left) + abs(self.y - self.top)
        if gap > _SAME_PLACE * size or self.starts[-1] == len(self.kinds):
            self.line(self.left, self.top)
        self.closed[-1] = True
        self.x, self.y = self.left, self.top
        self._lift()

    def outline(self) -> Outline | None:
        """What was collected; None if that is nothing."""
        if not self.kinds:
            return None
        if self.starts[-1] == len(self.kinds):
            self.starts.pop()
            self.closed.pop()
        return Outline(
            np.frombuffer(bytes(self.kinds), dtype=np.uint8),
            np.frombuffer(self.numbers.tobytes(), dtype=np.float64).reshape(-1, 4, 2),
            np.array([*self.starts, len(self.kinds)], dtype=np.int32),
            np.array(self.closed, dtype=np.bool_),
        )


def arc_of(
    x0: float,
    y0: float,
    rx: float,
    ry: float,
    degrees: float,
    large: bool,
    sweep: bool,
    x: float,
    y: float,
) -> tuple[float, ...]:
    """(centre, u, v, start, sweep) of an SVG arc, eight floats; radii above 0."""
    tilt = math.radians(degrees % 360.0)
    c, s = math.cos(tilt), math.sin(tilt)
    half_x, half_y = (x0 - x) / 2, (y0 - y) / 2
    # In the space where the ellipse is the unit circle: half the chord, and its square.
    px, py = (c * half_x + s * half_y) / rx, (c * half_y - s * half_x) / ry
    square = px * px + py * py
    if square > 1.0:
        scale = math.sqrt(square)
        rx, ry, px, py, square = rx * scale, ry * scale, px / scale, py / scale, 1.0
    away = math.sqrt(max(0.0, (1.0 - square) / square)) if square > 0.0 else 0.0
    if large == sweep:
        away = -away
    qx, qy = away * py, -away * px
    start = math.atan2(py - qy, px - qx)
    turn = math.atan2(-py - qy, -px - qx) - start
    if sweep and turn <= 0.0:
        turn += math.tau
    elif not sweep and turn >= 0.0:
        turn -= math.tau
    ux, uy, vx, vy = rx * c, rx * s, -ry * s, ry * c
    mid_x, mid_y = (x0 + x) / 2, (y0 + y) / 2
    return (mid_x + ux * qx + vx * qy, mid_y + uy * qx + vy * qy, ux, uy, vx, vy, start, turn)


@dataclass(frozen=True, slots=True)
class PathData:
    """An outline, or None, and whether all of the text was understood."""

    outline: Outline | None
    whole: bool


def parse_path(text: str) -> PathData:
    """The outline that path data describes, up to its first error.

    >>> data = parse_path("M0,0 1 1 2-2.5.5e1-3")
    >>> data.whole, data.outline.coords[:, 1].tolist()
    (True, [[1.0, 1.0], [2.0, -2.5], [5.0, -3.0]])
    >>> parse_path("M 10 10 L 20 garbage C 1 2 3") == PathData(None, False)
    True
    """
    end = _readable(text)
    pen = Pen()
    whole = _draw(pen, _COMMANDS.findall(text[:end])) and end == len(text)
    return PathData(pen.outline(), whole)


def _readable(text: str) -> int:
    """How far a text is commands and numbers."""
    end = len(text) - len(text.lstrip(" \t\r\n\f"))
    while match := _READABLE.match(text, end):
        end = match.end()
    return end


def _draw(pen: Pen, commands: Sequence[tuple[str, str]]) -> bool:
    """Draw the commands in order; false where one is wrong, with all before it drawn."""
    if not commands:
        return True
    if commands[0][0] not in "Mm":
        return False
    before = ""
    for letter, text in commands:
        name = letter.upper()
        if name == "Z":
            pen.close()
            if text and not text.isspace():
                return False
        elif name == "A":
            if not _draw_arcs(pen, text, letter == "a"):
                return False
        else:
            values = _values(text)
            if len(values) == 2 and name == "L":  # By far the most common of long paths.
                x, y = values
                pen.line(*((x, y) if letter == name else (pen.x + x, pen.y + y)))
                before = name
                continue
            count = len(values) // _TAKES[name]
            if count:
                _DRAW[name](pen, values, count, letter != name, before)
            if not count or count * _TAKES[name] != len(values):
                return False
        before = name
    return True


def _values(text: str) -> list[float]:
    """The numbers of a text that is nothing but numbers and what may part them."""
    try:
        # What floats are once they are parted by blanks and signs is numbers for SVG too.
        return list(map(float, text.replace("-", " -").replace(",", " ").split()))
    except ValueError:  # such as `1.5.5` and `1e-5`
        return [float(word) for word in _NUMBERS.findall(text)]


def _draw_arcs(pen: Pen, text: str, relative: bool) -> bool:
    end = 0
    while match := _ARC.match(text, end):
        rx, ry, degrees, large, sweep, x, y = match.groups()
        ox, oy = (pen.x, pen.y) if relative else (0.0, 0.0)
        pen.arc(
            float(rx), float(ry), float(degrees), large == "1", sweep == "1",
            ox + float(x), oy + float(y),
        )  # fmt: skip
        end = match.end()
    return end > 0 and not text[end:].strip()


def _steps(values: list[float], size: int, count: int) -> Iterator[tuple[float, ...]]:
    """The arguments, one tuple for each repetition of the command."""
    return zip(*(values[i : count * size : size] for i in range(size)), strict=True)


def _moves(pen: Pen, values: list[float], count: int, relative: bool, before: str) -> None:
    x, y = values[:2]
    pen.move(*((pen.x + x, pen.y + y) if relative else (x, y)))
    if count > 1:
        _lines(pen, values[2:], count - 1, relative, before)


def _lines(pen: Pen, values: list[float], count: int, relative: bool, _: str) -> None:
    if count >= _MANY:
        pen.run(LINE, values[: 2 * count], relative)
        return
    line = pen.line
    if relative:
        for x, y in _steps(values, 2, count):
            line(pen.x + x, pen.y + y)
    else:
        for x, y in _steps(values, 2, count):
            line(x, y)


def _level(pen: Pen, values: list[float], count: int, relative: bool, _: str) -> None:
    for x in values[:count]:
        pen.line(pen.x + x if relative else x, pen.y)


def _upright(pen: Pen, values: list[float], count: int, relative: bool, _: str) -> None:
    for y in values[:count]:
        pen.line(pen.x, pen.y + y if relative else y)


def _cubics(pen: Pen, values: list[float], count: int, relative: bool, _: str) -> None:
    if count >= _MANY:
        pen.run(CUBIC, values[: 6 * count], relative)
        return
    for x1, y1, x2, y2, x, y in _steps(values, 6, count):
        ox, oy = (pen.x, pen.y) if relative else (0.0, 0.0)
        pen.cubic(ox + x1, oy + y1, ox + x2, oy + y2, ox + x, oy + y)


def _smooth_cubics(pen: Pen, values: list[float], count: int, relative: bool, before: str) -> None:
    follows = before in ("C", "S")
    for x2, y2, x, y in _steps(values, 4, count):
        ox, oy = (pen.x, pen.y) if relative else (0.0, 0.0)
        x1, y1 = _mirrored(pen, CUBIC) if follows else (pen.x, pen.y)
        pen.cubic(x1, y1, ox + x2, oy + y2, ox + x, oy + y)
        follows = True


def _quadratics(pen: Pen, values: list[float], count: int, relative: bool, _: str) -> None:
    if count >= _MANY:
        pen.run(QUADRATIC, values[: 4 * count], relative)
        return
    for x1, y1, x, y in _steps(values, 4, count):
        ox, oy = (pen.x, pen.y) if relative else (0.0, 0.0)
        pen.quadratic(ox + x1, oy + y1, ox + x, oy + y)


def _smooth_quadratics(
    pen: Pen, values: list[float], count: int, relative: bool, before: str
) -> None:
    follows = before in ("Q", "T")
    for x, y in _steps(values, 2, count):
        ox, oy = (pen.x, pen.y) if relative else (0.0, 0.0)
        x1, y1 = _mirrored(pen, QUADRATIC) if follows else (pen.x, pen.y)
        pen.quadratic(x1, y1, ox + x, oy + y)
        follows = True


def _mirrored(pen: Pen, kind: int) -> tuple[float, float]:
    """The last control point of the segment before, mirrored at the current point."""
    at = -4 if kind == CUBIC else -6
    return 2 * pen.x - pen.numbers[at], 2 * pen.y - pen.numbers[at + 1]


_DRAW = {
    "M": _moves,
    "L": _lines,
    "H": _level,
    "V": _upright,
    "C": _cubics,
    "S": _smooth_cubics,
    "Q": _quadratics,
    "T": _smooth_quadratics,
}
