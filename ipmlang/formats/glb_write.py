"""Scenes of meshes as GLB: each mesh once, each copy a node; or copies by EXT_mesh_gpu_instancing.

Takes a scene; gives the bytes of a file, the same for the same scene. The whole is turned to y-up
by one root node, so that the copies' own transforms are kept as they are. What rules made the
copies stands in the scene's extras, in columns beside the geometry.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.distinct import distinct_rows
from ipmlang.formats.glb_shades import Entry, shade_entries
from ipmlang.formats.mesh_types import Material, Mesh, MeshScene, all_triangulated
from ipmlang.formats.node_transforms import Transforms, decomposed

_INSTANCING = "EXT_mesh_gpu_instancing"
_TURN = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]  # z-up to y-up, by columns
_ROOT: Entry = {"name": "z-up", "matrix": _TURN}
_FLOAT, _UINT, _USHORT = 5126, 5125, 5123
_VERTICES, _INDICES = 34962, 34963
_SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_BATCH = 100_000


def glb_bytes(
    scene: MeshScene, *, instancing: bool = False, up: Literal["y-up", "z-up"] = "z-up"
) -> bytes:
    """The GLB file of a scene; `instancing` writes equal copies as one node with an extension that
    fewer programs read, and says so in the file. up: of the scene.
    """
    if not np.isfinite(scene.matrix).all():
        raise FormatError("a copy stands at a place without a value (not a number, or infinite)")
    file = _File()
    variants = _variants(scene)
    file.add_meshes(scene.meshes, sorted({mesh for mesh, _ in variants.pairs}))
    meshes = [file.mesh(scene, mesh, material) for mesh, material in variants.pairs]
    transforms = decomposed(scene.matrix)
    if instancing:
        nodes = _instanced_nodes(file, scene, variants, transforms)
    else:
        nodes = _nodes(scene, variants.row, transforms)
    root: Entry = _ROOT if up == "z-up" else {"name": "y-up"}
    return file.packed(meshes, [_root(root, len(nodes)), *nodes], _extras(file, scene), instancing)


def _root(root: Entry, children: int) -> str:
    """The node that all others stand under."""
    under = {"children": list(range(1, children + 1))} if children else {}
    return json.dumps({**root, **under}, separators=(",", ":"))


@dataclass(slots=True)
class _Variants:
    """Pairs of mesh and material (-1: its own) in order of first use, and each row's pair."""

    pairs: list[tuple[int, int]]
    row: NDArray[np.int64]


def _variants(scene: MeshScene) -> _Variants:
    first, row = distinct_rows(np.stack([scene.mesh, scene.material], axis=1).astype(np.float64))
    pairs = zip(scene.mesh[first].tolist(), scene.material[first].tolist(), strict=True)
    return _Variants(list(pairs), row)


