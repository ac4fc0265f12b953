"""Names for what was found: from ids, groups and classes of the file where it has any, else words
for shapes and arrangements.

Takes hints and kinds; gives words that the language allows as names, each once. Assets are small
letters, rules begin with a capital.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.tokens import is_free_name
from ipmlang.formats.drawing import ARC, LINE, Outline

LONGEST = 24
BETWEEN = re.compile(r"\W+", re.ASCII)
GENERAL = re.compile(r"(path|g|rect|use|svg|layer|group|circle|line)[\d_]*")  # says nothing
TAKEN = frozenset({"i", "n", "r", "e", "pi", "split", "here"})
POLYGONS = {3: "triangle", 4: "quad", 5: "pentagon", 6: "hexagon", 8: "octagon", 10: "star"}


class Names:
    """Gives out names, never one twice."""

    def __init__(self) -> None:
        self._given: Counter[str] = Counter()

    def give(self, wish: str) -> str:
        """The wished name, with a number where it is taken.

        >>> names = Names()
        >>> names.give("leaf"), names.give("leaf"), names.give("at")
        ('leaf', 'leaf_2', 'at_1')
        """
        self._given[wish] += 1
        count = self._given[wish]
        name = wish if count == 1 and _free(wish) else f"{wish}_{count}"
        if name != wish and self._given[name]:
            return self.give(wish)
        if name != wish:
            self._given[name] += 1
        return name


def _free(name: str) -> bool:
    return is_free_name(name) and name not in OPERATIONS and name not in TAKEN


def word(text: str) -> str:
    """An id or class as a name in small letters, empty if nothing is left of it.

    >>> word("us-Star 12"), word("07"), word("path1234")
    ('us_star_12', '', '')
    """
    plain = BETWEEN.sub("_", text).strip("_").lower()
    if not plain or not plain[0].isalpha() or len(plain) > LONGEST:
        return ""
    return "" if GENERAL.fullmatch(plain) else plain


def capital(name: str) -> str:
    """A rule's name: `leaf_row` as `LeafRow`.

    >>> capital("us_star")
    'UsStar'
    """
    return "".join(part[:1].upper() + part[1:] for part in name.split("_") if part)


def shape_word(kind: str, outline: Outline | None, fragment: str | None) -> str:
    """What a person would call a shape."""
    if outline is None:
        return word(fragment or "") or "text"
    if kind == "ellipse":
        u, v = outline.coords[0, 1], outline.coords[0, 2]
        even = abs(float(np.hypot(*u) - np.hypot(*v))) <= 1e-9 * float(np.hypot(*u))
        return "circle" if even else "ellipse"
    if kind in ("line", "point"):
        return "line" if kind == "line" else "dot"
    if len(outline.starts) > 2:
        return "shape"
    if (outline.kind == LINE).all():
        if not outline.closed.all():
            return "polyline"
        return _polygon(outline)
    return "arc" if len(outline.kind) == 1 and outline.kind[0] == ARC else "curve"


def _polygon(outline: Outline) -> str:
    sides = len(outline.kind)
    if sides == 4:
        edges = outline.coords[:, 1] - outline.coords[:, 0]
        turned = np.abs(np.sum(edges * np.roll(edges, -1, axis=0), axis=1))
        long = np.hypot(edges[:, 0], edges[:, 1])
        if (turned <= 1e-6 * long * np.roll(long, -1)).all():
            return "square" if np.ptp(long) <= 1e-6 * long.max() else "rect"
    return POLYGONS.get(sides, "outline")


def own_hint(source: tuple[str, ...], above: int) -> str:
    """The last usable id or class of an element, or of a group that not everything stands in."""
    return next(filter(None, map(word, reversed(source[above:]))), "")


def shared_hint(sources: Sequence[tuple[str, ...]], above: int) -> str:
    """The innermost group that all of these elements stand in, empty if it says nothing. above:
    how many outer groups the whole drawing stands in.
    """
    shared = shared_groups(sources)
    return next(filter(None, map(word, reversed(shared[above:]))), "")


def shared_groups(sources: Sequence[tuple[str, ...]]) -> tuple[str, ...]:
    """The names that all sources begin with."""
    shared = sources[0] if sources else ()
    for source in sources[1:]:
        same = 0
        while same < min(len(shared), len(source)) and shared[same] == source[same]:
            same += 1
        shared = shared[:same]
    return shared
