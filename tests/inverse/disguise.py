"""Buildings made unrecognisable: triangles in any order, turned, without a name.

In goes a grammar that an author wrote, out comes the model it draws as a bare OBJ, so that all an
inference can go by is geometry. `apart` says how far two bags of triangles are from each other; it
shares nothing with the proof of the product.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import ipmlang
from ipmlang.formats.mesh_batches import world_triangles
from ipmlang.runtime.export.models import mesh_scene_of

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
TURN = 33.69  # degrees that a building is turned by: no part of it stays along an axis


def model_of(path: Path) -> tuple[Floats, Integers]:
    """Vertices (v, 3), each terminal's its own, and triangles (t, 3) that a grammar draws."""
    vertices, triangles = world_triangles(mesh_scene_of(ipmlang.load(path).run()), "z-up")[:2]
    return np.asarray(vertices, np.float64), np.asarray(triangles, np.int64)


def triangles_of(path: Path) -> Floats:
    """(t, 3, 3) all triangles of an OBJ file, by the plainest of readers: `v` and `f` lines."""
    points: list[list[float]] = []
    corners: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append([float(each) for each in rest[:3]])
        elif word == "f":
            ring = [int(each.split("/")[0]) - 1 for each in rest]
            corners += [(ring[0], *edge) for edge in pairwise(ring[1:])]
    return np.array(points)[np.array(corners, np.int64)]


def disguised(vertices: Floats, triangles: Integers, seed: int, degrees: float, weld: bool) -> str:
    """The OBJ of the same triangles: shuffled, each from another of its corners on, turned about z
    by an angle in degrees, moved. weld: what stands in one place is one vertex, whosever it is.
    """
    draw = np.random.default_rng(seed)
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    points = (vertices @ turn.T + [3.25, -1.5, 0.5]).round(9)
    corners = triangles[draw.permutation(len(triangles))]
    first = draw.integers(0, 3, len(corners))
    corners = corners[np.arange(len(corners))[:, None], (first[:, None] + np.arange(3)) % 3]
    if weld:
        points, same = np.unique(points, axis=0, return_inverse=True)
        corners = same.reshape(-1)[corners]
    order = draw.permutation(len(points))
    number = np.argsort(order)[corners] + 1
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in points[order].tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in number.tolist()]
    return "\n".join(lines) + "\n"


def apart(first: Floats, second: Floats) -> float:
    """How far the triangles (t, 3, 3) of two bags are from those of the other at most, infinite
    where one has more: corners of a triangle may begin anywhere, its winding may not change.
    """
    if len(first) != len(second):
        return float("inf")
    ours, theirs = _points(first), _points(second)
    of_ours, of_theirs = cKDTree(ours), cKDTree(theirs)
    there, back = of_theirs.query(ours, p=np.inf)[0], of_ours.query(theirs, p=np.inf)[0]
    far = float(max(np.max(there, initial=0.0), np.max(back, initial=0.0)))
    near = max(far, 1e-9) * 2
    count = [tree.query_ball_point(ours, near, p=np.inf, return_length=True)
             for tree in (of_ours, of_theirs)]  # fmt: skip
    return far if np.array_equal(*count) else float("inf")


def _points(triangles: Floats) -> Floats:
    """(t, 9) each triangle from the corner on that lies farthest along a direction of no edge."""
    along = triangles @ np.array([0.6180339887, 0.4142135623, 0.7320508075])
    first = np.argmax(along, axis=1)
    rows = np.arange(len(first))[:, None]
    return np.asarray(triangles[rows, (first[:, None] + np.arange(3)) % 3].reshape(-1, 9))
