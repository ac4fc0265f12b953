"""Strips cut off a polygon along its edges, and polygons moved in or out by a distance.

A level polygon and distances come in, pieces come out: what is left, and the strips by the side
that they lie at. Sides are those of the polygon's scope, and nothing here knows streets.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ipmlang.geometry.claims import claims_of
from ipmlang.geometry.corners import MITRE, THIN, Edges, corners_of, edges_of
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.planar import (
    Plane,
    Rings,
    closed,
    extent,
    grid_of,
    opened,
    rings_area,
    rings_of_shape,
    shape_of,
    together,
    without,
)
from ipmlang.geometry.solid import Floats, GeometryError, Indices, Solid
from ipmlang.geometry.strips import moved_in, rest_area, strips_of

SHAPE = frozenset({"shape", "inside", "rest", "remainder"})
BORDER = frozenset({"border", "all"})
SIDES = (
    (frozenset({"front"}), "front"),
    (frozenset({"right", "side"}), "side"),
    (frozenset({"back"}), "back"),
    (frozenset({"left", "side"}), "side"),
)
"""The sides of a scope: the words of each, and which distance is its."""
EVEN = 1e-9
"""Edges whose normals are this near to a diagonal count as front or back."""


def classified_edges(polygon: Solid) -> list[frozenset[str]]:
    """The words of each edge, in the order of the corners: front, back, or left or right and side.

    An edge's side is the axis that its outward normal is nearest to; a tie is front or back. The
    edges of a hole face into it.
    """
    rings, _ = opened(polygon, "an edge's side")
    return _words(edges_of(rings))


def _words(edges: Edges) -> list[frozenset[str]]:
    sides: list[int] = sides_of(edges).tolist()
    return [SIDES[side][0] for side in sides]


def sides_of(edges: Edges) -> Indices:
    """Which of SIDES each edge lies at (n,)."""
    x, y = -edges.inward.T
    upright = np.abs(y) >= np.abs(x) * (1 - EVEN)
    found: Indices = np.where(upright, np.where(y < 0, 0, 2), np.where(x < 0, 3, 1))
    return found


def axes_of(edges: Edges) -> Floats:
    """The axes (n, 3, 3) of each edge's strip: x along the edge, y inward from it, z up."""
    found = np.zeros((len(edges.along), 3, 3))
    found[:, 0, :2], found[:, 1, :2], found[:, 2, 2] = edges.along, edges.inward, 1.0
    return found + 0.0  # no -0


def widths_of(
    edges: Edges, distance: float, front: float | None, side: float | None, back: float | None
) -> Floats:
    """The width of each edge's strip (n,)."""
    given = {"front": front, "side": side, "back": back}
    by_side = {name: distance if own is None else own for name, own in given.items()}
    for name, width in by_side.items():
        if not (np.isfinite(width) and width >= 0):
            raise GeometryError(
                f"the distance at the {name} is {width:g}, and must be 0 or more",
                "offset moves edges outward",
            )
    return np.array([by_side[name] for _, name in SIDES])[sides_of(edges)]


def setback(
    polygon: Solid,
    distance: float,
    front: float | None = None,
    side: float | None = None,
    back: float | None = None,
    area: float | None = None,
) -> list[Piece]:
    """Cut strips off along the edges: `shape` (and `inside`, `rest`, `remainder`) is what is left,
    in one or more parts, or none; `border` (and `all`) the strips, mitred, with the words of their
    sides. A strip has axes of its own: x along its edge, y inward from it.

    front, side, back: widths at those edges, where not `distance`. area: all widths are multiplied
    by what leaves this area (to 1e-9 of the whole). Raises `GeometryError` for negative widths and
    for an area that no widths leave.

    >>> from ipmlang.geometry.solid import area, unit_square
    >>> [(sorted(p.words), round(area(p.solid), 2)) for p in setback(unit_square(), 0, front=0.25)]
    [(['inside', 'remainder', 'rest', 'shape'], 0.75), (['all', 'border', 'front'], 0.25)]
    """
    rings, plane = opened(polygon, "setback")
    edges = edges_of(rings)
    widths = widths_of(edges, distance, front, side, back)
    if area is not None:
        widths = widths * _factor(rings, widths, area)
    found = strips_of(rings, widths)
    pieces = [Piece(SHAPE, closed([rest], plane)) for rest in found.rest]
    for words, axes, strips in zip(_words(edges), axes_of(edges), found.strips, strict=True):
        pieces.extend(Piece(BORDER | words, closed([strip], plane), axes) for strip in strips)
    return pieces


def _factor(rings: Rings, widths: Floats, area: float) -> float:
    """What to multiply the widths by so that the area is left."""
    whole = rings_area(rings)
    if area < 0 or area > whole * (1 + 1e-9):
        raise GeometryError(
            f"setback cannot leave an area of {area:g}: the polygon has {whole:g}",
            "ask for the area first, as in: case geometry.area > …",
        )
    widest = float(widths.max())
    if area >= whole * (1 - 1e-12):
        return 0.0
    if widest == 0.0:
        raise GeometryError(
            "setback cannot leave a given area where all distances are 0",
            "the distances say how wide the strips are in proportion",
        )

    def over(factor: float) -> float:
        return rest_area(rings, widths * factor) - area

    guess = _guess(over, float(widths @ edges_of(rings).length), whole - area)
    if abs(over(guess)) <= 1e-12 * whole:
        return guess
    most = extent(rings) / widest
    left = rest_area(rings, widths * most)
    if left > area:
        raise GeometryError(
            f"setback cannot leave an area of {area:g}: the edges it cuts along leave {left:g}",
            "give more sides a distance",
        )

    return root_of(over, (0.0, whole - area), (most, left - area), 1e-12 * whole)


