"""Ways to cut what hangs together: where the file's own vertices part, into the solids that faces
bound, where more than two faces meet, along creases that fold in or out, and along planes that no
face crosses.

Takes faces of one or more parts; each way gives every face the label of the piece it would belong
to, in batches over all faces. Whether a cut is worth it is decided elsewhere; nothing is cut here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.distinct import distinct_numbers, stable_order
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.facing import facing
from ipmlang.inverse.parts.invariants import mixed
from ipmlang.inverse.parts.mending import area_vectors
from ipmlang.inverse.parts.pieces import neighbours, sums
from ipmlang.inverse.parts.welding import linked

_CREASE = np.cos(np.radians(25.0))
_ONE_PLANE = np.cos(np.radians(0.5))
_HOLLOW = 1e-4  # sine of an angle: what folds in by less is rounding
_PLANE = 1e-6  # share of the diagonal by which faces may reach over a plane


Truths: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """Faces with what cuts ask of them. part (f,); pairs (p, 2) of faces of one part that alone
    share an edge; bend (p,): 0 where they go on smoothly, 1 where the edge stands out, -1 where it
    lies in; flat (p,): whether they lie in one plane; inward (p,): whether the edge lies in at all,
    however smoothly; facing (q, 2): pairs of faces at edges of more than two that look at each
    other through the solid that they bound.
    """

    mesh: Mesh
    part: Integers
    pairs: Integers
    bend: Integers
    flat: Truths
    inward: Truths
    facing: Integers
    diagonal: float


Cut: TypeAlias = Callable[[Sheet], Integers]


def sheet_of(mesh: Mesh, same: Integers, part: Integers, diagonal: float) -> Sheet:
    """The faces of a mesh with equal labels for equal points."""
    after, _ = neighbours(mesh.offsets)
    face = np.repeat(np.arange(len(part)), np.diff(mesh.offsets))
    here = same[mesh.corners]
    low, high = np.minimum(here, here[after]), np.maximum(here, here[after])
    edge = mixed(mixed(low.astype(np.uint64)) ^ high.astype(np.uint64))
    edge = mixed(edge ^ part[face].astype(np.uint64))
    order = stable_order(edge)
    edge = edge[order]
    starts = np.flatnonzero(np.concatenate([[True], edge[1:] != edge[:-1]]))
    count = np.diff(np.append(starts, len(order)))
    two = starts[count == 2]
    first, second = order[two], order[two + 1]
    pairs = np.stack([face[first], face[second]], axis=1)
    crowded = np.repeat(count > 2, count)
    forth = here <= here[after]
    number = np.repeat(np.arange(len(count)), count)[crowded]
    area = area_vectors(mesh)
    corner = order[crowded]
    found = facing(mesh, number, corner, area[face[corner]], after, forth)
    return Sheet(mesh, part, pairs, *_bends(mesh, area, pairs), face[found], diagonal)


def _bends(mesh: Mesh, area: Floats, pairs: Integers) -> tuple[Integers, Truths, Truths]:
    normal = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), 1e-300)
    sizes = np.diff(mesh.offsets)
    points = mesh.vertices[mesh.corners]
    middle = sums(points, mesh.offsets) / sizes[:, None]
    one, other = pairs.T
    alike = np.einsum("pi,pi->p", normal[one], normal[other])
    way = middle[other] - middle[one]
    above = np.einsum("pi,pi->p", way, normal[one] - normal[other])
    bend = np.where(alike > _CREASE, 0, np.where(above > 0, -1, 1))
    return bend, alike > _ONE_PLANE, above > _HOLLOW * np.linalg.norm(way, axis=1)


def bounded(sheet: Sheet, parent: Integers, count: int, solids: Integers) -> tuple[Truths, Truths]:
    """(count,) whether the faces of each parent (f,) bound one convex solid, such as a box, a
    cylinder or a cone, which a person takes for one thing; and whether they bound several, which
    touch in no more than points. solids: a face of each piece that hangs together by edges.
    """
    corners = np.bincount(parent, np.diff(sheet.mesh.offsets), count)
    above = parent[sheet.pairs[:, 0]]
    closed = 2 * np.bincount(above, minlength=count) == corners
    hollow = np.bincount(above, sheet.inward, count) > 0
    many = np.bincount(parent[solids], minlength=count)
    return closed & ~hollow & (many == 1), closed & (many > 1)


def by_own_vertices(sheet: Sheet) -> Integers:
    """Faces that share vertices as the file has them. Where most faces have their own, as files
    write them to shade faces apart, only those in one plane count as apart.
    """
    mesh = sheet.mesh
    first = mesh.corners[mesh.offsets[:-1]]
    begin = np.repeat(first, np.diff(mesh.offsets))
    island = linked(len(mesh.vertices), np.stack([begin, mesh.corners], axis=1))[first]
    parts = int(sheet.part.max()) + 1
    faces = np.bincount(sheet.part, minlength=parts)
    one, _ = distinct_numbers(island)
    loose = 2 * np.bincount(sheet.part[one], minlength=parts) >= faces
    folded = loose[sheet.part[sheet.pairs[:, 0]]] & ~sheet.flat
    size = int(island.max()) + 1
    return linked(size, island[sheet.pairs[folded]])[island]


def by_edges(sheet: Sheet) -> Integers:
    """Faces that hang together by edges of two faces: where more meet, things touch."""
    return linked(len(sheet.part), sheet.pairs)


def by_solids(sheet: Sheet) -> Integers:
    """Faces that bound one solid: where solids touch along edges or whole faces, each keeps its
    own.
    """
    return linked(len(sheet.part), np.concatenate([sheet.pairs, sheet.facing]))


def by_valleys(sheet: Sheet) -> Integers:
    """Cut along creases that lie in: what stands out from a wall comes off it."""
    return linked(len(sheet.part), sheet.pairs[sheet.bend >= 0])


def by_ridges(sheet: Sheet) -> Integers:
    """Cut along creases that stand out: what is let into a wall comes off it."""
    return linked(len(sheet.part), sheet.pairs[sheet.bend <= 0])


def by_creases(sheet: Sheet) -> Integers:
    """Cut along all creases."""
    return linked(len(sheet.part), sheet.pairs[sheet.bend == 0])


def by_planes(sheet: Sheet) -> Integers:
    """Cut along planes across the axes that no face of the part crosses, then by what hangs
    together by edges.
    """
    mesh = sheet.mesh
    cell = np.stack([_slab(each[mesh.corners], sheet) for each in mesh.vertices.T.copy()], axis=1)
    one, other = sheet.pairs.T
    return linked(len(sheet.part), sheet.pairs[(cell[one] == cell[other]).all(axis=1)])


def _slab(place: Floats, sheet: Sheet) -> Integers:
    """The number of each face's slab along an axis by where its corners (c,) are: a new one begins
    where all before has ended. Faces that lie in such a plane belong to the slab below it.
    """
    slack = _PLANE * sheet.diagonal
    low = np.minimum.reduceat(place, sheet.mesh.offsets[:-1])
    high = np.maximum.reduceat(place, sheet.mesh.offsets[:-1])
    order = np.lexsort([high, low, sheet.part])
    begins, ends, owner = low[order], high[order], sheet.part[order]
    # Parts are moved apart along the axis, so that one running maximum serves all.
    other = np.diff(owner) != 0
    apart = np.concatenate([[0], np.cumsum(other)]) * (float(np.ptp(place)) * 2 + 1)
    reached = np.maximum.accumulate(ends + apart)
    new = (begins + apart)[1:] >= reached[:-1] - slack
    lying = (ends - begins)[1:] <= slack
    slab = np.concatenate([[0], np.cumsum(new & ~lying | other)])
    result = np.empty(len(order), np.int64)
    result[order] = slab
    return result
