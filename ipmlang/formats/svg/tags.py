"""Terminals as one short tag each, what many of them share said once around them.

Takes named elements and how far a point of each may be moved; gives lines of XML in which each can
be read by its id. An element whose numbers are shorter in the space that its file drew it in is
written in that space. The order of the lines says nothing.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape

import numpy as np

from ipmlang.formats.drawing import ARC, DrawnElement, Outline, Style
from ipmlang.formats.numbers import decimal_text, without_zero
from ipmlang.formats.svg.attributes import Linear, attributes_text, in_space, style_attributes
from ipmlang.formats.svg.definitions import Definitions, transform_text
from ipmlang.formats.svg.properties import INHERITED
from ipmlang.formats.svg.short_paths import short_path_texts
from ipmlang.formats.svg.style import neat
from ipmlang.formats.svg.transforms import determinant

Pairs = list[tuple[str, str]]

_DOUBLED = re.compile(r"#([0-9a-f])\1([0-9a-f])\2([0-9a-f])\3")
_NUMBERS = frozenset({"stroke-width", "stroke-dasharray", "stroke-dashoffset"})
_ROUND = 1e-12  # of the radius: where two are the same
_SIMILAR = 1e-9  # where a map keeps circles round
_PLAIN = (1.0, 0.0, 0.0, 1.0)
_MOST_ARCS = 4  # that programs make a whole ellipse of
_GROUP = len("<g>\n</g>\n")


@dataclass(frozen=True, slots=True)
class Tag:
    """One element as XML: its name, what it says of itself, and what it may inherit."""

    opening: str
    own: str
    shared: tuple[tuple[str, str], ...]


def tags_text(
    elements: Mapping[str, DrawnElement],
    allowed: Mapping[str, float],
    spaces: Mapping[str, Linear],
    definitions: Definitions,
) -> str:
    """The lines of all elements, each with its name as id.

    allowed: units, how far points may be moved; spaces: the linear part of the map that the file
    drew an element by, where it is known.
    """
    fragments: list[str] = []
    drawn: dict[str, DrawnElement] = {}
    for name, element in elements.items():
        if element.fragment is None:
            drawn[name] = element
        else:
            moved = transform_text(element.fragment.matrix)
            said = f' transform="{moved}"' if moved else ""
            xml = definitions.adopted(element.fragment.xml)
            fragments.append(f'<g id="{escape(name)}"{said}>{xml}</g>\n')
    return "".join(fragments) + _nested(_tags(drawn, allowed, spaces, definitions))


def _tags(
    elements: Mapping[str, DrawnElement],
    allowed: Mapping[str, float],
    spaces: Mapping[str, Linear],
    definitions: Definitions,
) -> list[Tag]:
    """The tags of outlines, each in the shorter of the spaces that it may be written in."""
    inner = {name: _unslanted(each) for name, each in elements.items()}
    pens = {name: each.style.stroke_matrix or _PLAIN for name, each in elements.items()}
    shapes = _shape_texts(inner, {name: allowed[name] / _size(pens[name]) for name in inner})
    found: dict[str, Tag] = {}
    for name, element in elements.items():
        pairs = style_attributes(element.style, definitions)
        found[name] = _tag(name, shapes[name], pairs)
    spaced = {
        name: moved
        for name, linear in spaces.items()
        if name in elements and (moved := _spaced(elements[name], linear, allowed[name]))
    }
    texts = _shape_texts(
        {name: element for name, (element, _) in spaced.items()},
        {name: allowed[name] / _size(linear) for name, (_, linear) in spaced.items()},
    )
    for name, (element, linear) in spaced.items():
        back = ("transform", transform_text((*linear, 0.0, 0.0)))
        made = _tag(name, texts[name], [back, *style_attributes(element.style, definitions)])
        if len(made.opening + made.own) < len(found[name].opening + found[name].own):
            found[name] = made
    return list(found.values())


def _unslanted(element: DrawnElement) -> DrawnElement:
    pen, outline = element.style.stroke_matrix, element.outline
    if pen is None or outline is None:
        return element
    return replace(element, outline=in_space(outline, pen))


def _tag(name: str, shape: str, pairs: Pairs) -> Tag:
    said = [(key, _short(key, value)) for key, value in pairs]
    own = [pair for pair in said if pair[0] not in INHERITED]
    shared = tuple(pair for pair in said if pair[0] in INHERITED)
    opening, _, rest = shape.partition(" ")
    return Tag(f'<{opening} id="{escape(name)}" {rest}', attributes_text(own) + "/>\n", shared)


def _short(name: str, value: str) -> str:
    """An attribute's value in fewer bytes."""
    if name in _NUMBERS:
        return ",".join(without_zero(word) for word in value.split(","))
    match = _DOUBLED.fullmatch(value)
    return f"#{match[1]}{match[2]}{match[3]}" if match else value


# ------------------------------------------------------------------------- shapes


def _shape_texts(
    elements: Mapping[str, DrawnElement], allowed: Mapping[str, float]
) -> dict[str, str]:
    """The element's name and its geometry: `circle r="5"`, else `path d="…"`."""
    known = {name: each.outline for name, each in elements.items() if each.outline is not None}
    found = {
        name: text
        for name, outline in known.items()
        if (text := _ellipse_text(outline, bool(elements[name].style.dashes)))
    }
    left = [name for name in known if name not in found]
    paths = short_path_texts([known[name] for name in left], [allowed[name] for name in left])
    found |= {name: f'path d="{text}"' for name, text in zip(left, paths, strict=True)}
    return {name: found.get(name, 'path d=""') for name in elements}


