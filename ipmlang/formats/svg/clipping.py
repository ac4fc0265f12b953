"""Which viewports really clip: where all that one holds lies within it, pens included, its clip
can go.

Takes what was placed and its outlines in the world; gives the (wrap, element) pairs that can go. A
viewport is kept or dropped whole, since copies of one symbol should stay alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import Floats, Outline, Style
from ipmlang.formats.svg.bounds import (
    place,
    segment_boxes,
    segment_ends,
    segment_tangents,
    transform_segments,
)
from ipmlang.formats.svg.context import Placed, Wrap
from ipmlang.formats.svg.paths import parse_path
from ipmlang.formats.svg.transforms import inverse
from ipmlang.formats.svg.units import number

_MITRE_LIMIT = 4.0
_SLACK = 1e-9


def needless_clips(
    placed: Sequence[Placed], outlines: Sequence[Outline | None]
) -> set[tuple[Wrap, int]]:
    """Pairs of a viewport's wrap and the index of an element, where it clips nothing."""
    held: dict[Wrap, list[int]] = {}
    for index, one in enumerate(placed):
        for wrap in one.wraps:
            if wrap.viewport is not None:
                held.setdefault(wrap, []).append(index)
    tips = _tips(placed, outlines, {index for indices in held.values() for index in indices})
    needless: set[tuple[Wrap, int]] = set()
    for wrap, indices in held.items():
        inside = _within(wrap, indices, placed, outlines, tips)
        if len(inside) == len(indices):
            needless.update((wrap, index) for index in indices)
    return needless


def _within(
    wrap: Wrap,
    indices: list[int],
    placed: Sequence[Placed],
    outlines: Sequence[Outline | None],
    tips: _Tips,
) -> list[int]:
    """The elements that lie within the viewport of a wrap."""
    shapes = [
        (index, shape)
        for index in indices
        if (shape := outlines[index] or _frame(placed[index])) is not None
    ]
    if wrap.viewport is None or not shapes:
        return []
    back = inverse(wrap.effect.matrix)
    linear = np.array([[back[0], back[2]], [back[1], back[3]]])
    kind = np.concatenate([shape.kind for _, shape in shapes])
    coords = np.concatenate([shape.coords for _, shape in shapes])
    counts = np.array([len(shape.kind) for _, shape in shapes])
    begins = np.cumsum(counts) - counts
    boxes = segment_boxes(kind, transform_segments(kind, coords, np.array(back)))
    pens = np.array([pen_extent(placed[index].style, linear) for index, _ in shapes])
    low = np.minimum.reduceat(boxes[:, :2], begins) - pens
    high = np.maximum.reduceat(boxes[:, 2:], begins) + pens
    row_of = np.full(len(placed), -1)
    row_of[[index for index, _ in shapes]] = np.arange(len(shapes))
    here = row_of[tips.element] >= 0
    mapped = tips.points[here] @ linear.T + np.array(back[4:])
    np.minimum.at(low, row_of[tips.element[here]], mapped)
    np.maximum.at(high, row_of[tips.element[here]], mapped)
    x, y, width, height = wrap.viewport
    slack = _SLACK * (abs(x) + abs(y) + width + height)
    fits = (low >= np.array([x, y]) - slack).all(axis=1)
    fits &= (high <= np.array([x + width, y + height]) + slack).all(axis=1)
    return [index for (index, _), fit in zip(shapes, fits.tolist(), strict=True) if fit]


def _frame(one: Placed) -> Outline | None:
    """The box that holds a fragment as an outline in the world; None where it is not known."""
    if one.reach is None:
        return None
    x, y, width, height = one.reach
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
    path = parse_path("M" + "L".join(f"{across!r} {down!r}" for across, down in corners)).outline
    return None if path is None else place(path, one.matrix)


