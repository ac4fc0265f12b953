"""Footprints that the tests make: rectilinear, rotated, stars, with courtyards, and hard cases.

Each is a list of rings of points, the outline first and counter-clockwise; the same seed gives the
same footprint.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import cos, pi, sin

import numpy as np
from numpy.random import Generator, default_rng
from shapely import affinity
from shapely.geometry import Polygon, box
from shapely.geometry.polygon import orient
from shapely.ops import unary_union

Rings = list[list[tuple[float, float]]]


def rings_of(shape: Polygon) -> Rings:
    turned = orient(shape)
    return [list(ring.coords)[:-1] for ring in (turned.exterior, *turned.interiors)]


def area_of(rings: Rings) -> float:
    return float(Polygon(rings[0], rings[1:]).area)


def rectilinear(chance: Generator) -> Polygon:
    while True:
        corners = chance.integers(0, 12, (int(chance.integers(3, 9)), 2))
        sizes = chance.integers(1, 8, corners.shape)
        shape = unary_union([box(*at, *(at + by)) for at, by in zip(corners, sizes, strict=True)])
        if shape.geom_type == "Polygon":
            return shape


def rotated(chance: Generator) -> Polygon:
    return affinity.rotate(rectilinear(chance), float(chance.uniform(0, 360)))


def star(chance: Generator, corners: int = 0) -> Polygon:
    count = corners or int(chance.integers(6, 40))
    while True:
        angles = np.sort(chance.uniform(0, 2 * pi, count))
        far = chance.uniform(3, 10, count)
        shape = Polygon(np.stack([np.cos(angles) * far, np.sin(angles) * far], axis=1))
        if np.diff(angles).min() > 1e-4 and shape.is_valid and shape.area > 1:
            return shape


def with_courtyards(chance: Generator) -> Polygon:
    while True:
        shape = star(chance, int(chance.integers(5, 20)))
        for _ in range(int(chance.integers(1, 5))):
            angles = np.sort(chance.uniform(0, 2 * pi, int(chance.integers(3, 7))))
            ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            hole = Polygon(ring * chance.uniform(0.3, 2) + chance.uniform(-7, 7, 2))
            if hole.is_valid and hole.area > 0.01 and shape.buffer(-0.05).contains(hole):
                shape = shape.difference(hole)
        if shape.interiors:
            return shape


def the_300() -> Iterator[tuple[str, Rings]]:
    """100 rectilinear, 100 rotated, 60 stars, 40 with holes."""
    made: list[tuple[Callable[[Generator], Polygon], int]] = [
        (rectilinear, 100), (rotated, 100), (star, 60), (with_courtyards, 40)
    ]  # fmt: skip
    for make, count in made:
        for k in range(count):
            yield f"{make.__name__} {k}", rings_of(make(default_rng([count, k])))


def regular(corners: int, radius: float = 5.0, turn: float = 0.0) -> list[tuple[float, float]]:
    angles = [turn + 2 * pi * k / corners for k in range(corners)]
    return [(radius * cos(angle), radius * sin(angle)) for angle in angles]


def turned(rings: Rings, angle: float) -> Rings:
    c, s = cos(angle), sin(angle)
    return [[(c * x - s * y, s * x + c * y) for x, y in ring] for ring in rings]


SQUARE: Rings = [[(0, 0), (4, 0), (4, 4), (0, 4)]]
L_SHAPE: Rings = [[(0, 0), (10, 0), (10, 4), (4, 4), (4, 9), (0, 9)]]
U_SHAPE: Rings = [[(0, 0), (12, 0), (12, 9), (8, 9), (8, 4), (4, 4), (4, 9), (0, 9)]]
T_SHAPE: Rings = [[(0, 6), (4, 6), (4, 0), (8, 0), (8, 6), (12, 6), (12, 10), (0, 10)]]
PLUS: Rings = [
    [
        *((4, 0), (8, 0), (8, 4), (12, 4), (12, 8), (8, 8)),
        *((8, 12), (4, 12), (4, 8), (0, 8), (0, 4), (4, 4)),
    ]
]
COURT: Rings = [[(0, 0), (12, 0), (12, 12), (0, 12)], [(4, 4), (4, 8), (8, 8), (8, 4)]]
FOUR_COURTS: Rings = [
    [(0, 0), (7, 0), (7, 7), (0, 7)],
    *([(x, y), (x, y + 2), (x + 2, y + 2), (x + 2, y)] for x in (1, 4) for y in (1, 4)),
]
ROUND_COURT: Rings = [regular(12), regular(12, 2.0)[::-1]]
NEAR_RECTANGLE: Rings = [[(0, 0.1), (10, -0.1), (10.1, 6), (0.05, 6.1)]]
NAMED: dict[str, Rings] = {
    "square": SQUARE,
    "rectangle": [[(0, 0), (10, 0), (10, 6), (0, 6)]],
    "L": L_SHAPE,
    "U": U_SHAPE,
    "T": T_SHAPE,
    "plus": PLUS,
    "court": COURT,
    "four courts": FOUR_COURTS,
    "round court": ROUND_COURT,
    "near-rectangle": NEAR_RECTANGLE,
    "triangle": [[(0, 0), (6, 0), (2, 5)]],
    "200-gon": [regular(200)],
}


def hard_cases(seed: int) -> Iterator[tuple[str, Rings]]:
    """What breaks skeletons: see each name."""
    chance = default_rng(seed)
    angle = float(chance.uniform(0, 6))
    for name, rings in NAMED.items():
        yield name, rings
        yield f"turned {name}", turned(rings, angle)
    for corners in (3, 5, 6, 8, 60, 199):
        yield f"{corners}-gon", [regular(corners, turn=angle)]
    flower = np.array(regular(24)) * np.where(np.arange(24) % 2, 1.0, 0.5)[:, None]
    yield "regular star", [[(x, y) for x, y in flower.tolist()]]
    corners = np.array([(0, 0), (9, 0), (9, 6), (0, 6)], float)
    for power in range(2, 14):
        moved = corners + chance.uniform(-1, 1, (4, 2)) * 10.0**-power * 2 * (9, 6)
        yield f"rectangle moved by 1e-{power}", [[(x, y) for x, y in moved.tolist()]]
    for power in range(1, 8):
        slit = 10.0**-power
        yield (
            f"slit of 1e-{power}",
            [
                [
                    *((0, 0), (10, 0), (10, 10), (6 + slit, 10), (6, 3), (6 - slit, 10)),
                    *((4, 10), (4, 4), (4 - slit, 4), (4 - slit, 10), (0, 10)),
                ]
            ],
        )
    yield (
        "notches that face",
        [[(0, 0), (4, 0), (5, 3), (6, 0), (10, 0), (10, 8), (6, 8), (5, 5), (4, 8), (0, 8)]],
    )


def with_more_corners(rings: Rings, chance: Generator, off: float) -> Rings:
    """Corners on the edges, off them by at most a distance."""
    found: Rings = []
    for ring in rings:
        own: list[tuple[float, float]] = []
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
            own.append((ax, ay))
            for part in np.sort(chance.uniform(0.1, 0.9, int(chance.integers(0, 3)))).tolist():
                x, y = chance.uniform(-off, off, 2).tolist()
                own.append((ax + part * (bx - ax) + x, ay + part * (by - ay) + y))
        found.append(own)
    return found


def with_tiny_edges(rings: Rings, chance: Generator, length: float) -> Rings:
    """Some corners cut off by edges of about a length."""
    found: Rings = []
    for ring in rings:
        own: list[tuple[float, float]] = []
        for x, y in ring:
            own.append((x, y))
            if chance.random() < 0.4:
                dx, dy = chance.uniform(-length, length, 2).tolist()
                own.append((x + dx, y + dy))
        found.append(own)
    shape = Polygon(found[0], found[1:])
    return found if shape.is_valid else with_tiny_edges(rings, chance, length)
