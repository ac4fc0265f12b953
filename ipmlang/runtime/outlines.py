"""Outlines that a turtle walks: polygons and paths, from the acts between their braces.

In go a stream and its turtle, out come the corners of each outline and the acts that close them. A
polygon has a corner at both ends of every `F` and `f`; a path is a line through what each `F`
draws, which begins anew where an `F` does not start at the line's end. Pens and order are not here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.runtime.interpret import Act, Stream, chosen
from ipmlang.runtime.scan import Real, Whole
from ipmlang.runtime.scene import OUTLINE, PATH
from ipmlang.runtime.turtle import Turtle

Polygons: TypeAlias = tuple[NDArray[np.float64], ...]
Closing: TypeAlias = tuple[Act, int, tuple[float, float, float], NDArray[np.int32]]

NEAR = 1e-12  # of the extent: corners that are one
CLOSED = 1e-9  # of the extent: where an outline meets its begin, or a path goes on
NO_SIZE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Outlines:
    """nest: (stream length,) in how many outlines each place stands; closing: the acts that draw,
    with OUTLINE or PATH and the number of each outline; corners: (m, 3) of each.
    """

    nest: NDArray[np.int32]
    closing: list[Closing]
    corners: Polygons


@dataclass(frozen=True, slots=True, eq=False)
class _Corners:
    """Corners in the order of the outlines and of the string. number: of the outline of each;
    points: (m, 3); lifted: whether a path does not draw a line to it.
    """

    number: Whole
    points: Real
    lifted: NDArray[np.bool_]

    def __getitem__(self, rows: NDArray[np.generic]) -> _Corners:
        return _Corners(self.number[rows], self.points[rows], self.lifted[rows])


def outlines_of(stream: Stream, turtle: Turtle) -> Outlines | None:
    """All polygons and paths of a stream, None where there are none."""
    begun = stream.of("polygon_open", "path_open")
    if not begun:
        return None
    nest = _nesting(stream, begun)
    at = np.concatenate([act.at for act in begun])
    drawn = np.concatenate([np.full(len(act.at), act.op == "path_open") for act in begun])
    order = np.argsort(at)
    opens, is_path = at[order], drawn[order]
    corners = _corners(stream, turtle, nest, opens, is_path)
    extent = float(np.ptp(corners.points, axis=0).max()) if len(corners.number) else 0.0
    on_path = is_path[corners.number]
    polygons = corners[~on_path]
    polygons = polygons[_distinct(polygons, extent)]
    paths = _parted(corners[on_path], extent)
    found = _Found(len(opens), polygons, paths)
    closing = _closing(stream, nest, opens, found.shown(is_path))
    drawn_numbers = np.unique(np.concatenate([opens[:0], *(number for *_, number in closing)]))
    shape = np.full(len(opens), -1, np.int32)
    shape[drawn_numbers] = np.arange(len(drawn_numbers))
    ready = [(act, kind, NO_SIZE, shape[number]) for act, kind, number in closing]
    pick = (found.path if is_path[k] else found.polygon for k in drawn_numbers.tolist())
    numbers = drawn_numbers.tolist()
    return Outlines(nest, ready, tuple(get(k) for get, k in zip(pick, numbers, strict=True)))


class _Found:
    """The corners of `count` outlines, by outline."""

    def __init__(self, count: int, polygons: _Corners, paths: _Corners) -> None:
        self._polygons, self._paths = polygons, paths
        self._counts = np.bincount(polygons.number, minlength=count)
        self._ends = np.cumsum(self._counts)
        self._drawn = np.bincount(paths.number, minlength=count)
        self._drawn_ends = np.cumsum(self._drawn)

    def shown(self, is_path: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(count,) which have an inside, or a line."""
        lines = np.bincount(self._paths.number[~self._paths.lifted], minlength=len(is_path))
        return np.where(is_path, lines >= 1, self._counts >= 3)

    def polygon(self, number: int) -> NDArray[np.float64]:
        """Its corners (m, 3)."""
        end = self._ends[number]
        return np.asarray(self._polygons.points[end - self._counts[number] : end])

    def path(self, number: int) -> NDArray[np.float64]:
        """Its points (m, 3), a row of NaN before each part but the first."""
        end = self._drawn_ends[number]
        own = slice(end - self._drawn[number], end)
        anew = np.flatnonzero(self._paths.lifted[own])
        return np.insert(self._paths.points[own], anew[1:], np.nan, axis=0)


