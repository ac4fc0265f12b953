"""From attributes, style sheets and `style` to what holds for an element: the cascade, inheritance.

`Cascade.specified` gives what an element itself declares, the strongest of each property;
`Cascade.computed` combines that with a parent. Values stay text except where a parent's font size
or a custom property must be put in.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from ipmlang.formats.svg.color import parse_color
from ipmlang.formats.svg.css import Declaration, match_sheets, parse_declarations
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.properties import (
    COLORS,
    FONT_SIZES,
    INHERITED,
    INITIAL,
    PAINTS,
    PRESENTATION,
)
from ipmlang.formats.svg.units import length, shown
from ipmlang.formats.svg.xml import Document, Node

_CHECKED = PAINTS | COLORS
_KEYWORDS = frozenset({"none", "currentcolor", "inherit", "initial", "unset", "revert"})
_CONTEXT = frozenset({"context-fill", "context-stroke"})
_FONT_RELATIVE = re.compile(r"\d(?:em|ex|ch|rem)\b", re.IGNORECASE)
_VARIABLE = re.compile(r"var\(\s*(--[\w-]+)\s*(?:,([^()]*))?\)")
_RESCALED = ("stroke-width", "stroke-dashoffset", "stroke-dasharray")
_LONGEST = 10_000


class Computed:
    """What holds for one element: `inherited` goes on to its children, `own` is what it declares.

    Compared by identity; `Cascade.computed` gives the same object for the same parent and
    declarations, so that it can be a key of caches.
    """

    __slots__ = ("font_size", "inherited", "own", "parent")

    def __init__(
        self,
        parent: Computed | None,
        inherited: Mapping[str, str],
        own: Mapping[str, str],
        font_size: float,
    ) -> None:
        self.parent = parent
        self.inherited = inherited
        self.own = own
        self.font_size = font_size

    def get(self, name: str) -> str:
        """The value of a property, "" where it has none and SVG names no initial one."""
        source = self.inherited if name in INHERITED else self.own
        return source.get(name) or INITIAL.get(name, "")


class Cascade:
    """The styles of one document."""

    def __init__(self, document: Document, limits: Limits, notes: Notes) -> None:
        self._sheets = match_sheets(document, limits, notes)
        self._notes = notes
        self._specified: dict[Node, Mapping[str, str]] = {}
        self._computed: dict[tuple[Computed, tuple[tuple[str, str], ...]], Computed] = {}
        self._of_document: dict[Node, Computed] = {}
        self.initial = Computed(None, {}, {}, FONT_SIZES["medium"])

    def specified(self, node: Node) -> Mapping[str, str]:
        """What the node declares: attributes, sheets, `style`, then what is !important."""
        known = self._specified.get(node)
        if known is None:
            known = self._specified[node] = self._declared(node)
        return known

    def _declared(self, node: Node) -> Mapping[str, str]:
        own: dict[str, str] = {}
        for name, value in node.attributes.items():
            if name in PRESENTATION:
                self._declare(own, name, value, node.line)
        sheet = self._sheets.get(node, ())
        style = node.attributes.get("style")
        inline: tuple[Declaration, ...] = parse_declarations(style) if style else ()
        for important in (False, True) if sheet or inline else ():
            for declarations in (sheet, inline):
                for name, value, is_important in declarations:
                    if is_important == important:
                        self._declare(own, name, value, node.line)
        return own

    def _declare(self, own: dict[str, str], name: str, value: str, line: int | None) -> None:
        """One declaration; what is no value of its property leaves the weaker one in force."""
        value = value.strip()
        if not value:
            return
        if name in _CHECKED and not _is_paint(value):
            self._notes.add("bad-value", f"`{value[:40]}` is no {name}", line)
        elif name == "marker":
            own["marker-start"] = own["marker-mid"] = own["marker-end"] = value
        else:
            own[name] = value

    def computed(self, parent: Computed, node: Node) -> Computed:
        """What holds for `node` below something for which `parent` holds."""
        own = self.specified(node)
        key = (parent, tuple(own.items()))
        known = self._computed.get(key)
        if known is None:
            known = self._computed[key] = _inherit(parent, own)
        return known

    def in_document(self, node: Node) -> Computed:
        """What holds for `node` where it stands in the file, whoever refers to it."""
        chain = [node, *node.ancestors()]
        style = self.initial
        for one in reversed(chain):
            known = self._of_document.get(one)
            if known is None:
                known = self._of_document[one] = self.computed(style, one)
            style = known
        return style


def _is_paint(value: str) -> bool:
    return (
        value.lower() in _KEYWORDS
        or parse_color(value) is not None
        or value.startswith(("url(", "var("))
        or "var(" in value
        or value in _CONTEXT
    )


def _inherit(parent: Computed, own: Mapping[str, str]) -> Computed:
    if not own:
        return Computed(parent, parent.inherited, own, parent.font_size)
    if any("var(" in value for value in own.values()):
        own = _with_variables(parent, own)
    own = {name: _keyword(parent, name, value) for name, value in own.items()}
    font_size = _font_size(own.get("font-size"), parent.font_size)
    passed_on = {n: v for n, v in own.items() if n in INHERITED or n.startswith("--")}
    inherited = {**parent.inherited, **passed_on}
    if "font-size" in own:
        inherited["font-size"] = shown(font_size)
    for name in _RESCALED:
        if name in own and _FONT_RELATIVE.search(own[name]):
            inherited[name] = _in_pixels(own[name], font_size)
    return Computed(parent, inherited, own, font_size)


def _keyword(parent: Computed, name: str, value: str) -> str:
    """`inherit`, `initial`, `unset` and `revert` as the values that they mean."""
    word = value.lower() if len(value) < 8 else ""
    if word == "inherit" or (word in ("unset", "revert") and name in INHERITED):
        return parent.get(name)
    if word == "currentcolor" and name == "color":
        return parent.get(name)
    if word in ("initial", "unset", "revert"):
        return INITIAL.get(name, "")
    return value


def _font_size(value: str | None, parent: float) -> float:
    if not value:
        return parent
    word = value.lower()
    if word in FONT_SIZES:
        return FONT_SIZES[word]
    if word in ("smaller", "larger"):
        return parent / 1.2 if word == "smaller" else parent * 1.2
    size = length(value, parent, parent)
    return parent if size is None or size < 0 else size


def _in_pixels(value: str, font_size: float) -> str:
    """Lengths that hang on the font size as numbers; percentages stay."""
    words = value.replace(",", " ").split()
    sizes = [None if word.endswith("%") else length(word, 0.0, font_size) for word in words]
    return " ".join(w if s is None else shown(s) for w, s in zip(words, sizes, strict=True))


def _with_variables(parent: Computed, own: Mapping[str, str]) -> dict[str, str]:
    """Every `var(--name, fallback)` replaced, within bounds; what stays unresolved is dropped."""
    known = {**parent.inherited, **own}
    result: dict[str, str] = {}
    for name, value in own.items():
        for _ in range(16):
            if "var(" not in value or len(value) > _LONGEST:
                break
            value = _VARIABLE.sub(lambda m: known.get(m[1]) or (m[2] or "").strip(), value)
        if value.strip() and "var(" not in value:
            result[name] = value.strip()
    return result
