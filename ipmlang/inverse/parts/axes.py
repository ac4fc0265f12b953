"""A building's own axes: how far it stands turned about the vertical.

Takes the faces of a model, z up; gives degrees, and the faces turned. Level edges vote with their
length for the direction that they have, modulo a quarter turn. A model that keeps to the world's
axes about as well as to its own counts as straight. Nothing here looks at parts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ipmlang.formats.mesh_types import Mesh
from ipmlang.inverse.frames import Floats

QUARTER = 90.0
LEVEL = 1e-4  # slope up to which an edge is level
BINS = 4500  # of directions in a quarter turn
FEWEST = 0.25  # share of the level length that follows the building's own axes, at least
BETTER = 2.0  # times as much as follows the world's


def askew(mesh: Mesh) -> float:
    """Degrees, above -45 and up to 45, by which a model is turned to the left; 0 if it is not."""
    angle, length = _level_edges(mesh)
    if not len(angle):
        return 0.0
    votes = np.bincount(np.rint(angle / QUARTER * BINS).astype(np.int64) % BINS, length, BINS)
    votes += np.roll(votes, 1) + np.roll(votes, -1)
    best = int(np.argmax(votes > (1 - 1e-6) * votes.max()))
    if votes[best] < max(FEWEST * length.sum(), BETTER * votes[0]):
        return 0.0
    return _refined(angle, length, best * QUARTER / BINS)


def straightened(mesh: Mesh, degrees: float) -> Mesh:
    """The faces turned to the right by degrees about the vertical through the origin."""
    return replace(mesh, vertices=mesh.vertices @ _turn(degrees), normals=_normals(mesh, degrees))


def _normals(mesh: Mesh, degrees: float) -> Floats | None:
    return None if mesh.normals is None else mesh.normals @ _turn(degrees)


def _turn(degrees: float) -> Floats:
    """(3, 3) what rows are multiplied with to turn to the right."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _level_edges(mesh: Mesh) -> tuple[Floats, Floats]:
    """(e,) degrees in a quarter turn, and lengths, of all level edges of all faces."""
    counts = np.diff(mesh.offsets)
    following = np.arange(1, len(mesh.corners) + 1)
    following[mesh.offsets[1:][counts > 0] - 1] = mesh.offsets[:-1][counts > 0]
    points = mesh.vertices[mesh.corners]
    away = points[following] - points
    length = np.hypot(away[:, 0], away[:, 1])
    level = (length > 0) & (np.abs(away[:, 2]) <= LEVEL * length)
    away, length = away[level], length[level]
    return np.degrees(np.arctan2(away[:, 1], away[:, 0])) % QUARTER, length


def _refined(angle: Floats, length: Floats, near: float) -> float:
    """The direction of the edges near to one, where long ones say it better."""
    off = (angle - near + QUARTER / 2) % QUARTER - QUARTER / 2
    width = 1.5 * QUARTER / BINS
    middle = 0.0
    for _ in range(4):
        own = np.abs(off - middle) <= width
        middle = float(np.average(off[own], weights=length[own] ** 2))
        width = max(width / 4, 3 * float(np.median(np.abs(off[own] - middle))))
    found = (near + middle) % QUARTER
    return found - QUARTER if found > QUARTER / 2 else found
