"""Take a solid apart into its faces, each with the scope that it gets and the words that select it.

A face's x runs along its lowest edge, z outward, y = z x x. A level face keeps the solid's x where
one of its edges does, else takes its longest edge. Faces stay in order, so that numbers select
them: a box gives bottom, top, front, right, back, left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import cos, radians, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.merging import merged_faces
from ipmlang.geometry.pieces import Piece, numbered_rings
from ipmlang.geometry.solid import (
    Floats,
    Indices,
    Solid,
    area_vectors,
    face_of_corners,
    joined,
)

LOOKS = ("front", "back", "left", "right", "top", "bottom")
LEANS = ("vertical", "aslant", "horizontal")
TOP = sqrt(0.5) + 1e-9
"""The z of a normal above which a face is the top: slopes flatter than 45 degrees."""
UPRIGHT, LEVEL = sin(radians(1)), cos(radians(1))
_SAME = 1e-6
"""Lengths and heights that differ by less than this share are the same."""

_WORDS = [
    frozenset(("all", look, lean)) | ({"side"} if look not in ("top", "bottom") else set())
    for look in LOOKS
    for lean in LEANS
]


@dataclass(frozen=True, slots=True, eq=False)
class Scopes:
    """The scopes of all faces, in the solid's coordinates.

    axes (f, 3, 3): rows x, y, z; origins (f, 3): the least corner of the box along those axes;
    sizes (f, 3): its extents, z of 0 for a plane face.
    """

    axes: Floats
    origins: Floats
    sizes: Floats


def faces(solid: Solid, merge: bool = False) -> list[Piece]:
    """Each face as a polygon in the solid's coordinates, with its axes; what `comp` gives.

    Words: `all`; one of front, back, left, right, top, bottom; `side` for the first four; one of
    vertical, horizontal, aslant (to a degree); and the face's tags. A face is `top` where it is
    flatter than 45 degrees and looks up. merge: first make faces of coplanar neighbours one, as
    meshes of triangles need.

    >>> from ipmlang.geometry.solid import unit_box
    >>> [min(piece.words & set(LOOKS)) for piece in faces(unit_box())]
    ['bottom', 'top', 'front', 'right', 'back', 'left']
    """
    return faces_of([merged_faces(solid) if merge else solid])[0]


def faces_of(solids: Sequence[Solid]) -> list[list[Piece]]:
    """What `faces` gives of each of many solids, measured all together."""
    if not solids:
        return []
    whole = joined(solids) if len(solids) > 1 else solids[0]
    vectors = area_vectors(whole)
    axes = _axes(whole, vectors)
    numbers = words_of(vectors).tolist()
    points = whole.vertices[whole.corners]
    rings, starts = whole.rings.tolist(), whole.faces.tolist()
    found: list[list[Piece]] = []
    face = 0
    for solid in solids:
        begin = rings[starts[face]]
        own: list[Piece] = []
        for tags in solid.tags:
            first, last = starts[face], starts[face + 1]
            a, b = rings[first], rings[last]
            numbering = numbered_rings(tuple(rings[n] - a for n in range(first + 1, last + 1)))
            uv = None if solid.uv is None else solid.uv[a - begin : b - begin]
            single = Solid(points[a:b], *numbering, (tags,), uv)
            own.append(Piece(_words(numbers[face], tags), single, axes[face]))
            face += 1
        found.append(own)
    return found


@lru_cache(maxsize=512)
def _words(number: int, tags: frozenset[str]) -> frozenset[str]:
    """The words of a face that looks this way and bears these tags."""
    return _WORDS[number] | tags


def face_words(solid: Solid) -> list[frozenset[str]]:
    """The words of each face, its tags among them."""
    numbers = words_of(area_vectors(solid)).tolist()
    return [_words(number, tags) for number, tags in zip(numbers, solid.tags, strict=True)]


def words_of(vectors: Floats) -> Indices:
    """Of each normal (f, 3) of any length, which way it looks and leans, as a row of one table."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    x, y, z = (vectors / np.where(length > 0, length, 1.0)[:, None]).T
    ahead = np.abs(y) >= np.abs(x) - 1e-9
    look = np.where(ahead, y > 0, 2 + (x > 0))
    look = np.where(z > TOP, 4, np.where(z < -TOP, 5, look))
    steep = np.abs(z)
    lean = 1 + (steep > LEVEL).astype(np.int64) - (steep < UPRIGHT)
    numbers: Indices = look * len(LEANS) + lean
    return numbers


