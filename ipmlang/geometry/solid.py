"""What a polygon or a solid is: faces with holes over shared vertices, and what follows from that.

One face makes a polygon; faces that close make a solid. Coordinates are those of a scope: its
origin is 0, z is up. Nothing here knows shapes, rules or files.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Tags = tuple[frozenset[str], ...]

UNTAGGED: frozenset[str] = frozenset()


class GeometryError(Exception):
    """What cannot be done with a geometry: why, in the user's words, and a hint."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Faces over shared vertices, counter-clockwise seen from outside (a polygon: from its front).

    vertices (v, 3) f64; corners (c,) vertex numbers of all rings, one after the other; rings
    (r + 1,) where each ring's corners begin; faces (f + 1,) where each face's rings begin: the
    first is its outline, the others are holes, which run the other way; tags: for each face, the
    words that `comp` can select it by; uv (c, 2) texture coordinates of corners, or None.
    """

    vertices: Floats
    corners: Indices
    rings: Indices
    faces: Indices
    tags: Tags
    uv: Floats | None = None

    def __len__(self) -> int:
        """How many faces there are."""
        return len(self.tags)


def solid_of(
    vertices: Floats | Sequence[Sequence[float]],
    faces: Iterable[Sequence[Sequence[int]]],
    tags: Sequence[Iterable[str]] | None = None,
) -> Solid:
    """A solid of faces that are lists of rings of vertex numbers.

    >>> square = solid_of([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [[[0, 1, 2, 3]]])
    >>> len(square), square.corners.tolist()
    (1, [0, 1, 2, 3])
    """
    corners: list[int] = []
    rings, starts = [0], [0]
    for face in faces:
        for ring in face:
            corners.extend(ring)
            rings.append(len(corners))
        starts.append(len(rings) - 1)
    own = [UNTAGGED] * (len(starts) - 1) if tags is None else [frozenset(each) for each in tags]
    return Solid(
        np.asarray(vertices, np.float64).reshape(-1, 3),
        np.array(corners, np.int64),
        np.array(rings, np.int64),
        np.array(starts, np.int64),
        tuple(own),
    )


def polygon(
    outline: Floats | Sequence[Sequence[float]],
    holes: Sequence[Floats | Sequence[Sequence[float]]] = (),
    tags: Iterable[str] = (),
) -> Solid:
    """A polygon of points (n, 2) or (n, 3), in the plane z = 0 where they have no z."""
    rings = [_in_space(ring) for ring in (outline, *holes)]
    counts = np.cumsum([0, *(len(ring) for ring in rings)])
    numbers = [list(range(a, b)) for a, b in pairwise(counts)]
    return solid_of(np.concatenate(rings), [numbers], [tags])


def _in_space(ring: Floats | Sequence[Sequence[float]]) -> Floats:
    points = np.asarray(ring, np.float64)
    if points.shape[1] == 3:
        return points
    return np.concatenate([points, np.zeros((len(points), 1))], axis=1)


BOX_TAGS = ("bottom", "top", "front", "right", "back", "left")


def unit_box() -> Solid:
    """From the origin to (1, 1, 1): bottom, top, front (-y), right (+x), back, left."""
    vertices = [(k & 1, k >> 1 & 1, k >> 2) for k in range(8)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    return solid_of(np.array(vertices, np.float64), [[face] for face in faces])


def unit_square() -> Solid:
    """From the origin to (1, 1, 0), facing +z."""
    return polygon([(0, 0), (1, 0), (1, 1), (0, 1)])


def rings_of(solid: Solid, face: int) -> Iterator[Indices]:
    """The vertex numbers of each ring of a face, its outline first."""
    for ring in range(int(solid.faces[face]), int(solid.faces[face + 1])):
        yield solid.corners[solid.rings[ring] : solid.rings[ring + 1]]


def ring_points(solid: Solid, face: int) -> list[Floats]:
    """The points (n, 3) of each ring of a face, its outline first."""
    return [solid.vertices[ring] for ring in rings_of(solid, face)]


def face_of_corners(solid: Solid) -> Indices:
    """The face of each corner (c,)."""
    ring_faces = np.repeat(np.arange(len(solid)), np.diff(solid.faces))
    return np.repeat(ring_faces, np.diff(solid.rings))


def area_vectors(solid: Solid) -> Floats:
    """Of each face, its normal times its area (f, 3), holes taken off (Newell's sum)."""
    if not len(solid):
        return np.zeros((0, 3))
    after = np.arange(1, len(solid.corners) + 1)
    after[solid.rings[1:] - 1] = solid.rings[:-1]
    starts = solid.rings[solid.faces[:-1]]
    points = solid.vertices[solid.corners]
    # less is lost far from 0, and a face's area is the same whatever else the solid has
    first = points[0] if len(starts) == 1 else points[np.repeat(starts, _counts(solid, starts))]
    x, y, z = (points - first).T
    u, v, w = x[after], y[after], z[after]
    cross = np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
    found: Floats = np.add.reduceat(cross, starts, axis=0) / 2
    return found


def _counts(solid: Solid, starts: Indices) -> Indices:
    """How many corners each face has, from where each begins."""
    return np.diff(starts, append=len(solid.corners))


def normals(solid: Solid) -> Floats:
    """The unit normal of each face (f, 3); 0 where a face has no area."""
    vectors = area_vectors(solid)
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.where(length > 0, length, 1.0)[:, None]


def area(solid: Solid) -> float:
    """The area of all faces."""
    vectors = area_vectors(solid)
    return float(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)).sum())


