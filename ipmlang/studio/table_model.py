"""A table of terminals on the graphics card as a model: which meshes it is made of, how far it
reaches, and who makes its copies.

Takes a `Table`; gives a `Model` of what the CPU drew, if it drew anything, and the copies of what
lies on the card. The meshes of boxes, segments and assets are those of any other model. Nothing is
derived here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, face_normals
from ipmlang.runtime.assemble import color
from ipmlang.runtime.export.model_assets import model_assets
from ipmlang.runtime.export.models import (
    CYLINDER_SIDES,
    THIN,
    mesh_scene_of,
    unit_cube,
    unit_cylinder,
    unit_square,
)
from ipmlang.runtime.gpu.table import Table
from ipmlang.runtime.scene import AssetRef
from ipmlang.studio import ways
from ipmlang.studio.card_copies import WAYS, CardCopies, Survey, first_place, survey
from ipmlang.studio.kinds import Kinds
from ipmlang.studio.library import Library, library_of
from ipmlang.studio.surfaces import Model, lone_surfaces, middle_and_size, model_of

Floats = NDArray[np.float64]
_KIND = 12  # numbers of a kind, see terminals.glsl
_CYLINDER, _ASSETS = 4, 5
_ROUNDS = 3  # of measuring, after the first
_SLIM = 0.765  # side of a box that is as wide on average as a prism of eight sides of diameter 1


@dataclass(frozen=True, slots=True, eq=False)
class _Crowd:
    """What can be seen of a table: its kinds, the images on them, a body (k, 3) around all of it,
    and whether one can look through anything.
    """

    kinds: Kinds
    images: tuple[Material, ...]
    outline: Floats
    clear: bool


def model_of_table(table: Table, *, lines: bool) -> tuple[Model, CardCopies | None]:
    """The model of what the CPU drew and the copies of what lies on the card, if either can be
    seen; an `IpmError` if neither can.
    """
    crowd, rest = _crowd(table, lines=lines), _rest(table)
    if crowd is None and rest is None:
        raise fail("nothing-drawn", "there is nothing to see: this grammar draws nothing")
    if crowd is None:
        assert rest is not None
        return model_of(rest, lines=lines), None
    if rest is None:
        middle, size = middle_and_size(crowd.outline)
        model = Model((), (), (crowd.outline - middle) / size, 0, False, middle, size)
    else:
        model = model_of(rest, lines=lines, beside=crowd.outline)
    copies = CardCopies(table, crowd.kinds, crowd.images, model.middle, model.size)
    return replace(model, clear=model.clear or crowd.clear), copies


def _rest(table: Table) -> MeshScene | None:
    """What the CPU drew, if it is anything."""
    try:
        return None if table.rest is None else mesh_scene_of(table.rest)
    except IpmError as error:
        if error.diagnostics[0].code != "nothing-drawn":
            raise
        return None


def _crowd(table: Table, *, lines: bool) -> _Crowd | None:
    """What can be seen of a table, if it is anything."""
    if not len(table):
        return None
    begin = first_place(table)
    scene = _meshes(table, begin)
    library = library_of(scene, lines=lines)
    kinds = Kinds(_numbers(scene, library), np.diff(library.faces))
    found = survey(table, kinds, begin, ways.even(WAYS))
    if not found.counts.any():
        return None
    outline = _outline(table, kinds, begin, found)
    known = _filled(table, kinds, library, found, float(np.ptp(outline, axis=0).max()))
    return _Crowd(known, library.images, outline + begin, _is_clear(known, found, library))


def _outline(table: Table, kinds: Kinds, begin: Floats, found: Survey) -> Floats:
    """The corners (k, 3) of a body around the table, not much larger than it."""
    asked, reach, points = ways.even(WAYS), found.reach, found.points.reshape(-1, 3)
    more = ways.facing(points, WAYS)
    for _ in range(_ROUNDS):
        again = survey(table, kinds, begin, more)
        asked, reach = np.concatenate([asked, more]), np.concatenate([reach, again.reach])
        points = np.concatenate([points, again.points.reshape(-1, 3)])
        outline = ways.within(asked, reach)
        more = ways.toward(outline, points, WAYS)
        if not len(more):
            break
    return outline


def _meshes(table: Table, begin: Floats) -> MeshScene:
    """The mesh of each kind, each once; assets that no terminal is are not read: cubes stand in."""
    plain = [unit_cube(), *map(unit_square, range(3)), unit_cylinder(CYLINDER_SIDES)]
    assets = table.program.assets
    refs = [AssetRef(each.name, each.path, each.node, each.stretch) for each in assets]
    if not refs:
        return _lone(plain)
    alike = _lone([*plain, *[unit_cube()] * len(refs)])
    kinds = Kinds(_numbers(alike, library_of(alike, lines=False)), np.ones(0, np.int64))
    counts = survey(table, kinds, begin, ways.even(WAYS)).counts[_ASSETS:]
    meshes, _ = model_assets(ref for ref, count in zip(refs, counts, strict=True) if count)
    return _lone([*plain, *(meshes.get(ref, plain[0]) for ref in refs)])


def _filled(table: Table, kinds: Kinds, library: Library, found: Survey, extent: float) -> Kinds:
    """The kinds with the surfaces of those that are there, and with the colours."""
    # Boxes stand for small meshes: there may be some where the table has none.
    needed = found.counts > 0
    needed[0] |= needed[_CYLINDER:].any()
    used = tuple(np.flatnonzero(needed).tolist())
    colors = np.zeros(max(len(table.program.strings), 1), np.uint32)
    for text in found.colors.tolist():
        red, green, blue, opacity = color(table.program.strings[text]).to_bytes(4, "big")
        colors[text] = red | green << 8 | blue << 16 | opacity << 24
    surfaces = lone_surfaces(library, used)
    return Kinds(kinds.numbers, kinds.triangles, used, surfaces, colors, extent * THIN or 1.0)


def _lone(meshes: list[Mesh]) -> MeshScene:
    """Meshes side by side, each once and where it is."""
    each = np.arange(len(meshes))
    matrix = np.broadcast_to(np.eye(3, 4), (len(meshes), 3, 4))
    names = np.zeros(len(meshes), np.int64)
    return MeshScene(tuple(meshes), each, matrix, names, names - 1, ("",))


def _numbers(scene: MeshScene, library: Library) -> NDArray[np.float32]:
    """Each mesh's low and high corner, the share of their box that stands for it, the mean colour
    of its corners, and the largest of its extents.
    """
    numbers = np.zeros((len(scene.meshes), _KIND), np.float32)
    for kind, mesh in enumerate(scene.meshes):
        points = mesh.vertices[mesh.corners]
        low, high = points.min(axis=0), points.max(axis=0)
        corners = slice(library.corners[kind], library.corners[kind + 1])
        mean = library.color[corners].astype(np.float64).mean(axis=0).round().astype(np.uint8)
        numbers[kind, 0:3], numbers[kind, 3:6] = low, high
        numbers[kind, 6:9] = (1.0, _SLIM, _SLIM) if kind == _CYLINDER else _share(mesh, high - low)
        numbers.view(np.uint32)[kind, 9] = mean.view(np.uint32)[0]
        numbers[kind, 10] = float((high - low).max()) or 1.0
    return numbers


def _share(mesh: Mesh, extent: Floats) -> float:
    """How much smaller than its own box a box is that looks as large from all sides on average: a
    body's mean shadow is a quarter of its surface (Cauchy), of one with hollows at most.
    """
    area = np.linalg.norm(face_normals(mesh), axis=1).sum() / 2
    around = 2 * (extent * np.roll(extent, 1)).sum()
    return float(np.clip(np.sqrt(area / around), 0.3, 1.0)) if around else 1.0


def _is_clear(kinds: Kinds, found: Survey, library: Library) -> bool:
    """Whether one can look through anything."""
    opacity = kinds.colors[found.colors] >> 24
    if ((opacity > 0) & (opacity < 255)).any():
        return True
    images = {
        library.images[image].alpha
        for surface in kinds.surfaces
        for *_, image in surface.parts
        if image >= 0
    }
    return bool(images - {""}) or any((each.color[:, 3] < 255).any() for each in kinds.surfaces)
