"""The walk over what is drawn: groups, uses, viewports and markers opened up, in paint order.

Takes a source; gives one `Placed` for each outline, text or image, in its own space with its map to
the world. No recursion: the stack holds iterators, so that depth costs nothing. Everything that is
made is counted against the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import Fragment, Outline, Style
from ipmlang.formats.svg.bounds import outline_box
from ipmlang.formats.svg.carry import Carrier, with_definitions
from ipmlang.formats.svg.cascade import Computed
from ipmlang.formats.svg.conditions import chosen
from ipmlang.formats.svg.context import Context, Placed, Source, own_transform, placed_by
from ipmlang.formats.svg.counting import Count
from ipmlang.formats.svg.effects import Effects, viewport_wrap
from ipmlang.formats.svg.extents import image_box, text_box
from ipmlang.formats.svg.markers import Frame, frame_of, placements
from ipmlang.formats.svg.paint import Paints, Site
from ipmlang.formats.svg.shapes import SHAPES, Measures, outline_of
from ipmlang.formats.svg.style import Styles
from ipmlang.formats.svg.transforms import Box, Matrix, is_usable, multiply, translate
from ipmlang.formats.svg.viewports import fit, parse_view_box
from ipmlang.formats.svg.xml import Node

Below: TypeAlias = "Iterator[tuple[Node, Context]] | None"
"""What is drawn inside an element, in paint order."""

_MARKED = frozenset({"path", "line", "polyline", "polygon"})
_MARKERS = ("marker-start", "marker-mid", "marker-end")
_NO_OPACITY = frozenset({"display", "clip-path", "mask", "filter", "overflow"})
_WITH_WRAP = _NO_OPACITY | {"opacity", "mix-blend-mode", "isolation"}
_VISITS_PER_ELEMENT = 16
_FREE_VISITS = 100_000
_MOST_IF_CYCLIC = 50_000
"""Elements of a drawing that refers to itself: they cannot be counted before they are made."""
_SEGMENTS_PER_ELEMENT = 4


class Walk:
    """Walks over one source, one after the other; `placed` is what the last has found so far."""

    def __init__(self, source: Source) -> None:
        self.placed: list[Placed] = []
        self._source = source
        self._cascade = source.cascade
        self._notes = source.notes
        self._carrier = Carrier(source)
        self._paints = Paints(source, self._carrier)
        self._styles = Styles(self._paints, source.notes)
        self._effects = Effects(source, self._carrier)
        self._outlines: dict[object, Outline | None] = {}
        self._above: dict[Node, frozenset[Node]] = {}
        self._conditional = source.left_out
        self._visitors: dict[str, Callable[[Node, Context], Below]] = {
            **dict.fromkeys(SHAPES, self._shape),
            **dict.fromkeys(("text", "image", "foreignObject"), self._fragment),
            **dict.fromkeys(("g", "a"), self._group),
            **dict.fromkeys(("svg", "symbol"), self._viewport),
            "switch": self._switch,
            "use": self._use,
        }

    def begin(self, count: Count) -> None:
        """Set out anew, to draw what has been counted."""
        most = self._source.limits.elements
        self.placed = []
        self._carrier.begin()
        self._limit = min(most, _MOST_IF_CYCLIC) if count.cyclic else most
        self._empty = count.empty
        self._visits = _FREE_VISITS + len(self._source.document.nodes)
        self._segments = most * _SEGMENTS_PER_ELEMENT

    def run(self, items: Iterable[tuple[Node, Context]]) -> None:
        """Draw the items and all below them, each in its context."""
        stack = [iter(items)]
        while stack:
            item = next(stack[-1], None)
            if item is None:
                stack.pop()
                continue
            self._visits -= 1
            if self._visits < 0:
                self._refuse(item[0])
            below = self._visit(*item)
            if below is not None:
                stack.append(below)

    def _refuse(self, node: Node) -> None:
        raise FormatError(
            "the drawing is too large after `use` and markers are expanded: "
            f"the limit is {self._limit:,} elements of {_SEGMENTS_PER_ELEMENT} segments",
            node.line,
        )

    def _place(self, one: Placed, node: Node) -> None:
        """One more element; groups around it have not been visited in vain."""
        self.placed.append(one)
        self._visits += _VISITS_PER_ELEMENT
        if len(self.placed) > self._limit:
            self._refuse(node)

    def _visit(self, node: Node, context: Context) -> Below:
        """Put the element's own style and transform into the context and draw it."""
        visitor = self._visitors.get(node.name)
        if visitor is None or node in self._conditional or node in self._empty:
            return None
        style = self._cascade.computed(context.style, node)
        own = style.own
        if own.get("display") == "none":
            return None
        matrix = context.matrix
        if "transform" in own:
            matrix = placed_by(matrix, self._own_transform(node, style, context))
            if not is_usable(matrix):
                self._notes.add("singular-matrix", "a transform leaves nothing to see", node.line)
                return None
        return visitor(node, context._replace(style=style, matrix=matrix))

    def _own_transform(self, node: Node, style: Computed, context: Context) -> Matrix:
        def box() -> Box | None:
            if node.name not in SHAPES:
                return None
            outline = self._outline(node, context._replace(style=style))
            return None if outline is None else outline_box(outline)

        return own_transform(style, context.viewport, box, self._notes, node.line)

    def inside(self, node: Node, context: Context) -> Context:
        """The context of what a group holds: its effects around it, its id among the names."""
        wrap = self._effects.wrap(context.style, context.matrix, alone=False)
        name = node.attributes.get("id")
        if wrap is None and not name and context.request is None:
            return context
        return context._replace(
            wraps=context.wraps if wrap is None else (*context.wraps, wrap),
            names=(*context.names, name) if name else context.names,
            request=None,
        )

    def _group(self, node: Node, context: Context) -> Below:
        inner = self.inside(node, context)
        return ((child, inner) for child in node.children)

    def _switch(self, node: Node, context: Context) -> Below:
        inner = self.inside(node, context)
        return ((child, inner) for child in chosen(node))

    def _viewport(self, node: Node, context: Context) -> Below:
        """A nested svg, or a symbol that a `use` asks for: content fitted into its box."""
        asked = context.request
        if node.name == "symbol" and asked is None:
            return None
        measures = self._measures(node, context)
        x, y = (measures["x"], measures["y"]) if node.name == "svg" else (0.0, 0.0)
        sizes = [
            measures.maybe(name) if size is None else size
            for name, size in zip(("width", "height"), asked or (None, None), strict=True)
        ]
        width, height = (
            whole if size is None else size
            for size, whole in zip(sizes, context.viewport, strict=True)
        )
        if not (width > 0 and height > 0):
            return None
        place: Box = (x, y, width, height)
        view = parse_view_box(node.attributes.get("viewBox"))
        matrix: Matrix | None = translate(x, y)
        if view is not None:
            matrix = fit(view, place, node.attributes.get("preserveAspectRatio"))
        matrix = None if matrix is None else multiply(context.matrix, matrix)
        if matrix is None or not is_usable(matrix):
            return None
        inner = self.inside(node, context)
        wraps = inner.wraps
        if context.style.own.get("overflow", "hidden") not in ("visible", "auto"):
            wraps = (*wraps, viewport_wrap(place, context.matrix))
        inner = inner._replace(
            matrix=matrix,
            viewport=(width, height) if view is None else (view[2], view[3]),
            wraps=wraps,
        )
        return ((child, inner) for child in node.children)

    def _use(self, node: Node, context: Context) -> Below:
        target = self._source.document.target(node.href)
        if target is None:
            outside = bool(node.href) and not node.href.startswith("#")
            code = "use-external" if outside else "use-dangling"
            where = "another file" if outside else "nothing"
            self._notes.add(code, f"a `use` refers to {where} and is left out", node.line)
            return None
        active = context.active | self._ancestors(node)
        if target in active:
            self._notes.add("use-cycle", "a `use` refers to what it is part of", node.line)
            return None
        measures = self._measures(node, context)
        inner = self.inside(node, context)
        shift = measures["x"], measures["y"]
        matrix = (
            context.matrix if shift == (0.0, 0.0) else multiply(context.matrix, translate(*shift))
        )
        request = None
        if target.name in ("svg", "symbol"):
            request = (measures.maybe("width"), measures.maybe("height"))
        inner = inner._replace(matrix=matrix, active=active | {target}, request=request)
        return iter(((target, inner),))

    def _ancestors(self, node: Node) -> frozenset[Node]:
        """The node and all it is part of."""
        known = self._above.get(node)
        if known is None:
            known = self._above[node] = frozenset((node, *node.ancestors()))
        return known

    def _measures(self, node: Node, context: Context) -> Measures:
        style = context.style
        return Measures(node, style.own, context.viewport, style.font_size, self._notes)

    def _outline(self, node: Node, context: Context) -> Outline | None:
        """The outline of a shape in its own space, made once for each viewport and font size."""
        key = (node, context.viewport, context.style.font_size)
        if key not in self._outlines:
            self._outlines[key] = outline_of(node, self._measures(node, context), self._notes)
        return self._outlines[key]

    def _shape(self, node: Node, context: Context) -> Below:
        style = context.style
        if style.get("visibility") in ("hidden", "collapse"):
            return None
        outline = self._outline(node, context)
        if outline is None:
            return None
        self._segments -= len(outline.kind)
        if self._segments < 0:
            self._refuse(node)
        frames = self._frames(node, context)
        wrap = self._effects.wrap(style, context.matrix, alone=not frames)
        wraps = context.wraps if wrap is None else (*context.wraps, wrap)
        site = Site(
            style, context.matrix, context.viewport, lambda: outline_box(outline), context.paints
        )
        drawn = self._styles.of(site, single=wrap is None)
        matrix, names = context.matrix, context.names + _names(node)
        self._place(Placed(outline, None, matrix, drawn, wraps, names, node.line), node)
        if not frames:
            return None
        return self._marked(outline, frames, context._replace(wraps=wraps), drawn)

    def _frames(self, node: Node, context: Context) -> list[tuple[Node, Frame] | None]:
        """Start, mid and end markers of a shape; empty where it has none."""
        style = context.style
        if node.name not in _MARKED or not any(name in style.inherited for name in _MARKERS):
            return []
        site = Site(style, context.matrix, context.viewport, lambda: (0.0, 0.0, 0.0, 0.0))
        width = self._styles.stroke_width(site)
        found: list[tuple[Node, Frame] | None] = []
        for name in _MARKERS:
            marker = self._marker(style.get(name))
            frame = None
            if marker is not None and marker not in context.active:
                font_size = self._cascade.in_document(marker).font_size
                frame = frame_of(marker, width, font_size)
            found.append(None if marker is None or frame is None else (marker, frame))
        return found if any(found) else []

    def _marker(self, value: str) -> Node | None:
        if not value.startswith("url("):
            return None
        address = value[4:].partition(")")[0].strip(" \t\r\n\"'")
        node = self._source.document.target(address)
        return node if node is not None and node.name == "marker" else None

    def _marked(
        self,
        outline: Outline,
        frames: list[tuple[Node, Frame] | None],
        context: Context,
        drawn: Style,
    ) -> Iterator[tuple[Node, Context]]:
        """What the markers of an outline draw, in paint order."""
        markers = {pair[1]: pair[0] for pair in frames if pair is not None}
        start, mid, end = (None if pair is None else pair[1] for pair in frames)
        for frame, place in placements(outline, start, mid, end):
            node = markers[frame]
            style = self._cascade.in_document(node)
            standing = multiply(context.matrix, place)
            matrix = multiply(standing, frame.matrix)
            if not is_usable(matrix):
                continue
            inner = self.inside(node, context._replace(style=style, matrix=matrix))
            inner = inner._replace(
                viewport=frame.viewport,
                active=context.active | self._ancestors(node),
                paints=((drawn.fill, 1.0), (drawn.stroke, 1.0)),
            )
            if style.own.get("overflow", "hidden") not in ("visible", "auto"):
                inner = inner._replace(wraps=(*inner.wraps, viewport_wrap(frame.tile, standing)))
            for child in node.children:
                yield child, inner

    def _fragment(self, node: Node, context: Context) -> Below:
        """Text, images and foreign content, carried through as XML."""
        style = context.style
        if not self._is_seen(node, style):
            return None
        wrap = self._effects.wrap(style, context.matrix, alone=True)
        skip = _NO_OPACITY if wrap is None else _WITH_WRAP
        carried = self._carrier.element(node, style, context.viewport, skip)
        wraps = context.wraps if wrap is None else (*context.wraps, wrap)
        names = context.names + _names(node)
        matrix = multiply(context.matrix, translate(*carried.origin))
        fragment = Fragment(node.name, with_definitions(carried), matrix)
        reach = self._reach(node, context, carried.origin)
        placed = Placed(None, fragment, matrix, Style(), wraps, names, node.line, reach)
        self._place(placed, node)
        code = "foreign-object" if node.name == "foreignObject" else node.name
        self._notes.add(code, f"<{node.name}> is carried through as it is", node.line)
        return None

    def _reach(self, node: Node, context: Context, at: tuple[float, float]) -> Box | None:
        """A box that holds a fragment, from where it begins."""
        if not any(wrap.viewport is not None for wrap in context.wraps):
            return None  # Nobody will ask.
        if node.name == "image":
            box = image_box(self._measures(node, context))
        else:
            box = text_box(node, context.style, self._cascade, (0.0, 0.0, *context.viewport))
        return None if box is None else (box[0] - at[0], box[1] - at[1], *box[2:])

    def _is_seen(self, node: Node, style: Computed) -> bool:
        """Whether something may show: text that is not empty, an image with a source."""
        if node.name == "image":
            return bool(node.href) and style.get("visibility") == "visible"
        if node.name == "foreignObject":
            return bool(node.children)
        pending, text, shown = [node], False, style.get("visibility") == "visible"
        while pending and not (text and shown):
            one = pending.pop()
            text = text or bool(one.text.strip()) or any(c.tail.strip() for c in one.children)
            if not shown:
                shown = self._cascade.specified(one).get("visibility") == "visible"
            pending.extend(one.children)
        return text and shown


def _names(node: Node) -> tuple[str, ...]:
    """The id and the classes of an element."""
    name, classes = node.attributes.get("id"), node.attributes.get("class")
    if name is None and classes is None:
        return ()
    return tuple(word for word in (name, *(classes or "").split()) if word)
