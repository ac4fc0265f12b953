"""A box that surely holds a text or an image, in its own space, without knowing any font.

Glyphs are taken as wider and taller than those of usual fonts. None where too much is unknown:
text on a path, stretched, spaced or vertical text, foreign content.
"""

from __future__ import annotations

from ipmlang.formats.svg.cascade import Cascade, Computed
from ipmlang.formats.svg.shapes import Measures
from ipmlang.formats.svg.transforms import Box
from ipmlang.formats.svg.units import length, words
from ipmlang.formats.svg.xml import Node

_GLYPH_WIDTH = 1.4
_ABOVE = 2.0
_BELOW = 1.5
_UNKNOWN = ("textLength", "rotate")
_SPACED = ("letter-spacing", "word-spacing", "writing-mode", "direction", "font")


def image_box(measures: Measures) -> Box | None:
    """Where an image with a size lies."""
    width, height = measures.maybe("width"), measures.maybe("height")
    if width is None or height is None:
        return None
    return measures["x"], measures["y"], width, height


def text_box(node: Node, style: Computed, cascade: Cascade, whole: Box) -> Box | None:
    """A box around a text; `whole` is the viewport, which percentages refer to."""
    size, glyphs, shift = style.font_size, 0, 0.0
    places: dict[str, list[float]] = {"x": [], "y": []}
    pending = [(node, style)]
    while pending:
        one, held = pending.pop()
        if one.name not in ("text", "tspan", "a", "title", "desc"):
            return None
        if any(name in one.attributes for name in _UNKNOWN) or any(map(held.get, _SPACED)):
            return None
        size = max(size, held.font_size)
        glyphs += len(one.text) + sum(len(child.tail) for child in one.children)
        for name, share in (("x", whole[2]), ("y", whole[3])):
            places[name] += _lengths(one.get(name), share, held.font_size)
            shift += sum(map(abs, _lengths(one.get("d" + name), share, held.font_size)))
        pending += [(child, cascade.computed(held, child)) for child in one.children]
    xs, ys = places["x"] or [0.0], places["y"] or [0.0]
    along = glyphs * size * _GLYPH_WIDTH + size + shift
    left = size if style.get("text-anchor") in ("", "start") else along
    x, y = min(xs) - left - shift, min(ys) - _ABOVE * size - shift
    return x, y, max(xs) + along - x, max(ys) + _BELOW * size + shift - y


def _lengths(text: str | None, whole: float, font_size: float) -> list[float]:
    found = (length(word, whole, font_size) for word in words(text or ""))
    return [value for value in found if value is not None]
