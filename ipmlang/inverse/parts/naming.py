"""Words for shape classes: from names in the file where these say something, else from the shape
and, for what stands once, from its place. A material is a name where one shape alone has it, and
tells shapes apart that would be called the same.

Takes classes with their meshes and the paths and boxes of their members; gives names that are free
to be symbols, each used once. Nothing here knows what a grammar's other names are.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from ipmlang.formats.coloring import is_color_name
from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats, Integers
from ipmlang.inverse.parts.describing import place_word, shape_word

CROWDED = 4  # parts of which it helps to say where each stands
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
    low: Floats,
    high: Floats,
) -> list[str]:
    """A name for each class; low, high: (n, 3) boxes of all parts."""
    own = word(stem)
    # One path for all parts tells nothing of any.
    several = len(set(paths)) > 1
    hints = [_hint(rows, paths) if several else "" for rows in members]
    by_group = _telling(hints, own)
    materials = _telling([_by_material(mesh) for mesh in meshes], own)
    by_material = _telling(materials, own, 1)
    said = [
        group or material or _described(mesh, rows, low, high)
        for group, material, mesh, rows in zip(by_group, by_material, meshes, members, strict=True)
    ]
    made: dict[str, set[str]] = {}
    for name, material in zip(said, materials, strict=True):
        made.setdefault(name, set()).add(material)
    return numbered(
        [
            name if group or material == name or len(made[name]) == 1 else material + name
            for name, group, material in zip(said, by_group, materials, strict=True)
        ]
    )


def _described(mesh: Mesh, rows: Integers, low: Floats, high: Floats) -> str:
    """What a shape is called by its box and faces, with its place where it stands once."""
    shape = shape_word(mesh)
    if len(rows) > 1 or len(low) < CROWDED:
        return shape
    whole = np.stack([low.min(axis=0), high.max(axis=0)])
    return place_word(low[rows[0]], high[rows[0]], whole, shape)


def _telling(words: Sequence[str], own: str, most: int = 0) -> list[str]:
    """Words without the file's own and those that so many classes would bear that they tell
    nothing; most: how many may, 0 for a share of them.
    """
    often = Counter(words)
    shared = len(often) == 1 < len(words)
    most = 0 if shared else most or max(3, len(words) // 4)
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
