"""Solids that fill the box from the origin to (1, 1, 1), and the disk that fills the unit square.

Their sides are plane, the first looks to the front; tags say which face is which. The cube and the
square are `solid.unit_box` and `solid.unit_square`.
"""

from __future__ import annotations

import numpy as np

from ipmlang.geometry.solid import Floats, Solid, polygon, solid_of

SIDES = 32


def disk(sides: int = SIDES) -> Solid:
    """A polygon of at least 3 equal sides, stretched to fill the unit square; `disk.face`.

    >>> disk(4).vertices.round(9).tolist()[:2]
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    """
    return polygon(_circle(sides), tags=["disk.face"])


def cylinder(sides: int = SIDES) -> Solid:
    """Upright: `cylinder.bottom`, `cylinder.top`, then each `cylinder.side`."""
    ring = _circle(sides)
    k = np.arange(sides)
    after = (k + 1) % sides
    quads = np.stack([k, after, after + sides, k + sides], axis=1).tolist()
    return solid_of(
        np.concatenate([_at(ring, 0.0), _at(ring, 1.0)]),
        [[k[::-1].tolist()], [(k + sides).tolist()], *([quad] for quad in quads)],
        [["cylinder.bottom"], ["cylinder.top"], *[["cylinder.side"]] * sides],
    )


def cone(sides: int = SIDES) -> Solid:
    """Upright with its point over the middle: `cone.bottom`, then each `cone.side`."""
    k = np.arange(sides)
    triangles = np.stack([k, (k + 1) % sides, np.full(sides, sides)], axis=1).tolist()
    return solid_of(
        np.concatenate([_at(_circle(sides), 0.0), [(0.5, 0.5, 1.0)]]),
        [[k[::-1].tolist()], *([triangle] for triangle in triangles)],
        [["cone.bottom"], *[["cone.side"]] * sides],
    )


def sphere(sides: int = SIDES) -> Solid:
    """Half as many zones as sides (at least 2) between two poles; `sphere.side` from below."""
    zones = max(2, sides // 2)
    ring = _circle(sides) - 0.5
    slope = np.pi * np.arange(1, zones) / zones
    levels = [_at(ring * np.sin(a) + 0.5, (1 - np.cos(a)) / 2) for a in slope]
    south, north = sides * (zones - 1), sides * (zones - 1) + 1
    faces: list[list[int]] = []
    for zone in range(zones):
        for k in range(sides):
            low, high = (zone - 1) * sides, zone * sides
            after = (k + 1) % sides
            below = [south] if zone == 0 else [low + k, low + after]
            above = [north] if zone == zones - 1 else [high + after, high + k]
            faces.append(below + above)
    points = _filled(np.concatenate([*levels, [(0.5, 0.5, 0.0), (0.5, 0.5, 1.0)]]))
    return solid_of(points, [[face] for face in faces], [["sphere.side"]] * len(faces))


def _circle(sides: int) -> Floats:
    """Points (n, 2) of a regular polygon with a side in front, stretched to the unit square."""
    angles = (np.arange(sides) * 2 - sides / 2 - 1) * np.pi / sides
    return _filled(np.stack([np.cos(angles), np.sin(angles)], axis=1))


def _filled(points: Floats) -> Floats:
    low, high = points.min(axis=0), points.max(axis=0)
    filled: Floats = (points - low) / (high - low)
    return filled


def _at(ring: Floats, z: float) -> Floats:
    return np.concatenate([ring, np.full((len(ring), 1), z)], axis=1)
