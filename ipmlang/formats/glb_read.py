"""GLB files to meshes and their copies, turned from y-up to z-up.

Takes a path; gives one mesh a glTF mesh and one copy a node that shows it, with the node's name.
Materials keep name, base colour and its image. What cannot be read (an extension that the file
requires, data in other files) is a `FormatError`, never silently empty.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.coloring import screen, with_vertex_colors
from ipmlang.formats.drawing import Note
from ipmlang.formats.glb_data import Container, Json, Object, open_glb, read_accessor, view_bytes
from ipmlang.formats.glb_shades import Shades
from ipmlang.formats.mesh_types import (
    Z_TO_Y,
    Mesh,
    MeshScene,
    merged,
    triangle_mesh,
    without_bad_faces,
)

Floats = NDArray[np.float64]

_DRACO = "KHR_draco_mesh_compression"
_INSTANCING = "EXT_mesh_gpu_instancing"
_READABLE = ("KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_")
_MODES = {4: "triangles", 5: "strip", 6: "fan"}
_DEEPEST = 1000


def read_glb(path: Path, nodes: Sequence[str | None] = (None,)) -> list[MeshScene]:
    """The scene of a GLB file for each None, and for each name what that node shows: with the
    node's own transform, but none of its parents'. A name may be a node's or a mesh's.
    """
    file = open_glb(path.read_bytes())
    _check_extensions(file)
    shades = Shades(file, path.parent)
    return [_Reader(file, shades).scene(node) for node in nodes]


def glb_names(path: Path) -> list[str]:
    """The names of nodes and meshes, in order, without reading geometry."""
    file = open_glb(path.read_bytes())
    named = [*file.items("nodes"), *file.items("meshes")]
    names = (each.get("name") for each in named)
    return list(dict.fromkeys(name for name in names if isinstance(name, str) and name))


def _check_extensions(file: Container) -> None:
    required = file.tree.get("extensionsRequired", [])
    for name in required if isinstance(required, list) else []:
        if name in (_DRACO, _INSTANCING) or str(name).startswith(_READABLE):
            continue
        message = f"the file requires the extension {name}, which cannot be read"
        raise FormatError(message, hint="save it again without compression or extensions")


@dataclass(slots=True)
class _Reader:
    """The copies found so far, in the order of the file's nodes."""

    file: Container
    shades: Shades
    mesh: list[int] = field(default_factory=list)
    matrix: list[Floats] = field(default_factory=list)
    name: list[str] = field(default_factory=list)
    notes: dict[str, Note] = field(default_factory=dict)

    def scene(self, node: str | None) -> MeshScene:
        """Everything that the roots show."""
        roots = self._roots() if node is None else self._named(node)
        turned = np.eye(4)
        turned[:3, :3] = Z_TO_Y.T
        for root in roots:
            self._walk(root, turned)
        used = sorted(set(self.mesh))
        meshes = [self._mesh(index) for index in used]
        number = {index: place for place, index in enumerate(used)}
        names = list(dict.fromkeys(self.name))
        where = {name: place for place, name in enumerate(names)}
        count = len(self.mesh)
        matrices = np.array(self.matrix).reshape(count, 4, 4)[:, :3]
        return MeshScene(
            tuple(meshes),
            np.array([number[index] for index in self.mesh], np.int64),
            matrices,
            np.array([where[name] for name in self.name], np.int64),
            np.full(count, -1, np.int64),
            tuple(names),
            notes=(*self.shades.notes, *self.notes.values()),
        )

    def _roots(self) -> list[int]:
        scenes = self.file.items("scenes")
        if scenes:
            chosen = self.file.item("scenes", self.file.tree.get("scene", 0))
            return _indices(chosen.get("nodes"))
        children = {i for node in self.file.items("nodes") for i in _indices(node.get("children"))}
        return [i for i in range(len(self.file.items("nodes"))) if i not in children]

    def _named(self, name: str) -> list[int]:
        nodes = self.file.items("nodes")
        found = [i for i, node in enumerate(nodes) if node.get("name") == name][:1]
        if found:
            return found
        meshes = self.file.items("meshes")
        for index, mesh in enumerate(meshes):
            if mesh.get("name") == name:
                turned = np.eye(4)
                turned[:3, :3] = Z_TO_Y.T
                self._add(index, turned, name)
                return []
        raise FormatError(f"nothing in the file is called `{name}`")

    def _walk(self, root: int, above: Floats) -> None:
        """A node and all below it; a node that holds itself is an error."""
        waiting: list[tuple[int, Floats, int]] = [(root, above, 0)]
        seen: set[int] = set()
        while waiting:
            index, outer, depth = waiting.pop()
            node = self.file.item("nodes", index)
            if index in seen or depth > _DEEPEST:
                raise FormatError(f"nodes[{index}] is below itself, or nested too deeply")
            seen.add(index)
            matrix = outer @ _local(node)
            if "mesh" in node:
                self._show(node, matrix)
            children = _indices(node.get("children"))
            waiting += [(child, matrix, depth + 1) for child in reversed(children)]

    def _show(self, node: Object, matrix: Floats) -> None:
        index = node.get("mesh")
        mesh = self.file.item("meshes", index)
        name = str(node.get("name") or mesh.get("name") or "")
        extensions = node.get("extensions")
        spread = extensions.get(_INSTANCING) if isinstance(extensions, dict) else None
        if not isinstance(index, int):
            raise FormatError("a node names no mesh")
        if not isinstance(spread, dict):
            self._add(index, matrix, name)
            return
        for copy in self._copies(spread):
            self._add(index, matrix @ copy, name)

    def _copies(self, spread: Object) -> Iterator[Floats]:
        """The matrices of EXT_mesh_gpu_instancing."""
        attributes = spread.get("attributes")
        if not isinstance(attributes, dict):
            raise FormatError(f"{_INSTANCING} has no attributes")
        columns = {name: read_accessor(self.file, index) for name, index in attributes.items()}
        usual = {"TRANSLATION": [0.0] * 3, "ROTATION": [0.0, 0, 0, 1], "SCALE": [1.0] * 3}
        count = max((len(column) for column in columns.values()), default=0)
        for name, values in usual.items():
            if name in columns and columns[name].shape != (count, len(values)):
                raise FormatError(f"{_INSTANCING} has a wrong number of values for {name}")
        table = {
            name: columns.get(name, np.tile(np.array(values), (count, 1)))
            for name, values in usual.items()
        }
        for row in range(count):
            yield _composed(*(table[name][row] for name in usual))

    def _add(self, mesh: int, matrix: Floats, name: str) -> None:
        self.mesh.append(mesh)
        self.matrix.append(matrix)
        self.name.append(name)

    def _mesh(self, index: int) -> Mesh:
        mesh = self.file.item("meshes", index)
        name = mesh.get("name")
        primitives = mesh.get("primitives")
        parts = [
            part
            for each in (primitives if isinstance(primitives, list) else [])
            if isinstance(each, dict)
            and (part := self._primitive(each, str(name or ""))) is not None
        ]
        return merged(parts)

    def _primitive(self, primitive: Object, name: str) -> Mesh | None:
        mode = primitive.get("mode", 4)
        if mode not in _MODES:
            self._note("not-a-surface", "points and lines of the model were left out")
            return None
        shade = self.shades.shade(primitive.get("material"))
        vertices, uv, normals, order = self._values(primitive, shade.uv_set if shade else 0)
        if len(order) and (order.min() < 0 or order.max() >= len(vertices)):
            raise FormatError(f"a face names a vertex that is not among the {len(vertices)}")
        triangles = _triangles(order, str(_MODES[int(str(mode))]))
        made = triangle_mesh(vertices, triangles, name)
        if shade is not None and uv is not None:
            uv = uv @ shade.uv_matrix[:, :2].T + shade.uv_matrix[:, 2]
        made = Mesh(
            made.vertices,
            made.corners,
            made.offsets,
            made.material if shade is None else made.material * 0,
            made.group,
            () if shade is None else (shade.material,),
            made.groups,
            None if uv is None else _upward(uv)[made.corners],
            None if normals is None else normals[made.corners],
        )
        made = self._painted(made, primitive)
        made, notes = without_bad_faces(made)
        for note in notes:
            self._note(note.code, note.message, note.count)
        return made

    def _painted(self, mesh: Mesh, primitive: Object) -> Mesh:
        """The mesh with the colours of its vertices, where it has no material."""
        attributes = primitive.get("attributes")
        extensions = primitive.get("extensions")
        packed = isinstance(extensions, dict) and _DRACO in extensions
        if mesh.materials or packed or not isinstance(attributes, dict):
            return mesh
        if "COLOR_0" not in attributes:
            return mesh
        colors = read_accessor(self.file, attributes["COLOR_0"])
        if colors.shape[1] not in (3, 4):
            raise FormatError("colours of vertices have three or four numbers each")
        made, notes = with_vertex_colors(mesh, np.hstack([screen(colors[:, :3]), colors[:, 3:]]))
        for note in notes:
            self._note(note.code, note.message, note.count)
        return made

    def _values(
        self, primitive: Object, uv_set: int
    ) -> tuple[Floats, Floats | None, Floats | None, NDArray[np.int64]]:
        """Positions, texture points as they stand, normals, and the order of the corners."""
        extensions = primitive.get("extensions")
        packed = extensions.get(_DRACO) if isinstance(extensions, dict) else None
        attributes = primitive.get("attributes")
        if not isinstance(attributes, dict) or "POSITION" not in attributes:
            raise FormatError("a part of a mesh has no positions")
        if isinstance(packed, dict):
            return _draco(view_bytes(self.file, packed.get("bufferView"))[0])
        texture_points = f"TEXCOORD_{uv_set}"
        columns = {
            name: read_accessor(self.file, attributes[name]) if name in attributes else None
            for name in ("POSITION", texture_points, "NORMAL")
        }
        vertices = columns["POSITION"]
        assert vertices is not None
        if vertices.shape[1] != 3:
            raise FormatError("positions have three numbers each")
        for name, column in columns.items():
            if column is not None and len(column) != len(vertices):
                raise FormatError(f"{name} has another count than the positions")
        uv = columns[texture_points]
        if uv is not None and uv.shape[1] != 2:
            raise FormatError("texture coordinates have two numbers each")
        if "indices" in primitive:
            order = read_accessor(self.file, primitive["indices"])[:, 0].astype(np.int64)
        else:
            order = np.arange(len(vertices))
        return vertices, uv, columns["NORMAL"], order

    def _note(self, code: str, message: str, count: int = 1) -> None:
        old = self.notes.get(code)
        self.notes[code] = Note(code, message, count + (old.count if old else 0))


