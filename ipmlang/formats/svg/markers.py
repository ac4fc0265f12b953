"""Markers: where on an outline they stand, how they are turned, and the map that places each.

Takes an outline in its own space and a marker element; gives placements in paint order. What a
marker draws is the walk's business.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ipmlang.formats.drawing import Floats, Outline
from ipmlang.formats.svg.bounds import segment_ends, segment_tangents
from ipmlang.formats.svg.transforms import Box, Matrix, multiply, translate
from ipmlang.formats.svg.units import length
from ipmlang.formats.svg.viewports import fit, parse_view_box
from ipmlang.formats.svg.xml import Node

_REFERENCE_WORDS = {"left": 0.0, "top": 0.0, "center": 0.5, "right": 1.0, "bottom": 1.0}
_ANGLE_UNITS = (("deg", 1.0), ("grad", 0.9), ("rad", 180 / math.pi), ("turn", 360.0))


@dataclass(frozen=True, slots=True)
class Frame:
    """A marker made ready.

    The map from its content to a tile whose reference point is the origin, the tile itself, the
    viewport of its content, and its turn in degrees (None: along the path).
    """

    matrix: Matrix
    tile: Box
    viewport: tuple[float, float]
    angle: float | None
    reversed_start: bool


def frame_of(node: Node, stroke_width: float, font_size: float) -> Frame | None:
    """The frame of a marker element on a path with this pen; None if it draws nothing."""
    in_user_space = node.attributes.get("markerUnits") == "userSpaceOnUse"
    scale = 1.0 if in_user_space else stroke_width
    width = _size(node, "markerWidth", font_size)
    height = _size(node, "markerHeight", font_size)
    if not (width > 0 and height > 0 and scale > 0):
        return None
    view = parse_view_box(node.attributes.get("viewBox"))
    place: Matrix | None = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    if view is not None:
        aspect = node.attributes.get("preserveAspectRatio")
        place = fit(view, (0.0, 0.0, width, height), aspect)
    if place is None:
        return None
    inner: Box = view or (0.0, 0.0, width, height)
    x = _reference(node.attributes.get("refX"), inner[0], inner[2], font_size)
    y = _reference(node.attributes.get("refY"), inner[1], inner[3], font_size)
    left = place[0] * x + place[4]
    down = place[3] * y + place[5]
    matrix = multiply((scale, 0.0, 0.0, scale, -scale * left, -scale * down), place)
    tile = (-scale * left, -scale * down, scale * width, scale * height)
    angle, reverses = _orient(node.attributes.get("orient") or "0")
    return Frame(matrix, tile, (inner[2], inner[3]), angle, reverses)


def _size(node: Node, name: str, font_size: float) -> float:
    text = node.attributes.get(name)
    return 3.0 if text is None else length(text, 0.0, font_size) or 0.0


def _reference(text: str | None, low: float, extent: float, font_size: float) -> float:
    if text is None:
        return 0.0
    word = text.strip()
    if word in _REFERENCE_WORDS:
        return low + _REFERENCE_WORDS[word] * extent
    return length(word, extent, font_size) or 0.0


def _orient(text: str) -> tuple[float | None, bool]:
    word = text.strip()
    if word in ("auto", "auto-start-reverse"):
        return None, word != "auto"
    for unit, degrees in _ANGLE_UNITS:
        if word.endswith(unit):
            return (length(word.removesuffix(unit)) or 0.0) * degrees, False
    return length(word) or 0.0, False


def placements(
    outline: Outline, start: Frame | None, mid: Frame | None, end: Frame | None
) -> Iterator[tuple[Frame, Matrix]]:
    """Frames with the map from tile to the outline's space: start, all in the middle, end."""
    points, turns = vertices(outline)
    last = len(points) - 1
    if start is not None:
        yield start, _standing(start, points[0], turns[0], start.reversed_start)
    if mid is not None:
        for index in range(1, last):
            yield mid, _standing(mid, points[index], turns[index], False)
    if end is not None:
        yield end, _standing(end, points[last], turns[last], False)


def _standing(frame: Frame, point: Floats, turn: float, back: bool) -> Matrix:
    angle = turn + (math.pi if back else 0.0)
    if frame.angle is not None:
        angle = math.radians(frame.angle)
    place = translate(float(point[0]), float(point[1]))
    if angle == 0.0:
        return place
    c, s = math.cos(angle), math.sin(angle)
    return multiply(place, (c, s, -s, c, 0.0, 0.0))


def vertices(outline: Outline) -> tuple[Floats, list[float]]:
    """The vertices of an outline, (n, 2), and the direction of the path there in radians: halfway
    between the way in and the way out.
    """
    first, last = segment_ends(outline.kind, outline.coords)
    leave, arrive = _tangents(outline)
    points: list[Floats] = []
    turns: list[float] = []
    bounds = zip(outline.starts[:-1], outline.starts[1:], outline.closed, strict=True)
    for begin, end, closed in bounds:
        ways_in = [arrive[end - 1] if closed else leave[begin], *arrive[begin:end]]
        ways_out = [*leave[begin:end], leave[begin] if closed else arrive[end - 1]]
        points += [first[begin : begin + 1], last[begin:end]]
        turns += [_between(a, b) for a, b in zip(ways_in, ways_out, strict=True)]
    return np.concatenate(points), turns


def _between(way_in: float, way_out: float) -> float:
    """Half the turn from one direction to the other, the short way round."""
    if abs(way_in - way_out) > math.pi:
        way_in += math.tau if way_in < way_out else -math.tau
    return (way_in + way_out) / 2


def _tangents(outline: Outline) -> tuple[list[float], list[float]]:
    """Directions at the start and the end of each segment, in radians; a segment without length
    has that of the one before it.
    """
    leave, arrive = segment_tangents(outline.kind, outline.coords)
    there = (leave != 0).any(axis=1).reshape(-1)
    before = np.maximum.accumulate(np.where(there, np.arange(len(there)), -1))
    # What stands before the first segment with a length takes its direction.
    known = np.where(before < 0, np.argmax(there), before)
    leave = np.where(there[:, None], leave, arrive[known])
    arrive = np.where(there[:, None], arrive, leave)
    ways = (np.arctan2(way[:, 1], way[:, 0]).tolist() for way in (leave, arrive))
    return next(ways), next(ways)
