"""Coplanar neighbours become one face: the triangles of a mesh turn into polygons with holes again.

Faces merge over a shared edge where both lie in one plane, bear the same tags and agree in their
texture coordinates there; then vertices in the middle of a straight edge go. What was closed stays
closed, what was a polygon stays one.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.loops import chained, frame, nested, unmatched
from ipmlang.geometry.sharing import first_at_place, following, neighbours
from ipmlang.geometry.solid import (
    Floats,
    Indices,
    Solid,
    area_vectors,
    face_of_corners,
    solid_of,
)

Marks = NDArray[np.bool_]

FLAT = 1e-6
"""How far out of its neighbour's plane a face may reach, as a share of the whole's extent."""


def merged_faces(solid: Solid, flat: float = FLAT) -> Solid:
    """The same surface with as few faces as it takes.

    flat: how far from one plane faces that merge may be, as a share of the whole's extent.

    >>> from ipmlang.geometry.solid import unit_box
    >>> corners = unit_box().corners.reshape(6, 4)
    >>> halves = [[list(map(int, quad[[0, *k]]))] for quad in corners for k in ([1, 2], [2, 3])]
    >>> len(merged_faces(solid_of(unit_box().vertices, halves)))
    6
    """
    if len(solid) < 2:
        return solid
    welded = replace(solid, corners=first_at_place(solid.vertices)[solid.corners])
    near = flat * float(np.ptp(solid.vertices, axis=0).max())
    vectors = area_vectors(welded)
    groups = _groups(welded, vectors, near)
    faces: list[list[list[int]]] = []
    tags: list[frozenset[str]] = []
    for group in groups:
        for face in _merged(welded, group, vectors):
            faces.append(face)
            tags.append(solid.tags[group[0]])
    kept = _without_straight(faces, welded, near)
    corners = [corner for face in kept for ring in face for corner in ring]
    used, numbers = np.unique(welded.corners[corners], return_inverse=True)
    found = _renumbered(solid.vertices[used], kept, numbers.tolist(), tags)
    return found if solid.uv is None else replace(found, uv=solid.uv[corners])


def _renumbered(
    vertices: Floats, faces: list[list[list[int]]], numbers: list[int], tags: list[frozenset[str]]
) -> Solid:
    """A solid of faces whose corners, in order, are these vertices."""
    at = iter(numbers)
    rings = [[[next(at) for _ in ring] for ring in face] for face in faces]
    return solid_of(vertices, rings, tags)


def _groups(solid: Solid, vectors: Floats, near: float) -> list[list[int]]:
    """Faces that make one, in the order of the first of each."""
    one, other = neighbours(solid)
    face = face_of_corners(solid)
    a, b = face[one], face[other]
    same = np.array([solid.tags[f] == solid.tags[g] for f, g in zip(a, b, strict=True)], bool)
    same &= a != b
    if solid.uv is not None:
        after = following(solid)
        same &= (np.abs(solid.uv[one] - solid.uv[after[other]]) <= FLAT).all(axis=1)
        same &= (np.abs(solid.uv[after[one]] - solid.uv[other]) <= FLAT).all(axis=1)
    a, b = a[same], b[same]
    level, thin = _coplanar(solid, vectors, a, b, near)
    root = list(range(len(solid)))
    for f, g in zip(a[level].tolist(), b[level].tolist(), strict=True):
        f, g = _root(root, f), _root(root, g)
        root[max(f, g)] = min(f, g)
    _join_slivers(solid, vectors, root, np.stack([a, b], axis=1)[thin], near)
    groups: dict[int, list[int]] = {}
    for f in range(len(solid)):
        groups.setdefault(_root(root, f), []).append(f)
    return list(groups.values())


def _root(root: list[int], face: int) -> int:
    while root[face] != face:
        root[face] = face = root[root[face]]
    return face


def _coplanar(
    solid: Solid, vectors: Floats, a: Indices, b: Indices, near: float
) -> tuple[Marks, Marks]:
    """Which pairs of faces lie in the plane of the larger: those that look the same way, and
    those with a sliver, thinner than `near`, which looks no way of its own.
    """
    size = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    swap = size[a] < size[b]
    big, small = np.where(swap, b, a), np.where(swap, a, b)
    normal = vectors[big] / np.maximum(size[big], 1e-300)[:, None]
    starts = solid.rings[solid.faces]
    counts = np.diff(starts)[small]
    ends = np.cumsum(counts)
    corners = np.arange(counts.sum()) - np.repeat(ends - counts - starts[small], counts)
    off = solid.vertices[solid.corners[corners]]
    off -= np.repeat(solid.vertices[solid.corners[starts[big]]], counts, axis=0)
    off = np.abs(np.einsum("ij,ij->i", off, np.repeat(normal, counts, axis=0)))
    within = np.maximum.reduceat(off, ends - counts) <= near if len(off) else off > 0
    thin = within & (size <= near * _longest(solid))[small]
    agree = np.einsum("ij,ij->i", vectors[small], normal) > 0.5 * size[small]
    return within & agree & ~thin, thin


def _longest(solid: Solid) -> Floats:
    """The length of each face's longest edge (f,)."""
    ahead = solid.vertices[solid.corners[following(solid)]] - solid.vertices[solid.corners]
    square = np.einsum("ij,ij->i", ahead, ahead)
    return np.sqrt(np.maximum.reduceat(square, solid.rings[solid.faces[:-1]]))