def _upward(uv: Floats) -> Floats:
    """Texture points whose v points down, as in glTF, with v pointing up."""
    return uv * [1.0, -1.0] + [0.0, 1.0]


def _indices(value: Json) -> list[int]:
    return [i for i in value if isinstance(i, int)] if isinstance(value, list) else []


def _local(node: Object) -> Floats:
    """A node's own transform (4, 4)."""
    matrix = node.get("matrix")
    if matrix is not None:
        return _floats(matrix, 16, np.zeros(16)).reshape(4, 4).T
    return _composed(
        _floats(node.get("translation"), 3, np.zeros(3)),
        _floats(node.get("rotation"), 4, np.array([0.0, 0, 0, 1])),
        _floats(node.get("scale"), 3, np.ones(3)),
    )


def _floats(value: Json, count: int, usual: Floats) -> Floats:
    if value is None:
        return usual
    try:
        found = np.array(value, dtype=np.float64)
    except (ValueError, TypeError):
        found = np.zeros(0)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise FormatError(f"a node's transform does not have {count} numbers")
    return found


def _composed(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """The (4, 4) matrix of a translation, a quaternion (x, y, z, w) and a scale."""
    x, y, z, w = (rotation / (np.linalg.norm(rotation) or 1.0)).tolist()
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * scale
    matrix[:3, 3] = translation
    return matrix


def _triangles(order: NDArray[np.int64], mode: str) -> NDArray[np.int64]:
    if mode == "triangles":
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if len(order) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == "fan":
        return np.stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]], axis=1)
    strip = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _draco(data: bytes) -> tuple[Floats, Floats | None, Floats | None, NDArray[np.int64]]:
    """The values of a part that is packed by Draco."""
    try:
        import DracoPy
    except ImportError as error:
        message = "the file is packed by Draco, which needs the library DracoPy"
        raise FormatError(message, hint="pip install DracoPy") from error
    try:
        found = DracoPy.decode(data)
    except Exception as error:  # the library raises its own kinds, and plain ones
        raise FormatError(f"a part packed by Draco cannot be read: {error}") from error
    vertices = np.asarray(found.points, np.float64).reshape(-1, 3)
    order = np.asarray(found.faces, np.int64).reshape(-1)
    uv = getattr(found, "tex_coord", None)
    normals = getattr(found, "normals", None)
    return vertices, _matching(uv, vertices), _matching(normals, vertices), order


def _matching(column: object, vertices: Floats) -> Floats | None:
    values = None if column is None else np.asarray(column, np.float64)
    return values if values is not None and values.shape[:1] == vertices.shape[:1] else None
