"""A model read and taken apart: the pipeline of this package.

Takes the path of a model; gives its parts as placed copies of shape classes. What was mended, left
out or guessed is said in notes. Nothing here looks for patterns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from ipmlang.formats import FormatError
from ipmlang.formats.distinct import distinct_numbers
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh import read_meshes
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers, from_matrices
from ipmlang.inverse.parts.axes import askew, straightened
from ipmlang.inverse.parts.classes import MOST_SYMMETRY, Classes, ShapeClass, classified
from ipmlang.inverse.parts.invariants import alike, centers
from ipmlang.inverse.parts.mending import sound
from ipmlang.inverse.parts.naming import class_names
from ipmlang.inverse.parts.observation import Likeness, PartClass, Parts
from ipmlang.inverse.parts.pieces import Pieces, piece_mesh, sorted_pieces, with_diagonals
from ipmlang.inverse.parts.scaling import likenesses
from ipmlang.inverse.parts.segmenting import segmented
from ipmlang.inverse.parts.soup import Soup, gathered
from ipmlang.inverse.parts.uprighting import upright
from ipmlang.inverse.parts.upward import upward
from ipmlang.inverse.parts.welding import connected_faces, welded

EXACT = 1e-6  # share of the diagonal that equal parts may differ by
_PER_NAME = 2  # parts that each name of the file may add by what it cuts
FINER = 1.1  # times as many shapes there may be for the sake of equal triangles


def observe(
    path: Path | str,
    *,
    up: Literal["auto", "y", "z"] = "auto",
    unit: float = 1.0,
    within: float | None = None,
    keep_uv: bool = False,
) -> Parts:
    """The parts of a model.

    up: which way is up in the file; unit: what lengths are multiplied with; within: share of the
    diagonal that equal parts may differ by, None for what counts as exact (1e-6); keep_uv: texture
    coordinates tell shapes apart even where no image is laid by them. FormatError where
    the file cannot be read or holds no faces.
    """
    return observe_with_faces(path, up=up, unit=unit, within=within, keep_uv=keep_uv)[0]


def observe_with_faces(
    path: Path | str,
    *,
    up: Literal["auto", "y", "z"] = "auto",
    unit: float = 1.0,
    within: float | None = None,
    keep_uv: bool = False,
    same_triangles: bool = False,
    own_axes: bool = False,
) -> tuple[Parts, Mesh]:
    """The same, and all faces of the model in the world, z up, as they were read but for what was
    mended: what a proof compares with. same_triangles: where the file's faces allow it, copies
    also have the triangles that a fan from the first corner cuts their faces into. own_axes: the
    parts are given in the axes of the building, which stands turned by `Parts.turn`.
    """
    path = Path(path)
    scene = read_meshes(path)
    turned, guess = upward(path, scene, up)
    soup = gathered(scene, turned, unit)
    turn = askew(soup.mesh) if own_axes else 0.0
    if turn:
        soup = replace(soup, mesh=straightened(soup.mesh, turn))
    reach = EXACT if within is None else within
    parts, mesh = _taken_apart(
        soup, reach, path.stem, keep_uv, (*scene.notes, *guess), same_triangles
    )
    up_in_file: Literal["y-up", "z-up"] = "y-up" if turned else "z-up"
    mesh = straightened(mesh, -turn) if turn else mesh
    source_bytes = path.stat().st_size
    parts = upright(parts) if own_axes else parts
    return replace(parts, up=up_in_file, turn=turn, source_bytes=source_bytes), mesh


def parts_of(
    soup: Soup,
    within: float,
    stem: str = "",
    keep_uv: bool = False,
    said: tuple[Note, ...] = (),
) -> Parts:
    """The parts of faces in the world; `stem` is what the model is called, `said` what its notes
    begin with. FormatError where no face has an area.
    """
    return _taken_apart(soup, within, stem, keep_uv, said)[0]


def _taken_apart(
    soup: Soup,
    within: float,
    stem: str,
    keep_uv: bool,
    said: tuple[Note, ...],
    same_triangles: bool = False,
) -> tuple[Parts, Mesh]:
    mesh = soup.mesh
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices[mesh.corners], axis=0)))
    same, met = welded(mesh.vertices, diagonal)
    owner, part = _connected(soup, met)
    better, kept, mended = sound(mesh, same, owner, diagonal)
    if not len(kept):
        hint = "; ".join(f"{note.message} ({note.count})" for note in (*said, *mended))
        raise FormatError("no face of the model has an area", hint=hint)
    _, part = distinct_numbers(part[kept])
    part, cut = segmented(better, same, part, diagonal, within * diagonal)
    pieces = sorted_pieces(better, same, part, keep_uv)
    found = _classes(pieces, within * diagonal, same_triangles)
    told = _told(replace(soup, mesh=better), pieces, found, diagonal, stem)
    parts = replace(
        told,
        likenesses=_likenesses(pieces, found, within * diagonal),
        triangles=int((np.diff(mesh.offsets) - 2).sum()),
        vertices=len(mesh.vertices),
        notes=(*said, *_unused(mesh), *mended, *cut, *told.notes),
    )
    return parts, better


def _classes(pieces: Pieces, tolerance: float, same_triangles: bool) -> Classes:
    """The classes of parts; where asked for, of parts whose copies have the same triangles, unless
    that tells many more shapes apart: faces may begin at any of their corners.
    """
    if not same_triangles or not (np.diff(pieces.offsets) > 3).any():
        return classified(pieces, tolerance)
    finer = classified(with_diagonals(pieces), tolerance)
    at_least = len(alike(pieces, centers(pieces), tolerance))  # quicker than the classes
    if len(finer.classes) <= FINER * at_least + 1:
        return finer
    found = classified(pieces, tolerance)
    return finer if len(finer.classes) <= FINER * len(found.classes) + 1 else found


def _likenesses(pieces: Pieces, found: Classes, tolerance: float) -> tuple[Likeness, ...]:
    """The classes that are scaled copies of others."""
    low = np.minimum.reduceat(pieces.vertices, pieces.vertex_start[:-1], axis=0)
    levers = np.stack([_lever(each, found, low) for each in found.classes])
    return likenesses(pieces, found, levers, tolerance)


def _connected(soup: Soup, met: Integers) -> tuple[Integers, Integers]:
    """For each face what it is given to and its part: copies of one mesh stay apart from what they
    touch, and so does what the file names apart, where its names do not cut through things.
    """
    mesh = soup.mesh

    def connected(owner: Integers) -> Integers:
        beyond = np.repeat(owner * (int(met.max()) + 1), np.diff(mesh.offsets))
        return connected_faces(beyond + met[mesh.corners], mesh.offsets)

    owner = np.where(soup.shared[soup.owner], soup.owner + 1, 0)
    part = connected(owner)
    names = len(np.unique(mesh.group))
    if names > 1:
        named = owner * len(soup.paths) + mesh.group
        finer = connected(named)
        # Groups for each material cut things to pieces; objects only part things that touch.
        if int(finer.max()) <= int(part.max()) + _PER_NAME * names:
            return named, finer
    return owner, part


def _told(soup: Soup, pieces: Pieces, found: Classes, diagonal: float, stem: str) -> Parts:
    """What was found, as an observation."""
    low = np.minimum.reduceat(pieces.vertices, pieces.vertex_start[:-1], axis=0)
    high = np.maximum.reduceat(pieces.vertices, pieces.vertex_start[:-1], axis=0)
    matrix = np.zeros((len(pieces), 3, 4))
    misfit = np.zeros(len(pieces))
    for each in found.classes:
        lever = _lever(each, found, low)
        matrix[each.rows, :, :3] = each.linear
        matrix[each.rows, :, 3] = found.center[each.rows] + each.shift + each.linear @ lever
        misfit[each.rows] = each.misfit
    paths = _paths(soup, pieces)
    meshes = [_own_mesh(soup.mesh, pieces, each, low) for each in found.classes]
    names = class_names([each.rows for each in found.classes], meshes, paths, stem, low, high)
    classes = tuple(
        PartClass(
            name,
            mesh,
            np.ptp(mesh.vertices, axis=0),
            from_matrices(_about(each.symmetry, -_lever(each, found, low))),
            each.rows,
        )
        for name, mesh, each in zip(names, meshes, found.classes, strict=True)
    )
    return Parts(
        found.shape,
        from_matrices(matrix),
        low,
        high,
        paths,
        classes,
        misfit,
        diagonal,
        "z-up",
        0,
        0,
        0,
        _remarks(found.classes),
    )


def _lever(each: ShapeClass, found: Classes, low: Floats) -> Floats:
    """The lowest corner of a class's shape from its centre."""
    if each.shape is None:
        return np.asarray(low[each.model] - found.center[each.model])
    return np.asarray(each.shape.min(axis=0))


