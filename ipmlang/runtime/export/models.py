"""A scene as meshes and copies: segments and paths as cylinders, scopes as boxes, assets, solids.

In goes the instance table, out comes a `MeshScene` of `formats.mesh_types`; every row becomes at
most one copy, and no mesh is made twice. Nothing is derived and nothing is written here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import fail
from ipmlang.formats import FormatError
from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Alpha, Material, Mesh, MeshScene
from ipmlang.formats.textures import Texture, has_alpha, texture_at
from ipmlang.runtime.export.colors import hex_color
from ipmlang.runtime.export.fitting import fitted_matrices
from ipmlang.runtime.export.model_assets import model_assets
from ipmlang.runtime.export.placing import frame_matrices
from ipmlang.runtime.export.solids import solid_mesh
from ipmlang.runtime.export.uv import Copies, laid
from ipmlang.runtime.scene import OUTLINE, PATH, SCOPE, SEGMENT, SOLID, Scene

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

CYLINDER_SIDES = 8
THIN = 1 / 200  # width of a segment whose pen sets none, as a share of the scene's extent


def mesh_scene_of(scene: Scene) -> MeshScene:
    """The meshes and copies of a scene; an `IpmError` if an asset is wrong."""
    return _Model(scene).mesh_scene()


@dataclass(slots=True)
class _Model:
    """The copies while they are gathered, part by part; `row` says which row each comes from."""

    scene: Scene
    meshes: list[Mesh] = field(default_factory=list)
    mesh: list[NDArray[np.int64]] = field(default_factory=list)
    matrix: list[Floats] = field(default_factory=list)
    row: list[Rows] = field(default_factory=list)
    notes: tuple[Note, ...] = ()

    def mesh_scene(self) -> MeshScene:
        table = self.scene.instances
        draw: dict[int, Callable[[Rows], None]] = {
            SEGMENT: self._segments,
            OUTLINE: self._polygons,
            PATH: self._paths,
            SCOPE: self._scopes,
            SOLID: self._solids,
        }
        kinds = np.unique(table.asset).tolist()
        for kind in kinds:
            if kind in draw:
                draw[kind](np.flatnonzero(table.asset == kind))
        self._assets([kind for kind in kinds if kind >= 0])
        if not self.row:
            raise fail("nothing-drawn", "this grammar draws nothing, so there is no model to write")
        row = np.concatenate(self.row)
        order = np.argsort(row, kind="stable")
        row = row[order]
        material, materials = self._materials(row)
        meshes, mesh = self.meshes, np.concatenate(self.mesh)[order]
        matrix = np.concatenate(self.matrix)[order]
        textured = np.array([*(each.texture is not None for each in materials), False])[material]
        if textured.any():
            maps = self.scene.texture_maps
            way = np.full(len(row), -1) if maps is None else maps.of[row].astype(np.int64)
            meshes, mesh = laid(meshes, Copies(mesh, matrix, way, textured), maps)
        return MeshScene(
            tuple(meshes),
            mesh,
            matrix,
            table.label[row].astype(np.int64),
            material,
            self.scene.labels,
            materials,
            table.rule[row].astype(np.int64),
            table.key[row],
            tuple(origin.rule for origin in self.scene.rules),
            {"seed": self.scene.seed},
            self.notes,
        )

    def _add(self, mesh: Mesh, rows: Rows, matrices: Floats) -> None:
        if len(rows):
            self.mesh.append(np.full(len(rows), len(self.meshes), np.int64))
            self.meshes.append(mesh)
            self.matrix.append(matrices)
            self.row.append(rows)

    def _segments(self, rows: Rows) -> None:
        """Cylinders along the frames' x; the pen's width is not scaled by the frame."""
        table = self.scene.instances
        rows = rows[table.size[rows, 0] != 0]
        matrices = frame_matrices(table, rows)
        length = table.size[rows, 0] * np.abs(table.scale[rows])
        axes = matrices[:, :, :3] / np.abs(table.scale[rows])[:, None, None]
        width = np.where(np.isnan(table.width[rows]), self._default_width(), table.width[rows])
        scale = np.stack([length, width, width], axis=1)
        matrices = np.concatenate([axes * scale[:, None, :], matrices[:, :, 3:]], axis=2)
        self._add(unit_cylinder(CYLINDER_SIDES), rows, matrices)

    def _paths(self, rows: Rows) -> None:
        """A cylinder for each line of turtle paths, which are in the world already."""
        table = self.scene.instances
        pairs = [_lines(self.scene.polygons[shape]) for shape in table.shape[rows].tolist()]
        owner = np.repeat(rows, [len(each) for each in pairs])
        lines = np.concatenate(pairs)
        length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
        lines, owner, length = lines[length > 0], owner[length > 0], length[length > 0]
        width = np.where(np.isnan(table.width[owner]), self._default_width(), table.width[owner])
        axes = _along((lines[:, 1] - lines[:, 0]) / length[:, None])
        axes *= np.stack([length, width, width], axis=1)[:, None, :]
        matrices = np.concatenate([axes, lines[:, 0, :, None]], axis=2)
        self._add(unit_cylinder(CYLINDER_SIDES), owner, matrices)

    def _default_width(self) -> float:
        table = self.scene.instances
        ends = table.position
        heading = frame_matrices(table, np.arange(len(table)))[:, :, 0] * table.size[:, :1]
        paths = [_lines(self.scene.polygons[k]) for k in table.shape[table.asset == PATH].tolist()]
        points = [ends, ends + heading, *(each.reshape(-1, 3) for each in paths)]
        extent = float(np.ptp(np.concatenate(points), axis=0).max())
        return extent * THIN or 1.0

    def _scopes(self, rows: Rows) -> None:
        """The box of each scope; a scope without extent draws nothing."""
        table = self.scene.instances
        rows = rows[(table.size[rows] != 0).sum(axis=1) >= 2]
        size = table.size[rows]
        matrices = frame_matrices(table, rows)
        # A rectangle has no extent along its third axis, whose length must not vanish all the same.
        matrices[:, :, :3] *= np.where(size == 0, 1.0, size)[:, None, :]
        solid = (size != 0).all(axis=1)
        self._add(unit_cube(), rows[solid], matrices[solid])
        for axis in range(3):
            flat = size[:, axis] == 0
            self._add(unit_square(axis), rows[flat], matrices[flat])

    def _polygons(self, rows: Rows) -> None:
        """Each turtle polygon is a mesh of its own, where it stands."""
        for row in rows.tolist():
            corners = self.scene.polygons[self.scene.instances.shape[row]]
            points = np.zeros((len(corners), 3))
            points[:, : corners.shape[1]] = corners
            count = len(points)
            face = Mesh(
                points,
                np.arange(count),
                np.array([0, count]),
                np.array([-1]),
                np.array([0]),
                groups=((),),
            )
            self._add(face, np.array([row]), np.eye(3, 4)[None])

    def _solids(self, rows: Rows) -> None:
        """Each solid once, stretched along the axes of the scopes that hold it."""
        table = self.scene.instances
        size = table.size[rows]
        matrices = frame_matrices(table, rows)
        matrices[:, :, :3] *= np.where(size == 0, 1.0, size)[:, None, :]
        used, number = np.unique(table.shape[rows], return_inverse=True)
        self.mesh.append(number.reshape(-1) + len(self.meshes))
        self.meshes += [solid_mesh(self.scene.solids[each]) for each in used.tolist()]
        self.matrix.append(matrices)
        self.row.append(rows)

    def _assets(self, kinds: list[int]) -> None:
        """Assets where their rows stand, fitted into the scopes that have a size."""
        table = self.scene.instances
        meshes, self.notes = model_assets(self.scene.assets[kind] for kind in kinds)
        for kind in kinds:
            mesh = meshes[self.scene.assets[kind]]
            used = mesh.vertices[mesh.corners]
            rows = np.flatnonzero(table.asset == kind)
            placed = fitted_matrices(table, rows, used.min(axis=0), used.max(axis=0))
            self._add(mesh, rows, placed)

    def _materials(self, row: Rows) -> tuple[NDArray[np.int64], tuple[Material, ...]]:
        """What the pen sets for each copy: a name, a colour, an image, or none of these (-1)."""
        table = self.scene.instances
        key = np.stack([table.style[row], table.color[row]], axis=1).astype(np.float64)
        named = any(style.material or style.texture for style in self.scene.styles)
        if not key[:, 1].any() and not named:
            return np.full(len(row), -1, np.int64), ()
        first, kind = distinct_rows(key)
        pens = key[first].astype(np.int64)
        textures = _textures(self.scene, np.unique(pens[:, 0]).tolist())
        found: dict[Material, int] = {}
        number = []
        for style, color in pens.tolist():
            material = _material(self.scene.styles[style].material, color, textures.get(style))
            number.append(-1 if material is None else found.setdefault(material, len(found)))
        return np.array(number, np.int64)[kind], tuple(found)


def _lines(points: Floats) -> Floats:
    """Both ends (k, 2, 3) of the lines of a path through points (m, 2 or 3), NaN between parts."""
    placed = np.zeros((len(points), 3))
    placed[:, : points.shape[1]] = points
    pairs = np.stack([placed[:-1], placed[1:]], axis=1)
    return pairs[~np.isnan(pairs).any(axis=(1, 2))]


def _along(heading: Floats) -> Floats:
    """Rotations (k, 3, 3) that take x to unit headings (k, 3), columns the axes."""
    steep = np.abs(heading[:, 2]) > 0.9
    aside = np.where(steep[:, None], (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    left = np.cross(aside, heading)
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    return np.stack([heading, left, np.cross(heading, left)], axis=2)


def _textures(scene: Scene, styles: list[int]) -> dict[int, Texture]:
    """The images of the styles that have one, each looked at once."""
    paths = {style: scene.styles[style].texture for style in styles}
    try:
        images = {path: texture_at(path) for path in paths.values() if path is not None}
    except FormatError as error:
        raise fail("bad-texture", error.message, hint=error.hint) from error
    return {style: images[path] for style, path in paths.items() if path is not None}


def _material(name: str, color: int, texture: Texture | None) -> Material | None:
    if not (color or name or texture):
        return None
    alpha: Alpha = "MASK" if texture is not None and has_alpha(texture) else ""
    if not color:
        return Material(name or (texture.name if texture else ""), None, texture, alpha)
    red, green, blue, opacity = ((color >> shift & 255) / 255 for shift in (24, 16, 8, 0))
    title = name or (texture.name if texture else hex_color(color)[0])
    return Material(title, (red, green, blue, opacity), texture, alpha)


def unit_cylinder(sides: int) -> Mesh:
    """From the origin along x to 1, of diameter 1, closed, with polygons for its ends."""
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = np.stack([np.zeros(sides), np.cos(angle) / 2, np.sin(angle) / 2], axis=1)
    vertices = np.concatenate([ring, ring + np.array([1.0, 0.0, 0.0])])
    near = np.arange(sides)
    after = (near + 1) % sides
    quads = np.stack([near, after, after + sides, near + sides], axis=1).reshape(-1)
    corners = np.concatenate([quads, near[::-1], near + sides])
    offsets = np.concatenate([4 * np.arange(sides + 1), 4 * sides + sides * np.array([1, 2])])
    count = sides + 2
    none, group = np.full(count, -1, np.int64), np.zeros(count, np.int64)
    return Mesh(vertices, corners.astype(np.int64), offsets, none, group, groups=(("segment",),))


def unit_cube() -> Mesh:
    """From the origin to (1, 1, 1), six quads."""
    vertices = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], np.float64)
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    none, group = np.full(6, -1, np.int64), np.zeros(6, np.int64)
    corners = np.array(quads, np.int64).reshape(-1)
    return Mesh(vertices, corners, np.arange(7) * 4, none, group, groups=(("box",),))


def unit_square(axis: int) -> Mesh:
    """From the origin to 1 along the two axes other than `axis`, facing right (+x), to the front
    (-y) or up (+z).
    """
    flat = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    none, offsets = np.zeros(1, np.int64), np.array([0, 4])
    vertices = np.insert(flat, axis, 0.0, axis=1)
    return Mesh(vertices, np.arange(4), offsets, none - 1, none, groups=(("rectangle",),))
