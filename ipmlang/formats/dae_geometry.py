"""The geometry of DAE files: sources, inputs and primitives to a mesh of polygons.

Takes a `<geometry>` element and what its material symbols stand for; gives a mesh whose corners
carry normals and texture coordinates where all primitives have them. Indices that point nowhere
are errors with their line; lines are passed over.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats.dae_xml import children, first, local_name, numbers, whole_numbers, wrong
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Material, Mesh, merged, without_bad_faces

if TYPE_CHECKING:
    from lxml.etree import _Element

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Shade: TypeAlias = Callable[[str], Material | None]

_FACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


def read_geometry(geometry: _Element, shade: Shade) -> tuple[Mesh, tuple[Note, ...]]:
    """The mesh of a geometry, and notes on what was left out."""
    holder = first(geometry, "mesh")
    if holder is None:
        return _empty(), (Note("not-a-surface", "curves of the model were left out"),)
    sources = {each.get("id", ""): each for each in holder if each.get("id")}
    name = geometry.get("name") or geometry.get("id") or ""
    meshes: list[Mesh] = []
    notes: list[Note] = []
    lines = 0
    for each in holder:
        if local_name(each) in _FACES:
            mesh, said = without_bad_faces(_primitive(each, sources, shade, name))
            meshes.append(mesh)
            notes += said
        elif local_name(each) in ("lines", "linestrips"):
            lines += 1
    if lines:
        notes.append(Note("not-a-surface", "points and lines of the model were left out", lines))
    return merged(meshes) if meshes else _empty(), tuple(notes)


def _empty() -> Mesh:
    none = np.zeros(0, np.int64)
    return Mesh(np.zeros((0, 3)), none, np.zeros(1, np.int64), none, none)


def _primitive(primitive: _Element, sources: dict[str, _Element], shade: Shade, name: str) -> Mesh:
    inputs = list(children(primitive, "input"))
    stride = 1 + max((_offset(each) for each in inputs), default=-1)
    counts, table = _table(primitive, stride)
    columns: dict[str, tuple[Floats, Indices]] = {}
    for each in inputs:
        for semantic, values in _given(each, sources):
            if semantic not in columns:
                columns[semantic] = (values, table[:, _offset(each)])
    if "POSITION" not in columns:
        raise wrong(primitive, "has no positions")
    for semantic, (values, index) in columns.items():
        if len(index) and (index.min() < 0 or index.max() >= len(values)):
            raise wrong(primitive, f"names a {semantic} that is not among the {len(values)}")
    vertices, corners = columns["POSITION"]
    uv, normals = _laid(columns.get("TEXCOORD"), 2), _laid(columns.get("NORMAL"), 3)
    material = shade(primitive.get("material", ""))
    zero = np.zeros(len(counts), np.int64)
    return Mesh(
        vertices[:, :3],
        corners,
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        zero if material else zero - 1,
        zero,
        (material,) if material else (),
        ((name,) if name else (),),
        uv,
        normals,
    )


def _offset(each: _Element) -> int:
    text = each.get("offset", "0")
    if not text.isdigit() or len(text) > 3:
        raise wrong(each, f"has the offset `{text[:20]}`")
    return int(text)


def _given(each: _Element, sources: dict[str, _Element]) -> list[tuple[str, Floats]]:
    """What an input gives: for VERTEX all that the vertices have."""
    found = sources.get(each.get("source", "")[1:])
    if found is None:
        raise wrong(each, f"names `{each.get('source', '')[:40]}`, which is not there")
    if each.get("semantic") == "VERTEX":
        return [pair for inner in children(found, "input") for pair in _given(inner, sources)]
    if each.get("semantic") not in ("POSITION", "NORMAL", "TEXCOORD"):
        return []
    return [(str(each.get("semantic")), _values(found))]


def _values(source: _Element) -> Floats:
    """The rows of a source."""
    array = first(source, "float_array")
    accessor = first(source, "technique_common", "accessor")
    if array is None:
        raise wrong(source, "has no numbers")
    values = numbers(array)
    text = accessor.get("stride", "3") if accessor is not None else "3"
    stride = int(text) if text.isdigit() and 0 < int(text) < 100 else 3
    return values[: len(values) // stride * stride].reshape(-1, stride)


def _laid(column: tuple[Floats, Indices] | None, width: int) -> Floats | None:
    """The values of corners (c, width), None where there are none."""
    if column is None or column[0].shape[1] < width:
        return None
    return np.asarray(column[0][column[1], :width])


def _table(primitive: _Element, stride: int) -> tuple[Indices, Indices]:
    """How many corners each face has, and the indices (c, stride) of all corners."""
    if stride < 1:
        raise wrong(primitive, "has no inputs")
    runs = [whole_numbers(each) for each in children(primitive, "p")]
    runs += [
        whole_numbers(outline)
        for holed in children(primitive, "ph")
        for outline in children(holed, "p")
    ]
    tables = [run[: len(run) // stride * stride].reshape(-1, stride) for run in runs]
    joined = np.concatenate(tables) if tables else np.zeros((0, stride), np.int64)
    match local_name(primitive):
        case "triangles":
            return _threes(joined)
        case "polylist":
            vcount = first(primitive, "vcount")
            counts = whole_numbers(vcount) if vcount is not None else np.zeros(0, np.int64)
            if (counts < 0).any() or counts.sum() > len(joined):
                raise wrong(primitive, "states more corners than it has")
            return counts, joined[: counts.sum()]
        case "polygons":
            return np.array([len(each) for each in tables], np.int64), joined
        case "tristrips":
            return _threes(np.concatenate([joined[:0], *(_strip(each) for each in tables)]))
        case _:
            return _threes(np.concatenate([joined[:0], *(_fan(each) for each in tables)]))


def _threes(corners: Indices) -> tuple[Indices, Indices]:
    count = len(corners) // 3
    return np.full(count, 3, np.int64), corners[: 3 * count]


def _strip(run: Indices) -> Indices:
    """The corners of a strip's triangles, every second turned."""
    number = np.arange(max(len(run) - 2, 0))
    odd = number % 2
    return run[np.stack([number + odd, number + 1 - odd, number + 2], axis=1).reshape(-1)]


def _fan(run: Indices) -> Indices:
    number = np.arange(1, max(len(run) - 1, 1))
    return run[np.stack([number * 0, number, number + 1], axis=1).reshape(-1)]
