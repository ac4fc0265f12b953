"""The branching structure of strokes: which segment each one grows from.

In come strokes in paint order; out comes, for each, the segment at whose end it begins (the
shallowest pop that fits), its children, and how far it goes on straight without any branch. None
where a segment begins nowhere. Time grows with the number of segments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipmlang.inverse.recursion.strokes import Integers, Strokes, clustered


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """parent: (n,) segment before, -1 at the root; children: by segment, those of the root last
    (index -1), in paint order; straight: (n,) segments from here on without branch or turn, at
    least 1; turn: (n,) degrees from the parent, from the first segment for those at the root.
    """

    parent: list[int]
    children: list[list[int]]
    straight: list[int]
    turn: list[float]


def grow_tree(strokes: Strokes) -> Tree | None:
    """The tree of the strokes."""
    places = _places(strokes)
    if places is None:
        return None
    begin, end = places
    parent = _parents(begin.tolist(), end.tolist())
    if parent is None:
        return None
    children: list[list[int]] = [[] for _ in range(len(parent) + 1)]
    for index, before in enumerate(parent):
        children[before].append(index)
    turn = _turns(strokes, np.array(parent))
    return Tree(parent, children, _straight(strokes, children), turn)


def _places(strokes: Strokes) -> tuple[Integers, Integers] | None:
    """Numbers of the start and end points; equal for points that coincide."""
    points = np.concatenate([strokes.start, strokes.end])
    columns = [clustered(axis, strokes.tolerance) for axis in (points.real, points.imag)]
    _, names = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
    begin, end = np.split(names.ravel().astype(np.int64), 2)
    return None if np.any(begin == end) else (begin, end)


def _parents(begin: list[int], end: list[int]) -> list[int] | None:
    parent = [-1]
    for index in range(1, len(begin)):
        before = index - 1
        while before >= 0 and end[before] != begin[index]:
            before = parent[before]
        if before < 0 and begin[index] != begin[0]:
            return None
        parent.append(before)
    return parent


def _turns(strokes: Strokes, parent: Integers) -> list[float]:
    """The turns, those that are equal but for rounding replaced by one number."""
    along = strokes.along
    turn = np.angle(along / np.where(parent < 0, along[0], along[parent]), deg=True)
    slack = np.rad2deg(2 * strokes.tolerance / np.abs(along))
    kind = clustered(turn, slack)
    mean = np.bincount(kind, turn) / np.bincount(kind)
    mean[np.abs(mean) <= slack.max()] = 0.0
    return [float(each) for each in mean[kind]]


def _straight(strokes: Strokes, children: list[list[int]]) -> list[int]:
    along = strokes.along
    same = np.abs(np.diff(along)) <= 4 * strokes.tolerance
    result = [1] * len(along)
    for index in range(len(along) - 2, -1, -1):
        if children[index] == [index + 1] and same[index]:
            result[index] = result[index + 1] + 1
    return result
