"""What fill and stroke mean: a colour with its alpha, or a gradient or pattern made self-contained.

Servers come out in userSpaceOnUse with all that they inherit by href, with the map from their space
to the world. What cannot be painted falls back as SVG says: to the colour behind the reference,
else to nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from ipmlang.formats.drawing import PaintServer
from ipmlang.formats.svg.carry import Carrier
from ipmlang.formats.svg.cascade import Computed
from ipmlang.formats.svg.color import parse_color
from ipmlang.formats.svg.context import Colored, Source
from ipmlang.formats.svg.transforms import (
    IDENTITY,
    Box,
    Matrix,
    is_usable,
    multiply,
    parse_transform,
)
from ipmlang.formats.svg.units import diagonal, length, number_or_percent, shown
from ipmlang.formats.svg.viewports import parse_view_box
from ipmlang.formats.svg.xml import Node

NOTHING: Colored = ("none", 1.0)
_GRADIENTS = {
    "linearGradient": (("x1", "0%"), ("y1", "0%"), ("x2", "100%"), ("y2", "0%")),
    "radialGradient": (("cx", "50%"), ("cy", "50%"), ("r", "50%"), ("fr", "0%")),
}
_DOWN = frozenset({"y", "y1", "y2", "cy", "fy", "height"})
_ACROSS = frozenset({"x", "x1", "x2", "cx", "fx", "width"})
_LONGEST_CHAIN = 32


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Where a paint is used: style, map to the world, viewport, and the box of what is painted."""

    style: Computed
    matrix: Matrix
    viewport: tuple[float, float]
    box: Callable[[], Box]
    paints: tuple[Colored, Colored] | None = None


def color_of(text: str, style: Computed) -> Colored | None:
    """A colour, `none` or currentColor; None for anything else."""
    word = text.lower()
    if word == "none":
        return NOTHING
    if word == "currentcolor":
        return parse_color(style.get("color")) or ("#000000", 1.0)
    return parse_color(text)


