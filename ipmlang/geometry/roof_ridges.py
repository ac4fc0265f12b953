"""Which way a roof's ridge runs, and which edges of a footprint bear its gables.

In go the clean rings of a footprint; out come a direction and numbers of edges. It builds nothing.
"""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.skeleton import skeleton_of
from ipmlang.geometry.skeleton_rings import Ring, directions
from ipmlang.geometry.solid import Floats

Marks = NDArray[np.bool_]
STRAIGHT = 1e-6  # the sine up to which two edges are one side of a building
FACING = -0.6  # the cosine up to which the two sides beside a gable face each other
ACROSS = (0.5, 0.766)  # cosines to the ridge that a gable may have: 60 degrees, else 40


def direction(degrees: float) -> tuple[float, float]:
    """The unit vector at an angle from the x axis."""
    return cos(radians(degrees)), sin(radians(degrees))


def longest_direction(outline: Floats) -> tuple[float, float]:
    """Along the longer side of the smallest box around an outline (n, 2); a square's first side."""
    along = directions(outline)
    on = outline @ along.T
    across = outline @ np.stack([-along[:, 1], along[:, 0]])
    width, depth = np.ptp(on, axis=0), np.ptp(across, axis=0)
    areas = width * depth
    best = int(np.flatnonzero(areas <= areas.min() * (1 + 1e-9))[0])
    x, y = along[best].tolist()
    return (x, y) if width[best] >= depth[best] * (1 - 1e-9) else (-y, x)


def gable_edges(rings: list[Ring], ridge: float | None) -> set[int]:
    """The edges of the outline, by the numbers they bear, that have gables; never two that touch.

    Without a direction (degrees) each wing ends in a gable: every side whose face in a hip roof
    is a triangle between sides that face each other. With one, or where there is neither a wing
    nor a courtyard, those between convex corners that run across the ridge, the most exactly first.
    """
    outline = rings[0]
    sides = _sides(outline.points)
    corners = outline.points[[side[0] for side in sides]]
    along = directions(corners)
    chosen = direction(ridge) if ridge is not None else longest_direction(corners)
    slant = np.abs(along @ np.array(chosen))
    turn = _cross(np.roll(along, 1, axis=0), along)
    convex = (turn > 0) & (np.roll(turn, -1) > 0)
    if len(sides) == 4 and len(rings) == 1 and convex.all():
        (marks,) = gables_of_four(corners[None], np.array([np.nan if ridge is None else ridge]))
        return {outline.edges[k] for side in np.flatnonzero(marks).tolist() for k in sides[side]}
    picked: list[int] = []
    if ridge is None:
        facing = (
            np.einsum("ij,ij->i", np.roll(along, 1, axis=0), np.roll(along, -1, axis=0)) < FACING
        )
        own = [outline.edges[side[0]] for side in sides]
        numbers = 1 + max(edge for ring in rings for edge in ring.edges)
        faces = skeleton_of([Ring(corners, own), *rings[1:]], [1.0] * numbers).faces
        triangular = np.array([len(faces[edge]) == 3 for edge in own])
        picked = _apart(convex & facing & triangular, slant, along)
    for limit in ACROSS if ridge is not None or len(rings) == 1 else ():
        picked = picked or _apart(convex & (slant <= limit), slant, along)
    return {outline.edges[k] for side in picked for k in sides[side]}


def gables_of_four(corners: Floats, ridge: Floats) -> Marks:
    """What `gable_edges` gives of many convex quadrilaterals (n, 4, 2) without courtyards, as marks
    (n, 4); ridge (n,), NaN for none.
    """
    step = np.roll(corners, -1, axis=1) - corners
    along = step / np.hypot(step[..., 0], step[..., 1])[..., None]
    free = np.isnan(ridge)
    given = np.stack([np.cos(np.radians(ridge)), np.sin(np.radians(ridge))], axis=1)
    chosen = np.where(free[:, None], _longest_directions(corners, along), given)
    slant = np.abs(_dot(along, chosen[:, None]))
    facing = _dot(np.roll(along, 1, axis=1), np.roll(along, -1, axis=1)) < FACING
    found = _apart_of_four(facing & _triangles_of_four(corners) & free[:, None], slant, along)
    for limit in ACROSS:
        none = ~found.any(axis=1, keepdims=True)
        found |= none & _apart_of_four(slant <= limit, slant, along)
    return found


