"""Whether two elements look alike apart from their geometry: styles, fragments, group effects.

In come values of `formats.drawing`, out come truth values. Numbers agree within 1e-6 of their size
wherever they stand, what cannot be seen (the width of no stroke) is left out, and the ids inside
carried XML may differ, since they are only names. Clips alone are compared by their outlines.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ipmlang.formats.drawing import (
    ARC,
    Drawing,
    Effect,
    Fragment,
    Outline,
    Paint,
    PaintServer,
    Style,
)
from ipmlang.inverse.clips import placed_clip
from ipmlang.inverse.distance import pair_distances
from ipmlang.inverse.lsystem.curves import stack

RELATIVE = 1e-6
# Colours and references (#1e3a5f, #clip2) and names with digits are words, not numbers.
TOKEN = re.compile(r"(#[\w-]+|[A-Za-z_]{2,}[\w-]*)|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
# An attribute in single quotes, as one in double quotes would be written.
QUOTED = re.compile(r"='([^'<>]*\"[^'<>]*)'")
DEFINED = re.compile(r"""\bid\s*=\s*["']([^"']+)["']""")
# Attributes of a group that look the same in any space; `style` holds blending alone.
SPACELESS = frozenset({"opacity", "style"})
Matrix = tuple[float, float, float, float, float, float]


def same_style(a: Style, b: Style, unit: float) -> bool:
    """Whether two styles draw the same, group effects aside. unit: the drawing's diagonal.

    >>> same_style(Style(stroke_width=1), Style(stroke_width=2), 100.0)  # nothing is stroked
    True
    """
    if not same_paint(a.fill, b.fill, unit) or not same_paint(a.stroke, b.stroke, unit):
        return False
    stroked, filled = a.stroke != "none", a.fill != "none"
    if stroked and not _same_pen(a, b):
        return False
    left, right = (_visible(each.more, stroked, filled) for each in (a, b))
    return len(left) == len(right) and all(
        x[0] == y[0] and same_text(x[1], y[1]) for x, y in zip(left, right, strict=True)
    )


def _same_pen(a: Style, b: Style) -> bool:
    plain = (1.0, 0.0, 0.0, 1.0)
    ends = (a.dash_offset, b.dash_offset) if a.dashes else (0.0, 0.0)
    return (
        near([a.stroke_width, ends[0]], [b.stroke_width, ends[1]])
        and near(a.dashes, b.dashes)
        and same_matrix(
            (*(a.stroke_matrix or plain), 0.0, 0.0), (*(b.stroke_matrix or plain), 0.0, 0.0), 1.0
        )
    )


def _visible(
    more: tuple[tuple[str, str], ...], stroked: bool, filled: bool
) -> list[tuple[str, str]]:
    """Properties that show, given what is painted."""
    hidden = [name for name, shows in (("stroke", stroked), ("fill", filled)) if not shows]
    return sorted(pair for pair in more if not pair[0].startswith(tuple(hidden)))


def same_paint(a: Paint, b: Paint, unit: float) -> bool:
    """Whether two paints are one colour or one gradient or pattern in one place."""
    if isinstance(a, PaintServer) and isinstance(b, PaintServer):
        same = a.kind == b.kind and same_matrix(a.matrix, b.matrix, unit)
        return same and same_text(a.xml, b.xml)
    return not isinstance(a, PaintServer) and not isinstance(b, PaintServer) and _text_equal(a, b)


def _text_equal(a: str, b: str) -> bool:
    return a.strip().lower() == b.strip().lower()


def same_fragment(a: Fragment | None, b: Fragment | None) -> bool:
    """Whether two fragments show the same; where is compared apart, by `same_matrix`."""
    if a is None or b is None:
        return a is b
    return a.kind == b.kind and same_text(*(_renamed([each.xml]) for each in (a, b)))


def same_matrix(a: Matrix, b: Matrix, unit: float) -> bool:
    """Whether two maps differ by less than 1e-6, of their size and of the diagonal."""
    size = max(abs(value) for value in a[:4]) or 1.0
    linear = all(abs(x - y) <= RELATIVE * size for x, y in zip(a[:4], b[:4], strict=True))
    return linear and all(abs(x - y) <= RELATIVE * unit for x, y in zip(a[4:], b[4:], strict=True))


def same_effects(
    a: Drawing, b: Drawing, left: Sequence[str], right: Sequence[str], unit: float
) -> bool:
    """Whether two stacks of effects, keys into their drawings, do the same."""
    return len(left) == len(right) and all(
        _same_effect(a.effects.get(x), b.effects.get(y), unit)
        for x, y in zip(left, right, strict=True)
    )


def _same_effect(a: Effect | None, b: Effect | None, unit: float) -> bool:
    if a is None or b is None:
        return a is b
    texts = [
        _renamed([each.definitions, *(part for pair in sorted(each.attributes) for part in pair)])
        for each in (a, b)
    ]
    placed = is_spaceless(a) or same_matrix(a.matrix, b.matrix, unit)
    return (placed and same_text(*texts)) or _same_clip(a, b, unit)


def _same_clip(a: Effect, b: Effect, unit: float) -> bool:
    """Whether two effects only clip, and to the same shape, however it is written."""
    one, other = placed_clip(a), placed_clip(b)
    if one is None or other is None or one[1] != other[1]:
        return False
    if _same_corners(one[0], other[0], RELATIVE * unit):
        return True
    fixed = np.zeros(1, np.bool_)
    error = pair_distances(stack([one[0]]), stack([other[0]]), fixed, unit)
    return bool(error[0] <= RELATIVE * unit)


def _same_corners(a: Outline, b: Outline, near: float) -> bool:
    """Whether outlines of the same segments have their points near each other, and so their curves;
    an arc has other numbers than points.
    """
    if len(a.kind) != len(b.kind) or (a.kind != b.kind).any() or (a.kind == ARC).any():
        return False
    same = np.array_equal(a.starts, b.starts) and np.array_equal(a.closed, b.closed)
    return same and bool(np.abs(a.coords - b.coords).max(initial=0.0) <= near / 2)


def is_spaceless(effect: Effect) -> bool:
    """Whether nothing about an effect depends on the space of its group."""
    return all(name in SPACELESS for name, _ in effect.attributes)


def _renamed(texts: Sequence[str]) -> str:
    """The texts as one, with the ids they define replaced by their order of appearance."""
    whole = QUOTED.sub(lambda match: '="' + match[1].replace('"', "&quot;") + '"', "\n".join(texts))
    names = list(dict.fromkeys(DEFINED.findall(whole)))
    if not names:
        return whole
    order = {name: f"id{number}" for number, name in enumerate(names)}
    # Only whole names, as ids or behind a '#': a colour or a word that looks alike stays.
    known = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    pattern = re.compile(rf"""(\bid\s*=\s*["']|#)({known})(?=["')\s]|$)""")
    return pattern.sub(lambda match: match[1] + order[match[2]], whole)


def same_text(a: str, b: str) -> bool:
    """Whether two texts agree, the numbers in them within 1e-6 of their size.

    >>> same_text("translate(1.0 2)", "translate(1 2.0000001)")
    True
    """
    if a == b:
        return True
    (words, numbers), (others, values) = _parsed(a), _parsed(b)
    return words == others and near(numbers, values)


def _parsed(text: str) -> tuple[list[str], list[float]]:
    """What stands between the numbers, blanks apart, and the numbers."""
    numbers = [float(match[2]) for match in TOKEN.finditer(text) if match[2]]
    marked = TOKEN.sub(lambda match: match[1] or "\0", text)
    return marked.split(), numbers


def near(a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether two sequences of numbers agree within 1e-6 of their size."""
    return len(a) == len(b) and all(
        abs(x - y) <= RELATIVE * max(abs(x), abs(y)) + 1e-12 for x, y in zip(a, b, strict=True)
    )
