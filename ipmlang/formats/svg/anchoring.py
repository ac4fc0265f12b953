"""Where a text or an image begins, apart from what it shows: equal labels are equal wherever they
stand, and whichever program wrote their places as attributes instead of as transforms.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from decimal import Decimal, InvalidOperation

from ipmlang.formats.svg.units import words
from ipmlang.formats.svg.xml import Node

PLACES = ("x", "y")
_ANCHORED = frozenset({"text", "image"})
_MOVING = frozenset({"text", "tspan", "a", "title", "desc", "image"})  # what is known to go along
_LARGEST = Decimal("1e9")  # beyond, a place is no place

Anchor = tuple[Decimal, Decimal]


def anchor(node: Node, own: Mapping[str, str], sized: Callable[[str, str], str]) -> Anchor | None:
    """Where a text or an image begins in its own space; None where it begins at the origin, or
    where something in it would stay behind if it moved. own: its style, for places given there;
    sized: an attribute's value by its name and text, percentages as numbers.
    """
    if node.name not in _ANCHORED or any(name in own for name in PLACES):
        return None
    pending = [node]
    while pending:
        one = pending.pop()
        if one.name not in _MOVING:
            return None
        for name in PLACES:
            if any(_number(word) is None for word in words(sized(name, one.get(name) or ""))):
                return None
        pending.extend(one.children)
    x, y = (_first(sized(name, node.get(name) or "")) for name in PLACES)
    return (x, y) if x or y else None


def moved(value: str, by: Decimal) -> str:
    """The places of an attribute, by so much nearer to the origin.

    >>> moved("40.1, 52", Decimal("30.1"))
    '10 21.9'
    """
    return " ".join(_shown(Decimal(word) - by) for word in words(value))


def _first(value: str) -> Decimal:
    own = words(value)
    return Decimal(own[0]) if own else Decimal(0)


def _number(word: str) -> Decimal | None:
    try:
        value = Decimal(word)
    except InvalidOperation:
        return None
    return value if value.is_finite() and abs(value) < _LARGEST else None


def _shown(value: Decimal) -> str:
    return format(value.normalize() if value else Decimal(0), "f")