def _own_mesh(mesh: Mesh, pieces: Pieces, each: ShapeClass, low: Floats) -> Mesh:
    """The faces of a class's model over the corners that stand for all, from the lowest."""
    own = piece_mesh(pieces, each.model, mesh)
    if each.shape is None:
        return replace(own, vertices=own.vertices - low[each.model])
    return replace(own, vertices=each.shape - each.shape.min(axis=0))


def _about(linear: Floats, center: Floats) -> Floats:
    """Maps (s, 3, 4) that turn about a centre."""
    return np.concatenate([linear, (center - linear @ center)[:, :, None]], axis=2)


def _paths(soup: Soup, pieces: Pieces) -> tuple[tuple[str, ...], ...]:
    """The path under which most faces of each part stood, of equally many the first."""
    part = np.repeat(np.arange(len(pieces)), np.diff(pieces.face_start))
    count = len(soup.paths)
    under = part * count + pieces.group
    key, first, often = np.unique(under, return_index=True, return_counts=True)
    order = np.lexsort([first, -often, key // count])
    leading = order[np.searchsorted(key[order] // count, np.arange(len(pieces)))]
    return tuple(soup.paths[each] for each in (key[leading] % count).tolist())


def _unused(mesh: Mesh) -> tuple[Note, ...]:
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.corners] = True
    lost = int((~used).sum())
    if not lost:
        return ()
    return (Note("unused-vertex", "vertices that no face uses were left out", lost),)


def _remarks(classes: Sequence[ShapeClass]) -> tuple[Note, ...]:
    capped = sum(not each.whole for each in classes)
    if not capped:
        return ()
    message = f"shapes may have more than {MOST_SYMMETRY} symmetries; only those along the axes"
    return (Note("symmetry", f"{message} are used", capped),)
