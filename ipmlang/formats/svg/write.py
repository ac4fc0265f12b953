"""Drawings as SVG text: one tag an element, in paint order, with its style.

Takes a `Drawing`; gives the whole file as text, the same bytes for the same drawing. Coordinates
are absolute and rounded to 1e-10 of the diagonal, so that errors do not add up. Never touches the
disk: `ipmlang.formats.atomic` does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.drawing import ARC, Drawing, DrawnElement, Outline
from ipmlang.formats.numbers import decimals_for, joined
from ipmlang.formats.svg.attributes import attributes_text, in_space, style_attributes
from ipmlang.formats.svg.definitions import Definitions, matrix_text
from ipmlang.formats.svg.path_data import path_texts
from ipmlang.formats.svg.transforms import IDENTITY, inverse, is_usable

Box = tuple[float, float, float, float]

_MARGIN = 0.02
_BATCH = 50_000
_XLINK = ' xmlns:xlink="http://www.w3.org/1999/xlink"'
_HEAD = f'<svg xmlns="http://www.w3.org/2000/svg"{_XLINK}{{size}}>\n'
# Effects that do not depend on the space of their group.
_SPACELESS = frozenset({"opacity", "mix-blend-mode", "isolation", "style"})


def write_svg(drawing: Drawing) -> str:
    """The SVG file of a drawing.

    >>> coords = np.zeros((1, 4, 2))
    >>> coords[0, 1] = 4, 3
    >>> line = Outline(np.ones(1, np.uint8), coords, np.array([0, 1]), np.array([False]))
    >>> from ipmlang.formats.drawing import Style
    >>> text = write_svg(Drawing((DrawnElement(line, Style(stroke="#ff0000")),), (0, 0, 4, 3)))
    >>> text.splitlines()[1]
    '<path d="M0 0L4 3" stroke="#ff0000"/>'
    """
    return write_groups(drawing, {})


def write_groups(
    drawing: Drawing,
    runs: Mapping[str, int],
    head: str = "",
    definitions: Definitions | None = None,
) -> str:
    """The SVG file of a drawing whose first elements form groups with ids: `runs` says how many
    each. `head` is XML that goes before them (metadata, say), `definitions` what that refers to.
    """
    box = drawing.box if drawing.box is not None else fitted_box(drawing.elements)
    if not all(map(math.isfinite, box)):
        raise FormatError("the drawing has a box without a value")
    definitions = Definitions() if definitions is None else definitions
    tags = _tags(drawing.elements, decimals_for(math.hypot(box[2], box[3])), definitions)
    body: list[str] = []
    start = 0
    for name, count in runs.items():
        inner = _grouped(drawing, tags, range(start, start + count), definitions)
        body.append(f'<g id="{escape(name)}">\n{inner}</g>\n')
        start += count
    body.append(_grouped(drawing, tags, range(start, len(tags)), definitions))
    opening = _HEAD.format(size=_size(drawing, box))
    text = "".join([definitions.text(), head, *body, "</svg>\n"])
    if definitions.short and "xlink:" not in text:
        opening = opening.replace(_XLINK, "")
    return opening + text


def fitted_box(elements: Sequence[DrawnElement]) -> Box:
    """The box of what is drawn (curves by their handles), pens included, and a margin."""
    corners = [np.zeros((0, 2))]
    corners += [np.array([each.fragment.matrix[4:]]) for each in elements if each.fragment]
    drawn = [each for each in elements if each.outline is not None and len(each.outline.kind)]
    for start in range(0, len(drawn), _BATCH):
        corners += _corners(drawn[start : start + _BATCH])
    points = np.concatenate(corners)
    if not len(points):
        return (0.0, 0.0, 1.0, 1.0)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * (float((high - low).max()) or 1.0)
    x, y = (low - margin).tolist()
    width, height = (high - low + 2 * margin).tolist()
    return (x, y, width, height)


def _corners(drawn: Sequence[DrawnElement]) -> list[NDArray[np.float64]]:
    """Points (m, 2) whose box contains elements: their lowest and highest ones."""
    outlines = [each.outline for each in drawn if each.outline is not None]
    kind = np.concatenate([outline.kind for outline in outlines])
    coords = np.concatenate([outline.coords for outline in outlines])
    pens = [each.style.stroke_width / 2 * (each.style.stroke != "none") for each in drawn]
    pen = np.repeat(pens, [len(outline.kind) for outline in outlines])[:, None]
    # Ends and handles of lines and curves; the box of the whole ellipse for arcs.
    used = np.arange(4) <= kind[:, None]
    reach = np.hypot(coords[:, 1], coords[:, 2])
    arc, used = kind[:, None] == ARC, used[:, :, None]
    low = np.where(used, coords, np.inf).min(axis=1)
    high = np.where(used, coords, -np.inf).max(axis=1)
    low = np.where(arc, coords[:, 0] - reach, low) - pen
    high = np.where(arc, coords[:, 0] + reach, high) + pen
    return [low.min(axis=0)[None], high.max(axis=0)[None]]


def _size(drawing: Drawing, box: Box) -> str:
    written = ((name, getattr(drawing, name)) for name in ("width", "height"))
    sizes = "".join(f' {name}="{escape(value)}"' for name, value in written if value is not None)
    return f'{sizes} viewBox="{joined(box)}"'


def _tags(elements: Sequence[DrawnElement], decimals: int, definitions: Definitions) -> list[str]:
    """The tag of each element, empty where there is nothing to draw."""
    tags: list[str] = []
    # Styles are shared objects as a rule: looking them up by identity is quicker than by value.
    styles: dict[int, str] = {}
    for element, path in zip(elements, _path_list(elements, decimals), strict=True):
        if element.fragment is not None:
            tags.append(definitions.fragment(element.fragment))
            continue
        style = element.style
        text = styles.get(id(style))
        if text is None:
            text = styles[id(style)] = attributes_text(style_attributes(style, definitions))
        tags.append(f"{path}{text}/>" if path else "")
    return tags


def _path_list(elements: Sequence[DrawnElement], decimals: int) -> list[str]:
    """The opening of each element's tag, `<path d="…"`, empty where there is no outline."""
    heads = [""] * len(elements)
    plain: list[int] = []
    slanted: list[int] = []
    outlines: list[Outline] = []
    inner: list[Outline] = []
    for index, element in enumerate(elements):
        outline, pen = element.outline, element.style.stroke_matrix
        if outline is None:
            continue
        if pen is not None:
            slanted.append(index)
            inner.append(in_space(outline, pen))
            continue
        plain.append(index)
        outlines.append(outline)
    _place(heads, plain, path_texts(outlines, decimals))
    _place(heads, slanted, path_texts(inner, decimals + 1))
    return heads


