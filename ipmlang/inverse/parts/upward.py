"""Which way is up in a model: what its format says, and what its geometry shows.

Takes a scene as it was read; says whether y is up in it. Formats that state it are believed, and so
are the names that building models (IFC) come with; other models tell by a plate that they stand on,
or by where their ground is. Nothing is turned here.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

import numpy as np

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, MeshScene, mapped
from ipmlang.inverse.frames import Floats

_STATED = (".glb", ".gltf", ".dae")  # their readers turn what they read to z-up
_USUAL_Y = (".obj",)
_GROUND = 0.01  # how near to 0 the ground is, as a share of the height
_PLATE = 0.6  # share of the box across an axis that a plate at its low end covers, if that is up
_INSET = 0.02  # share of the box that all else lies further in, on each side
_THICK = 0.02  # share of the height that belongs to a plate
_LOW = 0.5  # share of the height below which a plate lies
_FLAT = 1e-6  # how far from 1 the cosine of a level face is
_BANDS = 512  # heights that are told apart
_BUILDING_NAME = re.compile(r"Ifc[A-Z][a-z]")
_FEWEST_NAMED = 0.5  # share of the names that have to be such


def upward(
    path: Path, scene: MeshScene, up: Literal["auto", "y", "z"]
) -> tuple[bool, tuple[Note, ...]]:
    """Whether y is up, and a note where that was guessed."""
    suffix = path.suffix.lower()
    if suffix in _STATED:
        return up == "y", ()
    if up != "auto":
        return up == "y", ()
    axis, reason = _guess(scene, suffix)
    return axis == "y", (Note("up", f"{axis} was taken to be up, {reason}"),)


def _guess(scene: MeshScene, suffix: str) -> tuple[str, str]:
    """`y` or `z`, and why."""
    if _names_of_buildings(scene):
        return "z", "as in all IFC models"
    box = _box(scene)
    if plate := _plate(scene, box):
        return plate, f"it has a ground plate across {plate}"
    if ground := _ground(box):
        return ground, f"its ground lies at {ground} = 0"
    return "y" if suffix in _USUAL_Y else "z", f"as in most {suffix[1:]} files"


def _names_of_buildings(scene: MeshScene) -> bool:
    """Whether most groups are called after classes of IFC, the exchange format of architects."""
    used = [mesh.groups[each] for mesh in scene.meshes for each in np.unique(mesh.group)]
    named = sum(any(_BUILDING_NAME.match(word) for word in path) for path in used)
    return bool(used) and named >= _FEWEST_NAMED * len(used)


def _box(scene: MeshScene) -> Floats:
    """(2, 3) the box of all faces."""
    boxes = [
        [points.min(axis=0), points.max(axis=0)]
        for row, number in enumerate(scene.mesh.tolist())
        if len(points := _points(scene.meshes[number], scene.matrix[row]))
    ]
    low, high = zip(*boxes, strict=True)
    return np.array([np.min(low, axis=0), np.max(high, axis=0)])


def _plate(scene: MeshScene, box: Floats) -> str:
    """`y` or `z` if across it lies a plate that sticks out under all above it, and none across
    the other; else nothing.
    """
    if not np.isfinite(box).all():
        return ""
    every = zip(scene.mesh.tolist(), scene.matrix, strict=True)
    places = [(each, matrix) for each, matrix in every if len(scene.meshes[each].corners)]
    points = np.concatenate([_points(scene.meshes[each], matrix) for each, matrix in places])
    faces = [_faces(scene.meshes[each], matrix) for each, matrix in places]
    area, middle = (np.concatenate(column) for column in zip(*faces, strict=True))
    found = [name for axis, name in ((1, "y"), (2, "z")) if _juts(points, area, middle, box, axis)]
    return found[0] if len(found) == 1 else ""


def _juts(points: Floats, area: Floats, middle: Floats, box: Floats, axis: int) -> bool:
    """Whether a level in the lower half covers most of the box across an axis, and all that
    stands above it is further in on every side.
    """
    low, size = box[0], np.maximum(np.ptp(box, axis=0), 1e-300)
    flat = np.abs(area[:, axis]) > (1 - _FLAT) * np.linalg.norm(area, axis=1)
    band = np.rint((middle[flat, axis] - low[axis]) / size[axis] * _BANDS).astype(np.int64)
    covered = np.bincount(band, np.abs(area[flat, axis]), _BANDS + 1)[: int(_LOW * _BANDS)]
    sides = [each for each in range(3) if each != axis]
    wide = np.flatnonzero(covered >= _PLATE * size[sides].prod())
    if not len(wide):
        return False
    above = (points[:, axis] - low[axis]) / size[axis] > wide[-1] / _BANDS + _THICK
    within, inset = points[above][:, sides], _INSET * size[sides]
    inside = (within >= low[sides] + inset) & (within <= box[1, sides] - inset)
    return bool(above.any() and inside.all())


def _faces(mesh: Mesh, matrix: Floats) -> tuple[Floats, Floats]:
    """The vector areas (f, 3) and the middles of faces in the world."""
    points = _points(mesh, matrix).T.copy()
    starts, size = mesh.offsets[:-1], np.diff(mesh.offsets)
    away = points - np.repeat(points[:, starts], size, axis=1)
    ahead = np.roll(away, -1, axis=1)
    ahead[:, mesh.offsets[1:] - 1] = 0.0
    twice = [
        np.add.reduceat(away[i] * ahead[j] - away[j] * ahead[i], starts)
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]
    middle = [np.add.reduceat(column, starts) / size for column in points]
    return np.stack(twice, axis=1) / 2, np.stack(middle, axis=1)


def _ground(box: Floats) -> str:
    """`y` or `z` if the model stands where that is 0 and not where the other is; else nothing."""
    low, high = box
    stands = [bool(abs(low[axis]) <= _GROUND * (high[axis] - low[axis])) for axis in (1, 2)]
    return "y" if stands == [True, False] else "z" if stands == [False, True] else ""


def _points(mesh: Mesh, matrix: Floats) -> Floats:
    """The corners of all faces in the world."""
    return mapped(mesh.vertices, matrix)[mesh.corners]
