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
    shown = [
        _Held(number, index, shape)
        for number, indices in enumerate(held.values())
        for index in indices
        if (shape := outlines[index] or _frame(placed[index])) is not None
    ]
    if not shown:
        return set()
    inside = _inside(
        list(held), shown, placed, _tips(placed, outlines, (each.index for each in shown))
    )
    often = np.bincount([each.wrap for each in shown], inside, len(held)).tolist()
    return {
        (wrap, index)
        for (wrap, indices), count in zip(held.items(), often, strict=True)
        if count == len(indices)
        for index in indices
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Held:
    """A shape under a viewport: the number of its wrap and its own, and its outline."""

    wrap: int
    index: int
    shape: Outline


def _inside(
    wraps: Sequence[Wrap], shown: Sequence[_Held], placed: Sequence[Placed], tips: _Tips
) -> NDArray[np.bool_]:
    """(k,) which shapes lie within the viewports of their wraps, all looked at together."""
    kind = np.concatenate([each.shape.kind for each in shown])
    coords = np.concatenate([each.shape.coords for each in shown])
    counts = np.array([len(each.shape.kind) for each in shown])
    wrap = np.array([each.wrap for each in shown])
    back = np.array([inverse(each.effect.matrix) for each in wraps])
    boxes = segment_boxes(kind, transform_segments(kind, coords, back[np.repeat(wrap, counts)]))
    linear = back[:, [[0, 2], [1, 3]]]
    pens = np.array([pen_extent(placed[each.index].style, linear[each.wrap]) for each in shown])
    begins = np.cumsum(counts) - counts
    low = np.minimum.reduceat(boxes[:, :2], begins) - pens
    high = np.maximum.reduceat(boxes[:, 2:], begins) + pens
    row, tip = tips.of(np.array([each.index for each in shown]))
    mapped = np.einsum("kij,kj->ki", linear[wrap[row]], tips.points[tip]) + back[wrap[row], 4:]
    np.minimum.at(low, row, mapped)
    np.maximum.at(high, row, mapped)
    viewports = np.array([each.viewport for each in wraps], np.float64)
    corner, size = viewports[wrap, :2], viewports[wrap, 2:]
    slack = _SLACK * (np.abs(corner).sum(axis=1) + size.sum(axis=1))[:, None]
    fits = (low >= corner - slack) & (high <= corner + size + slack)
    return np.asarray(fits.all(axis=1))


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

    def of(self, elements: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows of some elements (k,) and of their tips, one of each for every tip."""
        order = np.argsort(self.element, kind="stable")
        known = self.element[order]
        first = np.searchsorted(known, elements)
        counts = np.searchsorted(known, elements, side="right") - first
        row = np.repeat(np.arange(len(elements)), counts)
        before = np.cumsum(counts) - counts
        return row, order[np.repeat(first - before, counts) + np.arange(len(row))]


def _tips(
    placed: Sequence[Placed], outlines: Sequence[Outline | None], indices: Iterable[int]
) -> _Tips:
    """The tips of some elements, those of one style together."""
    alike: dict[Style, list[tuple[int, Outline]]] = {}
    for index in sorted(set(indices)):
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
