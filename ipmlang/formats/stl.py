"""STL files to meshes and back: ascii and binary.

Takes a path or triangles; gives a mesh whose equal corners are one vertex, or the bytes of a binary
file. The normals in a file are passed over: the order of the corners says what they are.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ipmlang.formats import FormatError
from ipmlang.formats.mesh_types import MeshScene, single, triangle_mesh, without_bad_faces

_RECORD = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("more", "<u2")])
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(path: Path) -> MeshScene:
    """The mesh of an STL file."""
    data = path.read_bytes()
    stated = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + stated * _RECORD.itemsize:
        corners = np.frombuffer(data, _RECORD, stated, 84)["corners"].astype(np.float64)
    elif data.lstrip()[:5].lower() == b"solid" and b"vertex" in data:
        corners = _ascii(data)
    elif len(data) >= 84:
        whole = (len(data) - 84) // _RECORD.itemsize
        message = f"the file states {stated} triangles and holds {whole}"
        raise FormatError(message, hint="the file may be cut off, or be no STL")
    else:
        raise FormatError("this is no STL file: it is too short")
    points, index = _distinct(corners.reshape(-1, 3))
    mesh, notes = without_bad_faces(triangle_mesh(points, index.reshape(-1, 3), path.stem))
    return single(mesh, path.stem, notes)


def write_stl(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """A binary STL of triangles (t, 3) over vertices (v, 3)."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    records = np.zeros(len(triangles), _RECORD)
    records["normal"] = normal / np.where(length > 0, length, 1)
    records["corners"] = corners
    header = b"binary STL written by ipmlang".ljust(80)
    return header + len(triangles).to_bytes(4, "little") + records.tobytes()


def _ascii(data: bytes) -> NDArray[np.float64]:
    found = _VERTEX.findall(data)
    if len(found) % 3:
        raise FormatError("the last triangle is not complete", hint="the file may be cut off")
    try:
        return np.array(found, dtype=np.float64).reshape(-1, 3)
    except ValueError as error:
        raise FormatError(f"a corner is no number: {error}") from error


def _distinct(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Equal points as one, in order of first use, and the number of each."""
    points = points + 0.0  # one zero, not two
    first, index = _equal_rows(points)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return points[first[order]], rank[index.reshape(-1)]


def _equal_rows(points: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first row of each kind, and each row's kind. Sorts one hash a row, which is many times
    quicker than sorting rows, and checks that no two kinds share one.
    """
    words = points.view(np.uint64)
    with np.errstate(over="ignore"):
        mixed = words * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], "u8")
        mixed ^= mixed >> np.uint64(29)
        hashed = (mixed * np.uint64(0xBF58476D1CE4E5B9)).sum(axis=1, dtype=np.uint64)
    _, first, index = np.unique(hashed, return_index=True, return_inverse=True)
    if not np.array_equal(words[first[index]], words):
        _, first, index = np.unique(points, axis=0, return_index=True, return_inverse=True)
    return first, index.reshape(-1)