def _nesting(stream: Stream, begun: list[Act]) -> NDArray[np.int32]:
    """How many outlines each place of the stream stands in."""
    step = np.zeros(stream.length + 1, np.int32)
    for act in begun:
        step[act.at] += 1
    for act in stream.of("polygon_close", "path_close"):
        step[act.at + 1] -= 1
    return np.cumsum(step[:-1], dtype=np.int32)


def _closing(
    stream: Stream, nest: NDArray[np.int32], opens: Whole, shown: NDArray[np.bool_]
) -> list[tuple[Act, int, Whole]]:
    """The acts that close what is shown, what it is, and the number of each outline."""
    found = []
    for op, kind in (("polygon_close", OUTLINE), ("path_close", PATH)):
        for act in stream.visible(op):
            owner = _innermost(nest, opens, act.at)
            rows = np.flatnonzero(shown[owner])
            found.append((chosen(act, rows), kind, owner[rows]))
    return found


def _corners(
    stream: Stream,
    turtle: Turtle,
    nest: NDArray[np.int32],
    opens: Whole,
    is_path: NDArray[np.bool_],
) -> _Corners:
    """Both ends of every edge inside an outline, and the places marked as corners; of a path the
    ends of what draws alone.
    """
    at: list[Whole] = [np.zeros(0, np.int64)]
    points: list[Real] = [np.zeros((0, 3))]
    numbers: list[Whole] = [np.zeros(0, np.int64)]
    lifted: list[NDArray[np.bool_]] = [np.zeros(0, np.bool_)]
    for act in stream.of("segment", "move", "vertex"):
        inside = act.at[nest[act.at] > 0]
        number = _innermost(nest, opens, inside)
        if act.op == "move" or act.hidden:  # which moves a path without drawing
            left = ~is_path[number]
            inside, number = inside[left], number[left]
        for after in (False, True) if act.op != "vertex" else (False,):
            at.append(inside)
            points.append(turtle.places(inside, after=after))
            numbers.append(number)
            lifted.append(np.full(len(inside), act.op == "segment" and not after))
    number, place = np.concatenate(numbers), np.concatenate(at)
    # the two ends of an edge stand at one place: a stable sort keeps their order
    order = np.lexsort((np.arange(len(place)), place, number))
    return _Corners(number, np.concatenate(points), np.concatenate(lifted))[order]


def _innermost(nest: NDArray[np.int32], opens: Whole, at: Whole) -> Whole:
    """The number of the outline that each place stands in, by where it opens."""
    depths = nest[opens]
    found = np.zeros(len(at), np.int64)
    for depth in np.unique(depths).tolist():
        numbers = np.flatnonzero(depths == depth)
        rows = np.flatnonzero(nest[at] == depth)
        found[rows] = numbers[np.searchsorted(opens[numbers], at[rows], side="right") - 1]
    return found


def _distinct(corners: _Corners, extent: float) -> NDArray[np.bool_]:
    """Which corners differ from the one before, and at the end from the first, in their polygon."""
    number, points = corners.number, corners.points
    if not len(number):
        return np.zeros(0, np.bool_)
    first = np.ones(len(number), np.bool_)
    first[1:] = number[1:] != number[:-1]
    kept = first.copy()
    kept[1:] |= np.abs(points[1:] - points[:-1]).max(axis=1) > NEAR * max(extent, 1e-300)
    begin = np.flatnonzero(first)
    index = np.where(kept, np.arange(len(number)), -1)
    last = np.maximum.reduceat(index, begin)
    near = CLOSED * max(extent, 1e-300)
    closes = np.abs(points[last] - points[begin]).max(axis=1) <= near
    kept[last[closes & (last != begin)]] = False
    return kept


def _parted(corners: _Corners, extent: float) -> _Corners:
    """The points of paths, without those where an `F` starts at the end of the line, and without
    those that no line comes to or leaves.
    """
    near = CLOSED * max(extent, 1e-300)
    there = np.abs(corners.points[1:] - corners.points[:-1]).max(axis=1) <= near
    same = corners.number[1:] == corners.number[:-1]
    kept = np.ones(len(corners.number), np.bool_)
    kept[1:] = ~(corners.lifted[1:] & there & same)
    found = corners[kept]
    begins = found.lifted.copy()
    begins[:1] = True
    begins[1:] |= found.number[1:] != found.number[:-1]
    alone = begins & np.append(begins[1:], True)
    return _Corners(found.number, found.points, begins)[~alone]
