"""The parting of one face by a plane: what is below, what is above, what they share.

A face is rings of corner numbers over the lists of a cutting, which grow by the points where edges
meet planes. Any polygon comes in, with holes, concave, touching the plane or running along it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import chain

from ipmlang.geometry.loops import Vector, cross, dot, encloses

Ring = list[int]
"""Corner numbers, one after the other."""
Face = list[Ring]
Slab = tuple[list[Face], list[frozenset[str]]]
"""Faces, and the tags of each."""


@dataclass(slots=True)
class Cutting:
    """A solid under the knife: lists that grow by the points where edges meet planes.

    points, heights and ranks go by vertex, vertex and uv by corner. A vertex on plane k has the
    rank 2k + 1, one between planes k - 1 and k the rank 2k.
    """

    points: list[list[float]]
    heights: list[float]
    ranks: list[int]
    vertex: list[int]
    uv: list[list[float]] | None
    planes: list[float]
    up: Vector
    axis: int | None
    closed: bool
    near: float
    met: dict[tuple[int, int, int], int] = field(default_factory=dict)


def stacked(work: Cutting, ring: Ring, own: list[int], low: int, high: int) -> list[Ring]:
    """The parts from below of a ring that rises once and falls once, as most walls do.

    Nothing where it does not, or where it steps along a plane: that takes more care.
    """
    first = (low + 1) // 2
    parts: list[Ring] = [[] for _ in range(high // 2 - first + 1)]
    start = next(n for n, rank in enumerate(own) if rank == low and own[n - 1] != low)
    rising, before, last = True, low, ring[start]
    for n in range(start - len(ring), start + 1):
        corner, rank = ring[n], own[n]
        if rank != before:
            if rank > before and not rising:
                return []
            rising = rank > before
            for at, met in _met_all(work, last, before, corner, rank):
                parts[at - first].append(met)
                parts[at + 1 - first].append(met)
        elif rank % 2 and low < rank < high:
            return []
        if n < start:
            if rank > low or rank % 2 == 0:
                parts[rank // 2 - first].append(corner)
            if rank % 2 and rank < high:
                parts[rank // 2 + 1 - first].append(corner)
        before, last = rank, corner
    return parts


def _met_all(work: Cutting, a: int, rank: int, b: int, other: int) -> list[tuple[int, int]]:
    """The planes between two corners of these ranks and where each is met, from a to b."""
    falls = rank > other
    if falls:
        a, b, rank, other = b, a, other, rank
    found = []
    for k in range((rank + 1) // 2, other // 2):
        a = _met(work, a, b, k)
        found.append((k, a))
    return found[::-1] if falls else found


def normal_of(work: Cutting, face: Face) -> Vector:
    points = [work.points[work.vertex[corner]] for corner in face[0]]
    ox, oy, oz = points[0]
    x = y = z = 0.0
    bx, by, bz = (c - o for c, o in zip(points[-1], points[0], strict=True))
    for point in points:
        ax, ay, az = bx, by, bz
        bx, by, bz = point[0] - ox, point[1] - oy, point[2] - oz
        x += ay * bz - az * by
        y += az * bx - ax * bz
        z += ax * by - ay * bx
    return x, y, z


def parted(work: Cutting, face: Face, k: int) -> tuple[list[Face], list[Face]]:
    """A face that spans plane k as the faces below and those above it."""
    middle = 2 * k + 1
    own = [work.ranks[work.vertex[corner]] for corner in face[0]]
    if max(own) <= middle or min(own) >= middle:
        return ([face], []) if min(own) < middle else ([], [face])
    whole: tuple[Face, Face] = ([], [])
    chains: tuple[Face, Face] = ([], [])
    on: Ring = []
    for ring in face:
        ring, signs = _crossed(work, ring, k)
        if 0 in signs:
            on += [corner for corner, sign in zip(ring, signs, strict=True) if sign == 0]
            _collect(ring, signs, chains)
        else:
            whole[work.ranks[work.vertex[ring[0]]] > middle].append(ring)
    if len(face) == 1 and len(chains[0]) == len(chains[1]) == 1 and len(on) == 2:
        return [chains[0]], [chains[1]]
    normal = normal_of(work, face)
    right = cross(work.up, normal)
    along = {corner: dot(work.points[work.vertex[corner]], right) for corner in on}
    return (
        _housed(work, _linked(work, chains[0], along), whole[0], normal),
        _housed(work, _linked(work, chains[1], along), whole[1], normal),
    )


def _crossed(work: Cutting, ring: Ring, k: int) -> tuple[Ring, list[int]]:
    """The ring with corners put in where it crosses plane k, and the side of each: -1, 0, 1."""
    middle = 2 * k + 1
    corners: Ring = []
    signs: list[int] = []
    ranks, vertex = work.ranks, work.vertex
    last = ring[-1]
    before = ranks[vertex[last]]
    for corner in ring:
        here = ranks[vertex[corner]]
        if before < middle < here or here < middle < before:
            corners.append(_met(work, last, corner, k))
            signs.append(0)
        corners.append(corner)
        signs.append((here > middle) - (here < middle))
        last, before = corner, here
    return corners, signs


def _met(work: Cutting, a: int, b: int, k: int) -> int:
    """A new corner where the edge between two corners meets plane k."""
    one, other = work.vertex[a], work.vertex[b]
    if one > other:
        one, other, a, b = other, one, b, a
    h = work.heights[one]
    t = (work.planes[k] - h) / (work.heights[other] - h)
    number = work.met.get((one, other, k))
    if number is None:
        number = work.met[one, other, k] = len(work.points)
        (x, y, z), (u, v, w) = work.points[one], work.points[other]
        point = [x + t * (u - x), y + t * (v - y), z + t * (w - z)]
        if work.axis is not None:
            point[work.axis] = work.planes[k]
        work.points.append(point)
        work.heights.append(work.planes[k])
        work.ranks.append(2 * k + 1)
    work.vertex.append(number)
    if work.uv is not None:
        work.uv.append([c + t * (d - c) for c, d in zip(work.uv[a], work.uv[b], strict=True)])
    return len(work.vertex) - 1


def _collect(ring: Ring, signs: list[int], chains: tuple[Face, Face]) -> None:
    """The runs of a ring below and above the plane, each from and to a corner on it."""
    start = signs.index(0)
    ring = ring[start:] + ring[: start + 1]
    signs = signs[start:] + signs[: start + 1]
    begin = 0
    for at in range(1, len(ring)):
        if signs[at] == 0:
            if at - begin > 1:
                chains[signs[begin + 1] > 0].append(ring[begin : at + 1])
            begin = at


def _linked(work: Cutting, chains: Face, along: dict[int, float]) -> Face:
    """Loops of chains: along the plane, each links its end to a start.

    The inside just off the plane runs from the k-th start (its left, seen from below) to the k-th
    end, both in order along the plane; above it is the other way round, which comes to the same.
    """
    starts = sorted(chains, key=lambda each: along[each[0]])
    ends = sorted(range(len(chains)), key=lambda n: along[chains[n][-1]])
    follower = {n: starts[at] for at, n in enumerate(ends)}
    number = {id(each): n for n, each in enumerate(chains)}
    left = set(range(len(chains)))
    loops: Face = []
    while left:
        n = min(left)
        loop: Ring = []
        while n in left:
            left.discard(n)
            following = follower[n]
            loop += chains[n][1:]
            loop += _between(work, chains[n][-1], following[0], along)
            if work.vertex[following[0]] != work.vertex[loop[-1]]:
                loop.append(following[0])
            n = number[id(following)]
        loops.append(loop)
    return loops


def _between(work: Cutting, end: int, start: int, along: dict[int, float]) -> Ring:
    """Corners of the face on the link, which a neighbour may use: without them it would leak."""
    if not work.closed or len(along) < 3:
        return []
    a, b = along[end], along[start]
    used = {work.vertex[end], work.vertex[start]}
    found: Ring = []
    for corner in sorted(along, key=lambda each: along[each], reverse=a > b):
        number = work.vertex[corner]
        if min(a, b) < along[corner] < max(a, b) and number not in used:
            used.add(number)
            found.append(corner)
    return found


def _housed(work: Cutting, loops: Face, holes: Face, normal: Vector) -> list[Face]:
    """Faces of outlines, and of the holes that no plane cut."""
    faces = [[loop] for loop in loops]
    if len(faces) == 1:
        return [[*faces[0], *holes]]
    for hole in holes:
        drop = max(range(3), key=lambda n: abs(normal[n]))
        u, v = (drop + 1) % 3, (drop + 2) % 3
        flat = {
            corner: (point[u], point[v])
            for corner in chain(hole, *loops)
            for point in [work.points[work.vertex[corner]]]
        }
        for face in faces:
            if encloses(face[0], flat[hole[0]], flat):
                face.append(hole)
                break
    return faces
