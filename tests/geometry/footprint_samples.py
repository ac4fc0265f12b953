"""Polygons made by a seeded generator, for properties that must hold for all of them."""

from __future__ import annotations

import numpy as np
import shapely

from ipmlang.geometry.solid import Floats, Solid, polygon, ring_points

Chance = np.random.Generator


def star(chance: Chance, corners: int, inner: float) -> Floats:
    """A ring (n, 2) around the origin whose corners lie at random distances."""
    angles = np.sort(chance.uniform(0, 2 * np.pi, corners))
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False) + 0.6 * angles / corners
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) * (
        10 * chance.uniform(inner, 1, corners)[:, None]
    )


def rectilinear(chance: Chance, boxes: int) -> Floats:
    """The outline of boxes on a grid that hang together."""
    found = shapely.box(0, 0, 4, 3)
    while boxes:
        x, y = chance.integers(-6, 7, 2)
        more = shapely.box(x, y, x + chance.integers(1, 5), y + chance.integers(1, 5))
        if found.intersection(more).area > 0:
            found, boxes = found.union(more), boxes - 1
    outline = found.exterior.simplify(0)
    ring = shapely.get_coordinates(outline)[:-1]
    return ring if outline.is_ccw else ring[::-1]


def turned(ring: Floats, degrees: float) -> Floats:
    """A ring turned about the origin."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return ring @ np.array([[c, s], [-s, c]])


def jittered(chance: Chance, ring: Floats) -> Floats:
    """A ring as from a map: no right angles, a tiny edge at some corners."""
    moved = ring + chance.uniform(-0.05, 0.05, ring.shape)
    ahead = np.roll(moved, -1, axis=0) - moved
    tiny = moved + 1e-4 * ahead
    keep = np.stack([np.ones(len(ring), bool), chance.random(len(ring)) < 0.3], axis=1)
    return np.stack([moved, tiny], axis=1).reshape(-1, 2)[keep.reshape(-1)]


def with_hole(chance: Chance, ring: Floats) -> list[Floats]:
    """The ring, and a square hole where there is room for one."""
    whole = shapely.Polygon(ring)
    middle = whole.representative_point()
    size = min(0.8, whole.exterior.distance(middle) / 2)
    corners = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)]) * size * chance.uniform(0.3, 0.9)
    hole = turned(corners, chance.uniform(0, 90)) + np.array([middle.x, middle.y])
    return [ring, hole]


def samples(count: int, seed: int = 7) -> list[Solid]:
    """Rectilinear, turned, star-shaped and jittered polygons, some with a hole."""
    chance = np.random.default_rng(seed)
    found: list[Solid] = []
    for number in range(count):
        ring = (
            rectilinear(chance, 3) if number % 4 == 0
            else turned(rectilinear(chance, 4), chance.uniform(0, 360)) if number % 4 == 1
            else star(chance, int(chance.integers(3, 16)), 0.35) if number % 4 == 2
            else jittered(chance, rectilinear(chance, 3))
        )  # fmt: skip
        rings = with_hole(chance, ring) if number % 3 == 0 else [ring]
        found.append(polygon(rings[0], rings[1:]))
    return found


def shape_of_face(solid: Solid, face: int = 0) -> shapely.Polygon:
    """A face as shapely has it, seen from above."""
    rings = [ring[:, :2] for ring in ring_points(solid, face)]
    return shapely.Polygon(rings[0], rings[1:])


def shapes(solids: list[Solid]) -> list[shapely.Polygon]:
    """All faces of all solids."""
    return [shape_of_face(solid, face) for solid in solids for face in range(len(solid))]


def overlap(parts: list[shapely.Polygon]) -> float:
    """The area that two or more of the parts share."""
    tree = shapely.STRtree(parts)
    one, other = tree.query(parts, predicate="intersects")
    pairs = [(parts[a], parts[b]) for a, b in zip(one, other, strict=True) if a < b]
    return sum(a.intersection(b, grid_size=1e-10).area for a, b in pairs)