def pen_extent(style: Style, linear: Floats) -> Floats:
    """(2,) how far a pen reaches along x and y from the curve after a (2, 2) map, mitres apart."""
    if style.stroke == "none":
        return np.zeros(2)
    reach = style.stroke_width / 2
    if dict(style.more).get("stroke-linecap") == "square":
        reach *= 2**0.5
    rows: Floats = np.hypot(*(linear @ _pen_space(style)).T)
    return reach * rows


def _pen_space(style: Style) -> Floats:
    """(2, 2) what makes a round pen into the style's."""
    if style.stroke_matrix is None:
        return np.eye(2)
    a, b, c, d = style.stroke_matrix
    return np.array([[a, c], [b, d]])


@dataclass(frozen=True, slots=True, eq=False)
class _Tips:
    """The tips of mitred corners. points: (k, 2) in the world; element: (k,) whose they are."""

    points: Floats
    element: NDArray[np.intp]


def _tips(
    placed: Sequence[Placed], outlines: Sequence[Outline | None], indices: Iterable[int]
) -> _Tips:
    """The tips of some elements, those of one style together."""
    alike: dict[Style, list[tuple[int, Outline]]] = {}
    for index in sorted(indices):
        outline = outlines[index]
        if outline is not None:
            alike.setdefault(placed[index].style, []).append((index, outline))
    points, elements = [np.zeros((0, 2))], [np.zeros(0, np.intp)]
    for style, drawn in alike.items():
        found, segment = mitre_tips(_in_one([outline for _, outline in drawn]), style)
        owner = np.repeat([index for index, _ in drawn], [len(each.kind) for _, each in drawn])
        points.append(found)
        elements.append(owner[segment])
    return _Tips(np.concatenate(points), np.concatenate(elements))


def _in_one(outlines: Sequence[Outline]) -> Outline:
    """The subpaths of all outlines as those of one."""
    ends = np.cumsum([len(each.kind) for each in outlines])
    begins = [0, *ends[:-1].tolist()]
    starts = [each.starts[:-1] + begin for each, begin in zip(outlines, begins, strict=True)]
    return Outline(
        np.concatenate([each.kind for each in outlines]),
        np.concatenate([each.coords for each in outlines]),
        np.append(np.concatenate(starts), ends[-1]).astype(np.int32),
        np.concatenate([each.closed for each in outlines]),
    )


def mitre_tips(outline: Outline, style: Style) -> tuple[Floats, NDArray[np.intp]]:
    """(k, 2) the outer points of the corners of a stroke, none where they are rounded or cut, and
    (k,) the segment that ends in each.
    """
    more = dict(style.more)
    if style.stroke == "none" or more.get("stroke-linejoin", "miter") != "miter":
        return np.zeros((0, 2)), np.zeros(0, np.intp)
    space = _pen_space(style)
    into = np.linalg.inv(space)
    matrix = np.array([into[0, 0], into[1, 0], into[0, 1], into[1, 1], 0.0, 0.0])
    coords = transform_segments(outline.kind, outline.coords, matrix)
    leave, arrive = segment_tangents(outline.kind, coords)
    last = segment_ends(outline.kind, coords)[1]
    after = np.arange(1, len(outline.kind) + 1)
    ends = outline.starts[1:] - 1
    after[ends] = outline.starts[:-1]
    joined = np.ones(len(after), dtype=np.bool_)
    joined[ends] = outline.closed
    leave = leave[after]
    outward = arrive - leave
    # The tip is half a width over the cosine of half the turn away.
    half_turn = np.sqrt(np.clip((1 + (arrive * leave).sum(axis=1)) / 2, 0, 1))
    limit = number(more.get("stroke-miterlimit")) or _MITRE_LIMIT
    bends = np.hypot(outward[:, 0], outward[:, 1])
    pointed = joined & (bends > 1e-6) & (half_turn * limit >= 1)
    way = outward[pointed] / bends[pointed, None]
    tips = last[pointed] + style.stroke_width / 2 / half_turn[pointed, None] * way
    return np.asarray(tips @ space.T), np.flatnonzero(pointed)
