"""PLY files to meshes and back: ascii and binary, either byte order.

Takes a path or faces; gives a mesh with whatever polygons the file has (a point cloud has none), or
the bytes of a file. Counts in the header are checked against the length of the file before memory
is taken. Colours of vertices or faces become materials; other properties are passed over.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.coloring import with_face_colors, with_vertex_colors
from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, MeshScene, single, without_bad_faces

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_MOST = {"u1": 255.0, "u2": 65535.0}  # of a colour in whole numbers; others are shares
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_LONGEST_HEADER = 65_536
_COUNT = re.compile(r"[0-9]{1,15}")

Ints = NDArray[np.int64]


@dataclass(slots=True)
class _Property:
    name: str
    kind: str  # a numpy type without byte order
    count: str = ""  # the type of a list's length, empty for a single number


@dataclass(slots=True)
class _Element:
    name: str
    count: int
    properties: list[_Property]

    @property
    def lists(self) -> bool:
        return any(each.count for each in self.properties)


@dataclass(slots=True)
class _Columns:
    """The values of an element: single numbers by name, and its lists as values and lengths."""

    numbers: dict[str, NDArray[np.float64]]
    lists: dict[str, tuple[Ints, Ints]]


def read_ply(path: Path) -> MeshScene:
    """The mesh of a PLY file."""
    data = path.read_bytes()
    order, elements, start = _header(data)
    found: dict[str, _Columns] = {}
    tokens = data[start:].split() if not order else []
    position = 0 if not order else start
    for element in elements:
        if order:
            found[element.name], position = _binary(data, position, element, order)
        else:
            found[element.name], position = _ascii(tokens, position, element)
    return _mesh(found, elements, path.stem)


def write_ply(
    vertices: NDArray[np.float64], triangles: Ints, colors: NDArray[np.uint8] | None = None
) -> bytes:
    """A binary PLY: vertices (v, 3) as doubles, so that nothing is lost, triangles (t, 3), and for
    each its colour (t, 4) if there are any.
    """
    named = () if colors is None else ("red", "green", "blue", "alpha")
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment written by ipmlang\n"
        f"element vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\n"
        + "".join(f"property uchar {name}\n" for name in named)
        + "end_header\n"
    )
    faces = np.empty(
        len(triangles), [("count", "u1"), ("corners", "<i4", (3,)), ("color", "u1", (len(named),))]
    )
    faces["count"], faces["corners"] = 3, triangles
    if colors is not None:
        faces["color"] = colors
    return header.encode("ascii") + vertices.astype("<f8").tobytes() + faces.tobytes()


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Byte order (empty for ascii), elements, and where the values start."""
    if not data.startswith(b"ply"):
        raise FormatError("this is no PLY file: it does not begin with `ply`", 1)
    end = data.find(b"end_header", 0, _LONGEST_HEADER)
    if end < 0:
        raise FormatError("the PLY header has no end", hint="the file may be cut off")
    start = data.find(b"\n", end) + 1 or len(data)
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), 1):
        words = line.split()
        match words:
            case ["format", kind, *_] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", name, count] if _COUNT.fullmatch(count):
                elements.append(_Element(name, int(count), []))
            case ["property", "list", count, kind, name] if elements:
                types = _kind(kind, number), _kind(count, number)
                elements[-1].properties.append(_Property(name, *types))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, _kind(kind, number)))
            case ["ply"] | ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise FormatError(f"`{line.strip()[:60]}` means nothing in a PLY header", number)
    if order is None:
        raise FormatError("the PLY header names no format")
    return order, elements, start


def _kind(word: str, line: int) -> str:
    if word not in _TYPES:
        raise FormatError(f"`{word[:40]}` is no type of PLY", line)
    return _TYPES[word]


def _short(element: _Element) -> FormatError:
    message = f"the file ends before its {element.count} `{element.name}` are complete"
    return FormatError(message, hint="the file may be cut off")


