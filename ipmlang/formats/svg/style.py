"""From what holds for an element to the style of what is drawn: `Style`, hashable and canonical.

Lengths of the pen are scaled to the world, what cannot be seen is left out, and everything that has
SVG's initial value is not said. Styles of elements that share theirs are the same object.
"""

from __future__ import annotations

import math

from ipmlang.formats.drawing import Style
from ipmlang.formats.svg.context import Colored
from ipmlang.formats.svg.limits import Notes
from ipmlang.formats.svg.paint import Paints, Site
from ipmlang.formats.svg.properties import INITIAL
from ipmlang.formats.svg.transforms import Matrix
from ipmlang.formats.svg.units import diagonal, length, number, number_or_percent, shown, words

_OF_FILL = ("fill-rule",)
_OF_STROKE = ("stroke-linecap", "stroke-linejoin", "vector-effect")
_SIMILAR = 1e-9
_WIDEST = 1e100


class Styles:
    """Builds and remembers the styles of one source."""

    def __init__(self, paints: Paints, notes: Notes) -> None:
        self._paints = paints
        self._notes = notes
        self._known: dict[object, Style] = {}

    def of(self, site: Site, single: bool) -> Style:
        """The style of an element at `site`; `single`: its opacity and blending stay its own."""
        style = site.style
        fill, stroke = style.get("fill"), style.get("stroke")
        key = (style, site.matrix[:4], site.viewport, site.paints, single)
        shared = not fill.startswith("url(") and not stroke.startswith("url(")
        known = self._known.get(key) if shared else None
        if known is None:
            filled = self._paints.resolve(fill, site)
            stroked = self._paints.resolve(stroke, site)
            known = self._build(site, filled, stroked, single)
            if shared:
                self._known[key] = known
        return known

    def _build(self, site: Site, filled: Colored, stroked: Colored, single: bool) -> Style:
        style = site.style
        has_fill, has_stroke = filled[0] != "none", stroked[0] != "none"
        said = [(name, style.get(name)) for name in _OF_FILL if has_fill]
        said += [(name, style.get(name)) for name in _OF_STROKE if has_stroke]
        said.append(("shape-rendering", style.get("shape-rendering")))
        if has_fill and has_stroke:
            said.append(("paint-order", style.get("paint-order")))
        if single:
            said.append(("mix-blend-mode", style.get("mix-blend-mode")))
        more = [(name, value) for name, value in said if value != INITIAL[name]]
        shares = [("fill-opacity", filled[1])] if has_fill else []
        shares += [("stroke-opacity", stroked[1])] if has_stroke else []
        shares += [("opacity", 1.0)] if single else []
        for name, alpha in shares:
            share = alpha * opacity(style.get(name))
            if share < 1.0:
                more.append((name, shown(share)))
        if not has_stroke:
            return Style(fill=filled[0], more=tuple(sorted(more)))
        if style.get("stroke-linejoin") == "miter":
            limit = number(style.get("stroke-miterlimit"))
            if limit is not None and limit != 4.0 and limit >= 1.0:
                more.append(("stroke-miterlimit", shown(limit)))
        scale, pen = _pen(site.matrix)
        if style.get("vector-effect") == "non-scaling-stroke":
            scale, pen = 1.0, None
        return Style(
            fill=filled[0],
            stroke=stroked[0],
            stroke_width=neat(scale * self.stroke_width(site)),
            dashes=tuple(neat(scale * dash) for dash in self._dashes(site)),
            dash_offset=neat(scale * (self._length(site, "stroke-dashoffset") or 0.0)),
            more=tuple(sorted(more)),
            stroke_matrix=pen,
        )

    def stroke_width(self, site: Site) -> float:
        """In the element's own units; what cannot be read or is negative is the initial 1."""
        width = self._length(site, "stroke-width")
        return 1.0 if width is None or width < 0 else width

    def _length(self, site: Site, name: str) -> float | None:
        text = site.style.get(name)
        value = length(text, diagonal(site.viewport), site.style.font_size)
        if value is None:
            self._notes.add("bad-value", f"`{text[:40]}` is no {name}")
        return value

    def _dashes(self, site: Site) -> tuple[float, ...]:
        """Dashes and gaps in the element's own units; () for a whole line."""
        text = site.style.get("stroke-dasharray")
        if text == "none":
            return ()
        whole, font_size = diagonal(site.viewport), site.style.font_size
        found = [length(word, whole, font_size) for word in words(text)]
        dashes = [dash for dash in found if dash is not None and dash >= 0]
        if len(dashes) != len(found):
            self._notes.add("bad-value", f"`{text[:40]}` is no stroke-dasharray")
            return ()
        return tuple(dashes) if sum(dashes) > 0 else ()


def opacity(text: str) -> float:
    """A share from 0 to 1; 1 where the text is none."""
    value = number_or_percent(text)
    return 1.0 if value is None else min(1.0, max(0.0, value))


def _pen(matrix: Matrix) -> tuple[float, tuple[float, float, float, float] | None]:
    """How much a map widens a pen, and what it does to its shape if that is no circle any more."""
    a, b, c, d = matrix[:4]
    scale = math.sqrt(abs(a * d - b * c))
    size = a * a + b * b + c * c + d * d
    upright = abs(a * c + b * d) <= _SIMILAR * size
    if upright and abs(a * a + b * b - c * c - d * d) <= _SIMILAR * size:
        return math.hypot(a, b), None
    return scale, (neat(a / scale), neat(b / scale), neat(c / scale), neat(d / scale))


def neat(value: float) -> float:
    """12 significant digits: pens that differ by the rounding of their maps are the same pen."""
    return float(f"{min(value, _WIDEST):.12g}")
