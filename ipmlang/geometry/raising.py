"""Raise polygons into solids: straight along a direction, or drawing in toward the top.

Faces bear the tags `extrude.bottom`, `extrude.top`, `extrude.side` or `taper.bottom`, `taper.top`
(where there is one), `taper.side`, and come in that order: a side for each edge of the outline and
of the holes. Bottom and top keep the polygon's own tags. Texture coordinates are not carried over:
sides have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from ipmlang.geometry.converting import reversed_normals
from ipmlang.geometry.planar import opened
from ipmlang.geometry.roofs import roof_hip, roof_pyramid
from ipmlang.geometry.sharing import following
from ipmlang.geometry.slabs import slab
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Indices,
    Solid,
    Tags,
    alike,
    area_vectors,
    chosen,
    joined,
    reshaped,
)

_ORDER = ("taper.bottom", "taper.top", "taper.side")
_NAMES = {
    "roof.bottom": "taper.bottom",
    "split.cut": "taper.top",
    "roof.slope": "taper.side",
    **{word.replace("taper", "extrude"): word for word in _ORDER},
}


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


def extrusions(
    solids: Sequence[Solid], heights: Floats, directions: Floats | None = None
) -> list[Solid | None]:
    """What `extrude` makes of each of many polygons, by heights (n,) and directions (n, 3) or the
    normals; None for what it refuses, and for solids of several faces.

    >>> from ipmlang.geometry.solid import unit_square, volume
    >>> [volume(each) for each in extrusions([unit_square()] * 2, np.array([3.0, 4.0])) if each]
    [3.0, 4.0]
    """
    found: list[Solid | None] = [None] * len(solids)
    for _, places, vertices in alike(solids):
        one = solids[places[0]]
        if len(one) != 1:
            continue
        vectors = area_vectors(joined([solids[place] for place in places]))
        ways = vectors if directions is None else directions[places]
        length = np.sqrt(np.einsum("ij,ij->i", ways, ways))
        size = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
        high = heights[places]
        with np.errstate(all="ignore"):
            ways = ways / length[:, None]
            rises = np.einsum("ij,ij->i", vectors, ways) * high
            sound = (np.abs(rises) > 1e-9 * np.abs(high) * size) & np.isfinite(rises)
            sound &= (length > 1e-9 * np.abs(vectors).sum(axis=1)) & (length > 0)
        moved = vertices + (ways * high[:, None])[:, None]
        both = np.concatenate([vertices, moved], axis=1)
        for upward in (True, False):
            some = np.flatnonzero(sound & ((rises > 0) == upward)).tolist()
            if some:
                prism = _prism(one, moved[some[0]], upward=upward, kind="extrude")
                for row in some:
                    found[places[row]] = reshaped(prism, both[row])
    return found


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
        bottom = reversed_normals(bottom)
    else:
        top, sides = reversed_normals(top), sides[:, ::-1]
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
    after = following(solid)
    first, second = solid.corners, solid.corners[after]
    if len(solid) == 1:
        return first, second
    key = first * len(solid.vertices) + second
    alone = ~np.isin(key, second * len(solid.vertices) + first)
    return first[alone], second[alone]


def taper(polygon: Solid, height: float, inset: float | None = None) -> Solid:
    """The closed solid over a level polygon that faces up, `height` high (below it if negative).

    Every edge draws in by the same measure, as the slopes of a hip roof do.
    Without an inset it ends in one point above the middle where all edges can be seen from there,
    else in the ridges of a hip roof. With one (at least 0) the top's edges lie that far inside
    those of the polygon; where nothing is left there it closes at that height instead.
    GeometryError for no height, an inset below 0, and for what is no level polygon.

    >>> from ipmlang.geometry.solid import polygon, volume
    >>> square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)])
    >>> round(volume(taper(square, 3)), 9), round(volume(taper(square, 3, 1)), 9)
    (16.0, 28.0)
    """
    if not (isfinite(height) and height != 0):
        raise GeometryError("taper makes no solid: the height is 0", "give a height that is not 0")
    if inset is not None and not inset >= 0:
        raise GeometryError(
            f"taper cannot draw out: the inset is {inset:g}", "give an inset of at least 0"
        )
    opened(polygon, "taper")
    if inset is None:
        found = _pointed(polygon, abs(height))
    elif inset > 0:
        found = _drawn_in(polygon, abs(height), inset)
    else:
        found = extrude(polygon, abs(height))
    found = _in_order(_renamed(found, polygon.tags[0]))
    if height > 0:
        return found
    return reversed_normals(_scaled(found, _level(polygon), height, -height))


def _pointed(polygon: Solid, height: float) -> Solid:
    try:
        return roof_pyramid(polygon, height)
    except GeometryError:
        return _drawn_in(polygon, height, np.inf)


def _drawn_in(polygon: Solid, height: float, inset: float) -> Solid:
    """A hip roof of 45 degrees, whose heights are insets, cut off and stretched."""
    hip = roof_hip(polygon, 45.0)
    level = _level(polygon)
    deepest = float(hip.vertices[:, 2].max()) - level
    if inset >= deepest * (1 - 1e-9):
        return _scaled(hip, level, height, deepest)
    low = slab(hip, 2, level, level + inset)
    if low is None:  # so little inset is none
        return extrude(polygon, height)
    return _scaled(low, level, height, inset)


def _level(polygon: Solid) -> float:
    return float(polygon.vertices[polygon.corners, 2].min())


def _scaled(solid: Solid, level: float, height: float, before: float) -> Solid:
    """A solid that was so high over its level before made `height` high, its top exactly."""
    vertices = solid.vertices.copy()
    over = vertices[:, 2] - level
    vertices[:, 2] = level + over * (height / before)
    vertices[over >= before * (1 - 1e-12), 2] = level + height
    return replace(solid, vertices=vertices)


def _renamed(solid: Solid, lids: frozenset[str]) -> Solid:
    """The faces of a roof, a cut or an extrusion as those of a taper; lids bear more tags."""
    names = [frozenset(_NAMES[word] for word in own if word in _NAMES) for own in solid.tags]
    tags = [own if "taper.side" in own else own | lids for own in names]
    return replace(solid, tags=tuple(tags))


def _in_order(solid: Solid) -> Solid:
    rank = [next(n for n, word in enumerate(_ORDER) if word in tags) for tags in solid.tags]
    return chosen(solid, np.argsort(rank, kind="stable"))