def _guess(over: Callable[[float], float], loss: float, excess: float) -> float:
    """The factor if no strip ends early: the area left is then a quadratic of it, which loses at
    first as much as the edges are long.
    """
    step = excess / loss
    bend = (over(step) - excess + loss * step) / (step * step)
    root = np.sqrt(max(loss * loss - 4 * bend * excess, 0.0))
    return float(2 * excess / (loss + root))


def root_of(
    over: Callable[[float], float],
    low: tuple[float, float],
    high: tuple[float, float],
    near: float,
) -> float:
    """Where a falling function passes 0, between two points (x, value) that have it between them:
    the secant, kept inside by halving (the Illinois method), to `near` in the value or to the last
    bit in x.
    """
    (a, above), (b, below) = low, high
    kept = 0
    for step in range(200):
        share = above / (above - below) if step % 3 < 2 and above > below else 0.5
        x = a + (b - a) * share
        if not a < x < b:
            x = (a + b) / 2
        if not a < x < b:
            break
        value = over(x)
        if abs(value) <= near:
            return x
        if value > 0:
            a, above = x, value
            below = below / 2 if kept > 0 else below
            kept = 1
        else:
            b, below = x, value
            above = above / 2 if kept < 0 else above
            kept = -1
    return b


def offset(polygon: Solid, distance: float) -> list[Piece]:
    """All edges moved outward, or inward where negative, with mitred corners.

    Inward, `inside` is what is left, in one or more parts or none; outward it is the polygon grown
    by the border. `border` is what lies between the two outlines. A mitre longer than five
    distances is cut off there.

    >>> from ipmlang.geometry.solid import area, unit_square
    >>> [round(area(piece.solid), 9) for piece in offset(unit_square(), 0.5)]
    [4.0, 3.0]
    """
    rings, plane = opened(polygon, "offset")
    if not np.isfinite(distance):
        raise GeometryError("offset needs a distance that is a number")
    least = THIN * extent(rings)
    inside, border = (
        _grown(rings, distance) if distance > least
        else _shrunk(rings, -distance) if distance < -least
        else ([rings], [])
    )  # fmt: skip
    return _offset_pieces(inside, border, plane)


def _offset_pieces(inside: list[Rings], border: list[Rings], plane: Plane) -> list[Piece]:
    pieces = [Piece(frozenset({"inside", "shape"}), closed([each], plane)) for each in inside]
    words = frozenset({"border", "rest", "remainder"})
    return [*pieces, *(Piece(words, closed([each], plane)) for each in border)]


def _shrunk(rings: Rings, distance: float) -> tuple[list[Rings], list[Rings]]:
    edges = edges_of(rings)
    widths = np.full(len(edges.start), distance)
    corners = corners_of(edges, widths)
    moved = moved_in(edges, widths, corners)
    if moved is not None:
        return [moved], _between(rings, moved)
    shape = shape_of(rings)
    grid = grid_of(shape)
    taken = claims_of(shape, edges, widths, corners)
    known = np.concatenate([edges.start, corners.before, corners.own])
    rest = without(shape, taken, grid).item()
    border = without(shape, rest, grid).item()
    return rings_of_shape(rest, known, grid), rings_of_shape(border, known, grid)


def _between(whole: Rings, inner: Rings) -> list[Rings]:
    """What lies between a polygon and the same one with its rings moved in."""
    holes = zip(whole[1:], inner[1:], strict=True)
    return [[whole[0], inner[0][::-1]], *([wide[::-1], hole] for hole, wide in holes)]


def _grown(rings: Rings, distance: float) -> tuple[list[Rings], list[Rings]]:
    """The way in, seen from outside: rings run the other way, and the rest is what is not grown."""
    import shapely

    turned = [ring[::-1] for ring in rings]
    edges = edges_of(turned)
    widths = np.full(len(edges.start), distance)
    corners = corners_of(edges, widths)
    moved = moved_in(edges, widths, corners, outward=True)
    if moved is not None:
        grown = [ring[::-1] for ring in moved]
        return [grown], _between(grown, rings)
    shape = shape_of(rings)
    far = (MITRE + 1) * distance
    low, high = rings[0].min(axis=0) - far, rings[0].max(axis=0) + far
    around = shapely.difference(shapely.box(*low, *high), shape)
    grid = grid_of(around)
    whole = together([shape, claims_of(around, edges, widths, corners)], grid)
    border = without(whole, shape, grid).item()
    known = np.concatenate([edges.start, corners.before, corners.own])
    return rings_of_shape(whole, known, grid), rings_of_shape(border, known, grid)
