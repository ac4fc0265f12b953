"""The cutting of faces by parallel planes: each face is parted, each part closed along the plane.

Heights of vertices over the planes come in, the parts between each two planes go out; a closed
solid's parts get lids. Vertices near a plane are taken to lie on it, so cuts along what is already
there leave no slivers; what two faces share stays shared. Works on lists: pieces are small.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ipmlang.geometry.lids import lids_of, weld
from ipmlang.geometry.loops import Vector, dot
from ipmlang.geometry.parting import Cutting, Face, Slab, normal_of, parted, stacked
from ipmlang.geometry.solid import Floats, Indices, Solid, is_closed

LID = frozenset(["split.cut"])


def sliced(
    solid: Solid, heights: Floats, planes: Sequence[float], up: Vector, axis: int | None = None
) -> list[Solid | None]:
    """The parts of a solid between each two planes, from below; planes may be infinite.

    heights (v,) of the vertices along `up`, a unit vector; planes ascend, farther apart than the
    tolerance. Where `axis` is given the heights are that coordinate, and what lies on a plane gets
    exactly its coordinate. None where there is nothing.
    """
    if not len(solid) or len(planes) < 2:
        return [None] * (len(planes) - 1)
    near = tolerance(float(heights.max() - heights.min()), heights)
    ranks = _ranks(heights, np.asarray(planes), near)
    if (low := int(ranks.min())) == int(ranks.max()) and low % 2 == 0:
        return [solid if low == 2 * k else None for k in range(1, len(planes))]
    work = _laid_out(solid, heights, ranks, list(planes), up, axis, near)
    slabs = _assigned(work, solid)[1:-1]
    if work.closed:
        weld(work, slabs)
        for k, (faces, tags) in enumerate(slabs):
            lids = lids_of(work, k + 1, faces)
            _put((faces, tags), lids, LID)
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
    near: float,
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
    return Cutting(
        vertices.tolist(),
        snapped.tolist(),
        ranks.tolist(),
        solid.corners.tolist(),
        None if solid.uv is None else solid.uv.tolist(),
        planes,
        up,
        axis,
        is_closed(solid),
        near,
    )


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
            stack = stacked(work, face[0], own, low, high)
            for at, ring in enumerate(stack):
                _put(slabs[k + at], [[ring]], tags)
            if stack:
                continue
        rest = [face]
        while 2 * k + 1 < high:
            halves = [parted(work, each, k) for each in rest]
            _put(slabs[k], [part for below, _ in halves for part in below], tags)
            rest = [part for _, above in halves for part in above]
            k += 1
        _put(slabs[k], rest, tags)
    return slabs


def _put(slab: Slab, faces: list[Face], tags: frozenset[str]) -> None:
    slab[0].extend(faces)
    slab[1].extend([tags] * len(faces))


def _side_of_flat(work: Cutting, face: Face, k: int) -> int:
    """The slab of a face in plane k: what looks up bounds the one below.

    What is flat as a whole has no below: it goes above the plane, but for the last one.
    """
    if not work.closed and min(work.ranks) == max(work.ranks):
        return k + (k < len(work.planes) - 1 or k == 0)
    normal = normal_of(work, face)
    return k if dot(normal, work.up) > 0 else k + 1


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
