"""Scenes of meshes as OBJ, with a material library beside it where there are materials.

Takes a scene; gives the text of the files in parts, so that a large model is never whole in memory.
Copies become real; those of one name and material form a group, and polygons stay polygons. Axes
stay as they are unless y-up is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.atomic import Content
from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.mesh_batches import Batch, batches
from ipmlang.formats.mesh_types import UNCOLORED, Indices, Material, Mesh, MeshScene
from ipmlang.formats.mtl import library_contents

_NORMAL_DIGITS = 4
_NO_MATERIAL = Material("default", UNCOLORED)


def obj_contents(
    scene: MeshScene, path: Path, *, up: Literal["y-up", "z-up"] = "z-up"
) -> Mapping[Path, Content]:
    """The model's text, and if some face has a material its library's and the images of that."""
    materials = _materials(scene)
    if not materials:
        return {path: _model(scene, up, "", {})}
    library = path.with_suffix(".mtl")
    names = {material: name for name, material in materials.items()}
    text, images = library_contents({**materials, _NO_MATERIAL.name: _NO_MATERIAL}, path)
    return {path: _model(scene, up, library.name, names), library: text, **images}


def _materials(scene: MeshScene) -> dict[str, Material]:
    """All materials by the names they get: without blanks, and no name twice."""
    found = [*scene.materials, *(each for mesh in scene.meshes for each in mesh.materials)]
    named: dict[str, Material] = {}
    for material in dict.fromkeys(found):
        stem = _word(material.name) or "material"
        name, number = stem, 2
        while name in named:
            name, number = f"{stem}_{number}", number + 1
        named[name] = material
    return named


def _model(
    scene: MeshScene, up: Literal["y-up", "z-up"], library: str, names: Mapping[Material, str]
) -> Iterator[str]:
    yield "# written by ipmlang\n" + (f"mtllib {library}\n" if library else "")
    counts = np.zeros(3, np.int64)
    digits = _digits(scene)
    group = -1
    for batch in batches(scene, up):
        if batch.name != group:
            group = batch.name
            yield f"g {_word(scene.names[group]) or 'default'}\n"
        yield _rows("v", batch.vertices.reshape(-1, 3), digits)
        if batch.mesh.uv is not None:
            yield _rows("vt", batch.mesh.uv, 9)
        normals, chosen = _normals(batch)
        if len(normals):
            yield _rows("vn", normals, _NORMAL_DIGITS)
        yield from _faces(scene, batch, chosen, counts, names)
        counts += _written(batch, len(normals))


def _normals(batch: Batch) -> tuple[NDArray[np.float64], Indices]:
    """The different normals of a batch, and which each corner (k, c) has, -1 for none."""
    if batch.normals is None:
        return np.zeros((0, 3)), np.full((batch.vertices.shape[0], len(batch.mesh.corners)), -1)
    rounded = np.round(batch.normals.reshape(-1, 3), _NORMAL_DIGITS) + 0.0
    first, kind = distinct_rows(rounded)
    return rounded[first], kind.reshape(batch.normals.shape[:2])


def _written(batch: Batch, normals: int) -> NDArray[np.int64]:
    copies, size = batch.vertices.shape[:2]
    return np.array([copies * size, 0 if batch.mesh.uv is None else len(batch.mesh.uv), normals])


def _faces(
    scene: MeshScene,
    batch: Batch,
    normals: Indices,
    counts: NDArray[np.int64],
    names: Mapping[Material, str],
) -> Iterator[str]:
    """The faces of all copies, material by material."""
    mesh = batch.mesh
    sizes = np.diff(mesh.offsets)
    for material in np.unique(mesh.material).tolist() if batch.material < 0 else [-1]:
        own = batch.material < 0
        faces = np.flatnonzero(mesh.material == material) if own else np.arange(len(sizes))
        chosen: Material | None = None
        if not own:
            chosen = scene.materials[batch.material]
        elif material >= 0:
            chosen = mesh.materials[material]
        if names:
            yield f"usemtl {names[chosen] if chosen else _NO_MATERIAL.name}\n"
        yield _face_rows(mesh, normals, faces, sizes[faces], counts)


def _face_rows(
    mesh: Mesh, normals: Indices, faces: Indices, sizes: Indices, counts: NDArray[np.int64]
) -> str:
    """The lines of faces in all copies; normals (k, c): as in `_normals`."""
    copies = len(normals)
    step = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    corner = np.repeat(mesh.offsets[faces], sizes) + step
    shift = counts[0] + 1 + len(mesh.vertices) * np.arange(copies)
    vertex = (mesh.corners[corner][None] + shift[:, None]).reshape(-1)
    columns, word = [vertex], " %d"
    if mesh.uv is not None:
        columns.append(np.tile(corner + counts[1] + 1, copies))
        word += "/%d"
    if mesh.normals is not None:
        columns.append((normals[:, corner] + counts[2] + 1).reshape(-1))
        word += "/%d" if mesh.uv is not None else "//%d"
    numbers = vertex if len(columns) == 1 else np.stack(columns, axis=1).reshape(-1)
    templates = {size: "f" + word * size + "\n" for size in np.unique(sizes).tolist()}
    if len(templates) == 1:
        template: str = next(iter(templates.values())) * (len(sizes) * copies)
    else:
        template = "".join([templates[size] for size in sizes.tolist()]) * copies
    return template % tuple(numbers.tolist())


def _rows(word: str, values: NDArray[np.float64], digits: int) -> str:
    template: str = word + f" %.{digits}g" * int(values.shape[1]) + "\n"
    rows: str = template * len(values)
    return rows % tuple((values + 0.0).reshape(-1).tolist())


def _digits(scene: MeshScene) -> int:
    """How many significant digits keep 1e-10 of the model's size, however far away it lies."""
    size = farthest = reach = 0.0
    if len(scene.mesh):
        places = scene.matrix[:, :, 3]
        size, farthest = float(np.ptp(places, axis=0).max()), float(np.abs(places).max())
    scales = np.zeros(len(scene.meshes))
    np.maximum.at(scales, scene.mesh, np.abs(scene.matrix[:, :, :3]).max(axis=(1, 2)))
    for mesh, scale in zip(scene.meshes, scales.tolist(), strict=True):
        if len(mesh.vertices) and scale:
            low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            size = max(size, scale * float((high - low).max()))
            reach = max(reach, scale * float(np.maximum(-low, high).max()))
    farthest += reach
    ratio = max(farthest, 1e-300) / max(size, 1e-300)
    return min(17, 10 + max(0, math.ceil(math.log10(ratio))))


def _word(name: str) -> str:
    """A name that is one word, as groups and materials of OBJ have to be."""
    return "_".join(name.split())
