"""Solids that touch themselves along edges or in points, taken apart there by next to nothing.

Booleans go wrong, without a word, where a solid's own faces meet in an edge that more than two of
them share. A closed solid comes in; one whose faces meet in pairs goes out, and the places where
copies of a vertex were drawn inward.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2, tau

import numpy as np

from ipmlang.geometry.loops import Vector, dot, frame
from ipmlang.geometry.sharing import first_at_place, following
from ipmlang.geometry.solid import Floats, Indices, Solid, face_of_corners, normals

GAP = 2e-10
"""How far copies are drawn in, as a share of the solid's extent."""


def drawn_apart(solid: Solid) -> tuple[Solid, Floats]:
    """The solid with its vertices told apart by the faces around them, and the places (k, 3) that
    more than one of them had.

    >>> from ipmlang.geometry.solid import unit_box
    >>> same, places = drawn_apart(unit_box())
    >>> len(same.vertices), len(places)
    (8, 0)
    """
    used = np.unique(solid.corners)
    at = first_at_place(solid.vertices[used])
    if len(np.unique(at)) == len(used) and not _crowded(solid):
        return solid, np.zeros((0, 3))
    _, first, numbers = np.unique(_fans(solid), return_index=True, return_inverse=True)
    vertices = solid.vertices[solid.corners[first]]
    place = first_at_place(vertices)
    moves = np.bincount(place, minlength=len(place))[place] > 1
    toward = _toward_neighbours(replace(solid, vertices=vertices, corners=numbers))
    reach = GAP * float(np.ptp(vertices, axis=0).max())
    moved = vertices + np.where(moves, reach, 0.0)[:, None] * toward
    apart = replace(solid, vertices=moved, corners=numbers.astype(np.int64))
    return apart, np.unique(vertices[moves], axis=0)


def _crowded(solid: Solid) -> bool:
    """Whether more than two faces share an edge."""
    ahead = solid.corners[following(solid)]
    key = np.minimum(solid.corners, ahead) * len(solid.vertices) + np.maximum(solid.corners, ahead)
    return len(np.unique(key)) * 2 < len(key)


def _toward_neighbours(solid: Solid) -> Floats:
    """For each vertex (v, 3) the way into the wedge of material, or of nothing, whose tip it is."""
    after = following(solid)
    ways = solid.vertices[solid.corners[after]] - solid.vertices[solid.corners]
    ways /= np.sqrt(np.einsum("ij,ij->i", ways, ways))[:, None]
    found = np.zeros_like(solid.vertices)
    np.add.at(found, solid.corners, ways)
    length = np.sqrt(np.einsum("ij,ij->i", found, found))
    unit: Floats = found / np.where(length > 1e-9, length, 1.0)[:, None]
    return unit


def _fans(solid: Solid) -> Indices:
    """For each corner (c,) the first of those at its vertex that one piece of material joins."""
    after = following(solid).tolist()
    root = list(range(len(after)))
    for one, other in _pairs(solid, after):
        for a, b in ((one, after[other]), (after[one], other)):
            a, b = _root(root, a), _root(root, b)
            root[max(a, b)] = min(a, b)
    return np.array([_root(root, corner) for corner in range(len(root))])


def _root(root: list[int], corner: int) -> int:
    while root[corner] != corner:
        root[corner] = corner = root[root[corner]]
    return corner


def _pairs(solid: Solid, after: list[int]) -> list[tuple[int, int]]:
    """Corners where the two uses of an edge begin; of more than two, those around one wedge."""
    numbers = solid.corners.tolist()
    uses: dict[tuple[int, int], list[int]] = {}
    for corner, number in enumerate(numbers):
        ahead = numbers[after[corner]]
        uses.setdefault((min(number, ahead), max(number, ahead)), []).append(corner)
    found = []
    for edge, corners in uses.items():
        up = [corner for corner in corners if numbers[corner] == edge[0]]
        down = [corner for corner in corners if numbers[corner] != edge[0]]
        if len(up) == len(down) == 1:
            found.append((up[0], down[0]))
        else:
            found += _wedges(solid, edge, up, down)
    return found


def _wedges(
    solid: Solid, edge: tuple[int, int], up: list[int], down: list[int]
) -> list[tuple[int, int]]:
    """Each face that runs up an edge with the one that runs down beyond the material between.

    Around the edge material lies clockwise of faces that run up: turn back to the next that runs
    down.
    """
    along = solid.vertices[edge[1]] - solid.vertices[edge[0]]
    along = along / np.sqrt(along @ along)
    way: Vector = (float(along[0]), float(along[1]), float(along[2]))
    across, other = frame(way)
    outward = normals(solid)
    face = face_of_corners(solid)

    def angle(corner: int, sign: float) -> float:
        """Where a face lies around the edge: a quarter turn from its normal."""
        normal = outward[face[corner]].tolist()
        return atan2(dot(normal, other), dot(normal, across)) + sign * tau / 4

    ups = [(angle(corner, -1.0), corner) for corner in up]
    downs = [(angle(corner, 1.0), corner) for corner in down]
    found = []
    for turn, corner in ups[: len(downs)]:
        best = min(downs, key=lambda each: (turn - each[0]) % tau)
        downs.remove(best)
        found.append((corner, best[1]))
    return found
