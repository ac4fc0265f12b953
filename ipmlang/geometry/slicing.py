"""The cutting of faces by parallel planes: each face is parted, each part closed along the plane.

Heights of vertices over the planes come in, the parts between each two planes go out; a closed
solid's parts get lids. Vertices near a plane are taken to lie on it, so cuts along what is already
there leave no slivers; what two faces share stays shared. Works on lists: pieces are small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain, pairwise

import numpy as np

from ipmlang.geometry.loops import chained, encloses, nested, unmatched
from ipmlang.geometry.solid import Floats, Indices, Solid, is_closed

Ring = list[int]
"""Corner numbers, one after the other."""
Face = list[Ring]
Vector = tuple[float, float, float]

LID = frozenset(["split.cut"])


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
    met: dict[tuple[int, int, int], int] = field(default_factory=dict)


def sliced(
    solid: Solid, heights: Floats, planes: Sequence[float], up: Vector, axis: int | None = None
) -> list[Solid | None]:
    """The parts of a solid below the first plane, between each two and above the last.

    heights (v,) of the vertices along `up`, a unit vector; planes ascend, farther apart than the
    tolerance. Where `axis` is given the heights are that coordinate, and what lies on a plane gets
    exactly its coordinate. None where there is nothing.
    """
    extent = float(heights.max() - heights.min()) if len(heights) else 0.0
    near = tolerance(extent, heights)
    if not planes or not len(solid):
        return [solid if len(solid) else None] + [None] * len(planes)
    ranks = _ranks(heights, np.asarray(planes), near)
    if (low := int(ranks.min())) == int(ranks.max()) and low % 2 == 0:
        return [solid if low == 2 * k else None for k in range(len(planes) + 1)]
    work = _laid_out(solid, heights, ranks, list(planes), up, axis)
    slabs = _assigned(work, solid)
    if work.closed:
        for k, (faces, tags) in enumerate(slabs):
            _close(work, k, faces, tags)
    return [_built(work, faces, tags) for faces, tags in slabs]


def tolerance(extent: float, heights: Floats) -> float:
    """How near to a plane a vertex lies on it, for a solid of this extent."""
    farthest = float(np.abs(heights).max()) if len(heights) else 0.0
    return max(1e-9 * extent, 1e-14 * farthest)


def _ranks(heights: Floats, planes: Floats, near: float) -> Indices:
    above = np.searchsorted(planes, heights - near)
    on = np.searchsorted(planes, heights + near, side="right") > above
    return 2 * above + on


def _laid_out(
    solid: Solid,
    heights: Floats,
    ranks: Indices,
    planes: list[float],
    up: Vector,
    axis: int | None,
) -> Cutting:
    """Lists of a solid's arrays; vertices near a plane are put on it."""
    vertices = solid.vertices
    on = np.flatnonzero(ranks % 2)
    snapped = heights.copy()
    snapped[on] = np.asarray(planes)[ranks[on] // 2]
    if len(on):
        vertices = vertices.copy()
        if axis is None:
            vertices[on] += (snapped - heights)[on, None] * np.asarray(up)
        else:
            vertices[on, axis] = snapped[on]
    closed = is_closed(solid)
    corners = _welded(vertices)[solid.corners] if closed else solid.corners
    return Cutting(
        vertices.tolist(),
        snapped.tolist(),
        ranks.tolist(),
        corners.tolist(),
        None if solid.uv is None else solid.uv.tolist(),
        planes,
        up,
        axis,
        closed,
    )


def _welded(vertices: Floats) -> Indices:
    """For each vertex the first at the same place: a lid must not run between two of them."""
    order = np.lexsort(vertices.T)
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(vertices[order], axis=0) != 0).any(axis=1)
    numbers = np.empty(len(order), np.int64)
    numbers[order] = order[first][np.cumsum(first) - 1]
    return numbers


Slab = tuple[list[Face], list[frozenset[str]]]


