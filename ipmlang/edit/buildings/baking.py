"""Terminals baked into assets: what no scope can say, as vertices in a file beside the grammar.

In go terminals of a tree and the axes to bake them in, out come names of assets and their boxes; at
the end the draft with these assets. A cut or bent solid, or a part that stands askew in what is
stretched, keeps its shape that way. Where it stands is said elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import fail
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.draft import Draft
from ipmlang.inverse.frames import Floats, Frames, linear
from ipmlang.runtime.scene import SCOPE, SOLID

if TYPE_CHECKING:
    from ipmlang.formats.mesh_types import Mesh

DECIMALS = 9  # of a coordinate in a text file
STEM = "baked"


@dataclass(frozen=True, slots=True, eq=False)
class Asset:
    """A baked terminal: the name of its asset and its box in the axes that it was baked in, from
    the terminal's own origin.
    """

    name: str
    low: Floats
    high: Floats


@dataclass(slots=True, eq=False)
class Baking:
    """What was baked of one tree; `named` gives names that nothing bears."""

    tree: Tree
    named: Callable[[str], str]
    meshes: dict[str, Mesh] = field(default_factory=dict)
    _known: dict[object, Asset] = field(default_factory=dict)

    def bake(self, row: int, base: Frames) -> Asset:
        """A terminal in the axes of a frame."""
        one, table = self.tree.terminals, self.tree.scene.instances
        turn = np.linalg.solve(linear(base)[0], linear(one.frames[row : row + 1])[0])
        number, shape = int(table.asset[row]), int(table.shape[row])
        size = (
            np.ones(3)
            if self.tree.is_natural(row)
            else np.where(one.high[row] > 0, one.high[row], 1.0)
        )
        key = (number, shape, one.labels[row], tuple(np.round((turn * size).ravel(), 9).tolist()))
        if key not in self._known:
            mesh = self._mesh(row, number, shape)
            self._known[key] = self._baked(one.labels[row], mesh, turn * size)
        return self._known[key]

    def _mesh(self, row: int, number: int, shape: int) -> Mesh:
        """The terminal in its scope: in the unit box, where it fills one."""
        from ipmlang.geometry.solid import unit_box, unit_square
        from ipmlang.runtime.export.solids import solid_mesh

        if number == SOLID:
            return solid_mesh(self.tree.scene.solids[shape])
        if number == SCOPE:
            flat = self.tree.terminals.high[row][2] <= 0
            return solid_mesh(unit_square() if flat else unit_box())
        if number not in self.tree.meshes:
            raise fail(
                "cannot-edit-there",
                f"`{self.tree.terminals.labels[row]}` is drawn by a turtle and has no box to fit",
                hint="change the parameters of its rule: ipmlang edit set",
            )
        mesh = self.tree.meshes[number]
        if self.tree.is_natural(row):
            return mesh
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        extent = np.where(high > low, high - low, 1.0)
        return replace(mesh, vertices=(mesh.vertices - low) / extent)

    def _baked(self, label: str, mesh: Mesh, matrix: Floats) -> Asset:
        from ipmlang.formats.mesh_types import MeshScene, baked

        own = np.zeros(1, np.int64)
        placed = np.concatenate([matrix, np.zeros((3, 1))], axis=1)[None]
        found = baked(MeshScene((mesh,), own, placed, own, own - 1, (label,)))
        name = self.named(f"{label.lower()}_{STEM}")
        self.meshes[name] = replace(found, groups=tuple((name,) for _ in found.groups))
        points = found.vertices
        return Asset(name, points.min(axis=0), points.max(axis=0))

    def with_assets(self, draft: Draft) -> Draft:
        """The draft with all that was baked, as one file."""
        from ipmlang.edit.files import file_names
        from ipmlang.inverse.split.parts_file import write_parts

        if not self.meshes:
            return draft
        parts = write_parts(self.meshes, DECIMALS)
        taken = {*file_names(draft.grammar), *draft.added}
        file, number = f"{STEM}.parts{parts.suffix}", 2
        while file in taken or f"{draft.path.stem}.{file}" in taken:
            file, number = f"{STEM}_{number}.parts{parts.suffix}", number + 1
        item = ast.Asset(tuple(self.meshes), file, by_name=True)
        items = draft.grammar.items
        heads = (ast.Version, ast.Import, ast.Axes, ast.Asset)
        place = max((k for k, each in enumerate(items) if isinstance(each, heads)), default=-1) + 1
        grammar = replace(draft.grammar, items=(*items[:place], item, *items[place:]))
        return replace(draft, grammar=grammar, added={**draft.added, file: parts.content})