def _longest_directions(corners: Floats, along: Floats) -> Floats:
    """`longest_direction` of each outline (n, 4, 2)."""
    on = _dot(corners[:, :, None], along[:, None])
    across = _cross(along[:, None], corners[:, :, None])
    width, depth = np.ptp(on, axis=1), np.ptp(across, axis=1)
    areas = width * depth
    best = (areas <= areas.min(axis=1, keepdims=True) * (1 + 1e-9)).argmax(axis=1)
    rows = np.arange(len(best))
    way = along[rows, best]
    wide = width[rows, best] >= depth[rows, best] * (1 - 1e-9)
    turned = np.stack([-way[:, 1], way[:, 0]], axis=1)
    return np.where(wide[:, None], way, turned)


def _apart_of_four(sides: Marks, slant: Floats, along: Floats) -> Marks:
    """As `_apart`, of four sides each: the most upright one on the ridge, and the one across, but
    where both are in one row that bends little by little.
    """
    upright = np.where(sides, np.round(slant, 6), np.inf)
    best = upright.argmin(axis=1)
    rows = np.arange(len(best))
    across = (best + 2) % 4
    row = sides[rows, (best + 1) % 4] | sides[rows, (best + 3) % 4]
    bends = _dot(along[rows, best], along[rows, across]) > 0
    found = np.zeros(sides.shape, np.bool_)
    found[rows, best] = sides[rows, best]
    found[rows, across] = sides[rows, across] & ~(row & bends)
    return found


def _triangles_of_four(corners: Floats) -> Marks:
    """Whose faces of a hip roof over convex quadrilaterals (n, 4, 2) are triangles: the edge that
    the wavefront uses up first, and the one across, since a triangle is left then. All four where
    they are used up at once.
    """
    along = np.roll(corners, -1, axis=1) - corners
    length = np.sqrt(_dot(along, along))
    back = -np.roll(along, 1, axis=1)
    # the cotangent of half an angle between two vectors is (|a| |b| + a.b) / |a x b|
    product = length * np.roll(length, 1, axis=1)
    cotangent = (product + _dot(along, back)) / np.abs(_cross(along, back))
    time = length / (cotangent + np.roll(cotangent, -1, axis=1))
    first = time <= time.min(axis=1, keepdims=True) * (1 + 1e-9)
    return np.asarray(first | np.roll(first, 2, axis=1))


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _sides(outline: Floats) -> list[list[int]]:
    """Edges that follow each other in one line, together."""
    along = directions(outline)
    before = np.roll(along, 1, axis=0)
    bends = (np.abs(_cross(before, along)) > STRAIGHT) | ((before * along).sum(axis=1) < 0)
    starts = np.flatnonzero(bends).tolist()
    count = len(outline)
    return [
        [k % count for k in range(start, start + ((end - start) % count or count))]
        for start, end in zip(starts, starts[1:] + starts[:1], strict=True)
    ]


def _apart(sides: Marks, slant: Floats, along: Floats) -> list[int]:
    """Of some sides those that stand apart, the most upright on the ridge before the others.

    Of a row of such sides that bends little by little, as on a round building, there is only one.
    """
    row = np.cumsum(~sides)
    row[row == row[-1]] = 0  # the last row runs on into the first
    picked: list[int] = []
    for side in sorted(
        np.flatnonzero(sides).tolist(), key=lambda k: (round(float(slant[k]), 6), k)
    ):
        if not any(
            (side - other) % len(slant) in (1, len(slant) - 1)
            or (row[side] == row[other] and along[side] @ along[other] > 0)
            for other in picked
        ):
            picked.append(side)
    return picked
