"""Points that rings do not need, and rings that touch, taken apart into rings that do not.

Rings of point numbers come in, outlines counter-clockwise and holes clockwise; edges that run both
ways cancel, and what is left is walked with the inside on the left. Points are never made or moved;
rings that cross are refused.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ipmlang.geometry.solid import Floats, GeometryError, Indices

Marks = NDArray[np.bool_]
Ring = list[int]
Edge = tuple[int, int]


def loops_of(flat: Floats, rings: Sequence[Indices], near: float) -> list[Ring]:
    """The loops (of point numbers) around what the rings bound; `flat` (n, 2) has all points.

    Places nearer than `near` are one. Raises `GeometryError` where rings cross or where two run
    the same way along one edge.
    """
    start = np.concatenate(rings)
    end = np.concatenate([np.roll(ring, -1) for ring in rings])
    _refuse_crossings(flat, start, end, near)
    one = _merged(flat, start, near)
    return _walked(flat, _cancelled(flat, _noded(flat, one, start, end, near)))


def _refuse_crossings(flat: Floats, start: Indices, end: Indices, near: float) -> None:
    import shapely

    lines = shapely.linestrings(np.stack([flat[start], flat[end]], axis=1))
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    first, second = first[first < second], second[first < second]
    sides = np.stack([
        _side(flat[start[first]], flat[end[first]], flat[start[second]]),
        _side(flat[start[first]], flat[end[first]], flat[end[second]]),
        _side(flat[start[second]], flat[end[second]], flat[start[first]]),
        _side(flat[start[second]], flat[end[second]], flat[end[first]]),
    ])  # fmt: skip
    crossing = (sides[0] * sides[1] < 0) & (sides[2] * sides[3] < 0)
    crossing &= (np.abs(sides) > near).all(axis=0)
    if crossing.any():
        place = int(np.argmax(crossing))
        share = sides[2, place] / (sides[2, place] - sides[3, place])
        a, b = flat[start[first[place]]], flat[end[first[place]]]
        x, y = a + share * (b - a)
        raise GeometryError(
            f"the polygon crosses itself at ({x:.6g}, {y:.6g})",
            "put the points in the order in which they follow each other around the outline",
        )


def _side(start: Floats, end: Floats, point: Floats) -> Floats:
    """How far points lie to the left of lines."""
    line, to = end - start, point - start
    cross = line[:, 0] * to[:, 1] - line[:, 1] * to[:, 0]
    found: Floats = cross / np.maximum(np.hypot(*line.T), np.finfo(np.float64).tiny)
    return found


def _merged(flat: Floats, used: Indices, near: float) -> Indices:
    """For each point the number of the first one at its place."""
    import shapely

    spots = shapely.points(flat[used])
    this, other = shapely.STRtree(spots).query(spots, predicate="dwithin", distance=near)
    one = np.arange(len(flat))
    np.minimum.at(one, used[this], used[other])
    return one


def _noded(
    flat: Floats, one: Indices, start: Indices, end: Indices, near: float
) -> list[Edge]:  # fmt: skip
    """The edges, cut at each point that lies on them."""
    import shapely

    lines = shapely.linestrings(np.stack([flat[start], flat[end]], axis=1))
    marks = np.unique(one[start])
    spots = shapely.points(flat[marks])
    edge, mark = shapely.STRtree(spots).query(lines, predicate="dwithin", distance=near)
    on: dict[int, list[int]] = defaultdict(list)
    for which, spot in zip(edge.tolist(), marks[mark].tolist(), strict=True):
        on[which].append(spot)
    found: list[Edge] = []
    for which, (a, b) in enumerate(zip(one[start].tolist(), one[end].tolist(), strict=True)):
        between = {spot for spot in on[which] if spot not in (a, b)}
        stops = [a, *_in_order(flat, a, b, between), b]
        found += [(u, v) for u, v in pairwise(stops) if u != v]
    return found


def _in_order(flat: Floats, a: int, b: int, spots: set[int]) -> list[int]:
    return sorted(spots, key=lambda spot: float((flat[spot] - flat[a]) @ (flat[b] - flat[a])))


def _cancelled(flat: Floats, edges: list[Edge]) -> list[Edge]:
    """The edges without those that run both ways."""
    counts: dict[Edge, int] = defaultdict(int)
    for edge in edges:
        counts[edge] += 1
    left = [(edge, n - counts.get(edge[::-1], 0)) for edge, n in counts.items()]
    for edge, count in left:
        if count > 1:
            x, y = flat[list(edge)].mean(axis=0)
            raise GeometryError(
                f"the polygon runs twice along its edge at ({x:.6g}, {y:.6g})",
                "leave one of the two out",
            )
    return [edge for edge, count in left if count == 1]


def _walked(flat: Floats, edges: list[Edge]) -> list[Ring]:
    """Closed walks along the edges that keep the inside, on the left, in one part."""
    out: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        out[a].append(b)
    loops: list[Ring] = []
    left = set(edges)
    for edge in edges:
        if edge not in left:
            continue
        loop: Ring = []
        step: Edge | None = edge
        while step in left and step is not None:
            left.discard(step)
            loop.append(step[0])
            ways = [b for b in out[step[1]] if (step[1], b) in left]
            step = (step[1], _leftmost(flat, step, ways)) if ways else None
        loops.append(loop)
    return loops


def _leftmost(flat: Floats, step: Edge, ways: list[int]) -> int:
    """The way on that leaves no other way between itself and the way back, on the left."""
    if len(ways) == 1:
        return ways[0]
    forth = flat[ways] - flat[step[1]]
    back = flat[step[0]] - flat[step[1]]
    angles = np.arctan2(back[1], back[0]) - np.arctan2(forth[:, 1], forth[:, 0])
    return ways[int(np.argmin(np.mod(angles, 2 * np.pi)))]


def simple_loops(flat: Floats, loops: list[Ring]) -> list[Ring]:
    """Loops cut where they pass a point again, so that each passes it once; those without area
    fall away.
    """
    found: list[Ring] = []
    for loop in loops:
        path: Ring = []
        for point in loop:
            if point in path:
                place = path.index(point)
                found.append(path[place:])
                del path[place:]
            path.append(point)
        found.append(path)
    return [ring for ring in found if len(ring) > 2 and _area(flat[ring]) != 0.0]


def nest(flat: Floats, loops: list[Ring]) -> list[list[Ring]]:
    """Faces of simple loops: each counter-clockwise one with the clockwise ones inside it.

    Raises `GeometryError` where a hole lies outside, or an outline inside a hole's edge.
    """
    import shapely

    outer = [ring for ring in loops if _area(flat[ring]) > 0]
    inner = [ring for ring in loops if _area(flat[ring]) < 0]
    faces: list[list[Ring]] = [[ring] for ring in outer]
    shapes = [shapely.Polygon(flat[ring]) for ring in outer]
    for hole in inner:
        shape = shapely.Polygon(flat[hole])
        around = [k for k, each in enumerate(shapes) if each.covers(shape)]
        if not around:
            x, y = flat[hole].mean(axis=0)
            raise GeometryError(
                f"a hole, about ({x:.6g}, {y:.6g}), lies outside the outline",
                "the first ring is the outline; a second building is a polygon of its own",
            )
        faces[min(around, key=lambda k: shapes[k].area)].append(hole)
    _refuse_nested(flat, faces)
    return faces


def _refuse_nested(flat: Floats, faces: list[list[Ring]]) -> None:
    import shapely

    shapes = [shapely.Polygon(flat[f[0]], [flat[hole] for hole in f[1:]]) for f in faces]
    sound = all(shape.is_valid for shape in shapes)
    if not sound or shapely.union_all(shapes).area < (1 - 1e-9) * sum(s.area for s in shapes):
        x, y = flat[faces[0][0]].mean(axis=0)
        raise GeometryError(
            f"rings lie on each other in the polygon about ({x:.6g}, {y:.6g})",
            "holes lie inside the outline, and beside each other",
        )


def _area(ring: Floats) -> float:
    x, y = (ring - ring[0]).T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2


# --- points that a ring does not need -------------------------------------------------------------


def repeated(points: Floats, near: float) -> Marks:
    """Which points (n, 2) of a ring are at the place of the one before; the first stays where all
    are.
    """
    step = points - np.roll(points, 1, axis=0)
    found: Marks = np.hypot(*step.T) <= near
    if found.all():
        found[:1] = False
    return found


def spikes(points: Floats, near: float) -> Marks:
    """Which points of a ring are where it turns back on itself; of neighbours only the first."""
    drop: Marks = np.zeros(len(points), np.bool_)
    if len(points) < 3:
        return drop
    back, forth = np.roll(points, 1, axis=0) - points, np.roll(points, -1, axis=0) - points
    lengths = np.stack([np.hypot(*back.T), np.hypot(*forth.T)])
    width = np.abs(back[:, 0] * forth[:, 1] - back[:, 1] * forth[:, 0])
    off = width / np.maximum(lengths.max(axis=0), np.finfo(np.float64).tiny)
    found = (off <= near) & ((back * forth).sum(axis=1) > 0)
    for place in np.flatnonzero(found):
        drop[place] = not drop[place - 1] and not drop[(place + 1) % len(points)]
    return drop


def bends(points: Floats, before: Floats, after: Floats, near: Floats) -> Marks:
    """Which points (n, 2) a ring needs, by the points before and after each and how near is one
    place: those that are neither `repeated` nor `spikes`, and do not lie on a straight line.
    """
    back, forth = before - points, after - points
    lengths = np.stack([np.hypot(*back.T), np.hypot(*forth.T)])
    width = np.abs(back[:, 0] * forth[:, 1] - back[:, 1] * forth[:, 0])
    longer = np.maximum(lengths.max(axis=0), np.finfo(np.float64).tiny)
    spike = (width / longer <= near) & ((back * forth).sum(axis=1) > 0)
    found: Marks = (lengths[0] > near) & ~spike & (_off(points, before, after) > near)
    return found


def straight(points: Floats, near: float) -> Marks:
    """Which points of a ring lie within `near` of the straight line between those that stay."""
    back, forth = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    drop: Marks = np.asarray(_off(points, back, forth) <= near, np.bool_)
    if drop.all():  # a fine circle: start from any two points far apart
        drop[int(points[:, 0].argmin())] = False
    if drop.sum() == len(points) - 1:
        away = points - points[~drop]
        drop[int(np.hypot(*away.T).argmax())] = False
    corners = np.flatnonzero(~drop)
    for start, end in zip(corners, np.roll(corners, -1), strict=True):
        _keep_bends(points, int(start), int(end), near, drop)
    return drop


def _keep_bends(points: Floats, start: int, end: int, near: float, drop: Marks) -> None:
    """Many points that each bend a little may bend much together: keep the one farthest off."""
    count = len(points)
    runs = [(start, end if end > start else end + count)]
    while runs:
        first, last = runs.pop()
        between = np.arange(first + 1, last) % count
        if not len(between):
            continue
        off = _off(points[between], points[first % count], points[last % count])
        far = int(off.argmax())
        if off[far] > near:
            drop[between[far]] = False
            runs += [(first, first + 1 + far), (first + 1 + far, last)]


def _off(points: Floats, start: Floats, end: Floats) -> Floats:
    """How far points lie from the line of two others each."""
    line, to = end - start, points - start
    length = np.maximum(np.hypot(line[..., 0], line[..., 1]), np.finfo(np.float64).tiny)
    off: Floats = np.abs(line[..., 0] * to[..., 1] - line[..., 1] * to[..., 0]) / length
    return off
