"""Colours of the instance table as texts, without what reads style sheets.

In goes a number, out comes what an SVG or a material calls it.
"""

from __future__ import annotations


def hex_color(color: int) -> tuple[str, float]:
    """`#rrggbb` and opacity of 0xRRGGBBAA.

    >>> hex_color(0x2A6F4EFF), hex_color(0xFF000080)[0]
    (('#2a6f4e', 1.0), '#ff0000')
    """
    return f"#{color >> 8:06x}", (color & 255) / 255
