"""The XML of DAE files: bounded, without entities or network, and found by local names.

Takes the bytes of a file; gives its root and the elements that references name. What a
`FormatError` says names the line. Nothing here knows what the elements mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError

if TYPE_CHECKING:
    from lxml.etree import _Element


def open_dae(data: bytes) -> _Element:
    """The root of a DAE file."""
    from lxml import etree

    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, huge_tree=True, remove_comments=True
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise FormatError(f"the file is no XML: {error.msg}", error.lineno) from error
    if local_name(root) != "COLLADA":
        raise FormatError("this is no DAE file: it does not begin with `<COLLADA>`")
    return root


def local_name(node: _Element) -> str:
    """The name of an element without its namespace, nothing for what is no element."""
    return node.tag.rpartition("}")[2] if isinstance(node.tag, str) else ""


def children(node: _Element, name: str) -> Iterator[_Element]:
    """The children of that name."""
    return (each for each in node if local_name(each) == name)


def first(node: _Element, *names: str) -> _Element | None:
    """The first child of the first name, its first child of the second, and so on."""
    found: _Element | None = node
    for name in names:
        found = None if found is None else next(children(found, name), None)
    return found


def descend(node: _Element, *names: str) -> str | None:
    """The text of what `first` finds."""
    found = first(node, *names)
    return None if found is None else found.text


def indexed(root: _Element) -> dict[str, _Element]:
    """All elements with an id, by it."""
    found: dict[str, _Element] = {}
    for each in root.iter():
        name = each.get("id") if isinstance(each.tag, str) else None
        if name:
            found.setdefault(name, each)
    return found


def target(node: _Element, by_id: dict[str, _Element]) -> _Element | None:
    """What an element's `url` names within the file."""
    url = node.get("url", "")
    return by_id.get(url[1:]) if url.startswith("#") else None


def numbers(node: _Element, count: int | None = None) -> NDArray[np.float64]:
    """The numbers in an element, as many as are asked for."""
    try:
        found = np.array((node.text or "").split(), dtype=np.float64)
    except ValueError:
        raise wrong(node, "holds something that is no number") from None
    if count is not None and len(found) != count:
        raise wrong(node, f"holds {len(found)} numbers, not {count}")
    return found


def whole_numbers(node: _Element) -> NDArray[np.int64]:
    """The whole numbers in an element."""
    try:
        return np.array((node.text or "").split(), dtype=np.int64)
    except (ValueError, OverflowError):
        raise wrong(node, "holds something that is no whole number") from None


def wrong(node: _Element, what: str) -> FormatError:
    """What is wrong with an element, with its line."""
    line = cast("int | None", node.sourceline)
    return FormatError(f"`<{local_name(node)}>` {what}", line)