@dataclass(slots=True)
class _File:
    """The parts of a file as they grow: data, views and accessors into it, materials."""

    data: list[bytes] = field(default_factory=list)
    size: int = 0
    views: list[Entry] = field(default_factory=list)
    accessors: list[Entry] = field(default_factory=list)
    materials: dict[Material, int] = field(default_factory=dict)
    parts: dict[int, list[tuple[int, Entry]]] = field(default_factory=dict)

    def view(self, raw: bytes) -> int:
        """Add bytes and give the number of the view on them."""
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(raw)})
        self.data.append(raw + b"\0" * (-len(raw) % 4))
        self.size += len(self.data[-1])
        return len(self.views) - 1

    def accessor(
        self, values: NDArray[np.generic], component: int, target: int = 0, bounds: bool = False
    ) -> int:
        """Add a column (n,) or table (n, width) and give its number."""
        view = self.view(np.ascontiguousarray(values).tobytes())
        if target:
            self.views[view]["target"] = target
        width = values.shape[1] if values.ndim == 2 else 1
        entry: Entry = {
            "bufferView": view,
            "componentType": component,
            "count": len(values),
            "type": _SHAPES[width],
        }
        if bounds:
            table = values.reshape(-1, width)
            entry["min"], entry["max"] = table.min(axis=0).tolist(), table.max(axis=0).tolist()
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def add_meshes(self, meshes: Sequence[Mesh], used: Sequence[int]) -> None:
        """Add the geometry of the meshes that are used, by number."""
        cuts = all_triangulated([meshes[index] for index in used])
        for index, (corners, face) in zip(used, cuts, strict=True):
            self.parts[index] = self._primitives(meshes[index], corners, face)

    def mesh(self, scene: MeshScene, index: int, material: int) -> Entry:
        """A mesh with its own materials, or all of it in one; the geometry is shared."""
        mesh = scene.meshes[index]
        primitives = []
        for own, part in self.parts[index]:
            chosen = scene.materials[material] if material >= 0 else None
            if chosen is None and own >= 0:
                chosen = mesh.materials[own]
            primitives.append(part if chosen is None else {**part, "material": self._shade(chosen)})
        names = [each for group in mesh.groups for each in group]
        return {"primitives": primitives, **({"name": names[0]} if names else {})}

    def _shade(self, material: Material) -> int:
        return self.materials.setdefault(material, len(self.materials))

    def _primitives(
        self, mesh: Mesh, corners: NDArray[np.int64], face: NDArray[np.int64]
    ) -> list[tuple[int, Entry]]:
        """One part for each material of a mesh, with the number of the material."""
        if not mesh.materials:
            return [(-1, self._primitive(mesh, corners.reshape(-1)))] if len(corners) else []
        material = mesh.material[face]
        return [
            (own, self._primitive(mesh, corners[material == own].reshape(-1)))
            for own in np.unique(material).tolist()
        ]

    def _primitive(self, mesh: Mesh, corners: NDArray[np.int64]) -> Entry:
        """Corners with equal position, texture point and normal become one vertex."""
        if mesh.uv is None and mesh.normals is None:
            vertices, order = _used(mesh.vertices, mesh.corners[corners])
            attributes: Entry = {"POSITION": self._floats(vertices, bounds=True)}
        else:
            columns = [mesh.corners[corners][:, None].astype(np.float64)]
            columns += [each[corners] for each in (mesh.uv, mesh.normals) if each is not None]
            table = np.concatenate(columns, axis=1)
            first, order = _sorted_kinds(table)
            vertices = mesh.vertices[mesh.corners[corners[first]]]
            attributes = {"POSITION": self._floats(vertices, bounds=True)}
            if mesh.normals is not None:
                attributes["NORMAL"] = self._floats(_unit(mesh.normals[corners[first]]))
            if mesh.uv is not None:
                downward = mesh.uv[corners[first]] * [1.0, -1.0] + [0.0, 1.0]  # as v goes in glTF
                attributes["TEXCOORD_0"] = self._floats(downward)
        small = len(vertices) < 65_535
        indices = order.reshape(-1).astype("<u2" if small else "<u4")
        number = self.accessor(indices, _USHORT if small else _UINT, _INDICES)
        return {"attributes": attributes, "indices": number}

    def _floats(self, values: NDArray[np.float64], bounds: bool = False) -> int:
        return self.accessor(values.astype("<f4"), _FLOAT, _VERTICES, bounds)

    def packed(
        self, meshes: list[Entry], nodes: list[str], extras: Entry, instancing: bool
    ) -> bytes:
        """The whole file; `nodes`, the root first, are JSON already, as there may be very many."""
        tree: Entry = {
            "asset": {"version": "2.0", "generator": "ipmlang"},
            "scene": 0,
            "scenes": [{"nodes": [0], **({"extras": extras} if extras else {})}],
            "meshes": meshes,
            **shade_entries(self.materials, self.view),
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}] if self.size else [],
        }
        if instancing and len(nodes) > 1:
            tree["extensionsUsed"] = tree["extensionsRequired"] = [_INSTANCING]
        head = json.dumps({key: value for key, value in tree.items() if value != []},
                          separators=(",", ":"), ensure_ascii=False)  # fmt: skip
        text = head[:-1] + ',"nodes":[' + ",".join(nodes) + "]}"
        return _chunks(text.encode("utf-8"), b"".join(self.data))


