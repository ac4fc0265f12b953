"""Which way is up in a model: what its format says, and what its geometry shows.

Takes a scene as it was read; says whether y is up in it. Formats that state it are believed; of the
others a model that stands on the ground tells by where its ground is. Nothing is turned here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from ipmlang.formats.drawing import Note
from ipmlang.formats.mesh_types import Mesh, MeshScene
from ipmlang.inverse.frames import Floats

_STATED = (".glb", ".gltf", ".dae")  # their readers turn what they read to z-up
_USUAL_Y = (".obj",)
_GROUND = 0.01  # how near to 0 the ground is, as a share of the height


def upward(
    path: Path, scene: MeshScene, up: Literal["auto", "y", "z"]
) -> tuple[bool, tuple[Note, ...]]:
    """Whether y is up, and a note where that was guessed."""
    suffix = path.suffix.lower()
    if suffix in _STATED:
        return up == "y", ()
    if up != "auto":
        return up == "y", ()
    ground = _ground(scene)
    y_up = ground == "y" if ground else suffix in _USUAL_Y
    reason = f"its ground lies at {ground} = 0" if ground else f"as in most {suffix[1:]} files"
    return y_up, (Note("up", f"{'y' if y_up else 'z'} was taken to be up, {reason}"),)


def _ground(scene: MeshScene) -> str:
    """`y` or `z` if the model stands where that is 0 and not where the other is; else nothing."""
    boxes = np.array(
        [
            [points.min(axis=0), points.max(axis=0)]
            for row, number in enumerate(scene.mesh.tolist())
            if len(points := _points(scene.meshes[number], scene.matrix[row]))
        ]
    )
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    stands = [bool(abs(low[axis]) <= _GROUND * (high[axis] - low[axis])) for axis in (1, 2)]
    return "y" if stands == [True, False] else "z" if stands == [False, True] else ""


def _points(mesh: Mesh, matrix: Floats) -> Floats:
    """The corners of all faces in the world."""
    return np.asarray(mesh.vertices[mesh.corners] @ matrix[:, :3].T + matrix[:, 3])