def _join_slivers(
    solid: Solid, vectors: Floats, root: list[int], pairs: Indices, near: float
) -> None:
    """Let slivers join a neighbour, and join two neighbours only where these lie in one plane.

    A sliver in the edge between two planes lies in both, and must not make them one face.
    """
    size = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    thin = size <= near * _longest(solid)
    plane = {_root(root, face): face for face in np.flatnonzero(~thin)[::-1].tolist()}
    first = solid.vertices[solid.corners[solid.rings[solid.faces[:-1]]]]
    for f, g in pairs.tolist():
        f, g = sorted((_root(root, f), _root(root, g)))
        if f in plane and g in plane:
            one, other = plane[f], plane[g]
            way = vectors[one] / size[one]
            if way @ vectors[other] < (1 - 1e-9) * size[other]:
                continue
            if abs((first[other] - first[one]) @ way) > near:
                continue
        elif g in plane:
            plane[f] = plane[g]
        root[g] = f


def _merged(solid: Solid, group: list[int], vectors: Floats) -> list[list[list[int]]]:
    """The faces of a group as polygons of corner numbers."""
    rings, starts = solid.rings, solid.faces
    spans = [
        list(range(a, b))
        for face in group
        for a, b in pairwise(rings[starts[face] : starts[face + 1] + 1].tolist())
    ]
    if len(group) == 1:
        return [spans]
    corner_at: dict[tuple[int, int], int] = {}
    for span in spans:
        numbers = solid.corners[span].tolist()
        corner_at.update(
            zip(zip(numbers, numbers[1:] + numbers[:1], strict=True), span, strict=True)
        )
    way = vectors[group].sum(axis=0)
    across, along = np.array(frame(tuple((way / np.sqrt(way @ way)).tolist())))
    border = unmatched(corner_at)
    used = sorted({number for edge in border for number in edge})
    points = solid.vertices[used]
    flat = dict(zip(used, zip((points @ across).tolist(), (points @ along).tolist(), strict=True),
                    strict=True))  # fmt: skip
    faces = nested(chained(border, flat), flat)
    return [
        [[corner_at[a, b] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)] for ring in face]
        for face in faces
    ]


def _without_straight(
    faces: list[list[list[int]]], solid: Solid, near: float
) -> list[list[list[int]]]:
    """The faces without vertices that all their rings pass straight through."""
    around: dict[int, set[int]] = {}
    numbers = solid.corners.tolist()
    for face in faces:
        for ring in face:
            own = [numbers[corner] for corner in ring]
            for before, here, after in zip(own[-1:] + own, own, own[1:] + own[:1], strict=False):
                around.setdefault(here, set()).update((before, after))
    plain = [(here, *ends) for here, ends in around.items() if len(ends) == 2]
    if not plain:
        return faces
    here, one, other = solid.vertices[np.array(plain).T]
    line = other - one
    length = np.sqrt(np.einsum("ij,ij->i", line, line))
    bend = np.cross(here - one, line)
    straight = np.sqrt(np.einsum("ij,ij->i", bend, bend)) <= near * length
    straight &= np.einsum("ij,ij->i", here - one, here - other) < 0
    drop = {vertex for (vertex, _, _), plainly in zip(plain, straight, strict=True) if plainly}
    return [
        [
            kept if len(kept := [corner for corner in ring if numbers[corner] not in drop]) > 2
            else ring
            for ring in face
        ]
        for face in faces
    ]  # fmt: skip
