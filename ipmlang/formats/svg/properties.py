"""The presentation properties that matter here: which are inherited, what they are at first.

Tables only, from SVG 1.1's property index and SVG 2; nothing is parsed here.
"""

from __future__ import annotations

PAINTS = frozenset({"fill", "stroke"})
COLORS = frozenset({"color", "stop-color", "flood-color", "lighting-color"})

_FONT_NAMES = (
    "font font-family font-size font-size-adjust font-stretch font-style font-variant font-weight "
    "font-feature-settings font-kerning letter-spacing word-spacing line-height text-anchor "
    "writing-mode direction glyph-orientation-vertical glyph-orientation-horizontal white-space "
    "dominant-baseline text-rendering text-orientation text-transform text-indent"
)
_FONT = frozenset(_FONT_NAMES.split())
_PASSED_ON = (
    "fill fill-opacity fill-rule stroke stroke-dasharray stroke-dashoffset stroke-linecap "
    "stroke-linejoin stroke-miterlimit stroke-opacity stroke-width color visibility marker-start "
    "marker-mid marker-end clip-rule paint-order shape-rendering image-rendering color-rendering "
    "color-interpolation color-interpolation-filters pointer-events cursor"
)
INHERITED = _FONT | frozenset(_PASSED_ON.split())
_KEPT = (
    "opacity display clip-path mask filter mix-blend-mode isolation overflow clip stop-color "
    "stop-opacity flood-color flood-opacity lighting-color vector-effect transform "
    "transform-origin transform-box text-decoration unicode-bidi alignment-baseline "
    "baseline-shift mask-type background background-color"
)
NOT_INHERITED = frozenset(_KEPT.split())
GEOMETRY = frozenset({"x", "y", "cx", "cy", "r", "rx", "ry", "width", "height", "d"})
"""Attributes that style sheets may set as well."""

PRESENTATION = INHERITED | (NOT_INHERITED - {"background", "background-color"})
"""Properties that may stand as attributes of an element."""

STYLED = INHERITED | NOT_INHERITED | GEOMETRY | {"marker"}
"""Properties that are read from style sheets and `style` attributes."""

INITIAL = {
    "fill": "black",
    "fill-opacity": "1",
    "fill-rule": "nonzero",
    "stroke": "none",
    "stroke-opacity": "1",
    "stroke-width": "1",
    "stroke-dasharray": "none",
    "stroke-dashoffset": "0",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "color": "black",
    "visibility": "visible",
    "marker-start": "none",
    "marker-mid": "none",
    "marker-end": "none",
    "clip-rule": "nonzero",
    "paint-order": "normal",
    "shape-rendering": "auto",
    "font-size": "16",
    "opacity": "1",
    "display": "inline",
    "clip-path": "none",
    "mask": "none",
    "filter": "none",
    "mix-blend-mode": "normal",
    "isolation": "auto",
    "overflow": "visible",
    "vector-effect": "none",
}

FONT_SIZES = {
    "xx-small": 9.0,
    "x-small": 10.0,
    "small": 13.0,
    "medium": 16.0,
    "large": 18.0,
    "x-large": 24.0,
    "xx-large": 32.0,
}
