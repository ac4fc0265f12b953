"""The geometry of assets as solids: what `insert` measures, and what `split` and `comp` work on.

In goes the number of an asset, out comes a solid in the coordinates of its file, read when it is
first asked for. Nothing is drawn here.
"""

from __future__ import annotations

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.geometry.solid import UNTAGGED, Solid


class AssetSolids:
    """Reads the assets of a program, each once."""

    def __init__(self, program: ir.Program) -> None:
        self._assets = program.assets
        self._read: dict[int, Solid] = {}

    def __call__(self, asset: int) -> Solid:
        """The faces of an asset. Raises IpmError for a file that is none."""
        if asset not in self._read:
            self._read[asset] = self._solid(self._assets[asset])
        return self._read[asset]

    def _solid(self, asset: ir.AssetFile) -> Solid:
        from ipmlang.formats.mesh import read_mesh

        if asset.path.suffix.lower() in (".svg", ".svgz"):
            raise fail(
                "not-a-model",
                f"the asset `{asset.name}` is a drawing: {asset.path.name}",
                hint="`insert` takes assets from glb, obj, ply and stl files",
            )
        try:
            mesh = read_mesh(asset.path, asset.node)
        except FormatError as error:
            place = f"{asset.path.name}:{error.line}" if error.line else asset.path.name
            raise fail("bad-asset", f"{place}: {error.message}", hint=error.hint) from error
        count = len(mesh.offsets) - 1
        faces = np.arange(count + 1, dtype=np.int64)
        return Solid(mesh.vertices, mesh.corners, mesh.offsets, faces, (UNTAGGED,) * count, mesh.uv)
