"""Points in and on a solid from given uniforms: on its surface, in its volume, in its box.

Uniforms (n, 3) in [0, 1) come in, points (n, 3) go out: point k hangs on row k alone. No point is
tried and thrown away: each coordinate is found by inverting how much lies below it, so points are
uniform exactly, and the work for a point is bounded.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.geometry.sections import heights_of, layers_of, sections, sides_of, within
from ipmlang.geometry.solid import Floats, GeometryError, Indices, Solid, bounds, is_closed, joined
from ipmlang.geometry.triangles import triangles

_AT_ONCE = 200_000  # uses of triangles by points that are looked at together


def scatter(solid: Solid, count: int, over: str, uniforms: Floats) -> Floats:
    """`count` points (count, 3), one for each row of uniforms (count, 3).

    over: surface, uniform by area over all faces; volume, uniform within a closed solid; scope,
    uniform within the box around it. GeometryError where there is no area, or the solid is open.

    >>> from ipmlang.geometry.solid import unit_box
    >>> scatter(unit_box(), 1, "volume", np.array([[0.5, 0.25, 0.75]])).round(9).tolist()
    [[0.25, 0.75, 0.5]]
    """
    if not count:
        return np.zeros((0, 3))
    make = {"surface": _on_surface, "volume": _in_volume, "scope": _in_box}[over]
    return make(solid, np.asarray(uniforms, np.float64).reshape(count, 3))


def scattered(solids: Sequence[Solid], counts: Indices, over: str, uniforms: Floats) -> Floats:
    """What `scatter` gives in each of many solids, one after the other: `counts` (n,) points each,
    of as many rows of uniforms (p, 3).
    """
    ends = np.cumsum(counts).tolist()
    rows = [slice(end - count, end) for end, count in zip(ends, counts.tolist(), strict=True)]
    if over == "surface":
        parts = zip(_surfaces(solids), rows, strict=True)
        found = [_on_triangles(own, uniforms[chosen]) for own, chosen in parts]
    else:
        own = zip(solids, counts.tolist(), rows, strict=True)
        found = [scatter(solid, count, over, uniforms[chosen]) for solid, count, chosen in own]
    return np.concatenate([np.zeros((0, 3)), *found])


def _in_box(solid: Solid, uniforms: Floats) -> Floats:
    low, high = bounds(solid)
    points: Floats = low + uniforms * (high - low)
    return points


def _on_surface(solid: Solid, uniforms: Floats) -> Floats:
    return _on_triangles(_surfaces([solid])[0], uniforms)


def _surfaces(solids: Sequence[Solid]) -> list[Floats]:
    """The corners (t, 3, 3) of triangles that fill the faces of each solid."""
    if not solids:
        return []
    whole = joined(solids)
    corners, face = triangles(whole)
    last = np.searchsorted(face, np.cumsum([len(each) for each in solids]))
    return np.split(whole.vertices[corners], last[:-1])


def _on_triangles(corners: Floats, uniforms: Floats) -> Floats:
    a, b, c = corners.transpose(1, 0, 2)
    (x, y, z), (u, v, w) = (b - a).T, (c - a).T
    below = np.cumsum(np.sqrt((y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2))
    if not len(below) or below[-1] <= 0:
        raise GeometryError(
            "there is no surface to scatter on", "scatter over a polygon or a solid"
        )
    at = np.searchsorted(below, uniforms[:, 0] * below[-1], side="right")
    at = np.minimum(at, len(below) - 1)
    root = np.sqrt(uniforms[:, 1])[:, None]
    rest = uniforms[:, 2][:, None]
    points: Floats = (1 - root) * a[at] + root * ((1 - rest) * b[at] + rest * c[at])
    return points


def _in_volume(solid: Solid, uniforms: Floats) -> Floats:
    """z by the volume below it, then x and y within the section there."""
    if not is_closed(solid):
        raise GeometryError(
            "only a closed solid has a volume to scatter in",
            "scatter over the surface, or give the polygon a height with extrude first",
        )
    corners, _ = triangles(solid)
    centre = np.mean(bounds(solid), axis=0)  # sums of areas lose less near the origin
    sides = sides_of(solid.vertices[corners] - centre)
    layers = layers_of(sides)
    if not layers.below[-1] > 0:
        raise GeometryError("there is no volume to scatter in", "scatter over the surface")
    layer, z = heights_of(layers, uniforms[:, 0])
    points = np.empty((len(z), 3))
    points[:, 2] = z
    # Points whose sections are of about one size are looked at together.
    counts = layers.counts[layer]
    order = np.argsort(counts, kind="stable")
    begin = 0
    while begin < len(order):
        most = int(counts[order[min(begin + _AT_ONCE, len(order)) - 1]])
        some = order[begin : begin + max(1, _AT_ONCE // max(most, 1))]
        starts, ends, used = sections(sides, layers, layer[some], z[some])
        points[some, :2] = within(starts, ends, used, uniforms[some, 1:])
        begin += len(some)
    points += centre
    return points
