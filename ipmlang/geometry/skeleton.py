"""The weighted straight skeleton of a polygon with holes: a roof of planes seen from above.

Each edge moves inwards at its own speed; its face is what it sweeps, with the time as height. In
go rings and speeds; out comes one face for each edge over shared vertices, proved to tile the
polygon, or GeometryError, never a wrong result. After Aichholzer et al., "A Novel Type of Skeleton
for Polygons" (1995), and Biedl et al., "Weighted Straight Skeletons in the Plane" (2015).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import frexp, inf, ldexp
from random import Random

import numpy as np

from ipmlang.geometry.skeleton_faces import prove, traced
from ipmlang.geometry.skeleton_lines import BrokenError, Lines, OpenError, Region, loops_of
from ipmlang.geometry.skeleton_rings import Ring, directions, fit_rings, reversed_ring, signed_area
from ipmlang.geometry.skeleton_wavefront import Wavefront
from ipmlang.geometry.solid import Floats, GeometryError

Rings = Sequence[Floats | Sequence[Sequence[float]]]

# How near is contact, in units of the polygon's size, and how much speeds are changed by: tried
# in turn until a result is proved. The changes are far below what a result is measured by.
MOST = 1500  # corners: the work grows with their square, to some ten seconds
ATTEMPTS = ((1e-10, 0.0), (1e-12, 0.0), (1e-11, 1e-11), (1e-10, 1e-10), (1e-12, 3e-10))


@dataclass(frozen=True, slots=True)
class Skeleton:
    """vertices (v, 3): x, y and the time at which the wavefront is there.

    faces: for each edge of the input, in order through all rings, its vertices counter-clockwise
    seen from above, its own ends first; none for an edge without length. holes: for an edge so
    fast that its face runs all around others', the inner rings, clockwise. walls: upright faces
    between edges of unequal speed that follow each other in one line.
    """

    vertices: Floats
    faces: list[list[int]]
    holes: dict[int, list[list[int]]]
    walls: list[list[int]]


@dataclass(frozen=True, slots=True)
class _Problem:
    """Rings moved and scaled to about size 1 and speed 1, and what turns them back."""

    rings: list[Ring]
    speeds: list[float]
    centre: Floats
    unit: float
    fastest: float


def straight_skeleton(rings: Rings, speeds: Sequence[float] | None = None) -> Skeleton:
    """The skeleton of an outline and its holes, each (n, 2), any way round.

    speeds: of each edge (the first ring's edge k goes from its point k to the next), through all
    rings; at least 0, where 0 keeps the edge in place and gives an upright face; 1 for all if not
    given. Raises GeometryError for what is no polygon and for speeds that never close.

    >>> found = straight_skeleton([[(0, 0), (4, 0), (4, 2), (0, 2)]])
    >>> [len(face) for face in found.faces], float(found.vertices[:, 2].max())
    ([4, 3, 4, 3], 1.0)
    """
    return skeleton_of(fit_rings(rings), _for_each_edge(rings, speeds))


def skeleton_of(rings: list[Ring], speeds: Sequence[float]) -> Skeleton:
    """The skeleton of clean rings; speeds and faces are by the numbers that their edges bear."""
    problem = _problem(rings, speeds)
    open_ended = False
    for reach, change in ATTEMPTS:
        try:
            return _solved(problem, reach, change)
        except BrokenError as failure:
            open_ended = isinstance(failure, OpenError) and min(speeds) == 0
    if open_ended:
        raise GeometryError(
            "upright edges enclose a part of the polygon", "give more of its edges a slope"
        )
    raise GeometryError(
        "the polygon has no skeleton that can be proved right",
        "look for edges that nearly touch, or give its edges more equal slopes",
    )


def moved_rings(rings: list[Ring], distance: float, speeds: Sequence[float]) -> list[Ring]:
    """The rings after every edge has moved inwards by distance times its speed; speeds are by the
    numbers of the edges of clean rings.

    A negative distance moves edges outwards. Gives outlines counter-clockwise, each before its
    holes, which are clockwise; a point whose edge bears -1 begins a new one, between edges in one
    line that moved by unequal distances. None are left where the polygon is used up. Raises
    GeometryError as `straight_skeleton` does.
    """
    turned = [reversed_ring(ring) for ring in rings] if distance < 0 else rings
    problem = _problem(turned, speeds)
    limit = abs(distance) * problem.fastest / problem.unit
    for reach, change in ATTEMPTS:
        try:
            _, regions = _moved(problem, reach, change, limit)
        except BrokenError:
            continue
        found = [ring for region in regions for ring in _rings(problem, region, limit)]
        if distance < 0:
            found = sorted(map(reversed_ring, found), key=lambda ring: signed_area(ring.points) < 0)
        return found
    raise GeometryError("the polygon's edges cannot be moved by that distance")


def _for_each_edge(rings: Rings, speeds: Sequence[float] | None) -> list[float]:
    edges = sum(len(ring) for ring in rings)
    given = [1.0] * edges if speeds is None else [float(speed) for speed in speeds]
    if len(given) != edges:
        raise GeometryError(f"{edges} edges need {edges} speeds, not {len(given)}")
    return given


def _problem(rings: list[Ring], speeds: Sequence[float]) -> _Problem:
    corners = sum(len(ring.edges) for ring in rings)
    if corners > MOST:
        raise GeometryError(
            f"slopes can rise from up to {MOST:,} corners, and the polygon has {corners:,} corners",
            "draw round edges with fewer corners, or cut the polygon into parts",
        )
    if not all(0 <= speed < inf for speed in speeds):
        raise GeometryError("the speed of an edge must be at least 0")
    points = np.concatenate([ring.points for ring in rings])
    low, high = points.min(axis=0), points.max(axis=0)
    unit = ldexp(1.0, frexp(float((high - low).max()))[1])  # a power of two: scaling is exact
    fastest = max(speeds[edge] for ring in rings for edge in ring.edges)
    if fastest == 0:
        raise GeometryError("no edge moves", "one edge must have a slope")
    centre = (low + high) / 2
    scaled = [Ring((ring.points - centre) / unit, ring.edges) for ring in rings]
    return _Problem(scaled, [speed / fastest for speed in speeds], centre, unit, fastest)


def _started(problem: _Problem, reach: float, change: float) -> tuple[Wavefront, list[Region]]:
    """A wavefront at time 0; line k is the k-th edge of the cleaned rings."""
    lines = Lines()
    chance = Random(len(problem.speeds))
    changes: dict[tuple[float, float, float], float] = {}
    corners: list[list[tuple[float, float, int]]] = []
    for ring in problem.rings:
        onward = directions(ring.points)
        own: list[tuple[float, float, int]] = []
        for (x, y), (dx, dy), edge in zip(
            ring.points.tolist(), onward.tolist(), ring.edges, strict=True
        ):
            speed = problem.speeds[edge]
            if change:  # edges of one direction change together: they may come to lie in one line
                key = (round(dx, 9), round(dy, 9), speed)
                speed *= changes.setdefault(key, 1 + change * chance.uniform(-1, 1))
            own.append((x, y, lines.add(dx, dy, x, y, speed)))
        corners.append(own)
    front = Wavefront(lines, reach)
    return front, front.start(corners)


def _moved(
    problem: _Problem, reach: float, change: float, limit: float
) -> tuple[Wavefront, list[Region]]:
    """The wavefront at the limit and the regions that are left then."""
    front, waiting = _started(problem, reach, change)
    left: list[Region] = []
    budget = 20 * len(front.lines.dx) + 100
    while waiting:
        region = waiting.pop()
        found = front.step(region, limit)
        if found is None:
            left.append(region)
        else:
            waiting.extend(found)
        budget -= 1
        if budget < 0:
            raise BrokenError("the wavefront makes no progress")
    return front, left


def _solved(problem: _Problem, reach: float, change: float) -> Skeleton:
    front, _ = _moved(problem, reach, change, inf)
    edges = [edge for ring in problem.rings for edge in ring.edges]
    rings = traced(front, len(edges))
    nodes = np.array(front.nodes)
    kept = {line: face for line, face in enumerate(rings) if face or line < len(edges)}
    prove(front.lines, nodes, kept)
    used = sorted({node for face in kept.values() for ring in face for node in ring})
    number = {node: k for k, node in enumerate(used)}
    vertices = nodes[used] * problem.unit
    vertices[:, :2] += problem.centre
    vertices[:, 2] /= problem.fastest
    faces: list[list[int]] = [[] for _ in problem.speeds]
    holes: dict[int, list[list[int]]] = {}
    walls: list[list[int]] = []
    for line, face in kept.items():
        outline, *inner = [[number[node] for node in ring] for ring in face]
        if line >= len(edges):
            walls.append(outline)
            continue
        faces[edges[line]] = outline
        if inner:
            holes[edges[line]] = inner
    return Skeleton(vertices, faces, holes, walls)


def _rings(problem: _Problem, region: Region, limit: float) -> Iterator[Ring]:
    """The rings of what is left of a region, in the input's coordinates."""
    edges = [edge for ring in problem.rings for edge in ring.edges]
    for loop in loops_of(region.corners):
        points = np.array([corner.at(limit) for corner in loop]) * problem.unit + problem.centre
        own = [edges[c.after] if c.after < len(edges) else -1 for c in loop]
        yield Ring(points, own)
