"""XML in, a light tree of nodes out: bounded in bytes and depth, no network, no entities.

`read_document` takes a path or bytes and gives the nodes in document order with an index of ids.
It refuses what is not SVG with a line number, and never opens anything the file refers to.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

from ipmlang.formats import FormatError
from ipmlang.formats.svg.limits import Limits, Notes

if TYPE_CHECKING:
    from lxml import etree

SVG = "http://www.w3.org/2000/svg"
XLINK_HREF = "{http://www.w3.org/1999/xlink}href"
XML_SPACE = "{http://www.w3.org/XML/1998/namespace}space"
XML_LANG = "{http://www.w3.org/XML/1998/namespace}lang"
_LONG_TEXT = 9_000_000
"""Files shorter than this cannot hold an attribute that libxml2 calls too long."""


class Node:
    """One element. `name` is its local name in SVG's namespace and "" in any other; `tag` is the
    full name as `{namespace}local`. Iterates over its children, as style matching expects.
    """

    __slots__ = ("attributes", "children", "line", "name", "parent", "tag", "tail", "text")

    def __init__(
        self, tag: str, attributes: dict[str, str], parent: Node | None, line: int | None
    ) -> None:
        namespace, _, local = tag.rpartition("}")
        self.tag = tag
        self.name = local if namespace in ("", "{" + SVG) else ""
        self.attributes = attributes
        self.parent = parent
        self.line = line
        self.text = ""
        self.tail = ""
        self.children: list[Node] = []

    @property
    def attrib(self) -> dict[str, str]:
        """The attributes, under the name that selector matching looks for."""
        return self.attributes

    def get(self, name: str, default: str | None = None) -> str | None:
        """An attribute as written."""
        return self.attributes.get(name, default)

    def __iter__(self) -> Iterator[Node]:
        return iter(self.children)

    def ancestors(self) -> Iterator[Node]:
        """Parents from the nearest to the root."""
        node = self.parent
        while node is not None:
            yield node
            node = node.parent

    @property
    def href(self) -> str:
        """The target of `href` or `xlink:href`, or ""."""
        return (self.attributes.get("href") or self.attributes.get(XLINK_HREF) or "").strip()


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """A parsed file: nodes in document order, the first node of each id, its size in bytes."""

    root: Node
    nodes: list[Node]
    by_id: dict[str, Node]
    source_bytes: int

    def target(self, reference: str) -> Node | None:
        """The node that `#id` names; None if there is none or it lies outside this file."""
        if not reference.startswith("#"):
            return None
        return self.by_id.get(reference[1:])


def read_document(source: Path | str | bytes, limits: Limits, notes: Notes) -> Document:
    """Parse a file or its bytes; `FormatError` with the line where it is broken or not SVG."""
    data = _load(source, limits)
    root, nodes = _light_tree(_parse(data), limits, notes)
    if root.name != "svg":
        raise FormatError(
            f"the outermost element is <{root.tag.rpartition('}')[2]}>, not <svg>",
            root.line,
            'an SVG file begins with <svg xmlns="http://www.w3.org/2000/svg">',
        )
    by_id: dict[str, Node] = {}
    for node in nodes:
        name = node.attributes.get("id")
        if name:
            by_id.setdefault(name, node)
    return Document(root, nodes, by_id, len(data))


def _load(source: Path | str | bytes, limits: Limits) -> bytes:
    """The bytes of the file, unpacked when it is gzip."""
    if isinstance(source, bytes):
        data = source
    else:
        try:
            with open(source, "rb") as file:
                data = file.read(limits.bytes + 1)
        except OSError as error:
            raise FormatError(f"cannot read {source}: {error.strerror or error}") from None
    if data[:2] == b"\x1f\x8b":
        data = _unpack(data, limits)
    if len(data) > limits.bytes:
        raise FormatError(f"the file has more than {limits.bytes:,} bytes, the limit for an SVG")
    if not data.strip():
        raise FormatError("the file is empty", 1)
    return data


def _unpack(data: bytes, limits: Limits) -> bytes:
    try:
        return zlib.decompressobj(wbits=31).decompress(data, limits.bytes + 1)
    except zlib.error as error:
        raise FormatError(f"the file is packed with gzip, but broken: {error}") from None


def _parse(data: bytes) -> etree._Element:
    from lxml import etree

    # libxml2 refuses texts over 10 MB unless told that they are welcome, which also lifts its guard
    # against entities; so only a long file that surely declares none is read that way.
    long_texts = len(data) > _LONG_TEXT and b"<!ENTITY" not in data and b"\0" not in data
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=long_texts,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        message, line, hint = _xml_trouble(error)
        raise FormatError(message, line, hint) from None
    except ValueError as error:
        raise FormatError(f"the file is not XML: {error}", 1) from None


def _xml_trouble(error: etree.XMLSyntaxError) -> tuple[str, int | None, str | None]:
    """Message, line and hint for what libxml2 said."""
    said = (error.msg or "not XML").splitlines()[0].split(", line ")[0].rstrip(".,")
    line = error.lineno or 1
    if "Excessive depth" in said:
        return "elements are nested more than 256 deep", line, "flatten the groups"
    if "amplification" in said or "entity" in said.lower():
        return f"entities are not read: {said}", line, "write the text out instead of the entity"
    return f"the XML is broken: {said}", line, None


def _light_tree(
    root_element: etree._Element, limits: Limits, notes: Notes
) -> tuple[Node, list[Node]]:
    """The lxml tree as nodes in document order, without recursion."""
    nodes: list[Node] = []
    pending: list[tuple[etree._Element, Node | None, int]] = [(root_element, None, 1)]
    while pending:
        element, parent, depth = pending.pop()
        line = cast("int | None", element.sourceline)
        tag: object = element.tag  # Entities have a function for a tag.
        if not isinstance(tag, str):
            notes.add("entity", "an entity was left out", line)
            _append_text(parent, element.tail or "")
            continue
        if depth > limits.depth:
            raise FormatError(f"elements are nested more than {limits.depth} deep", line)
        # Attribute keys and values are str: lxml is given bytes and gives back text.
        node = Node(tag, dict(element.attrib), parent, line)  # type: ignore[arg-type]
        node.text = element.text or ""
        node.tail = element.tail or ""
        if parent is not None:
            parent.children.append(node)
        nodes.append(node)
        if len(element):
            depth += 1
            pending.extend((child, node, depth) for child in reversed(element))
    return nodes[0], nodes


def _append_text(parent: Node | None, text: str) -> None:
    """Text behind a node that is left out goes to the end of what stands before it."""
    if parent is None:
        return
    if parent.children:
        parent.children[-1].tail += text
    else:
        parent.text += text