def _ellipse_text(outline: Outline, directed: bool) -> str:
    """A whole circle or ellipse about the origin; empty for all else. directed: start and direction
    show, so they must be those of SVG's.
    """
    coords = outline.coords
    if len(coords) > _MOST_ARCS or len(outline.starts) != 2 or not outline.closed[0]:
        return ""
    if not (outline.kind == ARC).all():
        return ""
    rx, ry = np.abs(coords[0, 1:3]).max(axis=1).tolist()
    sides = np.abs(coords[:, 1:3])
    upright = np.abs(sides - np.diag((rx, ry))).max() <= _ROUND * max(rx, ry)
    if np.abs(coords[:, 0]).max() > _ROUND * max(rx, ry) or not min(rx, ry) > 0 or not upright:
        return ""
    start, turn = coords[:, 3, 0], coords[:, 3, 1]
    going = np.abs(start[1:] - start[:-1] - turn[:-1]).max(initial=0) <= _ROUND
    if not (going and abs(abs(turn.sum()) - 2 * np.pi) <= _ROUND and abs(start[0]) <= _ROUND):
        return ""
    if directed and not (turn[0] > 0 and coords[0, 1, 0] > 0 and coords[0, 2, 1] > 0):
        return ""
    if abs(rx - ry) <= _ROUND * rx:
        return f'circle r="{without_zero(decimal_text(rx, 14))}"'
    x, y = (without_zero(decimal_text(value, 14)) for value in (rx, ry))
    return f'ellipse rx="{x}" ry="{y}"'


# ------------------------------------------------------------------------- spaces


def _spaced(
    element: DrawnElement, linear: Linear, allowed: float
) -> tuple[DrawnElement, Linear] | None:
    """The element as it is in a space, and the map out of that in as few digits as will do."""
    style, outline = element.style, element.outline
    if outline is None or not isinstance(style.fill, str) or not isinstance(style.stroke, str):
        return None
    if abs(determinant((*linear, 0.0, 0.0))) == 0 or not all(map(math.isfinite, linear)):
        return None
    written = _rounded(linear, outline, allowed / 4, style.stroke != "none")
    told = style
    if style.stroke != "none":
        pen = _pen(style, written)
        if pen is None:
            return None
        told = pen
    inner = in_space(outline, written)
    return replace(element, style=told, outline=inner), written


def _rounded(linear: Linear, outline: Outline, allowed: float, exact: bool) -> Linear:
    """The map with so many digits that no point is moved too far; with all of them if a pen hangs
    on it.
    """
    size = _size(linear)
    reach = float(np.abs(outline.coords[:, :3]).max()) or 1.0
    digits = 15 if exact else min(15, max(1, math.ceil(math.log10(2 * reach / allowed))))
    places = digits - 1 - math.floor(math.log10(size))
    a, b, c, d = (round(value, places) + 0.0 for value in linear)
    return a, b, c, d


def _size(linear: Linear) -> float:
    return max(map(abs, linear))


def _pen(style: Style, linear: Linear) -> Style | None:
    """The style with a pen that is what it was once it has been scaled; None if there is none."""
    a, b, c, d = linear
    size = a * a + b * b + c * c + d * d
    if style.stroke_matrix is not None or abs(a * c + b * d) > _SIMILAR * size:
        return None
    if abs(a * a + b * b - c * c - d * d) > _SIMILAR * size:
        return None
    if ("vector-effect", "non-scaling-stroke") in style.more:
        return style
    scale = math.hypot(a, b)
    values = [style.stroke_width, *style.dashes, style.dash_offset]
    found = [_scaled_back(value, scale) for value in values]
    known = [value for value in found if value is not None]
    if len(known) < len(values):
        return None
    return replace(style, stroke_width=known[0], dashes=tuple(known[1:-1]), dash_offset=known[-1])


def _scaled_back(value: float, scale: float) -> float | None:
    """The shortest number that comes back as the value when it is scaled."""
    for digits in range(1, 13):
        found = float(f"{value / scale:.{digits}g}")
        if neat(scale * found) == value:
            return found
    return None


# ------------------------------------------------------------------------- groups


def _nested(tags: Sequence[Tag]) -> str:
    """The tags as lines, what several have in common said once by a group around them."""
    holders: dict[tuple[str, str], list[int]] = {}
    for row, tag in enumerate(tags):
        for pair in tag.shared:
            holders.setdefault(pair, []).append(row)
    order = sorted(holders, key=lambda pair: -_saved(pair, len(holders[pair])))
    taken: set[int] = set()
    lines: list[str] = []
    for pair in order:
        rows = [row for row in holders[pair] if row not in taken]
        if _saved(pair, len(rows)) <= 0:
            continue
        taken.update(rows)
        inner = [replace(tags[row], shared=_without(tags[row].shared, pair)) for row in rows]
        said, text = _merged(pair, _nested(inner))
        lines.append(f"<g{said}>\n{text}</g>\n")
    left = (tag for row, tag in enumerate(tags) if row not in taken)
    lines += [f"{tag.opening}{attributes_text(tag.shared)}{tag.own}" for tag in left]
    return "".join(lines)


def _merged(pair: tuple[str, str], text: str) -> tuple[str, str]:
    """The attributes of a group, those of an only group in it too, and what is in it."""
    said = attributes_text([pair])
    if text.startswith("<g ") and text.find("</g>\n") == len(text) - 5:
        inner, _, rest = text[2:-5].partition(">\n")
        return said + inner, rest
    return said, text


def _saved(pair: tuple[str, str], count: int) -> int:
    """Characters that a group with an attribute spares."""
    return (count - 1) * (len(pair[0]) + len(pair[1]) + 4) - _GROUP


def _without(
    pairs: tuple[tuple[str, str], ...], pair: tuple[str, str]
) -> tuple[tuple[str, str], ...]:
    return tuple(each for each in pairs if each != pair)
