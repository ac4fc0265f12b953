"""The container and the accessors of a GLB file: bytes to JSON and arrays, nothing about meshes.

Takes the bytes of a file; every offset and count is checked against what is there before memory is
taken. Quantised, normalised, strided and sparse accessors come out as plain numbers. What a
`FormatError` says names the part of the file that is wrong.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError

Json: TypeAlias = "dict[str, Json] | list[Json] | str | int | float | bool | None"
Object: TypeAlias = "dict[str, Json]"

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_LARGEST = 3_000_000  # numbers of an accessor without data of its own


@dataclass(slots=True)
class Container:
    """The JSON of a file and its binary chunk."""

    tree: Object
    binary: bytes
    _lists: dict[str, list[Object]] = field(default_factory=dict)

    def items(self, name: str) -> list[Object]:
        """A list of objects of the top level, empty if there is none; made once."""
        if name not in self._lists:
            found = self.tree.get(name, [])
            listed = found if isinstance(found, list) else []
            self._lists[name] = [each if isinstance(each, dict) else {} for each in listed]
        return self._lists[name]

    def item(self, name: str, index: Json) -> Object:
        """One of them by number."""
        found = self.items(name)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise FormatError(f"the file names {name}[{index}], which is not there")
        return found[index]


def open_glb(data: bytes) -> Container:
    """The chunks of a GLB file of version 2."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise FormatError("this is no GLB file: it does not begin with `glTF`")
    version, total = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FormatError(f"this is GLB version {version}; only version 2 can be read")
    if total > len(data):
        message = f"the file states {total} bytes and has {len(data)}"
        raise FormatError(message, hint="the file may be cut off")
    size, kind = struct.unpack_from("<I4s", data, 12)
    if kind != b"JSON" or 20 + size > len(data):
        raise FormatError("the file's first part is not its JSON")
    try:
        tree = json.loads(data[20 : 20 + size])
    except (ValueError, RecursionError) as error:
        raise FormatError(f"the file's JSON cannot be read: {error}") from error
    if not isinstance(tree, dict):
        raise FormatError("the file's JSON is no object")
    start = 20 + size
    binary = b""
    if start + 8 <= len(data):
        size, kind = struct.unpack_from("<I4s", data, start)
        if kind == b"BIN\0":
            binary = data[start + 8 : start + 8 + size]
    return Container(tree, binary)


def whole(value: Json, default: int = 0) -> int:
    """A whole number of at least 0."""
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
        raise FormatError(f"the file has `{str(value)[:40]}` where a count belongs")
    return value


def view_bytes(file: Container, index: Json) -> tuple[bytes, int]:
    """The bytes of a buffer view, and its stride (0: packed)."""
    view = file.item("bufferViews", index)
    buffer = file.item("buffers", view.get("buffer"))
    if "uri" in buffer:
        message = "the file keeps its data in other files"
        raise FormatError(message, hint="save it as one .glb file with its data inside")
    start, size = whole(view.get("byteOffset")), whole(view.get("byteLength"))
    if start + size > len(file.binary):
        raise FormatError(f"bufferViews[{index}] reaches past the end of the data")
    return file.binary[start : start + size], whole(view.get("byteStride"))


def read_accessor(file: Container, index: Json) -> NDArray[np.float64]:
    """The values of an accessor (n, width) as numbers; integers stay exact up to 2^53."""
    accessor = file.item("accessors", index)
    kind, width = _layout(accessor)
    count = whole(accessor.get("count"))
    if "bufferView" in accessor:
        values = _packed(file, accessor, kind, width, count)
    elif count * width > _LARGEST:
        raise FormatError(f"accessors[{index}] states {count} values and has none")
    else:
        values = np.zeros((count, width), kind)
    sparse = accessor.get("sparse")
    if isinstance(sparse, dict):
        values = _sparse(file, values, sparse, kind, width)
    numbers = values.astype(np.float64)
    if accessor.get("normalized") is True and kind.kind in "iu":
        largest = float(2 ** (8 * kind.itemsize - (kind.kind == "i")) - 1)
        numbers = np.maximum(numbers / largest, -1.0)
    return numbers


def _layout(accessor: Object) -> tuple[np.dtype[np.generic], int]:
    component, shape = accessor.get("componentType"), accessor.get("type")
    if not isinstance(component, int) or component not in _COMPONENTS:
        raise FormatError(f"an accessor has the unknown number type {component}")
    if not isinstance(shape, str) or shape not in _WIDTHS:
        raise FormatError(f"an accessor has the unknown shape {shape}")
    return np.dtype(_COMPONENTS[component]), _WIDTHS[shape]


def _packed(
    file: Container, accessor: Object, kind: np.dtype[np.generic], width: int, count: int
) -> NDArray[np.generic]:
    data, stride = view_bytes(file, accessor.get("bufferView"))
    start = whole(accessor.get("byteOffset"))
    row = width * kind.itemsize
    stride = stride or row
    if count and start + stride * (count - 1) + row > len(data):
        raise FormatError(f"an accessor states {count} values, more than its data hold")
    return np.ndarray((count, width), kind, data, start, (stride, kind.itemsize)).copy()


def _sparse(
    file: Container,
    values: NDArray[np.generic],
    sparse: Object,
    kind: np.dtype[np.generic],
    width: int,
) -> NDArray[np.generic]:
    """The values with those that a sparse part replaces."""
    count, where, what = (sparse.get(name) for name in ("count", "indices", "values"))
    if not isinstance(where, dict) or not isinstance(what, dict):
        raise FormatError("a sparse accessor lacks its indices or values")
    places_kind, _ = _layout({**where, "type": "SCALAR"})
    places = _packed(file, where, places_kind, 1, whole(count))[:, 0].astype(np.int64)
    if len(places) and places.max() >= len(values):
        raise FormatError("a sparse accessor replaces values that are not there")
    values[places] = _packed(file, what, kind, width, whole(count))
    return values
