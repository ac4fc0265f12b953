"""Words for shape classes: from names in the file where these say something, else from the shape.

Takes classes with their meshes and the paths of their members; gives names that are free to be
symbols, each used once. Nothing here knows what a grammar's other names are.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from ipmlang.formats.coloring import is_color_name
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers

_PLAIN = frozenset(
    ["default", "mesh", "object", "node", "group", "geometry", "scene", "root", "model", "part",
     "material", "none", "unnamed", "untitled", "generic", "surface", "polygon", "polygons",
     "shape", "visual", "lib", "slot", "lambert"]
)  # fmt: skip


def class_names(
    members: Sequence[Integers],
    meshes: Sequence[Mesh],
    paths: Sequence[tuple[str, ...]],
    stem: str,
) -> list[str]:
    """A name for each class."""
    own = word(stem)
    # One path for all parts tells nothing of any.
    several = len(set(paths)) > 1
    hints = [_hint(rows, paths) if several else "" for rows in members]
    by_group = _telling(hints, own)
    by_material = _telling([_by_material(mesh) for mesh in meshes], own)
    return numbered(
        [
            group or material or shape_word(mesh)
            for group, material, mesh in zip(by_group, by_material, meshes, strict=True)
        ]
    )


def _telling(words: Sequence[str], own: str) -> list[str]:
    """Words without the file's own and those that so many classes would bear that they tell
    nothing.
    """
    often = Counter(words)
    shared = len(often) == 1 < len(words)
    most = 0 if shared else max(3, len(words) // 4)
    return [each if each != own and often[each] <= most else "" for each in words]


def word(text: str) -> str:
    """A symbol in the way people write them: `IfcWallStandardCase_767` as `WallStandardCase`."""
    text = re.sub(r"^Ifc(?=[A-Z])", "", text)
    pieces = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[A-Z]", text)
    kept = [piece for piece in pieces if piece.lower() not in _PLAIN]
    return "".join(piece[0].upper() + piece[1:] for piece in kept)[:32]


def _hint(rows: Integers, paths: Sequence[tuple[str, ...]]) -> str:
    """The innermost name that says something, of most members."""
    found = Counter(
        next((said for name in reversed(paths[row]) if (said := word(name))), "")
        for row in rows[:64].tolist()
    )
    return found.most_common(1)[0][0]


def _by_material(mesh: Mesh) -> str:
    """The material's name where the part has one alone, and it is more than a colour's number."""
    if len(mesh.materials) != 1 or is_color_name(mesh.materials[0].name):
        return ""
    return word(mesh.materials[0].name)


def shape_word(mesh: Mesh) -> str:
    """What a shape is called by its box and faces."""
    size = np.ptp(mesh.vertices, axis=0)
    small, middle, large = np.sort(size)
    if large <= 0:
        return "Point"
    if small <= 1e-6 * large:
        return "Panel" if middle > 0.1 * large else "Strip"
    if middle <= 0.25 * large:
        return "Post" if size[2] == large else "Bar"
    if small <= 0.2 * middle:
        return "Slab" if size[2] == small else "Plate"
    return "Box" if _fills_box(mesh, size) else "Part"


def _fills_box(mesh: Mesh, size: Floats) -> bool:
    """Whether all vertices are corners of the box."""
    share = mesh.vertices / size
    return len(share) == 8 and bool((np.abs(share - np.rint(share)) < 1e-6).all())


def numbered(wanted: Sequence[str]) -> list[str]:
    """Names used once: the second `Box` is `Box2`."""
    taken: set[str] = set()
    numbers: Counter[str] = Counter()
    names = []
    for name in wanted:
        free = name
        while free in taken:
            numbers[name] += 1
            free = f"{name}{numbers[name] + 1}"
        taken.add(free)
        names.append(free)
    return names
