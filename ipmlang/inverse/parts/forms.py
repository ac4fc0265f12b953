"""Which shapes are one form in other materials: a roof of brick and a roof of slate.

In go parts, out come the classes that are another one but for what they are made of, with the map
between their coordinates. Nothing is moved here, and whether it pays to draw them alike is not
known.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import compose, from_matrices, inverse
from ipmlang.inverse.parts.classes import classified
from ipmlang.inverse.parts.observation import Likeness, Parts
from ipmlang.inverse.parts.pieces import Pieces, sorted_pieces, with_diagonals

NEAR = 1e-3  # of how far one form reaches, that another may reach further


def recolored(parts: Parts, tolerance: float) -> tuple[Likeness, ...]:
    """The classes that are another one in other materials. tolerance: how far apart vertices of
    equal forms may be, a length.
    """
    return tuple(
        each
        for some in _candidates(parts)
        for each in _likenesses([parts.classes[k].mesh for k in some], some, tolerance)
    )


def _likenesses(
    meshes: Sequence[Mesh], number: Sequence[int], tolerance: float
) -> Iterator[Likeness]:
    """Those among classes of these numbers, with the first of each form."""
    found = classified(_bare(meshes), tolerance)
    for each in found.classes:
        rows = each.rows.tolist()
        if len({_look(meshes[row]) for row in rows}) < len(rows):
            continue  # they differ in more than what they are made of
        place = found.center[rows] + each.shift
        every = from_matrices(np.concatenate([each.linear, place[:, :, None]], axis=2))
        way = compose(every, inverse(every[:1]))
        for k in range(1, len(rows)):
            yield Likeness(number[rows[k]], number[rows[0]], way[k : k + 1], 0.0)


def _candidates(parts: Parts) -> list[list[int]]:
    """Classes with as many vertices and faces as each other, which reach about as far from their
    middle, in materials that are not the same.
    """
    groups: dict[Hashable, list[tuple[float, int]]] = {}
    if all(len(each.members) == 1 for each in parts.classes):
        return []  # beside what stands once nothing stands again in another material
    for number, each in enumerate(parts.classes):
        mesh = each.mesh
        counts = len(mesh.vertices), len(mesh.corners), len(mesh.offsets)
        arm = mesh.vertices - mesh.vertices.mean(axis=0)
        groups.setdefault(counts, []).append((float(np.sqrt((arm**2).sum())), number))
    found: list[list[int]] = []
    for same in groups.values():
        same.sort()
        apart = [k for k in range(1, len(same)) if same[k][0] > (1 + NEAR) * same[k - 1][0]]
        for begin, end in pairwise([0, *apart, len(same)]):
            own = sorted(number for _, number in same[begin:end])
            if len({_look(parts.classes[k].mesh) for k in own}) > 1:
                found.append(own)
    return found


def _look(mesh: Mesh) -> Hashable:
    """What faces are made of, whichever they are."""
    images = None
    if mesh.uv is not None and any(each.texture is not None for each in mesh.materials):
        images = np.sort(np.round(mesh.uv, 4), axis=0).tobytes()
    return frozenset(each.name for each in mesh.materials), images


def _bare(meshes: Sequence[Mesh]) -> Pieces:
    """Meshes as parts without materials and images."""
    vertices = [len(each.vertices) for each in meshes]
    faces = [len(each.offsets) - 1 for each in meshes]
    begin = np.cumsum([0, *vertices])
    sizes = np.concatenate([np.diff(each.offsets) for each in meshes])
    nothing = np.zeros(sum(faces), np.int64)
    mesh = Mesh(
        np.concatenate([each.vertices for each in meshes]),
        np.concatenate([each.corners + at for each, at in zip(meshes, begin, strict=False)]),
        np.concatenate([[0], np.cumsum(sizes)]),
        nothing,
        nothing,
    )
    part = np.repeat(np.arange(len(meshes)), faces)
    return with_diagonals(sorted_pieces(mesh, np.arange(sum(vertices)), part, False))
