"""Parts of the file as self-contained XML: styles resolved onto them, what they refer to included.

For what is carried through as it is (text, images) and for definitions (clips, masks, filters,
patterns). Ids are replaced by names made from the content, so that equal definitions are equal
text. Scripts and event attributes are dropped; addresses of files and networks stay text, never
opened.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from ipmlang.formats import FormatError
from ipmlang.formats.svg.anchoring import PLACES, Anchor, anchor, moved
from ipmlang.formats.svg.cascade import Computed
from ipmlang.formats.svg.context import Source, own_transform
from ipmlang.formats.svg.properties import INHERITED, INITIAL, PRESENTATION
from ipmlang.formats.svg.transforms import IDENTITY
from ipmlang.formats.svg.units import length, shown, words
from ipmlang.formats.svg.xml import XML_LANG, XML_SPACE, Node

_REFERENCE = re.compile(r"""url\(\s*(["']?)#([^"')]+)\1\s*\)""")
_IDLE = frozenset({"marker-start", "marker-mid", "marker-end", "pointer-events", "cursor"})
_DROPPED = frozenset({"id", "class", "style", "transform", "href"}) | PRESENTATION
_SIZES = "x y dx dy width height cx cy r rx ry x1 y1 x2 y2 textLength"
_SIZED = frozenset(_SIZES.split())
_DEFINED = "clipPath mask pattern marker filter linearGradient radialGradient"
_DEFINITIONS = frozenset(_DEFINED.split())
_CONTAINERS = f"g defs svg symbol use switch image feMerge feComponentTransfer {_DEFINED}"
_TEXTLESS = frozenset(_CONTAINERS.split())
_OF_FILTERS = frozenset({"color", "color-interpolation-filters"})
_DEEPEST = 32
# Viewers differ in the size of text that nobody gave a size, so a size that is given is said.
_USUAL = {name: value for name, value in INITIAL.items() if name != "font-size"}


@dataclass(frozen=True, slots=True)
class Carried:
    """XML, the definitions that it refers to by id, and where its origin is in the node's space."""

    xml: str
    definitions: Mapping[str, str]
    origin: tuple[float, float] = (0.0, 0.0)


class Carrier:
    """Copies nodes of one source as XML."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._known: dict[Node, tuple[str, Mapping[str, str]]] = {}
        self._under_way: set[Node] = set()
        self.begin()

    def begin(self) -> None:
        """Count anew what is carried."""
        self._left = self._source.limits.carried

    def charge(self, text: str) -> None:
        """Count what is carried against the limit."""
        self._left -= len(text)
        if self._left < 0:
            raise FormatError(
                "too much text, gradients and other definitions are repeated in this drawing",
                hint=f"the limit is {self._source.limits.carried:,} characters",
            )

    def element(
        self,
        node: Node,
        style: Computed,
        viewport: tuple[float, float],
        skip: frozenset[str],
    ) -> Carried:
        """The node as XML with all that it inherits, without its own transform and `skip`, about
        where it begins if nothing stays behind.
        """
        at = anchor(node, style.own, lambda name, value: _sized(name, value, viewport))
        carried = self._about(at, node, style, viewport, skip)
        if at is not None and carried.definitions:  # which would stay behind
            return self._about(None, node, style, viewport, skip)
        return carried

    def _about(
        self,
        at: Anchor | None,
        node: Node,
        style: Computed,
        viewport: tuple[float, float],
        skip: frozenset[str],
    ) -> Carried:
        definitions: dict[str, str] = {}
        given = {
            name: value
            for name, value in style.inherited.items()
            if value != _USUAL.get(name) and name in INHERITED and name not in _IDLE
        }
        given |= {
            name: value
            for name, value in style.own.items()
            if name in PRESENTATION and name not in INHERITED and name not in skip
            and not name.startswith("transform")
        }  # fmt: skip
        root = _kept_space(node) | self._attributes(node, {}, viewport, definitions)
        root |= {name: self._rewritten(value, definitions) for name, value in given.items()}
        xml = self._subtree(node, _anchored(root, at, begins=True), viewport, definitions, at)
        self.charge(xml)
        return Carried(xml, definitions, (0.0, 0.0) if at is None else (float(at[0]), float(at[1])))

    def children(self, node: Node, viewport: tuple[float, float]) -> Carried:
        """What is inside the node, as XML."""
        definitions: dict[str, str] = {}
        drawn = (child for child in node.children if child.name != "defs")
        xml = "".join(self._subtree(child, None, viewport, definitions) for child in drawn)
        self.charge(xml)
        return Carried(xml, definitions)

    def value(self, text: str) -> Carried | None:
        """A property value with its references renamed; None where one points at nothing."""
        definitions: dict[str, str] = {}
        renamed = self._rewritten(text, definitions)
        return None if "url(#)" in renamed else Carried(renamed, definitions)

    def value_map(self, values: Mapping[str, str]) -> Carried:
        """Attributes as they are written, each with its references renamed."""
        definitions: dict[str, str] = {}
        renamed = {name: self._rewritten(value, definitions) for name, value in values.items()}
        return Carried("".join(f" {n}={quoteattr(v)}" for n, v in renamed.items()), definitions)

    def inherited_attributes(self, node: Node) -> dict[str, str]:
        """What a definition inherits where it stands in the file, as presentation attributes."""
        style = self._source.cascade.in_document(node)
        wanted = _OF_FILTERS if node.name == "filter" else INHERITED - _IDLE
        return {
            name: value
            for name, value in style.inherited.items()
            if value != _USUAL.get(name) and name in wanted
        }

    def _rewritten(self, text: str, definitions: dict[str, str]) -> str:
        """`url(#id)` renamed to the name of its definition, which is added to `definitions`."""
        if "url(" not in text:
            return text
        return _REFERENCE.sub(lambda match: f"url(#{self._name(match[2], definitions)})", text)

    def _name(self, identifier: str, definitions: dict[str, str]) -> str:
        """The content-made name of the node with this id; "" if there is none or it goes round."""
        node = self._source.document.by_id.get(identifier)
        if node is None or node in self._under_way or len(self._under_way) >= _DEEPEST:
            self._source.notes.add("reference", f"#{identifier[:40]} refers to nothing usable")
            return ""
        known = self._known.get(node)
        if known is None:
            self._under_way.add(node)
            known = self._known[node] = self._definition(node)
            self._under_way.remove(node)
        name, blocks = known
        definitions.update(blocks)
        return name

    def _definition(self, node: Node) -> tuple[str, Mapping[str, str]]:
        """A name for the node's content, and the XML blocks it needs under their names."""
        blocks: dict[str, str] = {}
        root = self._attributes(node, self._source.cascade.specified(node), None, blocks)
        if node.name in _DEFINITIONS:
            inherited = self.inherited_attributes(node)
            root = {n: self._rewritten(v, blocks) for n, v in inherited.items()} | root
        xml = self._subtree(node, root, None, blocks)
        digest = hashlib.sha256(xml.encode()).hexdigest()[:10]
        name = f"{node.name}-{digest}"
        head = f"<{node.name}"
        blocks[name] = f'{head} id="{name}"{xml[len(head) :]}'
        self.charge(xml)
        return name, blocks

    def _subtree(
        self,
        node: Node,
        root: dict[str, str] | None,
        viewport: tuple[float, float] | None,
        definitions: dict[str, str],
        at: Anchor | None = None,
    ) -> str:
        """The node and all below it as XML; `root` are its attributes where they are known; at:
        what is to be the origin of what is below it.
        """
        parts: list[str] = []
        pending: list[Node | str] = [node]
        while pending:
            item = pending.pop()
            if isinstance(item, str):
                parts.append(item)
                continue
            tag, opening = _tag(item, item is node)
            # What stands in `defs` is carried with whatever refers to it.
            if tag == "script" or (item.name == "defs" and item is not node):
                continue
            attributes = root if item is node and root is not None else None
            if attributes is None:
                own = self._source.cascade.specified(item)
                attributes = self._attributes(item, own, viewport, definitions)
                attributes = _anchored(attributes, at)
            written = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
            tail = _shown_text(item.parent, item.tail) if item is not node else ""
            text = _shown_text(item, item.text)
            if not item.children and not text:
                parts.append(f"<{opening}{written}/>{tail}")
                continue
            parts.append(f"<{opening}{written}>{text}")
            pending.append(f"</{tag}>{tail}")
            pending.extend(reversed(item.children))
        return "".join(parts)

    def _attributes(
        self,
        node: Node,
        own: Mapping[str, str],
        viewport: tuple[float, float] | None,
        definitions: dict[str, str],
    ) -> dict[str, str]:
        """Attributes of a copy: style resolved, references renamed, sizes free of the viewport."""
        result: dict[str, str] = {}
        for name, value in node.attributes.items():
            if name in (XML_SPACE, XML_LANG):
                result["xml:" + name.rpartition("}")[2]] = value
            elif name not in _DROPPED and name[0] != "{" and not name.lower().startswith("on"):
                result[name] = self._rewritten(_sized(name, value, viewport), definitions)
        for name, value in own.items():
            if name == "transform":
                result["transform"] = self._transform(node, value, own, viewport)
            elif not name.startswith(("--", "transform-")):
                result[name] = self._rewritten(value, definitions)
        href = node.href
        if href.startswith("#"):
            href = "#" + self._name(href[1:], definitions)
        if href and href != "#":
            result["href"] = href
        return result

    def _transform(
        self,
        node: Node,
        text: str,
        own: Mapping[str, str],
        viewport: tuple[float, float] | None,
    ) -> str:
        """A transform in the attribute's syntax, its origin worked in."""
        if text == (node.attributes.get("transform") or "").strip() and len(own) == 1:
            return text
        style = Computed(None, {}, own, 16.0)
        notes, line = self._source.notes, node.line
        matrix = own_transform(style, viewport or (0.0, 0.0), lambda: None, notes, line)
        if matrix == IDENTITY:
            return ""
        return f"matrix({' '.join(map(shown, matrix))})"


def _anchored(
    attributes: dict[str, str], at: Anchor | None, *, begins: bool = False
) -> dict[str, str]:
    """Attributes whose places count from an anchor; begins: where nothing said means the origin."""
    if at is None:
        return attributes
    known = {
        name: moved(attributes[name], origin)
        for name, origin in zip(PLACES, at, strict=True)
        if name in attributes
    }
    said = attributes | known
    return {name: value for name, value in said.items() if not (begins and known.get(name) == "0")}


def _shown_text(holder: Node | None, text: str) -> str:
    """Text inside an element as XML; blanks between elements that hold no text are no text."""
    if holder is not None and holder.name in _TEXTLESS and text.isspace():
        return ""
    return escape(text)


def _kept_space(node: Node) -> dict[str, str]:
    """The xml:space and xml:lang that hold for a node, from the nearest ancestor that has them."""
    chain = [node, *node.ancestors()]
    found = {}
    for full, name in ((XML_SPACE, "xml:space"), (XML_LANG, "xml:lang")):
        value = next((one.attributes[full] for one in chain if full in one.attributes), None)
        if value is not None:
            found[name] = value
    return found


def _tag(node: Node, is_root: bool) -> tuple[str, str]:
    """The element's name, and the name with a namespace where a foreign one begins."""
    namespace, _, local = node.tag.rpartition("}")
    outer = "" if is_root or node.parent is None else node.parent.tag.rpartition("}")[0]
    if node.name and (is_root or (node.parent is not None and node.parent.name)):
        return local, local
    if namespace == outer:
        return local, local
    return local, f"{local} xmlns={quoteattr(namespace[1:])}"


def _sized(name: str, value: str, viewport: tuple[float, float] | None) -> str:
    """Percentages of a viewport as numbers: the copy will stand in another one."""
    if viewport is None or "%" not in value or name not in _SIZED:
        return value
    whole = viewport[1] if name in ("y", "dy", "height", "cy", "ry", "y1", "y2") else viewport[0]
    sizes = (length(word, whole) if "%" in word else None for word in words(value))
    pairs = zip(words(value), sizes, strict=True)
    return " ".join(word if size is None else shown(size) for word, size in pairs)


def with_definitions(carried: Carried) -> str:
    """One piece of XML: a group that begins with the definitions, where there are any."""
    if not carried.definitions:
        return carried.xml
    return f"<g><defs>{''.join(carried.definitions.values())}</defs>{carried.xml}</g>"
