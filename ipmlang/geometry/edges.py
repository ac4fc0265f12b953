"""Take a solid apart into its edges and its vertices, with the words that select them.

An edge is a polygon of two points, a vertex one of one: no area, but a place, a direction, and the
words of the faces that meet there. Roofs name theirs: ridge, hip, valley, eave.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.geometry.faces import LEVEL, LOOKS, UPRIGHT, face_words
from ipmlang.geometry.pieces import Piece, numbered_rings
from ipmlang.geometry.sharing import following
from ipmlang.geometry.solid import (
    Floats,
    Indices,
    Solid,
    face_of_corners,
    joined,
    normals,
    solid_of,
)

SLOPE = "roof.slope"
_LOOKS = frozenset((*LOOKS, "side"))
_BEND = 1e-6
"""The sine of the angle below which two faces lie in one plane."""


def edges(solid: Solid) -> list[Piece]:
    """Each edge once, as a face of one ring of two points; what `comp(edges)` gives.

    x runs along the edge, z is the middle of the normals of the faces that meet there, y = z x x.
    Words: `all`; `horizontal`, `vertical` or `aslant` (to a degree); which ways its faces look
    (`top`, `front`, `side`, ...) and their tags. Between faces tagged `roof.slope`: `ridge` (level,
    both fall away from it), `hip` (aslant, bent outward) and `valley` (bent inward); `eave` is the
    lowest level edge of a slope against anything else.

    >>> from ipmlang.geometry.solid import unit_box
    >>> pieces = edges(unit_box())
    >>> len(pieces), sum("vertical" in piece.words for piece in pieces)
    (12, 4)
    """
    return edges_of([solid])[0]


def edges_of(solids: Sequence[Solid]) -> list[list[Piece]]:
    """What `edges` gives of each of many solids, measured all together."""
    found: list[list[Piece]] = [[] for _ in solids]
    whole = joined(solids)
    if not len(whole):
        return found
    first, second = _pairs(whole)
    after = following(whole)
    ends = whole.vertices[whole.corners[np.stack([first, after[first]], axis=1)]]
    along = ends[:, 1] - ends[:, 0]
    length = np.sqrt(np.einsum("ij,ij->i", along, along))
    x = along / np.where(length > 0, length, 1.0)[:, None]
    face = face_of_corners(whole)
    one, other = face[first], face[second]
    normal = normals(whole)
    axes = _axes(x, normal[one], normal[other])
    bend = np.einsum("ij,ij->i", np.cross(normal[one], normal[other]), x)
    owner = np.repeat(np.arange(len(solids)), [len(each) for each in solids])
    roof = _roof_words(whole, ends[:, 0, 2] + along[:, 2] / 2, x, bend, (one, other), owner)
    words = face_words(whole)
    lean = np.abs(x[:, 2])
    kinds = np.where(lean > LEVEL, "vertical", np.where(lean < UPRIGHT, "horizontal", "aslant"))
    numbering = numbered_rings((2,))
    rows = zip(one.tolist(), other.tolist(), kinds.tolist(), roof, length.tolist(), strict=True)
    for n, (f, g, kind, names, long) in enumerate(rows):
        if long > 0:
            tags = whole.tags[f] | whole.tags[g]
            own = ((words[f] | words[g]) & _LOOKS) | tags | names | {"all", kind}
            line = Solid(ends[n], *numbering, (tags,))
            found[owner[f]].append(Piece(own, line, axes[n]))
    return found


def vertices(solid: Solid) -> list[Piece]:
    """Each vertex once, as a face of one ring of one point; what `comp(vertices)` gives.

    Words: `all`, and `top` and `bottom` for the highest and the lowest. They keep the axes of the
    solid.
    """
    points, first = np.unique(solid.vertices[solid.corners], axis=0, return_index=True)
    points = points[np.argsort(first)]
    if not len(points):
        return []
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    near = 1e-6 * (high - low)
    pieces = []
    for point in points:
        words = {"all"}
        words |= {"top"} if point[2] >= high - near else set()
        words |= {"bottom"} if point[2] <= low + near else set()
        pieces.append(Piece(frozenset(words), solid_of([point], [[[0]]])))
    return pieces


def _pairs(solid: Solid) -> tuple[Indices, Indices]:
    """The corners where the two uses of each edge begin, in order of the first; the same corner
    twice where an edge has only one. Further uses of an edge are not told apart.
    """
    ahead = solid.corners[following(solid)]
    low, high = np.minimum(solid.corners, ahead), np.maximum(solid.corners, ahead)
    order = np.lexsort([high, low])
    key = low[order] * (len(solid.vertices) + 1) + high[order]
    starts = np.flatnonzero(np.diff(key, prepend=-1))
    ends = np.append(starts[1:], len(key))
    first, second = order[starts], order[ends - 1]
    turn = np.argsort(first)
    return first[turn], second[turn]


def _axes(x: Floats, one: Floats, other: Floats) -> Floats:
    """x, y, z (e, 3, 3) of edges between faces of these normals."""
    z = one + other
    length = np.sqrt(np.einsum("ij,ij->i", z, z))
    z = np.where((length > _BEND)[:, None], z / np.maximum(length, _BEND)[:, None], one)
    z = z - np.einsum("ij,ij->i", z, x)[:, None] * x
    length = np.sqrt(np.einsum("ij,ij->i", z, z))
    z = z / np.where(length > 0, length, 1.0)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=1)


def _roof_words(
    whole: Solid,
    middle: Floats,
    x: Floats,
    bend: Floats,
    faces: tuple[Indices, Indices],
    owner: Indices,
) -> list[frozenset[str]]:
    """What a roof calls each edge, if it is a roof's; `owner`: the solid of each face."""
    one, other = faces
    slope = np.array([SLOPE in tags for tags in whole.tags])
    if not slope.any():
        return [frozenset()] * len(x)
    starts = whole.rings[whole.faces[:-1]]
    z = whole.vertices[whole.corners, 2]
    lowest, highest = np.minimum.reduceat(z, starts), np.maximum.reduceat(z, starts)
    begins = np.flatnonzero(np.diff(owner, prepend=-1))
    high, low = np.maximum.reduceat(highest, begins), np.minimum.reduceat(lowest, begins)
    near = 1e-6 * np.repeat(high - low, np.diff(begins, append=len(owner)))
    both = slope[one] & slope[other] & (one != other)
    level = np.abs(x[:, 2]) < UPRIGHT
    base_one = slope[one] & (middle <= (lowest + near)[one])
    base_other = slope[other] & (middle <= (lowest + near)[other])
    outward, inward = bend > _BEND, bend < -_BEND
    marks = {
        "ridge": both & level & outward & ~base_one & ~base_other,
        "hip": both & ~level & outward,
        "valley": both & inward,
        "eave": level & ~both & (base_one | base_other),
    }
    # an edge has one name at most: a number for each
    numbers = np.select(list(marks.values()), range(1, 5), 0).tolist()
    names = [frozenset[str](), *(frozenset({word}) for word in marks)]
    return [names[number] for number in numbers]
