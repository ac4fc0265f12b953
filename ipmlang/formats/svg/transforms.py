"""Transform lists as text in, one affine matrix out; both the SVG attribute and the CSS property.

A matrix is (a, b, c, d, e, f): x' = a x + c y + e, y' = b x + d y + f. A list that cannot be read
is None, as SVG ignores it whole.
"""

from __future__ import annotations

import math
import re
from typing import TypeAlias

from ipmlang.formats.svg.units import NUMBER, UNITS

Matrix: TypeAlias = tuple[float, float, float, float, float, float]
Box: TypeAlias = tuple[float, float, float, float]

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
_CALL = re.compile(r"[\s,]*([a-zA-Z]+)\s*\(([^()]*)\)")
_ARGUMENT = re.compile(rf"\s*+,?+\s*+({NUMBER})(%|[a-zA-Z]*+)", re.ASCII)
_DEGREES = {"": 1.0, "deg": 1.0, "rad": 180 / math.pi, "grad": 0.9, "turn": 360.0}
_WORDS = {"left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%"}


def multiply(m: Matrix, n: Matrix) -> Matrix:
    """The map that applies `n` first, then `m`."""
    a, b, c, d, e, f = m
    p, q, r, s, t, u = n
    return (
        a * p + c * q,
        b * p + d * q,
        a * r + c * s,
        b * r + d * s,
        a * t + c * u + e,
        b * t + d * u + f,
    )


def translate(x: float, y: float) -> Matrix:
    """A shift by (x, y)."""
    return (1.0, 0.0, 0.0, 1.0, x, y)


def determinant(m: Matrix) -> float:
    """Signed area factor."""
    return m[0] * m[3] - m[1] * m[2]


def is_usable(m: Matrix) -> bool:
    """Whether the map is finite and does not flatten the plane (to rounding)."""
    size = m[0] * m[0] + m[1] * m[1] + m[2] * m[2] + m[3] * m[3]
    return (
        math.isfinite(size)
        and math.isfinite(m[4])
        and math.isfinite(m[5])
        and abs(determinant(m)) > 1e-14 * size
    )


def inverse(m: Matrix) -> Matrix:
    """The map that undoes `m`, which must be usable."""
    a, b, c, d, e, f = m
    k = 1.0 / determinant(m)
    return (
        d * k,
        -b * k,
        -c * k,
        a * k,
        (c * f - d * e) * k,
        (b * e - a * f) * k,
    )


def apply(m: Matrix, x: float, y: float) -> tuple[float, float]:
    """Where the point goes."""
    return m[0] * x + m[2] * y + m[4], m[1] * x + m[3] * y + m[5]


def parse_transform(text: str, box: Box = (0.0, 0.0, 0.0, 0.0)) -> Matrix | None:
    """The matrix of a transform list; `box` (x, y, width, height) is what percentages refer to.

    >>> parse_transform("translate(3) scale(2)")
    (2.0, 0.0, 0.0, 2.0, 3.0, 0.0)
    >>> parse_transform("rotate(foo)") is None
    True
    """
    if text.strip() in ("", "none"):
        return IDENTITY
    result, end = IDENTITY, 0
    for match in _CALL.finditer(text):
        if match.start() != end:
            return None
        end = match.end()
        step = _call(match[1].lower(), match[2], box)
        if step is None:
            return None
        result = multiply(result, step)
    return result if not text[end:].strip(" \t\r\n,") else None


def _call(name: str, text: str, box: Box) -> Matrix | None:
    """The matrix of one function of the list."""
    words: list[tuple[float, str]] = []
    end = 0
    for match in _ARGUMENT.finditer(text):
        if match.start() != end:
            return None
        end = match.end()
        words.append((float(match[1]), match[2].lower()))
    if text[end:].strip() or name not in _FUNCTIONS:
        return None
    counts, units = _FUNCTIONS[name]
    if len(words) not in counts:
        return None
    values = [_argument(*word, units[min(i, len(units) - 1)], box) for i, word in enumerate(words)]
    known = [value for value in values if value is not None]
    return _matrix(name, known) if len(known) == len(values) else None


_FUNCTIONS: dict[str, tuple[tuple[int, ...], str]] = {
    "matrix": ((6,), "nnnnxy"),
    "translate": ((1, 2), "xy"),
    "translatex": ((1,), "x"),
    "translatey": ((1,), "y"),
    "scale": ((1, 2), "n"),
    "scalex": ((1,), "n"),
    "scaley": ((1,), "n"),
    "rotate": ((1, 3), "axy"),
    "rotatez": ((1,), "a"),
    "skew": ((1, 2), "a"),
    "skewx": ((1,), "a"),
    "skewy": ((1,), "a"),
}
"""How many arguments a function takes, and of which kind: number, x or y length, angle."""


def _argument(value: float, unit: str, kind: str, box: Box) -> float | None:
    if not math.isfinite(value):
        return None
    if kind == "a":
        return value * _DEGREES[unit] if unit in _DEGREES else None
    if unit == "%":
        whole = {"x": box[2], "y": box[3], "n": 1.0}[kind]
        return value / 100 * whole
    if kind == "n":
        return value if unit == "" else None
    return value * UNITS[unit] if unit in UNITS else None


def _matrix(name: str, v: list[float]) -> Matrix:
    match name:
        case "matrix":
            return (v[0], v[1], v[2], v[3], v[4], v[5])
        case "translate":
            return translate(v[0], v[1] if len(v) > 1 else 0.0)
        case "translatex":
            return translate(v[0], 0.0)
        case "translatey":
            return translate(0.0, v[0])
        case "scale":
            return (v[0], 0.0, 0.0, v[-1], 0.0, 0.0)
        case "scalex":
            return (v[0], 0.0, 0.0, 1.0, 0.0, 0.0)
        case "scaley":
            return (1.0, 0.0, 0.0, v[0], 0.0, 0.0)
        case "skewy":
            return (1.0, math.tan(math.radians(v[0])), 0.0, 1.0, 0.0, 0.0)
        case "skew" | "skewx":
            up = math.tan(math.radians(v[1])) if len(v) > 1 else 0.0
            return (1.0, up, math.tan(math.radians(v[0])), 1.0, 0.0, 0.0)
        case _:
            turn = _rotation(v[0])
            return turn if len(v) == 1 else about(turn, v[1], v[2])


def _rotation(degrees: float) -> Matrix:
    """A rotation; quarter turns are exact, so that equal things stay equal."""
    quarter, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    else:
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (c, s, -s, c, 0.0, 0.0)


def about(m: Matrix, x: float, y: float) -> Matrix:
    """`m` with (x, y) as its origin."""
    return multiply(multiply(translate(x, y), m), translate(-x, -y))


def parse_origin(text: str, box: Box) -> tuple[float, float] | None:
    """The point of a `transform-origin`, counted from the corner of `box`."""
    words = text.split()
    if not words or len(words) > 3:
        return None
    first, second = words[0], words[1] if len(words) > 1 else "center"
    if first in ("top", "bottom") or second in ("left", "right"):
        first, second = second, first
    x = _origin_part(first, box[2])
    y = _origin_part(second, box[3])
    return None if x is None or y is None else (box[0] + x, box[1] + y)


def _origin_part(word: str, whole: float) -> float | None:
    from ipmlang.formats.svg.units import length

    return length(_WORDS.get(word, word), whole)