def _chunks(text: bytes, data: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    parts = [struct.pack("<I4s", len(text), b"JSON"), text]
    if data:
        parts += [struct.pack("<I4s", len(data), b"BIN\0"), data]
    size = 12 + sum(map(len, parts))
    if size >= 2**32:
        raise FormatError("the model is over 4 GB, more than a GLB can hold")
    return b"".join([struct.pack("<4sII", b"glTF", 2, size), *parts])


def _sorted_kinds(
    table: NDArray[np.float64],
) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
    """The first of each kind of row, kinds in lexical order, and the kind of each row."""
    first, kind = distinct_rows(table)
    order = np.lexsort(table[first].T[::-1])
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[kind]


def _used(
    vertices: NDArray[np.float64], corners: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The vertices that corners name, and the corners as numbers of these."""
    is_used = np.zeros(len(vertices), np.bool_)
    is_used[corners] = True
    if is_used.all():
        return vertices, corners
    return vertices[is_used], (np.cumsum(is_used) - 1)[corners]


def _unit(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    fallback = np.array([0.0, 0.0, 1.0])
    return np.where(length > 1e-12, normals / np.where(length > 0, length, 1), fallback)


def _nodes(scene: MeshScene, variant: NDArray[np.int64], transforms: Transforms) -> list[str]:
    """One node a copy, as JSON. Made by one format operation a batch."""
    names = [json.dumps(name, ensure_ascii=False).replace("%", "%%") for name in scene.names]
    parts = {
        (mesh, name): f'{{"mesh":{mesh},"name":{names[name]}'
        for mesh, name in set(zip(variant.tolist(), scene.name.tolist(), strict=True))
    }
    nodes: list[str] = []
    for begin in range(0, len(variant), _BATCH):
        rows = slice(begin, begin + _BATCH)
        templates, numbers = transforms.templates(rows)
        heads = zip(variant[rows].tolist(), scene.name[rows].tolist(), templates, strict=True)
        template = "\n".join([parts[mesh, name] + tail for mesh, name, tail in heads])
        nodes += (template % numbers).split("\n")
    return nodes


def _instanced_nodes(
    file: _File, scene: MeshScene, variants: _Variants, transforms: Transforms
) -> list[str]:
    """One node for all copies of a mesh that share a name; copies that are sheared stay nodes."""
    group = variants.row * (len(scene.names) + 1) + scene.name
    group = np.where(transforms.sheared, -1, group)
    _, first, inverse = np.unique(group, return_index=True, return_inverse=True)
    plain = np.flatnonzero(transforms.sheared)
    every = _nodes(scene, variants.row, transforms) if len(plain) else []
    nodes = [every[row] for row in plain.tolist()]
    for number in np.argsort(first).tolist():
        rows = np.flatnonzero(inverse.reshape(-1) == number)
        if transforms.sheared[rows[0]]:
            continue
        columns = {
            "TRANSLATION": transforms.translation[rows],
            "ROTATION": transforms.rotation[rows],
            "SCALE": transforms.scale[rows],
        }
        attributes = {
            name: file.accessor(values.astype("<f4"), _FLOAT) for name, values in columns.items()
        }
        node = {
            "mesh": int(variants.row[rows[0]]),
            "name": scene.names[scene.name[rows[0]]],
            "extensions": {_INSTANCING: {"attributes": attributes}},
        }
        nodes.append(json.dumps(node, separators=(",", ":"), ensure_ascii=False))
    return nodes


def _extras(file: _File, scene: MeshScene) -> Entry:
    """What is known of the derivation: names and rules, and for each copy (in the order of the
    nodes, one a copy) which they are and its key, as accessors.
    """
    if not len(scene.rule):
        return dict(scene.extras)
    words = np.ascontiguousarray(scene.key.astype("<u8")).view("<u4").reshape(-1, 2)
    return {
        **scene.extras,
        "labels": list(scene.names),
        "rules": list(scene.rules),
        "label": file.accessor(scene.name.astype("<u4"), _UINT),
        "rule": file.accessor(scene.rule.astype("<u4"), _UINT),
        "key": file.accessor(words, _UINT),
    }
