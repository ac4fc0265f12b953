"""The largest solid that building lines and sloping planes of light allow on a polygon.

Building lines lie within the edges, at a distance by side; from each the plane of light rises
inward at one angle. What lies below all of them, and below a height, is a closed solid.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.geometry.corners import edges_of
from ipmlang.geometry.planar import closed, opened
from ipmlang.geometry.raising import extrude
from ipmlang.geometry.roofs import roof_hip
from ipmlang.geometry.setbacks import widths_of
from ipmlang.geometry.slabs import slab
from ipmlang.geometry.solid import GeometryError, Solid, joined
from ipmlang.geometry.strips import strips_of

_NAMES = {
    "extrude.bottom": "envelope.bottom",
    "extrude.side": "envelope.side",
    "extrude.top": "envelope.top",
    "roof.bottom": "envelope.bottom",
    "roof.slope": "envelope.slope",
    "split.cut": "envelope.top",
}


def envelope(
    polygon: Solid,
    height: float,
    front: float = 0.0,
    side: float = 0.0,
    back: float = 0.0,
    angle: float = 90.0,
) -> Solid:
    """All that may be built on: within the building lines, below planes of light and a height.

    front, side, back: how far the building lines lie within the edges; angle: degrees from level
    at which planes rise inward from the building lines' feet; 90 gives upright sides. Faces are
    tagged `envelope.bottom`, `envelope.side` (upright) or `envelope.slope`, and `envelope.top`,
    which is missing where the planes meet below the height. Where the lines leave several parts
    the solid has one closed part over each. Raises `GeometryError` where they leave none.

    >>> from ipmlang.geometry.solid import unit_square, volume
    >>> round(volume(envelope(unit_square(), 2, front=0.5)), 9)
    1.0
    """
    if not (np.isfinite(height) and height > 0):
        raise GeometryError(f"an envelope's height must be above 0, and is {height:g}")
    if not 0 < angle <= 90:
        raise GeometryError(
            f"planes of light cannot rise at {angle:g} degrees", "the angle is above 0, up to 90"
        )
    rings, plane = opened(polygon, "envelope")
    edges = edges_of(rings)
    found = strips_of(rings, widths_of(edges, 0.0, front, side, back))
    if not found.rest:
        raise GeometryError(
            "the building lines leave nothing to build on", "give smaller distances to the edges"
        )
    bare = replace(plane, uv=None)
    return joined([_below(closed([rest], bare), height, angle) for rest in found.rest])


def _below(base: Solid, height: float, angle: float) -> Solid:
    if angle == 90:
        return _named(extrude(base, height))
    level = float(base.vertices[0, 2])
    below = slab(roof_hip(base, angle), 2, level, level + height)
    if below is None:
        raise GeometryError("the envelope is too low to have a volume")
    return _named(below)


def _named(solid: Solid) -> Solid:
    tags = tuple(frozenset(_NAMES.get(word, word) for word in each) for each in solid.tags)
    return replace(solid, tags=tags)
