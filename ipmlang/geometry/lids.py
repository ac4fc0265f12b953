"""Lids on the parts of a cut solid: what bounds their other faces in a plane is filled there.

Parts come in as faces over the lists of a cutting, lids go out as more of them. Where a solid
touches itself, points of the plane that were apart become one, and edges are broken at points on
them: whatever came closed is closed again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from ipmlang.geometry.loops import Edge, chained, frame, nested, unmatched
from ipmlang.geometry.parting import Cutting, Face, Ring, Slab
from ipmlang.geometry.sharing import first_at_place

Flat = dict[int, tuple[float, float]]


def weld(work: Cutting, slabs: Iterable[Slab]) -> None:
    """Make vertices at one place of a plane one, so that lids do not run between two of them.

    Faces that have no width left go.
    """
    on = np.array([n for n, rank in enumerate(work.ranks) if rank % 2])
    if not len(on):
        return
    points = np.array([work.points[n] for n in on])
    near = max(work.near, 1e-9 * float(np.ptp(points, axis=0).max()))
    apart = 10 * near * np.array([work.ranks[n] for n in on])
    first = on[first_at_place(np.column_stack([points, apart]), near)]
    if (first == on).all():
        return
    now = list(range(len(work.points)))
    for old, new in zip(on.tolist(), first.tolist(), strict=True):
        now[old] = new
    work.vertex = [now[number] for number in work.vertex]
    for faces, tags in slabs:
        for n in reversed(range(len(faces))):
            faces[n] = _unrepeated(work, faces[n])
            if not faces[n]:
                del faces[n], tags[n]


def _unrepeated(work: Cutting, face: Face) -> Face:
    """The rings of a face without corners at the place of the one before."""
    vertex = work.vertex
    rings = [[c for k, c in enumerate(ring) if vertex[c] != vertex[ring[k - 1]]] for ring in face]
    return [ring for ring in rings if len(ring) > 2] if len(rings[0]) > 2 else []


def lids_of(work: Cutting, k: int, faces: list[Face]) -> list[Face]:
    """The lids of slab k: whatever bounds its other faces in the plane below and the one above."""
    found = []
    for rank, rims in _rims(work, faces, k).items():
        facing = 1.0 if rank > 2 * k else -1.0
        lids, flat = _filled(work, rims, facing)
        if sum(len(ring) for lid in lids for ring in lid) < len(rims):
            _break_edges(work, faces, rims)
            lids, flat = _filled(work, _rims(work, faces, k)[rank], facing)
        found += [[_cornered(work, ring, flat, facing) for ring in lid] for lid in lids]
    return found


def _rims(work: Cutting, faces: list[Face], k: int) -> dict[int, list[Edge]]:
    """By the rank of either plane, the edges of lids: those of faces that no other face shares."""
    ranks, vertex = work.ranks, work.vertex
    border: dict[int, list[Edge]] = {2 * k - 1: [], 2 * k + 1: []}
    for face in faces:
        for ring in face:
            b = vertex[ring[-1]]
            rank = ranks[b]
            for corner in ring:
                a, before = b, rank
                b = vertex[corner]
                rank = ranks[b]
                if rank == before and rank % 2:
                    border[rank].append((a, b))
    return {rank: [(b, a) for a, b in unmatched(edges)] for rank, edges in border.items()}


def _filled(work: Cutting, rims: list[Edge], facing: float) -> tuple[list[list[Ring]], Flat]:
    """Lids of vertex numbers, and where these lie in the plane, seen from outside."""
    (a, b, c), (d, e, f) = frame(work.up)
    a, b, c = a * facing, b * facing, c * facing
    flat = {}
    for number, _ in rims:
        x, y, z = work.points[number]
        flat[number] = (a * x + b * y + c * z, d * x + e * y + f * z)
    return nested(chained(rims, flat), flat), flat


def _cornered(work: Cutting, ring: Ring, flat: Flat, facing: float) -> Ring:
    """New corners at vertices; a lid's texture lies in its plane, a unit of length to a unit."""
    first = len(work.vertex)
    work.vertex += ring
    if work.uv is not None:
        work.uv += [[flat[number][0] * facing, flat[number][1]] for number in ring]
    return list(range(first, len(work.vertex)))


def _break_edges(work: Cutting, faces: list[Face], rims: Sequence[Edge]) -> None:
    """Put corners into the edges that bound lids, wherever an end of another lies on them."""
    spots = sorted(set(chain.from_iterable(rims)))
    points = np.array([work.points[number] for number in spots])
    near = max(work.near, 1e-9 * float(np.ptp(points, axis=0).max()))
    broken: dict[Edge, list[tuple[float, int]]] = {}
    for a, b in rims:
        start = np.array(work.points[b])
        way = np.array(work.points[a]) - start
        length = float(np.sqrt(way @ way))
        at = (points - start) @ way / length
        off = points - start - np.outer(at / length, way)
        on = (at > near) & (at < length - near) & ((off * off).sum(axis=1) <= near * near)
        broken[b, a] = sorted((float(at[n]) / length, spots[n]) for n in np.flatnonzero(on))
    for face in faces:
        for ring in face:
            ring[:] = _broken(work, ring, broken)


def _broken(work: Cutting, ring: Ring, broken: dict[Edge, list[tuple[float, int]]]) -> Ring:
    found: Ring = []
    for k, corner in enumerate(ring):
        before = ring[k - 1]
        for share, number in broken.get((work.vertex[before], work.vertex[corner]), ()):
            found.append(len(work.vertex))
            work.vertex.append(number)
            if work.uv is not None:
                ends = zip(work.uv[before], work.uv[corner], strict=True)
                work.uv.append([c + share * (d - c) for c, d in ends])
        found.append(corner)
    return found