def _place(heads: list[str], indices: list[int], texts: Iterable[str]) -> None:
    for index, text in zip(indices, texts, strict=True):
        heads[index] = f'<path d="{text}"' if text else ""


def _grouped(drawing: Drawing, tags: list[str], which: range, definitions: Definitions) -> str:
    """The tags line by line, runs with the same effects wrapped in one group."""
    lines: list[str] = []
    open_groups: tuple[str, ...] = ()
    closers: list[str] = []
    for index in which:
        tag = tags[index]
        if not tag:
            continue
        wanted = drawing.elements[index].style.effects
        if wanted != open_groups:
            shared = _shared(open_groups, wanted)
            lines += reversed(closers[shared:])
            del closers[shared:]
            for name in wanted[shared:]:
                opener, closer = _group_tags(drawing, name, definitions)
                lines.append(opener)
                closers.append(closer)
            open_groups = wanted
        lines.append(tag)
    lines += reversed(closers)
    return "\n".join(lines) + "\n" if lines else ""


def _shared(first: tuple[str, ...], second: tuple[str, ...]) -> int:
    count = 0
    for one, other in zip(first, second, strict=False):
        if one != other:
            break
        count += 1
    return count


def _group_tags(drawing: Drawing, name: str, definitions: Definitions) -> tuple[str, str]:
    """Opening and closing tags of an effect. Where the effect lives in a space of its own, the
    group takes that space and an inner group leads back to the drawing's.
    """
    effect = drawing.effects.get(name)
    if effect is None:
        raise FormatError(f"the drawing has no effect called `{name}`")
    attributes = definitions.group(effect)
    spaceless = all(attribute in _SPACELESS for attribute, _ in effect.attributes)
    if spaceless or effect.matrix == IDENTITY or not is_usable(effect.matrix):
        return f"<g{attributes}>", "</g>"
    back = inverse(effect.matrix)
    own = f'<g transform="{matrix_text(effect.matrix)}"{attributes}>'
    return f'{own}<g transform="{matrix_text(back)}">', "</g></g>"
