"""Numbers and lengths of SVG and CSS as text in, floats in user units (pixels) out.

What cannot be read, or is not finite, is None: the caller decides what stands in for it.
Percentages need the length they are a part of, `em` and `ex` a font size.
"""

from __future__ import annotations

import math
import re

# No group is possessive (`)*+`): before Python 3.11.5 such groups do not match what they should.
NUMBER = r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_LENGTH = re.compile(rf"\s*({NUMBER})\s*([a-zA-Z]*|%)\s*", re.ASCII)
_NUMBERS = re.compile(NUMBER, re.ASCII)
_ONLY_NUMBERS = re.compile(rf"\s*+(?:{NUMBER}\s*+,?+\s*+)*", re.ASCII)

INCH = 96.0
UNITS = {
    "": 1.0,
    "px": 1.0,
    "in": INCH,
    "cm": INCH / 2.54,
    "mm": INCH / 25.4,
    "q": INCH / 101.6,
    "pt": INCH / 72,
    "pc": INCH / 6,
}
FONT_UNITS = {"em": 1.0, "ex": 0.5, "ch": 0.5, "rem": 1.0}


def number(text: str | None) -> float | None:
    """A finite number, or None.

    >>> number(" -.5e1 "), number("12px"), number("nan")
    (-5.0, None, None)
    """
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def number_or_percent(text: str | None) -> float | None:
    """`0.5` or `50%`, both as 0.5."""
    if text is not None and text.rstrip().endswith("%"):
        value = number(text.rstrip()[:-1])
        return None if value is None else value / 100
    return number(text)


def words(text: str) -> list[str]:
    """The words of a list, between which blanks or commas stand."""
    return text.replace(",", " ").split()


def length(text: str | None, whole: float = 0.0, font_size: float = 16.0) -> float | None:
    """A length in user units; `whole` is what a percentage is a part of.

    >>> length("1in"), length("50%", whole=30), length("2em", font_size=10), length("2 apples")
    (96.0, 15.0, 20.0, None)
    """
    if text is None:
        return None
    plain = number(text)
    if plain is not None:
        return plain
    match = _LENGTH.fullmatch(text)
    if match is None:
        return None
    unit = match[2].lower()
    if unit == "%":
        factor = whole / 100
    elif unit in UNITS:
        factor = UNITS[unit]
    elif unit in FONT_UNITS:
        factor = FONT_UNITS[unit] * font_size
    else:
        return None
    value = float(match[1]) * factor
    return value if math.isfinite(value) else None


def diagonal(viewport: tuple[float, float]) -> float:
    """What a percentage that is neither horizontal nor vertical is a part of."""
    return math.hypot(*viewport) / math.sqrt(2)


def numbers(text: str) -> tuple[list[float], bool]:
    """Numbers parted by blanks or commas up to what is none, and whether that was all.

    >>> numbers("1,2 3-4 x 5")
    ([1.0, 2.0, 3.0, -4.0], False)
    """
    match = _ONLY_NUMBERS.match(text)
    end = match.end() if match else 0
    return [float(word) for word in _NUMBERS.findall(text[:end])], end == len(text)


def shown(value: float) -> str:
    """A number in the fewest characters that read back as the same float.

    >>> shown(2.0), shown(0.25), shown(-0.0)
    ('2', '0.25', '0')
    """
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
