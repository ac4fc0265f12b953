"""OFF files to meshes.

Takes a path; gives a mesh with the file's polygons; colours are passed over. Counts are checked
against the length of the file before memory is taken. Nothing is written.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipmlang.formats import FormatError
from ipmlang.formats.mesh_types import Mesh, MeshScene, single, without_bad_faces


def read_off(path: Path) -> MeshScene:
    """The mesh of an ASCII OFF file."""
    text = path.read_bytes().decode("latin-1")
    lines = [(n, line.split("#")[0].split()) for n, line in enumerate(text.splitlines(), 1)]
    lines = [(number, words) for number, words in lines if words]
    if not lines or lines[0][1][0].upper() not in ("OFF", "COFF", "NOFF"):
        raise FormatError("this is no OFF file: it does not begin with `OFF`", 1)
    lines = [(lines[0][0], lines[0][1][1:]), *lines[1:]] if lines[0][1][1:] else lines[1:]
    counts = _whole(*lines[0]) if lines else []
    if len(counts) < 2 or min(counts) < 0:
        raise FormatError("the file does not say how many vertices and faces it has", 2)
    points, faces = counts[:2]
    if points + faces > len(lines) - 1:
        stated = f"{points} vertices and {faces} faces"
        message = f"the file states {stated} and has {len(lines) - 1} lines"
        raise FormatError(message, lines[0][0], "the file may be cut off")
    vertices = np.array([_point(*line) for line in lines[1 : 1 + points]]).reshape(-1, 3)
    corners: list[int] = []
    sizes: list[int] = []
    for number, words in lines[1 + points : 1 + points + faces]:
        face = _face(number, words, points)
        corners += face
        sizes.append(len(face))
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    none, group = np.full(faces, -1, np.int64), np.zeros(faces, np.int64)
    mesh = Mesh(vertices, np.array(corners, np.int64), offsets, none, group, groups=((path.stem,),))
    mesh, notes = without_bad_faces(mesh)
    return single(mesh, path.stem, notes)


def _whole(number: int, words: list[str]) -> list[int]:
    try:
        return [int(word) for word in words]
    except ValueError:
        raise FormatError(f"`{' '.join(words)[:60]}` are not whole numbers", number) from None


def _point(number: int, words: list[str]) -> list[float]:
    try:
        x, y, z = (float(word) for word in words[:3])
    except ValueError:
        raise FormatError(f"`{' '.join(words)[:60]}` are not three numbers", number) from None
    return [x, y, z]


def _face(number: int, words: list[str], points: int) -> list[int]:
    size = _whole(number, words[:1])[0]
    face = _whole(number, words[1 : 1 + max(size, 0)])
    if len(face) != size or any(not 0 <= index < points for index in face):
        written = " ".join(words)[:60]
        raise FormatError(f"the face `{written}` names no vertices of the file", number)
    return face
