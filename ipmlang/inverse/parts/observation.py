"""What was seen in a model, free of file formats: parts as placed copies of shape classes.

Coordinates are those of the model turned so that z points up. Columns over parts say which class
stands in which frame under which names. Nothing here reads files or looks for patterns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Frames, Integers

Up = Literal["y-up", "z-up"]


@dataclass(frozen=True, slots=True, eq=False)
class PartClass:
    """Parts that are one shape: the same faces, materials and texture coordinates, up to a rigid
    motion or a mirror.

    name: a word for it, from the file's groups and materials where they say one, unique among
        classes and free to be a symbol.
    mesh: the representative, its box from (0, 0, 0) to `size`, turned as most of its members are.
    size: (3,) of that box.
    symmetry: the frames that map the representative onto itself, identity first.
    members: (k,) rows of the parts.
    """

    name: str
    mesh: Mesh
    size: Floats
    symmetry: Frames
    members: Integers


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """Class `shape` is class `of` made larger or smaller: its own coordinates = frame(those of
    `of`), one row; misfit: units that a vertex is off at most.
    """

    shape: int
    of: int
    frame: Frames
    misfit: float


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """n parts of a model as columns, with what they refer to.

    shape: (n,) into classes; frames: (n,) world = frame(representative), the simplest of those that
    the class's symmetry allows; low, high: (n, 3) boxes in the world; path: for each part the names
    of nodes, objects and groups that it stood under, outermost first, none where the file says
    nothing; misfit: (n,) largest distance of a vertex from where its frame puts it; diagonal: of
    the box of everything; up: which way was up in the file; triangles, vertices: as counted in the
    file; source_bytes: of the file; notes: what was mended, split or left out; turn: degrees about
    the vertical, to the left, by which all of it is to be turned to stand in the world; likenesses:
    of classes that are scaled copies of others.
    """

    shape: Integers
    frames: Frames
    low: Floats
    high: Floats
    path: tuple[tuple[str, ...], ...]
    classes: tuple[PartClass, ...]
    misfit: Floats
    diagonal: float
    up: Up
    triangles: int
    vertices: int
    source_bytes: int
    notes: tuple[Note, ...] = ()
    turn: float = 0.0
    likenesses: tuple[Likeness, ...] = ()
