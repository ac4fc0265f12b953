"""The geometry of assets as solids: what `insert` measures, and what `split` and `comp` work on.

In goes the number of an asset, out comes a solid in the coordinates of its file, read when it is
first asked for. Nothing is drawn here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.formats import FormatError
from ipmlang.geometry.solid import UNTAGGED, Solid

if TYPE_CHECKING:
    from ipmlang.formats.mesh_types import Mesh


class AssetSolids:
    """Reads the assets of a program, each once, a file that several are parts of once for all."""

    def __init__(self, program: ir.Program) -> None:
        self._assets = program.assets
        self._read: dict[int, Mesh] = {}
        self._made: dict[int, Solid] = {}

    def __call__(self, asset: int) -> Solid:
        """The faces of an asset. Raises IpmError for a file that is none."""
        if asset not in self._made:
            if asset not in self._read:
                self._read |= self._file(asset)
            self._made[asset] = _solid(self._read[asset], self._assets[asset].stretch)
        return self._made[asset]

    def _file(self, number: int) -> dict[int, Mesh]:
        """An asset with all others of its file; alone, where one of those cannot be read."""
        wanted = self._assets[number]
        beside = [k for k, asset in enumerate(self._assets) if asset.path == wanted.path]
        try:
            return dict(zip(beside, self._meshes(beside), strict=True))
        except IpmError:
            return {number: self._meshes([number])[0]}

    def _meshes(self, numbers: Sequence[int]) -> list[Mesh]:
        """The assets of these numbers, parts of one file, as large as they are there."""
        from ipmlang.formats.known_parts import part_meshes

        path = self._assets[numbers[0]].path
        if path.suffix.lower() in (".svg", ".svgz"):
            raise fail(
                "not-a-model",
                f"the asset `{self._assets[numbers[0]].name}` is a drawing: {path.name}",
                hint="`insert` takes assets from glb, obj, ply and stl files",
            )
        try:
            parts = part_meshes(path, [self._assets[number].node for number in numbers])
        except FormatError as error:
            place = f"{path.name}:{error.line}" if error.line else path.name
            raise fail("bad-asset", f"{place}: {error.message}", hint=error.hint) from error
        return [mesh for mesh, _ in parts]


def _solid(mesh: Mesh, stretch: Sequence[float]) -> Solid:
    """The faces of a mesh that is so many times as large; solids have no normals to turn."""
    from ipmlang.formats.mesh_types import stretched

    mesh = stretched(replace(mesh, normals=None), stretch)
    count = len(mesh.offsets) - 1
    faces = np.arange(count + 1, dtype=np.int64)
    return Solid(mesh.vertices, mesh.corners, mesh.offsets, faces, (UNTAGGED,) * count, mesh.uv)
