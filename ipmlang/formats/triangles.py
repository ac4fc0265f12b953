"""Polygons in space cut into triangles, many at once: convex ones as fans, others by ear.

Takes corners of faces over shared vertices; gives triangles of corner numbers that keep the way
round. Faces are flat or nearly so; none is checked for crossing itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_HOLLOW = -1e-9  # how far a corner may turn inward, as a share of the face's area: rounding
_BATCH = 1_000_000  # corners looked at at a time


def cut_faces(vertices: Floats, corners: Indices, offsets: Indices) -> tuple[Indices, Indices]:
    """Corner numbers (t, 3) of triangles that cover the faces, and the face of each (t,).

    vertices (v, 3), corners (c,), offsets (f + 1,) as in `Mesh`.
    """
    counts = np.diff(offsets)
    hollow = _hollow(vertices, corners, offsets, np.flatnonzero(counts > 3))
    simple = np.maximum(counts - 2, 0)
    simple[hollow] = 0
    face = np.repeat(np.arange(len(counts)), simple)
    step = np.arange(len(face)) - np.repeat(np.cumsum(simple) - simple, simple)
    first = offsets[face]
    fans = np.stack([first, first + step + 1, first + step + 2], axis=1)
    if not len(hollow):
        return fans, face
    parts, owners = [fans], [face]
    for index in hollow.tolist():
        begin, end = offsets[index : index + 2].tolist()
        cut = ears(vertices[corners[begin:end]])
        parts.append(cut + begin)
        owners.append(np.full(len(cut), index))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(parts)[order], owner[order]


def _hollow(vertices: Floats, corners: Indices, offsets: Indices, faces: Indices) -> Indices:
    """Those of the faces that turn inward at some corner, so that a fan would not cover them."""
    ends = np.cumsum(np.diff(offsets)[faces])
    pieces = np.searchsorted(ends, np.arange(_BATCH, ends[-1] if len(ends) else 0, _BATCH))
    found = [
        part[_turns_inward(vertices, corners, offsets, part)]
        for part in np.split(faces, pieces)
        if len(part)
    ]
    return np.concatenate([np.zeros(0, np.int64), *found])


def _turns_inward(
    vertices: Floats, corners: Indices, offsets: Indices, faces: Indices
) -> NDArray[np.bool_]:
    sizes = np.diff(offsets)[faces]
    begins = np.cumsum(sizes) - sizes
    face = np.repeat(np.arange(len(faces)), sizes)
    place = np.arange(len(face))
    after, before = place + 1, place - 1
    after[begins + sizes - 1], before[begins] = begins, begins + sizes - 1
    points = vertices[corners[np.repeat(offsets[faces] - begins, sizes) + place]]
    points = points - points[begins][face]
    normal = np.add.reduceat(_cross(points, points[after]), begins, axis=0)
    turn = _cross(points - points[before], points[after] - points)
    inward = np.minimum.reduceat(np.einsum("ci,ci->c", turn, normal[face]), begins)
    result: NDArray[np.bool_] = inward < _HOLLOW * np.einsum("fi,fi->f", normal, normal)
    return result


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross products of rows."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def ears(points: Floats, ends: Indices | None = None) -> Indices:
    """Triangles (t, 3) of a polygon (m, 3), oriented as it is. `ends`: where each of its rings ends
    if it has holes; the first is its outline.
    """
    import mapbox_earcut

    ends = np.array([len(points)]) if ends is None else ends
    outline = points[: ends[0]] - points[0]
    sums = outline[:-1].T @ outline[1:]  # the last corner's step ends at the first, which is 0
    normal = (sums - sums.T)[[1, 2, 0], [2, 0, 1]]
    axis = int(np.argmax(np.abs(normal)))
    one, other = (axis + 1) % 3, (axis + 2) % 3
    flat = points[:, [one, other] if normal[axis] >= 0 else [other, one]]
    found = mapbox_earcut.triangulate_float64(np.ascontiguousarray(flat), ends.astype(np.uint32))
    cut = np.asarray(found, np.int64).reshape(-1, 3)
    if not len(cut):  # a face without area still has its corners
        steps = np.arange(1, ends[0] - 1)
        return np.stack([np.zeros_like(steps), steps, steps + 1], axis=1)
    triangle = flat[cut]
    ab, ac = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    return np.where((area < 0)[:, None], cut[:, ::-1], cut)
