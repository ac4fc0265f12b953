"""Many placed things as columns: what terminals are, and frames as maps of points.

In go scenes, and frames with a row for each thing; out come boxes and matrices, a row each. What is
placed, and what made it, is not known here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipmlang.inverse.frames import Floats, Frames, linear
from ipmlang.runtime.scene import OUTLINES, SEGMENT, Scene

if TYPE_CHECKING:
    from ipmlang.formats.mesh_types import Mesh

FEW = 64  # points that are sooner looked at than enclosed


@dataclass(frozen=True, slots=True, eq=False)
class Terminals:
    """m drawn things: frames; low, high (m, 3): their boxes in their own axes; label (m,) names."""

    frames: Frames
    low: Floats
    high: Floats
    labels: tuple[str, ...]


def terminals_of(scene: Scene, meshes: Mapping[int, Mesh]) -> Terminals:
    """The terminals of a scene; meshes: of the assets that it draws, by their numbers."""
    table = scene.instances
    frames = Frames(
        np.array(table.position),
        np.array(table.rotation),
        np.where(table.scale < 0, -1.0, 1.0),
        np.abs(table.scale),
    )
    low, high = np.zeros((len(table), 3)), np.array(table.size, np.float64)
    numbers: dict[str, list[int]] = {}
    for k, label in enumerate(scene.labels):
        numbers.setdefault(label, []).append(k)
    for number, mesh in meshes.items():
        own = numbers.get(scene.assets[number].name, [])  # of other labels are those that fill
        natural = table.label == own[0] if len(own) == 1 else np.isin(table.label, own)
        rows = (table.asset == number) & natural
        low[rows], high[rows] = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    outline = np.isin(table.asset, OUTLINES)
    for shape in np.unique(table.shape[outline]).tolist():
        rows = outline & (table.shape == shape)
        points = scene.polygons[shape]
        low[rows, : points.shape[1]], high[rows, : points.shape[1]] = (
            np.nanmin(points, axis=0),
            np.nanmax(points, axis=0),
        )
    high[table.asset == SEGMENT, 1:] = 0.0
    labels = tuple(scene.labels[k] for k in table.label.tolist())
    return Terminals(frames, low, high, labels)


@dataclass(frozen=True, slots=True, eq=False)
class Maps:
    """n frames as maps of points: out, into (n, 3, 3) and origin (n, 3), such that `into @ point +
    origin` is a point of the world in the frame; turn (n, 3, 3): their axes, as columns.
    """

    turn: Floats
    out: Floats
    into: Floats
    origin: Floats

    def __getitem__(self, row: int) -> Maps:
        """Those of one, without the n."""
        return Maps(self.turn[row], self.out[row], self.into[row], self.origin[row])


def maps_of(frames: Frames) -> Maps:
    """Frames as maps of points."""
    out = linear(frames)
    turn = out / frames.scale[:, None, None]
    turn[:, :, 0] *= frames.hand[:, None]
    into = turn.transpose(0, 2, 1) / frames.scale[:, None, None]
    into[:, 0] *= frames.hand[:, None]
    return Maps(turn, out, into, np.einsum("nij,nj->ni", into, -frames.position))


def outermost(points: Floats) -> Floats:
    """Those of points (n, 3) that no others enclose, where there are many."""
    if len(points) <= FEW:
        return points
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:  # they lie in one plane
        return points


__all__ = ["Maps", "Terminals", "maps_of", "outermost", "terminals_of"]
