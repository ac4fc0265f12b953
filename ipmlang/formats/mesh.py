"""Models by the suffix of their file: names, meshes and scenes, read with one call each.

Takes a path and perhaps the name of a node; gives types of `mesh_types`. Everything that comes in
is z-up: GLB and DAE are turned, the others keep their axes. Which bytes mean what is known to the
module of each format.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from ipmlang.formats import FormatError
from ipmlang.formats.atomic import Content
from ipmlang.formats.mesh_types import Mesh, MeshScene, baked, chosen_faces

SUFFIXES = (".glb", ".obj", ".ply", ".stl", ".off", ".dae")


def mesh_names(path: Path | str) -> tuple[str, ...]:
    """The names that parts of a model go by: nodes, objects, groups. Cheap: no geometry is read."""
    path = Path(path)
    with _explained(path):
        match _suffix(path):
            case ".glb":
                from ipmlang.formats.glb_read import glb_names

                return tuple(glb_names(path))
            case ".obj":
                from ipmlang.formats.obj_read import obj_names

                return tuple(obj_names(path))
            case ".dae":
                from ipmlang.formats.dae import read_dae

                return read_dae(path).names
            case _:
                return () if path.is_file() else _absent(path)


def read_meshes(path: Path | str, node: str | None = None) -> MeshScene:
    """A model with its copies, or the part of it that goes by a name."""
    return read_parts(path, [node])[0]


def read_parts(path: Path | str, nodes: Sequence[str | None]) -> list[MeshScene]:
    """The parts of a model that go by these names (None: the whole), its file read once."""
    path = Path(path)
    # Broken files hold numbers of all kinds; those without a value are looked for afterwards.
    with _explained(path), np.errstate(all="ignore"):
        scenes = _read(path, nodes)
    for scene in scenes:
        if not any(len(mesh.corners) for mesh in scene.meshes):
            raise FormatError(f"there are no faces in {path.name}", hint=_why_empty(scene))
    return scenes


def read_mesh(path: Path | str, node: str | None = None) -> Mesh:
    """A model, or the part of it that goes by a name, as one mesh in the world."""
    return baked(read_meshes(path, node))


def mesh_contents(
    scene: MeshScene,
    path: Path,
    *,
    up: Literal["y-up", "z-up"] = "z-up",
    instancing: bool = False,
) -> Mapping[Path, Content]:
    """The files of a model by path, ready to write: the model, and for OBJ its materials."""
    match _suffix(path):
        case ".glb":
            from ipmlang.formats.glb_write import glb_bytes

            return {path: glb_bytes(scene, instancing=instancing)}
        case ".obj":
            from ipmlang.formats.obj_write import obj_contents

            return obj_contents(scene, path, up=up)
        case ".ply":
            from ipmlang.formats.mesh_batches import world_triangles
            from ipmlang.formats.ply import write_ply

            return {path: write_ply(*world_triangles(scene, up))}
        case ".stl":
            from ipmlang.formats.mesh_batches import world_triangles
            from ipmlang.formats.stl import write_stl

            return {path: write_stl(*world_triangles(scene, up)[:2])}
        case suffix:
            raise FormatError(f"a model cannot be written as `{suffix}`")


def _read(path: Path, nodes: Sequence[str | None]) -> list[MeshScene]:
    match _suffix(path):
        case ".glb":
            from ipmlang.formats.glb_read import read_glb

            return read_glb(path, nodes)
        case ".obj":
            from ipmlang.formats.obj_read import read_obj

            scene = read_obj(path)
        case ".ply":
            from ipmlang.formats.ply import read_ply

            scene = read_ply(path)
        case ".stl":
            from ipmlang.formats.stl import read_stl

            scene = read_stl(path)
        case ".dae":
            from ipmlang.formats.dae import read_dae

            return [_named(read_dae(path), node) for node in nodes]
        case _:
            from ipmlang.formats.off import read_off

            scene = read_off(path)
    return [scene if node is None else _part(scene, node) for node in nodes]


def _named(scene: MeshScene, node: str | None) -> MeshScene:
    """The copies that go by a name, where they stand."""
    if node is None:
        return scene
    rows = np.flatnonzero(scene.name == (scene.names.index(node) if node in scene.names else -1))
    if not len(rows):
        raise FormatError(f"nothing in the file is called `{node}`")
    return replace(
        scene,
        mesh=scene.mesh[rows],
        matrix=scene.matrix[rows],
        name=scene.name[rows],
        material=scene.material[rows],
    )


def _part(scene: MeshScene, node: str) -> MeshScene:
    """The faces that go by a name; files of these formats hold one mesh."""
    mesh = scene.meshes[0]
    wanted = np.array([node in names for names in mesh.groups])
    if not wanted.any():
        raise FormatError(f"nothing in the file is called `{node}`")
    return replace(scene, meshes=(chosen_faces(mesh, wanted[mesh.group]),), names=(node,))


def _suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        known = f"{', '.join(SUFFIXES[:-1])} and {SUFFIXES[-1]}"
        raise FormatError(f"`{path.name}` is no model that can be read", hint=f"there are {known}")
    return suffix


def _absent(path: Path) -> tuple[str, ...]:
    raise FileNotFoundError(2, "no such file", str(path))


def _why_empty(scene: MeshScene) -> str | None:
    said = "; ".join(f"{note.message} ({note.count})" for note in scene.notes)
    return said or "it may be cut off, or hold points and lines alone"


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise FormatError(f"cannot read {path}: {reason}") from error
    except MemoryError as error:
        raise FormatError(f"there is not enough memory to read {path.name}") from error
