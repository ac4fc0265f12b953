"""The parts of models in files beside a grammar: meshes, read once while their file is the same.

Takes a path and names; gives meshes in the world with what the reader noted, and the names in a
file. What was read is known again by the bytes of the file, wherever that lies, so an edit that
derives a grammar over and over reads its parts once. Only files that name no other are remembered,
the last few small ones; what is given out of memory cannot be written to.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache as remember
from pathlib import Path
from typing import TypeAlias

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh import mesh_names, read_parts
from ipmlang.formats.mesh_types import Mesh, baked

FILES = 8  # that are remembered
MOST_BYTES = 4_000_000  # of a file that is remembered
MOST_CORNERS = 1_000_000  # of all parts of a file: small ones say large meshes by their copies
OTHERS = {".obj": (b"mtllib", b"map_"), ".glb": (b'"uri"',)}  # what names other files

Part: TypeAlias = tuple[Mesh, tuple[Note, ...]]


@dataclass(slots=True, eq=False)
class _Known:
    """What was read of one file."""

    names: tuple[str, ...] | None = None
    parts: dict[str | None, Part] = field(default_factory=dict)


@remember
def _files() -> OrderedDict[tuple[str, bytes], _Known]:
    """The files that this process remembers, the one asked for last at the end."""
    return OrderedDict()


def part_names(path: Path) -> tuple[str, ...]:
    """What `mesh_names` gives."""
    known = _known(path)
    if known is None:
        return mesh_names(path)
    if known.names is None:
        known.names = mesh_names(path)
    return known.names


def part_meshes(path: Path, nodes: Sequence[str | None]) -> list[Part]:
    """The parts of a model that go by these names (None: the whole), each as one mesh in the world.
    Raises FormatError as `read_parts` does.
    """
    known = _known(path)
    if known is None:
        return _read(path, nodes)
    found = {node: known.parts[node] for node in nodes if node in known.parts}
    missing = [node for node in dict.fromkeys(nodes) if node not in found]
    if missing:
        read = dict(zip(missing, _read(path, missing), strict=True))
        found |= read
        if _corners(known.parts) + _corners(read) <= MOST_CORNERS:
            known.parts.update({node: _fixed(part) for node, part in read.items()})
    return [found[node] for node in nodes]


def _corners(parts: Mapping[str | None, Part]) -> int:
    return sum(len(mesh.corners) for mesh, _ in parts.values())


def _read(path: Path, nodes: Sequence[str | None]) -> list[Part]:
    return [(baked(scene), scene.notes) for scene in read_parts(path, nodes)]


def _known(path: Path) -> _Known | None:
    """What is remembered of a file, nothing yet for a new one; None where it is not to be."""
    others = OTHERS.get(path.suffix.lower())
    try:
        if others is None or path.stat().st_size > MOST_BYTES:
            return None
        content = path.read_bytes()
    except OSError:  # which is for whoever reads it to tell
        return None
    if any(word in content for word in others):
        return None
    files = _files()
    key = (path.suffix.lower(), hashlib.blake2b(content, digest_size=16).digest())
    known = files.setdefault(key, _Known())
    files.move_to_end(key)
    if len(files) > FILES:
        files.popitem(last=False)
    return known


def _fixed(part: Part) -> Part:
    """The part, so that nobody writes to what others are given, too."""
    mesh = part[0]
    for column in (
        mesh.vertices, mesh.corners, mesh.offsets, mesh.material, mesh.group, mesh.uv, mesh.normals
    ):  # fmt: skip
        if column is not None:
            column.flags.writeable = False
    return part
