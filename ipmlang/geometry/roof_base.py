"""What all roofs stand on: the footprint they cover, the eaves around it, and their undersides.

In goes a polygon in a plane z = const; out come its clean rings, its rings moved outwards, and the
faces that close a roof from below. Without an overhang that is the footprint itself; with one, a
flat soffit at the eaves' height and, up to the footprint, the inside of what hangs over.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ipmlang.geometry.skeleton import moved_rings
from ipmlang.geometry.skeleton_rings import Ring, fit_rings, mostly_inside
from ipmlang.geometry.solid import Floats, GeometryError, Solid, normals, ring_points, solid_of

BOTTOM, SOFFIT = ("roof.bottom",), ("roof.soffit",)
FLAT = 1e-6  # how far from its plane a corner of a footprint may be, of the footprint's size


@dataclass(frozen=True, slots=True)
class Footprint:
    """A polygon to be roofed: its clean rings, its plane's z, and how many edges it came with."""

    rings: list[Ring]
    level: float
    edges: int

    @property
    def points(self) -> list[Floats]:
        """The points (n, 2) of each ring, the outline first."""
        return [ring.points for ring in self.rings]


def footprint(polygon: Solid) -> Footprint:
    """The footprint that a polygon is; GeometryError if it is not one flat face towards +z."""
    if len(polygon) != 1:
        raise GeometryError(
            f"a roof stands on one polygon, not on {len(polygon)} faces",
            "choose a face first, with comp",
        )
    rings = ring_points(polygon, 0)
    everything = np.concatenate(rings)
    low, high = everything.min(axis=0), everything.max(axis=0)
    if high[2] - low[2] > FLAT * float((high - low).max()):
        raise GeometryError(
            "a roof stands on a level polygon", "this one is not level in its scope"
        )
    fit = fit_rings([ring[:, :2] for ring in rings])
    if normals(polygon)[0, 2] < 0:
        raise GeometryError("a roof's polygon must face up", "turn it over first")
    return Footprint(fit, float(low[2]), len(everything))


@dataclass(frozen=True, slots=True)
class Eaves:
    """The clean rings that a roof begins at, `drop` below its footprint.

    The edges of the rings bear numbers of their own; origins: of each number, the polygon's edge
    that the edge is, -1 for none.
    """

    rings: list[Ring]
    origins: Sequence[int]
    drop: float


def eaves(base: Footprint, drop: float, speeds: Sequence[float]) -> Eaves:
    """The footprint's rings when each of its edges has moved outwards by drop times its speed."""
    if drop == 0:
        return Eaves(base.rings, range(base.edges), 0.0)
    moved = moved_rings(base.rings, -drop, speeds)
    origins = [edge for ring in moved for edge in ring.edges]
    return Eaves(fit_rings([ring.points for ring in moved]), origins, drop)


@dataclass(slots=True)
class Faces:
    """A solid in the making."""

    vertices: list[tuple[float, float, float]] = field(default_factory=list)
    faces: list[list[list[int]]] = field(default_factory=list)
    tags: list[tuple[str, ...]] = field(default_factory=list)

    def add_points(self, points: Iterable[Sequence[float]], level: float = 0.0) -> list[int]:
        """New vertices, from points over a level; their numbers."""
        first = len(self.vertices)
        self.vertices.extend((float(x), float(y), float(z) + level) for x, y, z in points)
        return list(range(first, len(self.vertices)))

    def add_level(self, points: Floats, z: float) -> list[int]:
        """New vertices at a height, from points (n, 2); their numbers."""
        return self.add_points((x, y, z) for x, y in points.tolist())

    def add(self, rings: list[list[int]], tags: tuple[str, ...]) -> None:
        """A face of rings of vertex numbers, counter-clockwise from outside."""
        self.faces.append(rings)
        self.tags.append(tags)

    def solid(self) -> Solid:
        """All faces, over the vertices that they use."""
        used = sorted({corner for face in self.faces for ring in face for corner in ring})
        number = {vertex: k for k, vertex in enumerate(used)}
        vertices = np.array(self.vertices)[used]
        faces = [[[number[corner] for corner in ring] for ring in face] for face in self.faces]
        return solid_of(vertices, faces, self.tags)


def add_underside(made: Faces, base: Footprint, around: Eaves, border: list[list[int]]) -> None:
    """Close a roof from below; `border` are the vertex numbers of the eaves' rings."""
    if around.drop == 0:
        made.add([ring[::-1] for ring in border], BOTTOM)
        return
    upper = [made.add_level(points, base.level) for points in base.points]
    lower = [made.add_level(points, base.level - around.drop) for points in base.points]
    made.add([ring[::-1] for ring in upper], BOTTOM)
    for high, low in zip(upper, lower, strict=True):
        for k in range(len(high)):
            made.add([[high[k - 1], high[k], low[k], low[k - 1]]], SOFFIT)
    # Seen from below: the eaves' outline around the footprint's, its holes around the eaves' holes.
    soffits = [[border[0][::-1], lower[0]], *([ring] for ring in lower[1:])]
    for ring, court in zip(border[1:], around.rings[1:], strict=True):
        inside = [
            k for k, hole in enumerate(base.points) if k and mostly_inside(court.points, hole)
        ]
        soffits[inside[0] if inside else 0].append(ring[::-1])
    for soffit in soffits:
        made.add(soffit, SOFFIT)
