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

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh import read_meshes
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, from_matrices
from ipmlang.inverse.parts.classes import MOST_SYMMETRY, Classes, ShapeClass, classified
from ipmlang.inverse.parts.naming import class_names
from ipmlang.inverse.parts.observation import PartClass, Parts
from ipmlang.inverse.parts.pieces import Pieces, piece_mesh, sorted_pieces
from ipmlang.inverse.parts.soup import Soup, gathered
from ipmlang.inverse.parts.upward import upward
from ipmlang.inverse.parts.welding import connected_faces, welded

EXACT = 1e-6  # share of the diagonal that equal parts may differ by


def observe(
    path: Path | str,
    *,
    up: Literal["auto", "y", "z"] = "auto",
    unit: float = 1.0,
    within: float | None = None,
) -> Parts:
    """The parts of a model.

    up: which way is up in the file; unit: what lengths are multiplied with; within: share of the
    diagonal that equal parts may differ by, None for what counts as exact (1e-6). FormatError where
    the file cannot be read or holds no faces.
    """
    path = Path(path)
    scene = read_meshes(path)
    turned, guess = upward(path, scene, up)
    soup = gathered(scene, turned, unit)
    parts = parts_of(soup, EXACT if within is None else within, path.stem)
    up_in_file: Literal["y-up", "z-up"] = "y-up" if turned else "z-up"
    notes = (*scene.notes, *guess, *parts.notes)
    return replace(parts, up=up_in_file, source_bytes=path.stat().st_size, notes=notes)


def parts_of(soup: Soup, within: float, stem: str = "") -> Parts:
    """The parts of faces in the world; `stem` is what the model is called."""
    mesh = soup.mesh
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices[mesh.corners], axis=0)))
    same, met = welded(mesh.vertices, diagonal)
    nodes = met[mesh.corners]
    apart = soup.shared[soup.owner]
    if apart.any():  # copies of one mesh stay whole, and apart from what they touch
        owner = np.repeat(np.where(apart, soup.owner + 1, 0), np.diff(mesh.offsets))
        nodes = owner * (int(met.max()) + 1) + nodes
    part = connected_faces(nodes, mesh.offsets)
    pieces = sorted_pieces(mesh, same, part)
    return _told(soup, pieces, classified(pieces, within * diagonal), diagonal, stem)


def _told(soup: Soup, pieces: Pieces, found: Classes, diagonal: float, stem: str) -> Parts:
    """What was found, as an observation."""
    low = np.minimum.reduceat(pieces.vertices, pieces.vertex_start[:-1], axis=0)
    high = np.maximum.reduceat(pieces.vertices, pieces.vertex_start[:-1], axis=0)
    matrix = np.zeros((len(pieces), 3, 4))
    misfit = np.zeros(len(pieces))
    for each in found.classes:
        lever = low[each.model] - found.center[each.model]
        matrix[each.rows, :, :3] = each.linear
        matrix[each.rows, :, 3] = found.center[each.rows] + each.linear @ lever
        misfit[each.rows] = each.misfit
    paths = _paths(soup, pieces)
    meshes = [_own_mesh(soup.mesh, pieces, each.model, low) for each in found.classes]
    names = class_names([each.rows for each in found.classes], meshes, paths, stem)
    classes = tuple(
        PartClass(
            name,
            mesh,
            high[each.model] - low[each.model],
            from_matrices(_about(each.symmetry, found.center[each.model] - low[each.model])),
            each.rows,
        )
        for name, mesh, each in zip(names, meshes, found.classes, strict=True)
    )
    sizes = np.diff(soup.mesh.offsets)
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
        int((sizes - 2).sum()),
        len(soup.mesh.vertices),
        0,
        _remarks(found.classes),
    )


def _own_mesh(mesh: Mesh, pieces: Pieces, part: int, low: Floats) -> Mesh:
    own = piece_mesh(pieces, part, mesh)
    return replace(own, vertices=own.vertices - low[part])


def _about(linear: Floats, center: Floats) -> Floats:
    """Maps (s, 3, 4) that turn about a centre."""
    return np.concatenate([linear, (center - linear @ center)[:, :, None]], axis=2)


def _paths(soup: Soup, pieces: Pieces) -> tuple[tuple[str, ...], ...]:
    """The path under which most faces of each part stood, of equally many the first."""
    part = np.repeat(np.arange(len(pieces)), np.diff(pieces.face_start))
    count = len(soup.paths)
    key, first, often = np.unique(part * count + pieces.group, return_index=True, return_counts=True)
    order = np.lexsort([first, -often, key // count])
    leading = order[np.searchsorted(key[order] // count, np.arange(len(pieces)))]
    return tuple(soup.paths[each] for each in (key[leading] % count).tolist())


def _remarks(classes: Sequence[ShapeClass]) -> tuple[Note, ...]:
    capped = sum(not each.whole for each in classes)
    if not capped:
        return ()
    message = f"shapes may have more than {MOST_SYMMETRY} symmetries; only those along the axes"
    return (Note("symmetry", f"{message} are used", capped),)
