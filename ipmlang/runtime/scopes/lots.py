"""The closed paths of a drawing as rings of points: what a start stands on.

In goes an SVG file, out come outlines with holes in model coordinates (y up). Curves become chords;
open paths are left out and counted. Where rings of one path cross is told; nothing is mended here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.formats.chords import chords
from ipmlang.formats.drawing import Drawing, Outline
from ipmlang.geometry.solid import Floats, GeometryError

if TYPE_CHECKING:
    import shapely

FINE = 1e-3  # how far chords may be off their curves, as a part of the path's size
MET = 1e-9  # a path whose ends are so near, as a part of its size, is closed


@dataclass(frozen=True, slots=True, eq=False)
class Lot:
    """One closed path or face: its outline first, then its holes, each (n, 2) or (n, 3);
    `trouble`: why it bounds nothing; `name`: what its file calls it.
    """

    rings: tuple[Floats, ...]
    trouble: GeometryError | None = None
    name: str = ""


def closed_paths(path: Path, node: str | None = None) -> tuple[list[Lot], list[str]]:
    """Every closed path in the order of the file, or of one element, and notes of what is left out.

    Subpaths of one element that lie within each other are holes, and islands in these, by
    even-odd; those beside each other are lots of their own. An outline that runs clockwise is
    read from its end, so that a <rect> begins with its lower edge. Raises FormatError for what
    cannot be read.
    """
    from ipmlang.formats.svg import read_node, read_svg

    drawing = read_svg(path) if node is None else read_node(path, node)
    lots: list[Lot] = []
    left = 0
    for element in drawing.elements:
        if element.outline is not None:
            rings, opened = _rings(element.outline, _flip(drawing))
            name = element.source[-1] if element.source else ""
            lots += [replace(each, name=name) for each in _nested(rings)]
            left += opened
    notes = [] if not left else [f"{left} open path{'s' if left > 1 else ''} left out"]
    return lots, notes


def _flip(drawing: Drawing) -> float:
    """What y is taken from, so that it grows upward."""
    return 0.0 if drawing.box is None else 2 * drawing.box[1] + drawing.box[3]


def _rings(outline: Outline, flip: float) -> tuple[list[Floats], int]:
    """The closed subpaths of an element, y up, and how many are open."""
    if not len(outline.kind):
        return [], 0
    lines = chords(outline, max(_size(outline), 1e-300) * FINE)
    rings = []
    for line, closed in zip(lines, outline.closed.tolist(), strict=True):
        points = np.stack([line[:, 0], flip - line[:, 1]], axis=1)
        gap = float(np.abs(points[0] - points[-1]).max())
        met = gap <= MET * float(np.ptp(points, axis=0).max())
        if not closed and not met:
            continue
        rings.append(_onward(points[:-1] if met else points))
    return rings, len(lines) - len(rings)


def _size(outline: Outline) -> float:
    """The greater extent of an element."""
    from ipmlang.formats.svg.bounds import segment_boxes

    boxes = segment_boxes(outline.kind, outline.coords)
    return float((boxes[:, 2:].max(axis=0) - boxes[:, :2].min(axis=0)).max())


def _onward(ring: Floats) -> Floats:
    """A ring counter-clockwise."""
    return ring[::-1] if _twice_area(ring) < 0 else ring


def _twice_area(ring: Floats) -> float:
    x, y = (ring - ring[0]).T  # the first is 0, and so is what it adds
    return float((x[:-1] * y[1:] - y[:-1] * x[1:]).sum())


# ------------------------------------------------------------------------------ holes


def _nested(rings: Sequence[Floats]) -> list[Lot]:
    """The lots that the rings of one element bound, by how many others are around each."""
    if len(rings) == 1:
        return [Lot((rings[0],))]
    around: list[list[int]] = [[] for _ in rings]
    troubles: dict[int, GeometryError] = {}
    for outer, inner in _neighbours(rings):
        try:
            if _is_within(rings[inner], rings[outer]):
                around[inner].append(outer)
        except GeometryError as error:
            troubles[min(outer, inner)] = error
    depth = [len(each) for each in around]
    lots = []
    for number, ring in enumerate(rings):
        if depth[number] % 2 == 0 or number in troubles:
            holes = [
                other
                for other, each in enumerate(around)
                if number in each and depth[other] == depth[number] + 1
            ]
            own = (ring, *(rings[other] for other in holes))
            lots.append(Lot(own, troubles.get(number)))
    return lots


def _neighbours(rings: Sequence[Floats]) -> list[tuple[int, int]]:
    """Pairs of rings whose boxes meet, in both orders."""
    import shapely

    lines = [shapely.linearrings(ring) if len(ring) > 2 else shapely.Point(ring[0])
             for ring in rings]  # fmt: skip
    boxes = shapely.envelope(np.array(lines))
    first, second = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    return [(a, b) for a, b in zip(first.tolist(), second.tolist(), strict=True) if a != b]


def _area_of(ring: Floats) -> shapely.Geometry:
    """What a ring bounds, by even-odd where it crosses itself."""
    import shapely

    valid = shapely.make_valid(shapely.Polygon(ring))
    mixed = valid.geom_type == "GeometryCollection"
    return shapely.buffer(valid, 0) if mixed else valid


def _is_within(inner: Floats, outer: Floats) -> bool:
    """Whether a ring lies within another one. Raises GeometryError where they cross."""
    import shapely

    if len(inner) < 3 or len(outer) < 3:
        return False
    one, other = (_area_of(ring) for ring in (inner, outer))
    shared = float(shapely.area(shapely.intersection(one, other)))
    least = min(float(one.area), float(other.area))
    if shared <= MET * least:
        return False
    if shared < least * (1 - MET):
        x, y = shapely.intersection(one.boundary, other.boundary).representative_point().coords[0]
        raise GeometryError(
            f"its rings cross each other near ({x:.6g}, {y:.6g})",
            "draw them as paths of their own, or unite them first",
        )
    if abs(float(one.area) - float(other.area)) <= MET * least:
        raise GeometryError("two of its rings are the same", "leave one of the two out")
    return float(one.area) < float(other.area)
