"""Prove, then print, for models: what was inferred is derived and compared with the file.

Takes the text of a grammar and its parts file; gives the difference. Works in a folder of its own
that is gone afterwards, so that nothing is written before it is known to be right.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from ipmlang.compiler import compile_file
from ipmlang.formats.mesh_batches import batches
from ipmlang.formats.mesh_types import Mesh, MeshScene, merged
from ipmlang.inverse.split.comparison import Difference, compare_models
from ipmlang.inverse.split.parts_file import PartsFile
from ipmlang.runtime import derive
from ipmlang.runtime.export.models import mesh_scene_of


def derived(text: str, parts: PartsFile, stem: str) -> Mesh:
    """What a grammar and its parts file draw, in the world, z up."""
    with tempfile.TemporaryDirectory(prefix="ipmlang-") as folder:
        path = Path(folder) / f"{stem}.ipm"
        path.write_text(text, encoding="utf-8")
        (Path(folder) / parts.name(stem)).write_bytes(parts.content)
        _, program, _ = compile_file(path)
        return world_mesh(mesh_scene_of(derive(program)))


def world_mesh(scene: MeshScene) -> Mesh:
    """All copies of a scene as one mesh, many at a time."""
    found: list[Mesh] = []
    for batch in batches(scene):
        copies, size = batch.vertices.shape[:2]
        mesh = batch.mesh if batch.material < 0 else _painted(batch.mesh, scene, batch.material)
        found.append(_copied(mesh, batch.vertices.reshape(-1, 3), copies, size))
    return merged(found)


def _painted(mesh: Mesh, scene: MeshScene, material: int) -> Mesh:
    own = np.zeros(len(mesh.material), np.int64)
    return replace(mesh, material=own, materials=(scene.materials[material],))


def _copied(
    mesh: Mesh, vertices: np.ndarray[tuple[int, ...], np.dtype[np.float64]], copies: int, size: int
) -> Mesh:
    """The faces of a mesh over the vertices of its copies."""
    shift = np.arange(copies)[:, None]
    corners = (mesh.corners[None] + size * shift).reshape(-1)
    ends = (mesh.offsets[None, 1:] + len(mesh.corners) * shift).reshape(-1)
    return Mesh(
        vertices,
        corners,
        np.concatenate([[0], ends]).astype(np.int64),
        np.tile(mesh.material, copies),
        np.tile(mesh.group, copies),
        mesh.materials,
        mesh.groups,
    )


def prove(source: Mesh, text: str, parts: PartsFile, stem: str, limit: float) -> Difference:
    """How what is derived differs from the model that was read; limit: units that may be off."""
    return compare_models(source, derived(text, parts, stem), limit)