def _assigned(work: Cutting, solid: Solid) -> list[Slab]:
    """The faces of each slab, with their tags; faces that span planes are parted."""
    slabs: list[Slab] = [([], []) for _ in range(len(work.planes) + 1)]
    rings, starts = solid.rings.tolist(), solid.faces.tolist()
    ranks, vertex = work.ranks, work.vertex
    for number, (first, last) in enumerate(pairwise(starts)):
        face = [list(range(a, b)) for a, b in pairwise(rings[first : last + 1])]
        own = [ranks[n] for n in vertex[rings[first] : rings[last]]]
        low, high = min(own), max(own)
        tags = solid.tags[number]
        if low == high and low % 2:
            k = _side_of_flat(work, face, low // 2)
            _put(slabs[k], [face], tags)
            continue
        # Planes strictly between the lowest and the highest vertex are those that cut the face.
        k = (low + 1) // 2
        if 2 * k + 1 < high and len(face) == 1:
            stack = _stacked(work, face[0], own, low, high)
            for at, ring in enumerate(stack):
                _put(slabs[k + at], [[ring]], tags)
            if stack:
                continue
        rest = [face]
        while 2 * k + 1 < high:
            halves = [_parted(work, each, k) for each in rest]
            _put(slabs[k], [part for below, _ in halves for part in below], tags)
            rest = [part for _, above in halves for part in above]
            k += 1
        _put(slabs[k], rest, tags)
    return slabs


def _stacked(work: Cutting, ring: Ring, own: list[int], low: int, high: int) -> list[Ring]:
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


def _put(slab: Slab, faces: list[Face], tags: frozenset[str]) -> None:
    slab[0].extend(faces)
    slab[1].extend([tags] * len(faces))


def _side_of_flat(work: Cutting, face: Face, k: int) -> int:
    """The slab of a face in plane k: what looks up bounds the one below.

    What is flat as a whole has no below: it goes above the plane, but for the last one.
    """
    if not work.closed and min(work.ranks) == max(work.ranks):
        return k + (k < len(work.planes) - 1 or k == 0)
    normal = _normal(work, face)
    return k if _dot(normal, work.up) > 0 else k + 1


def _normal(work: Cutting, face: Face) -> Vector:
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


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _parted(work: Cutting, face: Face, k: int) -> tuple[list[Face], list[Face]]:
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
    normal = _normal(work, face)
    right = _cross(work.up, normal)
    along = {corner: _dot(work.points[work.vertex[corner]], right) for corner in on}
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


def _close(work: Cutting, k: int, faces: list[Face], tags: list[frozenset[str]]) -> None:
    """Add the lids of slab k: whatever bounds its other faces in either plane."""
    ranks, vertex = work.ranks, work.vertex
    border: dict[int, list[tuple[int, int]]] = {2 * k - 1: [], 2 * k + 1: []}
    for face in faces:
        for ring in face:
            b = vertex[ring[-1]]
            for corner in ring:
                a, b = b, vertex[corner]
                if ranks[a] == ranks[b] and ranks[a] % 2:
                    border[ranks[a]].append((a, b))
    for rank, edges in border.items():
        rims = [(b, a) for a, b in unmatched(edges)]
        if rims:
            lids = _lids(work, rims, facing=1.0 if rank > 2 * k else -1.0)
            faces += lids
            tags += [LID] * len(lids)


def _lids(work: Cutting, rims: list[tuple[int, int]], facing: float) -> list[Face]:
    across, along = frame(work.up)
    flat = {}
    for number in chain.from_iterable(rims):
        point = work.points[number]
        flat[number] = (_dot(point, across) * facing, _dot(point, along))
    lids = nested(chained(rims, flat), flat)
    return [[_cornered(work, ring, flat, facing) for ring in lid] for lid in lids]


def _cornered(
    work: Cutting, ring: Ring, flat: dict[int, tuple[float, float]], facing: float
) -> Ring:
    """New corners at vertices; a lid's texture lies in its plane, a unit of length to a unit."""
    first = len(work.vertex)
    work.vertex += ring
    if work.uv is not None:
        work.uv += [[flat[number][0] * facing, flat[number][1]] for number in ring]
    return list(range(first, len(work.vertex)))


def frame(up: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors across a unit vector, right-handed with it; x, y, z stay in order."""
    main = max(range(3), key=lambda n: abs(up[n]))
    start = [float(n == (main + 1) % 3) for n in range(3)]
    along = _cross(up, start)
    length = _dot(along, along) ** 0.5
    along = (along[0] / length, along[1] / length, along[2] / length)
    return _cross(along, up), along


def _built(work: Cutting, faces: list[Face], tags: list[frozenset[str]]) -> Solid | None:
    if not faces:
        return None
    corners = [corner for face in faces for ring in face for corner in ring]
    numbers: dict[int, int] = {}
    used = [numbers.setdefault(work.vertex[corner], len(numbers)) for corner in corners]
    ranks = {work.ranks[number] for number in numbers}
    if work.closed and len(ranks) == 1 and min(ranks) % 2:
        return None  # a solid without thickness
    rings, starts = [0], [0]
    for face in faces:
        for ring in face:
            rings.append(rings[-1] + len(ring))
        starts.append(len(rings) - 1)
    uv = None if work.uv is None else np.array([work.uv[corner] for corner in corners])
    return Solid(
        np.array([work.points[number] for number in numbers]),
        np.array(used, np.int64),
        np.array(rings, np.int64),
        np.array(starts, np.int64),
        tuple(tags),
        uv,
    )
