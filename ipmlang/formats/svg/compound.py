"""Compound paths taken apart into elements of their own, where that cannot change the picture.

`split_compound` takes a drawing and gives one in which subpaths that do not touch each other, or
that only an opaque pen draws, are elements. What a fill joins (holes, overlaps) stays together.
Paint order and styles are kept; nothing is moved.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import LINE, Drawing, DrawnElement, Floats, Outline, Style
from ipmlang.formats.svg.bounds import segment_boxes
from ipmlang.formats.svg.clipping import mitre_tips, pen_extent

_TRANSLUCENT = frozenset({"opacity", "stroke-opacity", "mix-blend-mode"})
_MOST_PAIRS = 30_000_000
_PAIRS_AT_ONCE = 2_000_000


def split_compound(drawing: Drawing, whole: Set[int] = frozenset()) -> Drawing:
    """The drawing with compound paths split into as many elements as look the same; whole: numbers
    of elements that stay as they are.
    """
    elements = tuple(
        part
        for number, element in enumerate(drawing.elements)
        for part in ((element,) if number in whole else _parts(element))
    )
    return replace(drawing, elements=elements)


def _parts(element: DrawnElement) -> Iterator[DrawnElement]:
    outline = element.outline
    if outline is None or len(outline.closed) < 2:
        yield element
        return
    labels = _labels(outline, element.style)
    if labels is None:
        pieces = [_slice(outline, index) for index in range(len(outline.closed))]
    else:
        order = np.argsort(labels, kind="stable")
        cuts = np.flatnonzero(np.diff(labels[order])) + 1
        groups = sorted(np.split(order, cuts), key=lambda group: int(group[0]))
        pieces = [outline] if len(groups) == 1 else [_gather(outline, group) for group in groups]
    for piece in pieces:
        yield replace(element, outline=piece)


def _labels(outline: Outline, style: Style) -> NDArray[np.intp] | None:
    """Which subpaths must stay together, by equal labels; None if each may stand alone."""
    has_stroke = style.stroke != "none"
    has_fill = style.fill != "none" and not _is_all_lines(outline)
    if not has_fill and (not has_stroke or _is_opaque(style)):
        return None
    boxes = _subpath_boxes(outline)
    if has_stroke:
        extent = pen_extent(style, np.eye(2))
        boxes += np.concatenate([-extent, extent])
        boxes = _with_tips(boxes, outline, style)
    return _overlapping(boxes)


def _is_all_lines(outline: Outline) -> bool:
    """Whether every subpath is one straight line, which a fill does not show."""
    lengths = np.diff(outline.starts)
    return bool((lengths == 1).all() and (outline.kind == LINE).all())


def _is_opaque(style: Style) -> bool:
    return isinstance(style.stroke, str) and not any(n in _TRANSLUCENT for n, _ in style.more)


def _subpath_boxes(outline: Outline) -> Floats:
    """(s, 4) boxes of the subpaths."""
    boxes = segment_boxes(outline.kind, outline.coords)
    begins = outline.starts[:-1]
    low = np.minimum.reduceat(boxes[:, :2], begins)
    high = np.maximum.reduceat(boxes[:, 2:], begins)
    return np.concatenate([low, high], axis=1)


def _with_tips(boxes: Floats, outline: Outline, style: Style) -> Floats:
    """The boxes of subpaths grown by the mitred corners of their strokes; a line has none."""
    tips, segment = mitre_tips(outline, style)
    subpath = np.searchsorted(outline.starts, segment, side="right") - 1
    bent = np.diff(outline.starts)[subpath] > 1
    np.minimum.at(boxes[:, :2], subpath[bent], tips[bent])
    np.maximum.at(boxes[:, 2:], subpath[bent], tips[bent])
    return boxes


def _overlapping(boxes: Floats) -> NDArray[np.intp]:
    """(n,) labels: equal for boxes that touch, directly or through others.

    Boxes are sorted along the axis on which fewer of them overlap; only those pairs are looked at.
    """
    count = len(boxes)
    sweeps = [_sweep(boxes, axis) for axis in (0, 1)]
    order, reach = min(sweeps, key=lambda sweep: int(sweep[1].sum()))
    if int(reach.sum()) > _MOST_PAIRS:
        return np.zeros(count, dtype=np.intp)
    labels = np.arange(count)
    ends = np.cumsum(reach)
    first = 0
    while first < count:
        done = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, done + _PAIRS_AT_ONCE, side="right")))
        repeats = reach[first:last]
        left = np.repeat(np.arange(first, last), repeats)
        step = np.arange(len(left)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
        a, b = order[left], order[left + 1 + step]
        touch = (boxes[a, :2] <= boxes[b, 2:]).all(axis=1)
        touch &= (boxes[b, :2] <= boxes[a, 2:]).all(axis=1)
        labels = _joined(labels, a[touch], b[touch])
        first = last
    return labels


def _sweep(boxes: Floats, axis: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The order along an axis, and for each box in it how many after it begin before it ends."""
    order = np.argsort(boxes[:, axis], kind="stable")
    begins = boxes[order, axis]
    until = np.searchsorted(begins, boxes[order, axis + 2], side="right")
    return order, until - np.arange(1, len(boxes) + 1)


def _joined(labels: NDArray[np.intp], a: NDArray[np.intp], b: NDArray[np.intp]) -> NDArray[np.intp]:
    """Labels after joining the pairs: each label is the least index of its group."""
    while True:
        low = np.minimum(labels[a], labels[b])
        lowered = labels.copy()
        for ends in (a, b):
            np.minimum.at(lowered, labels[ends], low)
            np.minimum.at(lowered, ends, low)
        while not np.array_equal(lowered, lowered[lowered]):
            lowered = lowered[lowered]
        if np.array_equal(lowered, labels):
            return labels
        labels = lowered


def _slice(outline: Outline, index: int) -> Outline:
    """One subpath as an outline."""
    begin, end = int(outline.starts[index]), int(outline.starts[index + 1])
    return Outline(
        outline.kind[begin:end],
        outline.coords[begin:end],
        np.array([0, end - begin], dtype=np.int32),
        outline.closed[index : index + 1],
    )


def _gather(outline: Outline, subpaths: NDArray[np.intp]) -> Outline:
    """Some subpaths as one outline, in their order."""
    if len(subpaths) == 1:
        return _slice(outline, int(subpaths[0]))
    lengths = np.diff(outline.starts)[subpaths]
    begins = outline.starts[:-1][subpaths]
    ends = np.cumsum(lengths)
    rows = np.arange(int(ends[-1])) + np.repeat(begins - (ends - lengths), lengths)
    return Outline(
        outline.kind[rows],
        outline.coords[rows],
        np.concatenate([[0], ends]).astype(np.int32),
        outline.closed[subpaths],
    )