def volume(solid: Solid) -> float:
    """The volume of a closed solid (the divergence theorem); without meaning for an open one."""
    if not len(solid):
        return 0.0
    vectors = area_vectors(solid)
    first = solid.vertices[solid.corners[solid.rings[solid.faces[:-1]]]]
    return float(np.einsum("ij,ij->", vectors, first - first[0]) / 3)


def is_closed(solid: Solid) -> bool:
    """Whether every edge is used once in each direction, vertices taken by number."""
    if len(solid) < 4:
        return False
    after = np.arange(1, len(solid.corners) + 1)
    after[solid.rings[1:] - 1] = solid.rings[:-1]
    pairs = np.stack([solid.corners, solid.corners[after]], axis=1)
    one = pairs[np.lexsort(pairs.T)]
    other = pairs[:, ::-1][np.lexsort(pairs[:, ::-1].T)]
    return bool((one == other).all())


def bounds(solid: Solid) -> tuple[Floats, Floats]:
    """The least and the greatest corner (3,) of the box around all vertices."""
    return solid.vertices.min(axis=0), solid.vertices.max(axis=0)


def placed(
    solid: Solid, scale: Floats | Sequence[float], offset: Floats | Sequence[float]
) -> Solid:
    """The solid scaled along the axes (factors of at least 0), then moved."""
    return reshaped(solid, solid.vertices * np.asarray(scale) + np.asarray(offset))


def reshaped(solid: Solid, vertices: Floats) -> Solid:
    """The same faces over other vertices (v, 3); what `replace` gives, in a fifth of its time."""
    return Solid(vertices, solid.corners, solid.rings, solid.faces, solid.tags, solid.uv)


def _stacked(arrays: list[Floats]) -> Floats:
    """Arrays of one shape as one; less is asked of each than `stack` does."""
    return np.concatenate(arrays).reshape(len(arrays), *arrays[0].shape)


Makeup = tuple[int, bytes, bytes, bytes, Tags]


def makeup(solid: Solid) -> Makeup:
    """What two solids have in common that differ in the places of their vertices alone (and in
    texture coordinates).
    """
    parts = (solid.corners.tobytes(), solid.rings.tobytes(), solid.faces.tobytes())
    return (len(solid.vertices), *parts, solid.tags)


def alike(solids: Sequence[Solid]) -> list[tuple[Makeup, list[int], Floats]]:
    """The solids by their make-up: the places of those that share one, and their vertices
    (n, v, 3), so that all can be worked on at once.
    """
    groups: dict[Makeup, list[int]] = {}
    for place, solid in enumerate(solids):
        groups.setdefault(makeup(solid), []).append(place)
    return [
        (made, places, _stacked([solids[place].vertices for place in places]))
        for made, places in groups.items()
    ]


def tagged(solid: Solid, *words: str) -> Solid:
    """The solid whose faces all bear these tags, too."""
    more = frozenset(words)
    return replace(solid, tags=tuple(each | more for each in solid.tags))


def chosen(solid: Solid, keep: Sequence[int] | NDArray[np.intp]) -> Solid:
    """Some faces, with only the vertices that they use."""
    rings: list[list[Indices]] = [list(rings_of(solid, int(face))) for face in keep]
    used, numbers = np.unique(
        np.concatenate([np.zeros(0, np.int64), *(ring for face in rings for ring in face)]),
        return_inverse=True,
    )
    counts = [len(ring) for face in rings for ring in face]
    uv = None
    if solid.uv is not None:
        spans = [
            np.arange(solid.rings[ring], solid.rings[ring + 1])
            for face in keep
            for ring in range(int(solid.faces[face]), int(solid.faces[face + 1]))
        ]
        uv = solid.uv[np.concatenate([np.zeros(0, np.int64), *spans])]
    return Solid(
        solid.vertices[used],
        numbers.reshape(-1).astype(np.int64),
        np.cumsum([0, *counts]).astype(np.int64),
        np.cumsum([0, *(len(face) for face in rings)]).astype(np.int64),
        tuple(solid.tags[int(face)] for face in keep),
        uv,
    )


def joined(parts: Sequence[Solid]) -> Solid:
    """All faces of all parts in one; vertices are not welded."""
    vertices = np.cumsum([0, *(len(part.vertices) for part in parts)])
    corners = np.cumsum([0, *(len(part.corners) for part in parts)])
    rings = np.cumsum([0, *(len(part.rings) - 1 for part in parts)])
    zero = [np.zeros(1, np.int64)]
    whole = all(part.uv is not None for part in parts)
    return Solid(
        np.concatenate([np.zeros((0, 3)), *(part.vertices for part in parts)]),
        np.concatenate(
            [np.zeros(0, np.int64), *(p.corners + n for p, n in zip(parts, vertices, strict=False))]
        ),
        np.concatenate([*zero, *(p.rings[1:] + n for p, n in zip(parts, corners, strict=False))]),
        np.concatenate([*zero, *(p.faces[1:] + n for p, n in zip(parts, rings, strict=False))]),
        tuple(tag for part in parts for tag in part.tags),
        np.concatenate([part.uv for part in parts if part.uv is not None]) if whole and parts
        else None,
    )  # fmt: skip