def _binary(data: bytes, position: int, element: _Element, order: str) -> tuple[_Columns, int]:
    if not element.properties:
        return _Columns({}, {}), position
    if element.lists:
        return _binary_lists(data, position, element, order)
    record = np.dtype([(str(k), order + p.kind) for k, p in enumerate(element.properties)])
    if len(data) - position < record.itemsize * element.count:
        raise _short(element)
    rows = np.frombuffer(data, record, element.count, position)
    numbers = {p.name: rows[str(k)].astype(float) for k, p in enumerate(element.properties)}
    return _Columns(numbers, {}), position + record.itemsize * element.count


def _binary_lists(
    data: bytes, position: int, element: _Element, order: str
) -> tuple[_Columns, int]:
    """Lists of equal length are one read; the first row tells the length, all rows are checked."""
    sizes = _row_sizes(data, position, element, order)
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    for k, each in enumerate(element.properties):
        if each.count:
            fields.append((f"n{k}", order + each.count))
            fields.append((str(k), order + each.kind, (sizes[k],)))
        else:
            fields.append((str(k), order + each.kind))
    record = np.dtype(fields)
    if len(data) - position >= record.itemsize * element.count:
        rows = np.frombuffer(data, record, element.count, position)
        listed = [k for k, each in enumerate(element.properties) if each.count]
        if all((rows[f"n{k}"] == sizes[k]).all() for k in listed):
            columns = _Columns({}, {})
            for k, each in enumerate(element.properties):
                if not each.count:
                    columns.numbers[each.name] = rows[str(k)].astype(float)
            for k in listed:
                lengths = np.full(element.count, sizes[k], np.int64)
                values = rows[str(k)].reshape(-1)
                columns.lists[element.properties[k].name] = (_whole(values), lengths)
            return columns, position + record.itemsize * element.count
    return _uneven_lists(data, position, element, order)


def _row_sizes(data: bytes, position: int, element: _Element, order: str) -> list[int]:
    """The length of each list in the first row, 0 for single numbers."""
    sizes = []
    for each in element.properties:
        size = 0
        if each.count and element.count:
            kind = np.dtype(order + each.count)
            if len(data) - position < kind.itemsize:
                raise _short(element)
            size = max(0, int(np.frombuffer(data, kind, 1, position)[0]))
            position += kind.itemsize
        width = np.dtype(order + each.kind).itemsize
        position += width * (size if each.count else 1)
        if position > len(data):
            raise _short(element)
        sizes.append(size)
    return sizes


def _uneven_lists(
    data: bytes, position: int, element: _Element, order: str
) -> tuple[_Columns, int]:
    """Lists of different lengths, row by row: where a row begins hangs on the one before."""
    if element.count > len(data) - position:
        raise _short(element)
    kinds = [(np.dtype(order + p.kind), p) for p in element.properties]
    counts = [np.dtype(order + (p.count or "u1")) for p in element.properties]
    values: dict[str, list[NDArray[np.generic]]] = {p.name: [] for p in element.properties}
    lengths: dict[str, list[int]] = {p.name: [] for p in element.properties}
    for _ in range(element.count):
        for (kind, each), count in zip(kinds, counts, strict=True):
            size = 1
            if each.count:
                if len(data) - position < count.itemsize:
                    raise _short(element)
                size = max(0, int(np.frombuffer(data, count, 1, position)[0]))
                position += count.itemsize
            if len(data) - position < size * kind.itemsize:
                raise _short(element)
            values[each.name].append(np.frombuffer(data, kind, size, position))
            lengths[each.name].append(size)
            position += size * kind.itemsize
    columns = _Columns({}, {})
    for each in element.properties:
        flat = np.concatenate([np.zeros(0), *values[each.name]])
        if each.count:
            columns.lists[each.name] = (_whole(flat), np.array(lengths[each.name], np.int64))
        else:
            columns.numbers[each.name] = flat
    return columns, position


def _whole(values: NDArray[np.generic]) -> Ints:
    return np.asarray(values).astype(np.int64)


