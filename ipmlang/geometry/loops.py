"""From edges to faces: directed edges chain to loops, loops nest to outlines with their holes.

Edges run with the inside on their left. Where several loops meet in a point, the sharpest left
turn is taken, so that a loop never crosses itself. Points are plane; nothing here knows solids.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import atan2, tau

Flat = Mapping[int, tuple[float, float]]
Edge = tuple[int, int]
Vector = tuple[float, float, float]


def unmatched(edges: Iterable[Edge]) -> list[Edge]:
    """The edges without their opposites: the border of what they bound, in the order given.

    >>> unmatched([(0, 1), (1, 2), (2, 1), (2, 0)])
    [(0, 1), (2, 0)]
    """
    count: dict[Edge, int] = {}
    for edge in edges:
        opposite = (edge[1], edge[0])
        if count.get(opposite, 0):
            count[opposite] -= 1
        else:
            count[edge] = count.get(edge, 0) + 1
    return [edge for edge, number in count.items() for _ in range(number)]


def chained(edges: Sequence[Edge], flat: Flat) -> list[list[int]]:
    """Loops of vertex numbers that use each edge once; edges that lead nowhere are left out.

    >>> chained([(0, 1), (1, 2), (2, 0)], {0: (0, 0), 1: (1, 0), 2: (0, 1)})
    [[0, 1, 2]]
    """
    after: dict[int, list[int]] = {}
    for start, end in edges:
        after.setdefault(start, []).append(end)
    loops = []
    for start, _ in edges:
        while after.get(start):
            loop = _walked(start, after, flat)
            if loop is not None:
                loops.append(loop)
    return loops


def _walked(start: int, after: dict[int, list[int]], flat: Flat) -> list[int] | None:
    loop = [start]
    now = after[start].pop()
    while now != start:
        ways = after.get(now)
        if not ways:
            return None
        way = 0 if len(ways) == 1 else _leftmost(flat[loop[-1]], flat[now], [flat[w] for w in ways])
        loop.append(now)
        now = ways.pop(way)
    # A loop ends where it began; if it passed its start before, the rest makes the next loop.
    return loop


def _leftmost(
    before: tuple[float, float], here: tuple[float, float], ways: list[tuple[float, float]]
) -> int:
    back = atan2(before[1] - here[1], before[0] - here[0])
    turns = [(back - atan2(y - here[1], x - here[0])) % tau for x, y in ways]
    return min(range(len(ways)), key=lambda way: turns[way] or tau)


def signed_area(loop: Sequence[int], flat: Flat) -> float:
    """The area of a loop, negative where it runs clockwise."""
    points = [flat[number] for number in loop]
    ox, oy = points[0]
    total = 0.0
    for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1], strict=True):
        total += (ax - ox) * (by - oy) - (bx - ox) * (ay - oy)
    return total / 2


def encloses(loop: Sequence[int], point: tuple[float, float], flat: Flat) -> bool:
    """Whether a point lies in a loop (by counting crossings)."""
    x, y = point
    inside = False
    bx, by = flat[loop[-1]]
    for number in loop:
        ax, ay = bx, by
        bx, by = flat[number]
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


def nested(loops: Sequence[list[int]], flat: Flat) -> list[list[list[int]]]:
    """Faces of loops: each that runs counter-clockwise is an outline, with the holes within it."""
    areas = [signed_area(loop, flat) for loop in loops]
    order = [n for n, each in enumerate(areas) if each > 0]
    faces = {n: [loops[n]] for n in order}
    for n, hole in enumerate(loops):
        if areas[n] < 0 and (owner := _owner(hole, order, loops, areas, flat)) is not None:
            faces[owner].append(hole)
    return list(faces.values())


def _owner(
    hole: list[int],
    outlines: list[int],
    loops: Sequence[list[int]],
    areas: list[float],
    flat: Flat,
) -> int | None:
    """The smallest outline around a hole."""
    if len(outlines) < 2:
        return outlines[0] if outlines else None
    around = []
    for n in outlines:
        corners = set(loops[n])
        free = next((flat[number] for number in hole if number not in corners), None)
        if areas[n] >= 0 and (free is None or encloses(loops[n], free, flat)):
            around.append(n)
    return min(around, key=lambda n: areas[n], default=None)


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """The sum of the products of two vectors' three coordinates."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    """The vector across two, as long as the area between them."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def frame(up: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors across a unit vector, right-handed with it; x, y, z stay in order."""
    main = max(range(3), key=lambda n: abs(up[n]))
    start = [float(n == (main + 1) % 3) for n in range(3)]
    along = cross(up, start)
    length = dot(along, along) ** 0.5
    along = (along[0] / length, along[1] / length, along[2] / length)
    return cross(along, up), along
