"""The file that a grammar keeps its terminals in: one named mesh for each, as small as it may be.

Takes the classes of parts that are terminals; gives the bytes and the suffix of the file. Polygons
stay polygons in an OBJ; triangles, and what bears images, are a GLB. Nothing is written to disk.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ipmlang.formats.mesh_types import Z_TO_Y, Mesh, MeshScene, moved

_UP = np.concatenate([Z_TO_Y, np.zeros((3, 1))], axis=1)


@dataclass(frozen=True, slots=True)
class PartsFile:
    """suffix: `.obj` or `.glb`."""

    suffix: str
    content: bytes

    def name(self, stem: str) -> str:
        """What it is called beside `<stem>.ipm`."""
        return parts_name(stem, self.suffix)


def parts_name(stem: str, suffix: str) -> str:
    """`castle.parts.obj`."""
    return f"{stem}.parts{suffix}"


def write_parts(terminals: Mapping[str, Mesh], decimals: int) -> PartsFile:
    """The file for terminals by name; decimals: behind the point of a coordinate, where the file
    is text.
    """
    meshes = list(terminals.values())
    if _polygons(meshes) and not _pictures(meshes):
        from ipmlang.formats.obj_parts import obj_parts

        return PartsFile(".obj", obj_parts(terminals, decimals).encode("utf-8"))
    from ipmlang.formats.glb_write import glb_bytes

    return PartsFile(".glb", glb_bytes(_scene(terminals), up="y-up"))


def _polygons(meshes: list[Mesh]) -> bool:
    return any(bool((np.diff(mesh.offsets) > 3).any()) for mesh in meshes)


def _pictures(meshes: list[Mesh]) -> bool:
    return any(each.texture is not None for mesh in meshes for each in mesh.materials)


def _scene(terminals: Mapping[str, Mesh]) -> MeshScene:
    """Each terminal once, at the origin, y up as a node of such a file is."""
    count = len(terminals)
    names = tuple(terminals)
    number = np.arange(count)
    meshes = tuple(
        replace(moved(mesh, _UP), groups=tuple((name,) for _ in mesh.groups))
        for name, mesh in terminals.items()
    )
    still = np.tile(np.eye(3, 4), (count, 1, 1))
    return MeshScene(meshes, number, still, number, np.full(count, -1), names)
