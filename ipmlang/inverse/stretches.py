"""What one turtle may have drawn of a drawing: a stretch of lines, of paths, or one polygon.

Takes an observation; gives the segments of each stretch in paint order, y up, and the braces that
make outlines of them. Bounds come before work: what has too many different lengths is no turtle's.
Nothing here searches for rules.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.drawing import LINE, Outline, Style
from ipmlang.inverse.lsystem.frames import Complexes
from ipmlang.inverse.observation import Observation

PATH, POLYGON = "path", "polygon"
MOST_OTHERS = 40  # elements that are not of a stretch; with more the drawing is no turtle's
FEWEST = 12  # lines of an outline that could have a rule
MOST = 1_000_000  # lines of outlines that are looked at
MOST_LENGTHS = 256  # plus a share of the lines: with more there is no rule
SHARE = 1 / 8
GRAIN = 1e-4  # of the extent: lengths that differ by less may be one
MOST_ALONE = 8  # outlines that are looked at by themselves
MANY = 20_000  # lines, of which it is first asked whether stretches of them recur:
WINDOW = 16  # joints of a stretch
COARSE = np.pi / 8  # of a turn
PRIME = 1_099_511_628_211  # of the hash of a stretch
DIFFERENT = 0.25  # of all stretches, that may be another each
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """rows: of the elements, in paint order; start, end: (n,) their segments, x + iy; braces: what
    makes outlines of them, "" for lines; numbers: coordinates of outlines of more than one line,
    which a file of parts would hold, and which are no placement of a line.
    """

    rows: Integers
    start: Complexes
    end: Complexes
    braces: str = ""
    numbers: int = 0


def stretches(observed: Observation) -> Iterator[Stretch]:
    """Stretches that a turtle may have drawn: all lines first, then outlines."""
    if any(style.effects for style in observed.styles):
        return
    straight = _straight(observed)
    rows = np.flatnonzero(straight == 1)
    lines = _together(observed, rows)
    if lines and all(_is_stroke(observed.styles[k]) for k in np.unique(observed.style[rows])):
        yield Stretch(rows, *_ends(observed, rows))
    if len(observed) - int((straight > 0).sum()) <= MOST_OTHERS:
        yield from _outlines(observed, straight)


def _straight(observed: Observation) -> Integers:
    """(n,) of how many straight lines each element is, 0 if it has others or none."""
    counts = np.zeros(len(observed), np.int64)
    for shape in observed.classes:
        outline = shape.outline
        if shape.kind == "line":
            counts[shape.members] = 1
        elif shape.kind == "path" and outline is not None and (outline.kind == LINE).all():
            counts[shape.members] = len(outline.kind)
    return counts


def _together(observed: Observation, rows: Integers) -> bool:
    """Whether elements follow each other and hardly anything else is there."""
    few = len(observed) - len(rows) <= MOST_OTHERS
    return few and len(rows) > 0 and bool(rows[-1] - rows[0] + 1 == len(rows))


def _outlines(observed: Observation, straight: Integers) -> Iterator[Stretch]:
    """All outlines of one style as one path, then the longest by themselves."""
    longest = int(straight.max(initial=0))
    if longest < 2 or int(straight.sum()) > MOST:
        return
    rows = np.flatnonzero(straight > 0)
    if len(rows) > 1 and _together(observed, rows) and np.ptp(observed.style[rows]) == 0:
        yield from _stretch(observed, rows)
    if are_few(observed):
        single = np.array([len(each.members) == 1 for each in observed.classes], np.bool_)
        alone = np.where(single[observed.shape], straight, 0)  # others are drawn by one rule each
        order = np.argsort(-alone, kind="stable")[:MOST_ALONE]
        for row in order[alone[order] > 1].tolist():
            yield from _stretch(observed, np.array([row]))


def are_few(observed: Observation) -> bool:
    """Whether outlines are looked at by themselves: there are few elements, and not two that could
    both be curves. Rules of several curves in one file count their steps, which is for others.
    """
    if len(observed) > MOST_OTHERS + 1:
        return False
    long = (
        shape.outline
        for shape in observed.classes
        if shape.outline is not None and len(shape.outline.kind) >= 2 * FEWEST
    )
    return sum(bool((each.kind == LINE).all()) for each in long) < 2


def _stretch(observed: Observation, rows: Integers) -> Iterator[Stretch]:
    """Open outlines as a path, or one closed outline as a polygon, where it can have a rule."""
    outlines = [observed.drawing.elements[row].outline for row in rows.tolist()]
    closed = [bool(part) for each in outlines if each is not None for part in each.closed]
    if not _is_plain(observed.styles[int(observed.style[rows[0]])]):
        return
    if any(closed) and len(closed) > 1:
        return
    start, end = _ends(observed, rows)
    if len(start) >= FEWEST and is_regular(start, end):
        counts = np.array([len(each.kind) for each in outlines if each is not None])
        numbers = int(2 * (counts[counts > 1] + 1).sum())
        yield Stretch(rows, start, end, POLYGON if closed[0] else PATH, numbers)


def is_regular(start: Complexes, end: Complexes) -> bool:
    """Whether there are so few different lengths that rules may have made them."""
    points = np.concatenate([start, end])
    grain = GRAIN * max(1e-300, abs(complex(np.ptp(points.real), np.ptp(points.imag))))
    lengths = np.unique(np.round(np.abs(end - start) / grain))
    if len(lengths) > MOST_LENGTHS + SHARE * len(start):
        return False
    return len(start) < MANY or _recurs(start, end)


def _recurs(start: Complexes, end: Complexes) -> bool:
    """Whether the same few joints follow each other again and again, seen so coarsely that rounded
    coordinates change nothing.
    """
    along = np.where(end == start, 1e-300, end - start)
    ratio = along[1:] / along[:-1]
    turn = np.round(np.angle(ratio) / COARSE).astype(np.int64) % round(2 * np.pi / COARSE)
    size = np.clip(np.round(np.log2(np.abs(ratio))), -4, 4).astype(np.int64) + 4
    jumps = np.abs(start[1:] - end[:-1]) > 0.1 * np.abs(along[:-1])
    letters = (turn * 9 + size) * 2 + jumps
    windows = np.zeros(len(letters) - WINDOW + 1, np.uint64)
    for place in range(WINDOW):
        part = letters[place : place + len(windows)].astype(np.uint64)
        windows = windows * np.uint64(PRIME) + part + np.uint64(1)
    return len(np.unique(windows)) <= len(windows) * DIFFERENT


def is_turtles(outline: Outline, style: Style) -> bool:
    """Whether an outline could be a turtle's `path` or `polygon`: straight lines in a plain pen, in
    one closed part or any number of open ones.
    """
    one = len(outline.closed) == 1 or not outline.closed.any()
    return one and _is_plain(style) and not style.effects and bool((outline.kind == LINE).all())


def _is_plain(style: Style) -> bool:
    paints = isinstance(style.fill, str) and isinstance(style.stroke, str)
    return paints and style.stroke_matrix is None


def _is_stroke(style: Style) -> bool:
    return _is_plain(style) and not style.dashes


def _ends(observed: Observation, rows: Integers) -> tuple[Complexes, Complexes]:
    """Both ends of the lines of elements as they were drawn, y up."""
    outlines = [observed.drawing.elements[row].outline for row in rows.tolist()]
    points = np.concatenate([_both(each) for each in outlines if each is not None])
    ends = points[:, :, 0] + 1j * (observed.flip - points[:, :, 1])
    return ends[:, 0], ends[:, 1]


def _both(outline: Outline) -> NDArray[np.float64]:
    return np.asarray(outline.coords[:, :2], np.float64)
