"""Raise polygons into solids: straight along a direction, or drawing in toward the top.

Faces bear the tags `extrude.bottom`, `extrude.top`, `extrude.side` or `taper.bottom`, `taper.top`,
`taper.side`. Faces come in the order bottom, top, then a side for each edge of the outline and of
the holes. Texture coordinates are not carried over: sides have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Indices,
    Solid,
    Tags,
    area_vectors,
    joined,
)


def extrude(
    solid: Solid, height: float, direction: Floats | Sequence[float] | None = None
) -> Solid:
    """The closed solid between polygons and the same moved by `height` along a direction (3,).

    Without a direction they move along their normal (that of their sum where there are several);
    faces that share an edge get no side there. `extrude.bottom` is where they were,
    `extrude.top` where they came to, even below. Both keep the tags of the polygon. GeometryError
    where nothing is enclosed: no height, or a direction within the plane.

    >>> from ipmlang.geometry.solid import unit_square, volume
    >>> volume(extrude(unit_square(), 3))
    3.0
    """
    vectors = area_vectors(solid)
    way = vectors.sum(axis=0) if direction is None else np.asarray(direction, np.float64)
    length = float(np.sqrt(way @ way))
    _check_raised(vectors, length)
    way = way / length
    rises = vectors @ way * height
    if (np.abs(rises) <= 1e-9 * abs(height) * np.sqrt((vectors * vectors).sum(axis=1))).all():
        raise GeometryError(
            "extrude makes no solid: "
            + ("the height is 0" if height == 0 else "the direction lies in the polygon's plane"),
            "give a height that is not 0 and a direction out of the polygon's plane",
        )
    moved = solid.vertices + way * height
    return _prism(solid, moved, upward=float(rises.sum()) > 0, kind="extrude")


def _check_raised(vectors: Floats, length: float) -> None:
    if not len(vectors) or not np.abs(vectors).any():
        raise GeometryError("there is no polygon to raise", "make a polygon with an area first")
    if length == 0 or length <= 1e-9 * float(np.abs(vectors).sum()):
        raise GeometryError(
            "the direction to raise along is not known: the faces look all ways",
            "give a direction, as `along: up`, or take one face with comp first",
        )


def _prism(solid: Solid, moved: Floats, *, upward: bool, kind: str) -> Solid:
    """The faces as bottom, the same over moved vertices (v, 3) as top, sides between them."""
    count = len(solid.vertices)
    bottom = replace(solid, uv=None, tags=_and(solid.tags, f"{kind}.bottom"))
    top = replace(bottom, corners=solid.corners + count, tags=_and(solid.tags, f"{kind}.top"))
    first, second = _border(solid)
    sides = np.stack([first, second, second + count, first + count], axis=1)
    if upward:
        bottom = turned(bottom)
    else:
        top, sides = turned(top), sides[:, ::-1]
    lids = joined([replace(part, vertices=np.zeros((0, 3))) for part in (bottom, top)])
    walls = len(sides)
    return Solid(
        np.concatenate([solid.vertices, moved]),
        np.concatenate([lids.corners, sides.reshape(-1)]),
        np.concatenate([lids.rings, lids.rings[-1] + 4 * np.arange(1, walls + 1)]),
        np.concatenate([lids.faces, lids.faces[-1] + np.arange(1, walls + 1)]),
        lids.tags + (frozenset([f"{kind}.side"]),) * walls,
    )


def _and(tags: Tags, word: str) -> Tags:
    return tuple(each | {word} for each in tags)


def _border(solid: Solid) -> tuple[Indices, Indices]:
    """The directed edges (e,), (e,) of all faces that have no opposite, in order."""
    after = _next(solid)
    first, second = solid.corners, solid.corners[after]
    if len(solid) == 1:
        return first, second
    key = first * len(solid.vertices) + second
    alone = ~np.isin(key, second * len(solid.vertices) + first)
    return first[alone], second[alone]


def _next(solid: Solid) -> Indices:
    """The number of the corner after each corner (c,) in its ring."""
    after = np.arange(1, len(solid.corners) + 1)
    after[solid.rings[1:] - 1] = solid.rings[:-1]
    return after


def turned(solid: Solid) -> Solid:
    """All faces turned inside out: each ring runs the other way, from the same corner.

    >>> from ipmlang.geometry.solid import unit_square
    >>> turned(unit_square()).corners.tolist()
    [0, 3, 2, 1]
    """
    lengths = np.diff(solid.rings)
    start = np.repeat(solid.rings[:-1], lengths)
    within = np.arange(len(solid.corners)) - start
    source = start + (-within) % np.repeat(lengths, lengths)
    uv = None if solid.uv is None else solid.uv[source]
    return replace(solid, corners=solid.corners[source], uv=uv)
