"""Hip and gable roofs over many convex quadrilaterals at once, which most lots of a town are.

In go polygons with an angle and an overhang each; out come the roofs that `roofs` makes. Over a
convex quadrilateral the wavefront has two moments only: the edge that is used up first, then the
one across, when the three lines left meet. What is near a tie, a fold or any other shape is left
out, for the general algorithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import tan

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.roof_base import FLAT, Eaves, Footprint
from ipmlang.geometry.roof_ridges import gables_of_four
from ipmlang.geometry.roofs import roofed
from ipmlang.geometry.skeleton import Skeleton
from ipmlang.geometry.skeleton_rings import Ring
from ipmlang.geometry.solid import Floats, Indices, Solid, reshaped

Marks = NDArray[np.bool_]

BENT = 1e-3  # the least sine at a corner
CLEAR = 1e-4  # of the polygon's size: the shortest edge, and the shortest ridge
APART = 1e-6  # of a moment: how much later the other edges must be used up
# of an edge that is used up first: the faces of it and of those after it, over the corners 0 to 3
# that begin with its own, and the ends of the ridge, 4 and 5
_FACES = ((0, 1, 4), (1, 2, 5, 4), (2, 3, 5), (3, 0, 4, 5))


def roofs(
    polygons: Sequence[Solid], degrees: Floats, overhang: Floats, ridge: Floats, *, gabled: bool
) -> list[Solid | None]:
    """What `roof_hip`, or `roof_gable` where `gabled`, makes of each polygon; degrees, overhang and
    ridge (n,), NaN for no ridge. None for what is no plain convex quadrilateral.

    >>> from ipmlang.geometry.solid import polygon, volume
    >>> lot, none = polygon([(0, 0), (4, 0), (4, 2), (0, 2)]), np.array([np.nan])
    >>> (roof,) = roofs([lot], np.array([45.0]), np.zeros(1), none, gabled=False)
    >>> len(roof), round(volume(roof), 9)
    (5, 3.333333333)
    """
    found: list[Solid | None] = [None] * len(polygons)
    places, corners, level = _quadrilaterals(polygons)
    known = (degrees > 0) & (degrees < 90) & np.isfinite(overhang) & (overhang >= 0)
    known &= ~np.isinf(ridge)
    keep = known[places]
    places, corners, level = places[keep], corners[keep], level[keep]
    if not len(places):
        return found
    slope = np.array([tan(each) for each in np.radians(degrees[places]).tolist()])
    upright = np.zeros((len(places), 4), np.bool_)
    if gabled:
        upright = gables_of_four(corners, ridge[places])
    reach = overhang[places]
    around = _moved_out(corners, reach)
    speeds = np.where(upright, 0.0, 1 / slope[:, None])
    ridges, first, sound = _ridges(around, speeds)
    drop = reach * slope
    kind = first * 32 + (upright @ np.array([1, 2, 4, 8])) * 2 + (drop > 0)
    vertices = _vertices(around, ridges, corners, level, drop)
    for each in sorted(set(kind[sound].tolist())):
        some = np.flatnonzero(sound & (kind == each)).tolist()
        one = some[0]
        made = _example(corners[one], around[one], ridges[one], int(first[one]),
                        speeds[one].tolist(), float(drop[one]))  # fmt: skip
        for row in some:
            own = vertices[row] if drop[row] > 0 else vertices[row, :6]
            found[places[row]] = reshaped(made, own)
    return found


def _quadrilaterals(polygons: Sequence[Solid]) -> tuple[Indices, Floats, Floats]:
    """The places of those that are level convex quadrilaterals, their corners (n, 4, 2), and z."""
    four = [
        place
        for place, each in enumerate(polygons)
        if len(each) == 1 and len(each.corners) == 4 and len(each.rings) == 2
    ]
    if not four:
        return np.zeros(0, np.int64), np.zeros((0, 4, 2)), np.zeros(0)
    points = np.stack([polygons[place].vertices[polygons[place].corners] for place in four])
    low, high = points.min(axis=1), points.max(axis=1)
    size = (high - low).max(axis=1)
    flat = points[:, :, :2]
    along, length = _directions(flat)
    sound = (high - low)[:, 2] <= FLAT * size
    sound &= (length > CLEAR * size[:, None]).all(axis=1)
    sound &= (_cross(_before(along), along) > BENT).all(axis=1)
    sound &= _cross(flat[:, 2] - flat[:, 0], flat[:, 3] - flat[:, 1]) > 0  # once around, not twice
    return np.array(four)[sound], flat[sound], low[sound, 2]


def _directions(corners: Floats) -> tuple[Floats, Floats]:
    """Of each edge the unit vector along it (n, 4, 2) and its length (n, 4)."""
    step = _after(corners) - corners
    length = np.hypot(step[..., 0], step[..., 1])
    return step / np.where(length > 0, length, 1.0)[..., None], length


def _before(each: Floats) -> Floats:
    return np.roll(each, 1, axis=1)


def _after(each: Floats) -> Floats:
    return np.roll(each, -1, axis=1)


def _cross(a: Floats, b: Floats) -> Floats:
    found: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return found


def _moved_out(corners: Floats, distance: Floats) -> Floats:
    """The corners when all edges have moved outwards by a distance (n,)."""
    along, _ = _directions(corners)
    last = _before(along)
    # both lines move: the corner goes along the difference of their directions, over their sine
    away = (last - along) / _cross(last, along)[..., None]
    return corners + away * distance[:, None, None]


def _ridges(corners: Floats, speeds: Floats) -> tuple[Floats, Indices, Marks]:
    """Both ends of each ridge (n, 2, 3), x, y and time; the edge (n,) that is used up first; and
    where nothing else happens at about that time.
    """
    along, length = _directions(corners)
    last, slow = _before(along), _before(speeds)
    moves = (slow[..., None] * along - speeds[..., None] * last) / _cross(last, along)[..., None]
    closing = -((_after(moves) - moves) * along).sum(axis=2)
    size = np.ptp(corners, axis=1).max(axis=1)
    fast = closing > CLEAR * speeds.max(axis=1)[:, None]
    time = np.where(fast, length / np.where(fast, closing, 1.0), np.inf)
    first = time.argmin(axis=1)
    rows = np.arange(len(first))
    ends = np.empty((len(first), 2, 3))
    for place in (0, 1):
        edge = (first + 2 * place) % 4
        own = np.where(np.isfinite(time), time, 0.0)[rows, edge]
        ends[:, place, :2] = corners[rows, edge] + moves[rows, edge] * own[:, None]
        ends[:, place, 2] = own
    later = np.minimum(time[rows, (first + 1) % 4], time[rows, (first + 3) % 4])
    sound = np.isfinite(time[rows, (first + 2) % 4]) & (later > time.min(axis=1) * (1 + APART))
    sound &= np.hypot(*(ends[:, 1, :2] - ends[:, 0, :2]).T) > CLEAR * size
    return ends, first, sound


def _vertices(
    around: Floats, ridges: Floats, corners: Floats, level: Floats, drop: Floats
) -> Floats:
    """The vertices of all roofs (n, 14, 3): at the eaves, of the ridge, and, for those that hang
    over, of the polygon and below it.
    """
    found = np.empty((len(corners), 14, 3))
    eaves = (level - drop)[:, None]
    found[:, :4, :2], found[:, :4, 2] = around, eaves
    found[:, 4:6, :2], found[:, 4:6, 2] = ridges[:, :, :2], ridges[:, :, 2] + eaves
    found[:, 6:10, :2], found[:, 6:10, 2] = corners, level[:, None]
    found[:, 10:, :2], found[:, 10:, 2] = corners, eaves
    return found


def _example(
    corners: Floats, around: Floats, ridges: Floats, first: int, speeds: list[float], drop: float
) -> Solid:
    """One roof, put together as all are: others of its kind have the same faces."""
    edges = list(range(4))
    base = Footprint([Ring(corners, edges)], 0.0, 4)
    own = Eaves([Ring(around, edges)], edges, drop)
    faces: list[list[int]] = [[], [], [], []]
    for step, face in enumerate(_FACES):
        faces[(first + step) % 4] = [k if k > 3 else (first + k) % 4 for k in face]
    flat = np.column_stack([around, np.zeros(4)])
    return roofed(base, own, Skeleton(np.concatenate([flat, ridges]), faces, {}, []), speeds)
