"""How many elements a drawing would have, counted before any is made.

Every subtree is counted once, whatever refers to it, so the work is linear in the file even where a
few `use` elements mean 2^30 copies. Markers are not counted here; the walk counts as it goes.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.formats import FormatError
from ipmlang.formats.svg.conditions import chosen
from ipmlang.formats.svg.context import Source
from ipmlang.formats.svg.shapes import SHAPES
from ipmlang.formats.svg.xml import Node

CARRIED = frozenset({"text", "image", "foreignObject"})
GROUPS = frozenset({"g", "a", "svg", "symbol"})


@dataclass(frozen=True, slots=True)
class Count:
    """What counting found: nodes that draw nothing, and whether something refers to itself (then no
    count is sure, and no node is called empty).
    """

    empty: frozenset[Node]
    cyclic: bool


def count_elements(source: Source, root: Node) -> Count:
    """`FormatError`, naming the place, if `root` means more elements than the limits allow."""
    limit = source.limits.elements
    counts: dict[Node, int] = {}
    under_way: set[Node] = set()
    cyclic = False
    pending = [root]
    while pending:
        node = pending[-1]
        if node in counts:
            pending.pop()
            continue
        parts = _parts(source, node)
        if node not in under_way:
            under_way.add(node)
            missing = [part for part in parts if part not in counts and part not in under_way]
            if missing:
                pending.extend(missing)
                continue
        # What is not counted here refers back to itself: it will not be drawn again.
        cyclic = cyclic or any(part not in counts for part in parts)
        drawn = 1 if node.name in SHAPES or node.name in CARRIED else 0
        counts[node] = total = drawn + sum(counts.get(part, 0) for part in parts)
        if total > limit:
            raise _too_many(node, total, limit)
        pending.pop()
    empty = (node for node, count in counts.items() if not count and _parts(source, node))
    return Count(frozenset() if cyclic else frozenset(empty), cyclic)


def _parts(source: Source, node: Node) -> list[Node]:
    """What is drawn where `node` is drawn."""
    if source.cascade.specified(node).get("display") == "none":
        return []
    if node.name in GROUPS:
        return [child for child in node.children if child.name != "symbol"]
    if node.name == "switch":
        return chosen(node)
    if node.name == "use":
        target = source.document.target(node.href)
        return [] if target is None else [target]
    return []


def _too_many(node: Node, total: int, limit: int) -> FormatError:
    name = node.attributes.get("id")
    label = f'<{node.name} id="{name[:40]}">' if name else f"<{node.name}>"
    return FormatError(
        f"{label} would draw {total:,} elements; the limit is {limit:,}",
        node.line,
        "nested `use` elements multiply",
    )
