"""CSS colours as text in, `#rrggbb` and an alpha out.

Names, hexadecimal forms, rgb(), rgba(), hsl(), hsla() and hwb(), with commas or blanks, numbers or
percentages. What is no colour is None. `currentColor` is the caller's to resolve.
"""

from __future__ import annotations

import re
from colorsys import hls_to_rgb
from functools import lru_cache
from typing import TypeAlias

from ipmlang.formats.svg.units import NUMBER

Color: TypeAlias = tuple[str, float]

_CALL = re.compile(r"(rgba?|hsla?|hwb)\(([^()]*)\)", re.IGNORECASE)
_PART = re.compile(rf"({NUMBER})(%|deg|rad|grad|turn)?|none", re.IGNORECASE)
_HEX = re.compile(r"#[0-9a-fA-F]+")
_DEGREES = {"": 1.0, "deg": 1.0, "rad": 57.29577951308232, "grad": 0.9, "turn": 360.0}


@lru_cache(maxsize=8192)
def parse_color(text: str) -> Color | None:
    """The colour, or None.

    >>> parse_color("rgb(100%, 0%, 50%)"), parse_color("#0f08"), parse_color("no colour")
    (('#ff0080', 1.0), ('#00ff00', 0.5333333333333333), None)
    """
    text = text.strip()
    if text.startswith("#"):
        return _hexadecimal(text)
    call = _CALL.fullmatch(text)
    if call is not None:
        return _function(call[1].lower(), call[2])
    if text.isalpha():
        return _named(text)
    return None


def _hexadecimal(text: str) -> Color | None:
    if _HEX.fullmatch(text) is None:
        return None
    digits = text[1:].lower()
    if len(digits) in (3, 4):
        digits = "".join(digit * 2 for digit in digits)
    if len(digits) not in (6, 8):
        return None
    alpha = int(digits[6:], 16) / 255 if len(digits) == 8 else 1.0
    return "#" + digits[:6], alpha


def _named(text: str) -> Color | None:
    from tinycss2.color3 import parse_color as parse_name

    if text.lower() == "rebeccapurple":  # The one name of CSS 4 that CSS 3 lacks.
        return "#663399", 1.0
    found = parse_name(text)
    if found is None or isinstance(found, str):
        return None
    return _shown(found.red, found.green, found.blue), float(found.alpha)


def _function(name: str, text: str) -> Color | None:
    words = text.replace(",", " ").replace("/", " ").split()
    parts = [_PART.fullmatch(word) for word in words]
    if len(parts) not in (3, 4) or None in parts:
        return None
    pairs = [(float(m[1] or 0), (m[2] or "").lower()) for m in parts if m is not None]
    alpha = 1.0
    if len(pairs) == 4:
        value, unit = pairs[3]
        alpha = min(1.0, max(0.0, value / 100 if unit == "%" else value))
    if name.startswith("rgb"):
        red, green, blue = (v / 100 if unit == "%" else v / 255 for v, unit in pairs[:3])
        return _shown(red, green, blue), alpha
    hue = pairs[0][0] * _DEGREES.get(pairs[0][1], 1.0) / 360 % 1.0
    first, second = (min(1.0, max(0.0, value / 100)) for value, _ in pairs[1:3])
    if name.startswith("hsl"):
        return _shown(*hls_to_rgb(hue, second, first)), alpha
    return _shown(*_hwb(hue, first, second)), alpha


def _hwb(hue: float, white: float, black: float) -> tuple[float, float, float]:
    if white + black >= 1:
        grey = white / (white + black)
        return grey, grey, grey
    red, green, blue = (
        channel * (1 - white - black) + white for channel in hls_to_rgb(hue, 0.5, 1.0)
    )
    return red, green, blue


def _shown(red: float, green: float, blue: float) -> str:
    """Channels from 0 to 1 as #rrggbb, halves rounded up as browsers do."""
    channels = (
        int(min(1.0, max(0.0, channel)) * 255 + 0.5 + 1e-9) for channel in (red, green, blue)
    )
    return "#{:02x}{:02x}{:02x}".format(*channels)
