"""Names for what was found: from ids, groups and classes of the file where it has any, else words
for shapes and arrangements.

Takes hints and kinds; gives words that the language allows as names, each once. Assets are small
letters, rules begin with a capital.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from xml.sax.saxutils import unescape

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.tokens import is_free_name
from ipmlang.formats.drawing import ARC, LINE, Fragment, Outline

LONGEST = 24
DIGITS = 6  # of a text that is a number
MOST_ROUNDED = 8  # sides and bends of a rounded rectangle
BETWEEN = re.compile(r"\W+", re.ASCII)
MARKS = re.compile(r"<[^>]*>")
DEFINED = re.compile(r"<defs>.*</defs>", re.DOTALL)
# What says nothing: kinds of elements, and what programs number by themselves.
GENERAL = re.compile(
    r"(path|g|rect|use|svg|layer|group|circle|line|line2d|polyline|polygon|ellipse|rectangle|text"
    r"|tspan|image|vector|shape|object|st|cls|fil|str|xmlid|surface)[\d_]*|(patch|frame)_?\d+"
)
TAKEN = frozenset({"i", "n", "r", "e", "pi", "split", "here"})
POLYGONS = {3: "triangle", 4: "quad", 5: "pentagon", 6: "hexagon", 8: "octagon", 10: "decagon"}


class Names:
    """Gives out names, never one twice."""

    def __init__(self) -> None:
        self._given: Counter[str] = Counter()

    def copy(self) -> Names:
        """The same names as given, to go on from."""
        made = Names()
        made._given = self._given.copy()
        return made

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

    >>> word("us-Star 12"), word("07"), word("path1234"), word("cls-1"), word("patch")
    ('us_star_12', '', '', '', 'patch')
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


def text_word(fragment: Fragment) -> str:
    """What a text says as a name in small letters, empty if it says too much or nothing.

    >>> text_word(Fragment("text", "<text>North <tspan>Wing</tspan></text>", (1, 0, 0, 1, 0, 0)))
    'north_wing'
    >>> text_word(Fragment("text", "<text>20 %</text>", (1, 0, 0, 1, 0, 0)))
    'text20'
    >>> text_word(Fragment("text", "<text>E</text>", (1, 0, 0, 1, 0, 0)))
    'letter_e'
    """
    said = unescape(MARKS.sub(" ", DEFINED.sub("", fragment.xml)))
    number = BETWEEN.sub("", said)
    if number.isdecimal() and len(number) <= DIGITS:
        return f"text{number}"
    plain = word(said)
    return f"letter_{plain}" if len(plain) == 1 else plain


def shape_word(kind: str, outline: Outline | None, fragment: Fragment | None) -> str:
    """What a person would call a shape, or a fragment: a text by what it says."""
    if outline is None:
        said = fragment is not None and fragment.kind == "text" and text_word(fragment)
        return said or word("" if fragment is None else fragment.kind) or "text"
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
    if outline.closed.all() and len(outline.starts) == 2:
        return _rounded(outline)
    return "arc" if len(outline.kind) == 1 and outline.kind[0] == ARC else "curve"


def _polygon(outline: Outline) -> str:
    sides = len(outline.kind)
    if sides == 4:
        edges = outline.coords[:, 1] - outline.coords[:, 0]
        turned = np.abs(np.sum(edges * np.roll(edges, -1, axis=0), axis=1))
        long = np.hypot(edges[:, 0], edges[:, 1])
        if (turned <= _room(edges)).all():
            return "square" if np.ptp(long) <= 1e-6 * long.max() else "rect"
    return _cornered(outline.coords[:, 0], sides) if sides > 4 else POLYGONS.get(sides, "outline")


def _cornered(corners: NDArray[np.float64], sides: int) -> str:
    """A polygon by its corners (k, 2): a `star` has every second one inward, or goes around more
    than once; what is else not convex is an `outline`.
    """
    edges = np.roll(corners, -1, axis=0) - corners
    ahead = np.roll(edges, -1, axis=0)
    across = edges[:, 0] * ahead[:, 1] - edges[:, 1] * ahead[:, 0]
    sign = np.where(np.abs(across) <= _room(edges), 0.0, np.sign(across))
    if (sign * sign[0] < 0).any():
        pointed = sides % 2 == 0 and np.ptp(sign[::2]) == np.ptp(sign[1::2]) == 0 and sign.all()
        return "star" if pointed else "outline"
    turned = np.arctan2(across, np.sum(edges * ahead, axis=1)).sum()
    return "star" if abs(turned) > 3 * np.pi else POLYGONS.get(sides, "outline")


def _rounded(outline: Outline) -> str:
    """A closed outline with bends: `rect` if four sides at right angles have a bend at each corner,
    a `pill` if two alike ones have, a `sector` if one bend joins two straight lines.
    """
    straight = outline.kind == LINE
    edges = (outline.coords[:, 1] - outline.coords[:, 0])[straight]
    apart = not (straight & np.roll(straight, 1)).any() and len(straight) <= MOST_ROUNDED
    if apart and len(edges) == 4:
        turned = np.abs(np.sum(edges * np.roll(edges, -1, axis=0), axis=1))
        return "rect" if (turned <= _room(edges)).all() else "curve"
    if apart and len(edges) == 2:
        back = float(np.hypot(*(edges[0] + edges[1])))
        return "pill" if back <= 1e-6 * float(np.hypot(*edges[0])) else "curve"
    return "sector" if len(straight) == 3 and len(edges) == 2 else "curve"


def _room(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """What products of neighbouring edges (k, 2) may be off."""
    long = np.hypot(edges[:, 0], edges[:, 1])
    return np.asarray(1e-6 * long * np.roll(long, -1), np.float64)


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