def _ascii(tokens: Sequence[bytes], position: int, element: _Element) -> tuple[_Columns, int]:
    width = len(element.properties)
    if element.count * width > len(tokens) - position:
        raise _short(element)
    columns = _Columns({}, {})
    try:
        if not element.lists:
            end = position + element.count * width
            table = np.array(tokens[position:end], dtype=np.float64).reshape(-1, max(width, 1))
            columns.numbers = {p.name: table[:, k] for k, p in enumerate(element.properties)}
            return columns, end
        return _ascii_lists(tokens, position, element)
    except (ValueError, OverflowError) as error:
        raise FormatError(f"a value of `{element.name}` is no number: {error}") from error


def _ascii_lists(tokens: Sequence[bytes], position: int, element: _Element) -> tuple[_Columns, int]:
    values: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count}
    lengths: dict[str, list[int]] = {name: [] for name in values}
    numbers: dict[str, list[float]] = {p.name: [] for p in element.properties if not p.count}
    for _ in range(element.count):
        for each in element.properties:
            if not each.count:
                if position >= len(tokens):
                    raise _short(element)
                numbers[each.name].append(float(tokens[position]))
                position += 1
                continue
            if position >= len(tokens):
                raise _short(element)
            size = max(0, int(tokens[position]))
            position += 1
            if position + size > len(tokens):
                raise _short(element)
            values[each.name] += map(int, tokens[position : position + size])
            lengths[each.name].append(size)
            position += size
    lists = {
        name: (np.array(values[name], np.int64), np.array(lengths[name], np.int64))
        for name in values
    }
    return _Columns({name: np.array(own) for name, own in numbers.items()}, lists), position


def _colors(columns: _Columns, kinds: Mapping[str, str]) -> NDArray[np.float64] | None:
    """(n, 3) or (n, 4) the colours of an element, 0 to 1; None if it has none."""
    for start in ("", "diffuse_"):
        names = [f"{start}{name}" for name in ("red", "green", "blue", "alpha")]
        names = names if names[3] in columns.numbers else names[:3]
        if all(name in columns.numbers for name in names):
            most = [_MOST.get(kinds.get(name, ""), 1.0) for name in names]
            return np.stack([columns.numbers[name] for name in names], axis=1) / most
    return None


def _kinds(elements: Sequence[_Element], name: str) -> dict[str, str]:
    """The types of an element's single numbers."""
    return {
        each.name: each.kind
        for element in elements
        if element.name == name
        for each in element.properties
        if not each.count
    }


def _mesh(found: dict[str, _Columns], elements: Sequence[_Element], name: str) -> MeshScene:
    vertex = found.get("vertex")
    if vertex is None or not all(axis in vertex.numbers for axis in "xyz"):
        raise FormatError("the PLY file has no vertices with x, y and z")
    vertices = np.stack([vertex.numbers[axis] for axis in "xyz"], axis=1)
    lists = found["face"].lists if "face" in found else {}
    empty = (np.zeros(0, np.int64), np.zeros(0, np.int64))
    corners, lengths = lists.get("vertex_indices", lists.get("vertex_index", empty))
    if len(corners) and (corners.min() < 0 or corners.max() >= len(vertices)):
        raise FormatError(f"a face names a vertex that is not among the {len(vertices)}")
    count = len(lengths)
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    none, group = np.full(count, -1, np.int64), np.zeros(count, np.int64)
    mesh = Mesh(vertices, corners, offsets, none, group, groups=((name,),))
    painted: tuple[Note, ...] = ()
    face_colors = _colors(found["face"], _kinds(elements, "face")) if count else None
    if face_colors is not None:
        mesh, painted = with_face_colors(mesh, face_colors)
    elif (colors := _colors(vertex, _kinds(elements, "vertex"))) is not None:
        mesh, painted = with_vertex_colors(mesh, colors)
    mesh, notes = without_bad_faces(mesh)
    return single(mesh, name, (*painted, *notes))