def face_scopes(solid: Solid) -> Scopes:
    """The axes and boxes of all faces at once."""
    axes = _axes(solid, area_vectors(solid))
    starts = solid.rings[solid.faces[:-1]]
    own = np.einsum("cij,cj->ci", axes[face_of_corners(solid)], solid.vertices[solid.corners])
    low = np.minimum.reduceat(own, starts, axis=0) if len(starts) else own
    high = np.maximum.reduceat(own, starts, axis=0) if len(starts) else own
    return Scopes(axes, np.einsum("fi,fij->fj", low, axes), high - low)


def _axes(solid: Solid, vectors: Floats) -> Floats:
    """The unit x, y, z (f, 3, 3) of each face; those of the solid where a face has no area."""
    length = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    flat = length == 0
    normal = vectors / np.where(flat, 1.0, length)[:, None]
    normal[flat] = (0.0, 0.0, 1.0)
    level = np.abs(normal[:, 2]) > LEVEL
    x = _bases(solid, level)
    x[flat] = (1.0, 0.0, 0.0)
    x -= np.einsum("ij,ij->i", x, normal)[:, None] * normal
    x /= np.sqrt(np.einsum("ij,ij->i", x, x))[:, None]
    against = level & (x[:, 0] + _SAME * x[:, 1] < 0)
    x[against] *= -1
    axes = np.empty((len(solid), 3, 3))
    axes[:, 0], axes[:, 2] = x, normal
    one, two, three = x.T
    p, q, r = normal.T
    axes[:, 1, 0] = q * three - r * two
    axes[:, 1, 1] = r * one - p * three
    axes[:, 1, 2] = p * two - q * one
    axes += 0.0  # no -0
    return axes


def _bases(solid: Solid, level: NDArray[np.bool_]) -> Floats:
    """The edge (f, 3) of each face's outline that its x runs along."""
    if not len(solid):
        return np.zeros((0, 3))
    after = np.arange(1, len(solid.corners) + 1)
    after[solid.rings[1:] - 1] = solid.rings[:-1]
    a = solid.vertices[solid.corners]
    ahead = a[after] - a
    face = face_of_corners(solid)
    starts = solid.rings[solid.faces[:-1]]
    long = np.sqrt(np.einsum("ij,ij->i", ahead, ahead))
    longest = np.maximum.reduceat(long, starts)
    middle = a[:, 2] + ahead[:, 2] / 2
    nothing = long <= _SAME * longest[face]  # what is next to nothing points nowhere
    middle[nothing] = np.inf
    lowest = np.minimum.reduceat(middle, starts)
    low = middle <= (lowest + _SAME * longest)[face]
    across = (np.abs(ahead[:, 1]) + np.abs(ahead[:, 2]) <= _SAME * long) & ~nothing
    score = long + np.where(np.where(level[face], across, low), 2 * longest[face], 0.0)
    score[_of_holes(solid)] = -1.0
    best = np.maximum.reduceat(score, starts)
    places = np.where(score >= (1 - _SAME) * best[face], np.arange(len(score)), len(score))
    chosen = np.minimum.reduceat(places, starts)
    found: Floats = ahead[chosen]
    return found


def _of_holes(solid: Solid) -> NDArray[np.bool_]:
    """Which corners (c,) are those of holes."""
    hole = np.ones(len(solid.rings) - 1, bool)
    hole[solid.faces[:-1]] = False
    return np.repeat(hole, np.diff(solid.rings))