class Paints:
    """Resolves the paints of one source."""

    def __init__(self, source: Source, carrier: Carrier) -> None:
        self._source = source
        self._carrier = carrier
        self._noted: set[Node] = set()
        self._stops: dict[Node, list[tuple[float, str, float]]] = {}
        self._pattern_content: dict[Node, str] = {}

    def resolve(self, text: str, site: Site) -> Colored:
        """The paint of a `fill` or `stroke` value."""
        plain = color_of(text, site.style)
        if plain is not None:
            return plain
        if text in ("context-fill", "context-stroke"):
            return site.paints[text == "context-stroke"] if site.paints else NOTHING
        if not text.startswith("url("):
            return NOTHING
        address, _, fallback = text[4:].partition(")")
        node = self._source.document.target(address.strip(" \t\r\n\"'"))
        found = self._server(node, site) if node is not None else None
        if found is None:
            if node is None:
                self._source.notes.add("paint-reference", f"{text[:40]} refers to no paint")
            found = color_of(fallback.strip() or "none", site.style) or NOTHING
        return found

    def _server(self, node: Node, site: Site) -> Colored | None:
        if node.name in _GRADIENTS:
            return self._gradient(node, site)
        if node.name == "pattern":
            return self._pattern(node, site)
        return None

    def _note(self, node: Node) -> None:
        if node not in self._noted:
            self._noted.add(node)
            kind = "pattern" if node.name == "pattern" else "gradient"
            self._source.notes.add(kind, f"a {kind} is carried through as it is", node.line)

    def _chain(self, node: Node) -> list[Node]:
        """The node and what it inherits from by href, nearest first."""
        chain = [node]
        while len(chain) < _LONGEST_CHAIN:
            after = self._source.document.target(chain[-1].href)
            if after is None or after in chain:
                break
            chain.append(after)
        return chain

    def _gradient(self, node: Node, site: Site) -> Colored | None:
        chain = self._chain(node)
        stops = next((s for s in (self._stops_of(one) for one in chain) if s), [])
        if not stops:
            return NOTHING
        last: Colored = (stops[-1][1], stops[-1][2])
        if len(stops) == 1:
            return last
        matrix = _server_matrix(_first(chain, "gradientTransform"))
        boxed = _first(chain, "gradientUnits") != "userSpaceOnUse"
        if boxed:
            x, y, width, height = site.box()
            if not (width > 0 and height > 0):
                return None
            matrix = multiply((width, 0.0, 0.0, height, x, y), matrix)
        matrix = multiply(site.matrix, matrix)
        if not is_usable(matrix):
            return last
        values = self._ends(node, chain, boxed, site)
        if _has_no_extent(node, values):
            return last
        attributes = [("gradientUnits", "userSpaceOnUse")]
        attributes += [(name, shown(value)) for name, value in values.items()]
        for name, usual in (("spreadMethod", "pad"), ("color-interpolation", "sRGB")):
            value = _first(chain, name)
            if value and value != usual:
                attributes.append((name, value))
        self._note(node)
        body = "".join(_stop_xml(*stop) for stop in stops)
        xml = f"<{node.name}{_written(attributes)}>{body}</{node.name}>"
        self._carrier.charge(xml)
        return PaintServer(node.name, xml, matrix), 1.0

    def _ends(self, node: Node, chain: list[Node], boxed: bool, site: Site) -> dict[str, float]:
        """The numbers that say where the gradient runs, in its own space."""
        same = [one for one in chain if one.name == node.name]
        names = dict(_GRADIENTS[node.name])
        values = {n: _size(n, _first(same, n) or usual, boxed, site) for n, usual in names.items()}
        for focus, centre in (("fx", "cx"), ("fy", "cy")):
            text = _first(same, focus)
            if node.name == "radialGradient" and text:
                values[focus] = _size(focus, text, boxed, site)
                if values[focus] == values[centre]:
                    del values[focus]
        if values.get("fr") == 0.0:
            del values["fr"]
        return values

    def _stops_of(self, node: Node) -> list[tuple[float, str, float]]:
        """(offset, colour, opacity) of the node's own stops, offsets never falling."""
        known = self._stops.get(node)
        if known is None:
            known = self._stops[node] = []
            for child in node.children:
                if child.name == "stop":
                    floor = known[-1][0] if known else 0.0
                    known.append(self._stop(child, floor))
        return known

    def _stop(self, node: Node, floor: float) -> tuple[float, str, float]:
        style = self._source.cascade.in_document(node)
        offset = number_or_percent(node.attributes.get("offset")) or 0.0
        colored = color_of(style.own.get("stop-color") or "black", style) or ("#000000", 1.0)
        color, alpha = colored
        opacity = number_or_percent(style.own.get("stop-opacity"))
        alpha *= 1.0 if opacity is None else min(1.0, max(0.0, opacity))
        return max(floor, min(1.0, max(0.0, offset))), str(color), alpha

    def _pattern(self, node: Node, site: Site) -> Colored | None:
        chain = self._chain(node)
        holder = next((one for one in chain if one.children), None)
        boxed = _first(chain, "patternUnits") != "userSpaceOnUse"
        view = _first(chain, "viewBox")
        content_boxed = (
            parse_view_box(view) is None
            and _first(chain, "patternContentUnits") == "objectBoundingBox"
        )
        box = site.box() if boxed or content_boxed else (0.0, 0.0, 1.0, 1.0)
        if holder is None or not (box[2] > 0 and box[3] > 0):
            return None
        tile = _tile(chain, boxed, box, site)
        matrix = multiply(site.matrix, _server_matrix(_first(chain, "patternTransform")))
        if not (tile[2] > 0 and tile[3] > 0) or not is_usable(matrix):
            return NOTHING
        sizes = zip(("x", "y", "width", "height"), tile, strict=True)
        attributes = [("patternUnits", "userSpaceOnUse"), *((n, shown(v)) for n, v in sizes)]
        if parse_view_box(view) is not None:
            attributes.append(("viewBox", view or ""))
            aspect = _first(chain, "preserveAspectRatio")
            attributes += [("preserveAspectRatio", aspect)] if aspect else []
        body = self._content(holder)
        if content_boxed:
            body = f'<g transform="scale({shown(box[2])} {shown(box[3])})">{body}</g>'
        self._note(node)
        style = self._source.cascade.in_document(node)
        if style.own.get("overflow") in ("visible", "auto"):
            attributes.append(("overflow", "visible"))
        xml = f"<pattern{_written(attributes)}>{body}</pattern>"
        self._carrier.charge(xml)
        return PaintServer("pattern", xml, matrix), 1.0

    def _content(self, holder: Node) -> str:
        """What a pattern draws, with all that it needs."""
        known = self._pattern_content.get(holder)
        if known is None:
            # Marked first: a pattern that is painted with itself comes back here.
            self._pattern_content[holder] = ""
            carried = self._carrier.children(holder, (0.0, 0.0))
            inherited = self._carrier.value_map(self._carrier.inherited_attributes(holder))
            definitions = {**carried.definitions, **inherited.definitions}
            known = carried.xml
            if inherited.xml:
                known = f"<g{inherited.xml}>{known}</g>"
            if definitions:
                known = f"<defs>{''.join(definitions.values())}</defs>{known}"
            self._pattern_content[holder] = known
        return known


def _first(chain: Iterable[Node], name: str) -> str | None:
    """The attribute of the nearest in the chain that has it."""
    return next((one.attributes[name].strip() for one in chain if name in one.attributes), None)


def _server_matrix(text: str | None) -> Matrix:
    return (parse_transform(text) if text else None) or IDENTITY


def _size(name: str, text: str, boxed: bool, site: Site) -> float:
    """A coordinate of a paint server in its own units."""
    if boxed:
        return number_or_percent(text) or 0.0
    if name in _ACROSS:
        whole = site.viewport[0]
    elif name in _DOWN:
        whole = site.viewport[1]
    else:
        whole = diagonal(site.viewport)
    return length(text, whole, site.style.font_size) or 0.0


def _tile(chain: list[Node], boxed: bool, box: Box, site: Site) -> Box:
    """The reference box of a pattern in the space of what it paints."""
    x, y, width, height = (
        _size(name, _first(chain, name) or "0", boxed, site)
        for name in ("x", "y", "width", "height")
    )
    if not boxed:
        return x, y, width, height
    return box[0] + x * box[2], box[1] + y * box[3], width * box[2], height * box[3]


def _has_no_extent(node: Node, values: dict[str, float]) -> bool:
    if node.name == "radialGradient":
        return values["r"] <= 0
    return values["x1"] == values["x2"] and values["y1"] == values["y2"]


def _stop_xml(offset: float, color: str, opacity: float) -> str:
    attributes = [("offset", shown(offset)), ("stop-color", color)]
    if opacity < 1:
        attributes.append(("stop-opacity", shown(opacity)))
    return f"<stop{_written(attributes)}/>"


def _written(attributes: Iterable[tuple[str, str]]) -> str:
    return "".join(f" {name}={quoteattr(value)}" for name, value in attributes)
