"""Many named meshes as one compact OBJ: what a grammar keeps its terminals in.

Takes meshes by name; gives the text of one file. Numbers have no digit more than asked for, texture
points and normals are shared by all, normals that are those of their face are left out, and
materials stand in the file itself. Images cannot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.mesh_types import Floats, Material, Mesh, face_normals
from ipmlang.formats.mtl import library_contents
from ipmlang.formats.numbers import decimal_texts

UV_DIGITS = 6
NORMAL_DIGITS = 4
FLAT = 0.99995  # cosine between a normal and its face's from which on they are the same


def obj_parts(parts: Mapping[str, Mesh], decimals: int) -> str:
    """The file; decimals: behind the point of a coordinate."""
    materials = _materials(list(parts.values()))
    lines: list[str] = []
    if any(material.color is not None for material in materials.values()):
        text, _ = library_contents(materials, Path())
        lines += text.strip().split("\n")[1:]
    words = {material: word for word, material in materials.items()}
    shared = _Shared(lines)
    for part, mesh in parts.items():
        lines.append(f"o {part}")
        shared.add(mesh, decimals, words)
    return "\n".join(lines) + "\n"


def _materials(meshes: Sequence[Mesh]) -> dict[str, Material]:
    """All materials by the names they get, which are one word each."""
    found = dict.fromkeys(
        mesh.materials[number]
        for mesh in meshes
        for number in np.unique(mesh.material[mesh.material >= 0]).tolist()
    )
    named: dict[str, Material] = {}
    for material in found:
        stem = "_".join(material.name.split()) or "material"
        name, number = stem, 2
        while name in named:
            name, number = f"{stem}_{number}", number + 1
        named[name] = material
    return named


class _Shared:
    """The lines of a file as it grows, and what is in it already."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = lines
        self.vertices = 0
        self.textures: dict[str, int] = {}
        self.normals: dict[str, int] = {}
        self.material = ""

    def add(self, mesh: Mesh, decimals: int, words: Mapping[Material, str]) -> None:
        """One mesh with all its faces."""
        vertex = self._vertices(mesh, decimals)
        texture = self._column("vt", self.textures, mesh.uv, UV_DIGITS)
        flat = _flat_faces(mesh)
        if mesh.normals is not None and not self.normals:
            flat[:1] = False  # one face with its normals tells readers that faces have some
        bent = np.repeat(~flat, np.diff(mesh.offsets))
        normal = self._column("vn", self.normals, mesh.normals, NORMAL_DIGITS, bent)
        for own in np.unique(mesh.material).tolist():
            self._use(words[mesh.materials[own]] if own >= 0 else "")
            for face in np.flatnonzero(mesh.material == own).tolist():
                corners = range(int(mesh.offsets[face]), int(mesh.offsets[face + 1]))
                given = None if flat[face] else normal
                words_of = [_corner(k, vertex, texture, given) for k in corners]
                self.lines.append("f " + " ".join(words_of))

    def _use(self, material: str) -> None:
        """Say the material of the faces that follow; without a name: none."""
        if material != self.material:
            self.lines.append(f"usemtl {material}".rstrip())
            self.material = material

    def _vertices(self, mesh: Mesh, decimals: int) -> list[int]:
        """The numbers of all corners' vertices; those of equal text are one."""
        texts = _row_texts(mesh.vertices, decimals)
        used = dict.fromkeys(texts[k] for k in mesh.corners.tolist())
        numbers = {text: self.vertices + k + 1 for k, text in enumerate(used)}
        self.lines += [f"v {text}" for text in used]
        self.vertices += len(used)
        return [numbers[texts[k]] for k in mesh.corners.tolist()]

    def _column(
        self,
        word: str,
        known: dict[str, int],
        values: Floats | None,
        digits: int,
        used: NDArray[np.bool_] | None = None,
    ) -> list[int] | None:
        """The numbers of what belongs to corners, written where it is new and used."""
        if values is None:
            return None
        numbers = []
        for row, text in enumerate(_row_texts(values, digits)):
            if used is not None and not used[row]:
                numbers.append(0)
                continue
            if text not in known:
                known[text] = len(known) + 1
                self.lines.append(f"{word} {text}")
            numbers.append(known[text])
        return numbers


def _corner(k: int, vertex: list[int], texture: list[int] | None, normal: list[int] | None) -> str:
    if normal is not None:
        return f"{vertex[k]}/{'' if texture is None else texture[k]}/{normal[k]}"
    return f"{vertex[k]}" if texture is None else f"{vertex[k]}/{texture[k]}"


def _row_texts(values: Floats, digits: int) -> list[str]:
    texts = decimal_texts(values.reshape(-1), digits)
    width = values.shape[1]
    return [" ".join(texts[k : k + width]) for k in range(0, len(texts), width)]


def _flat_faces(mesh: Mesh) -> NDArray[np.bool_]:
    """Faces all of whose normals are the face's own."""
    count = len(mesh.offsets) - 1
    if mesh.normals is None or not count:
        return np.ones(count, np.bool_)
    own = np.repeat(face_normals(mesh), np.diff(mesh.offsets), axis=0)
    length = np.linalg.norm(mesh.normals, axis=1) * np.linalg.norm(own, axis=1)
    cosine = np.einsum("ij,ij->i", own, mesh.normals) / np.maximum(length, 1e-300)
    return np.asarray(np.minimum.reduceat(cosine, mesh.offsets[:-1]) >= FLAT)
