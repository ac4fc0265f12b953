"""Planar operations take a polygon apart without losing or doubling any of it."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from geometry.footprint_samples import overlap, samples, shape_of_face, shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from ipmlang.geometry.areas import area_cuts
from ipmlang.geometry.arms import shape_l, shape_o, shape_u
from ipmlang.geometry.pieces import Piece
from ipmlang.geometry.rectangles import inner_rect, largest_rectangle
from ipmlang.geometry.setbacks import classified_edges, offset, setback
from ipmlang.geometry.slabs import slab
from ipmlang.geometry.solid import GeometryError, Solid, area, polygon, unit_box, unit_square

YARD = polygon([(0, 0), (10, 0), (10, 8), (0, 8)])
ELL = polygon([(0, 0), (10, 0), (10, 4), (4, 4), (4, 8), (0, 8)])
SAMPLES = samples(60)


def by_word(pieces: list[Piece], word: str) -> list[Solid]:
    """The geometry of the pieces that a word selects."""
    return [piece.solid for piece in pieces if word in piece.words]


def total(solids: list[Solid]) -> float:
    """The area of all."""
    return sum(area(solid) for solid in solids)


def assert_parted(whole: Solid, parts: list[Solid]) -> None:
    """The parts are sound polygons that make up the whole, each bit of it once."""
    faces = shapes(parts)
    assert all(face.is_valid for face in faces)
    assert sum(face.area for face in faces) == pytest.approx(area(whole), rel=1e-9)
    assert overlap(faces) <= 1e-9 * area(whole)
    around = shape_of_face(whole).buffer(1e-6)
    assert all(around.covers(face) for face in faces)


# --- setback ----------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(len(SAMPLES)))
def test_setback_parts_the_polygon(number: int) -> None:
    """Strips and rest are the whole; nothing left is nearer to an edge than its strip is wide."""
    whole, chance = SAMPLES[number], np.random.default_rng(number)
    front, side, back = chance.choice([0.0, 0.4, 1.0, 2.5], 3)
    pieces = setback(whole, 0.0, front=front, side=side, back=back)
    assert_parted(whole, [piece.solid for piece in pieces])
    rest = shapely.union_all(shapes(by_word(pieces, "shape"))).buffer(-1e-7)
    ring = shape_of_face(whole)
    edges = _outlines(ring)
    for edge, words in zip(edges, classified_edges(whole), strict=True):
        width = front if "front" in words else back if "back" in words else side
        assert not _seen(rest, ring, edge, width)


def _outlines(shape: shapely.Polygon) -> list[np.ndarray]:
    rings = [shapely.get_coordinates(ring) for ring in (shape.exterior, *shape.interiors)]
    return [ring[k : k + 2] for ring in rings for k in range(len(ring) - 1)]


def _seen(rest: shapely.Geometry, whole: shapely.Polygon, edge: np.ndarray, width: float) -> bool:
    """Whether, straight in from the middle of an edge, something is left too near to it."""
    middle, along = edge.mean(axis=0), edge[1] - edge[0]
    inward = np.array([-along[1], along[0]]) / np.hypot(*along)
    ray = shapely.LineString([middle + inward * 1e-6, middle + inward * (width - 1e-6)])
    return bool(width > 0 and whole.covers(ray) and rest.intersects(ray))


@pytest.mark.parametrize("number", range(0, len(SAMPLES), 2))
def test_equal_setbacks_agree_with_an_offset_of_geos(number: int) -> None:
    """With one width, what is left is what another library's mitred offset leaves."""
    whole = SAMPLES[number]
    for width in (0.05, 0.6, 1.7):
        left = total(by_word(setback(whole, width), "shape"))
        inward = total(by_word(offset(whole, -width), "inside"))
        ring = shape_of_face(whole)
        other = shapely.buffer(ring, -width, join_style="mitre", mitre_limit=5).area
        assert left == pytest.approx(inward, abs=1e-9 * area(whole))
        assert left == pytest.approx(other, abs=2e-3 * area(whole))


def test_setback_of_a_yard() -> None:
    """Numbers by hand: corners are mitred, sides are chosen by where edges face."""
    pieces = setback(YARD, 2, front=3)
    assert [area(piece.solid) for piece in pieces] == [18, 24, 11, 16, 11]
    assert [sorted(piece.words - {"border", "all"}) for piece in pieces[1:]] == [
        ["front"], ["right", "side"], ["back"], ["left", "side"],
    ]  # fmt: skip
    only = setback(YARD, 0, back=1)
    assert [area(piece.solid) for piece in only] == [70, 10]
    assert not by_word(setback(YARD, 4), "shape")
    with pytest.raises(GeometryError, match="-1"):
        setback(YARD, -1)


def test_edges_on_one_line_may_have_different_widths() -> None:
    """Where strips of different widths meet on a straight edge, they end side by side."""
    bent = polygon([(0, 0), (5, 0), (10, 1e-3), (10, 8), (0, 8)])
    pieces = setback(bent, 0, front=2)
    assert_parted(bent, [piece.solid for piece in pieces])
    assert total(by_word(pieces, "border")) == pytest.approx(20, rel=1e-3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, len(SAMPLES) - 1), st.floats(0.02, 1.0), st.floats(0.2, 3), st.floats(0.2, 3))
def test_setback_to_an_area(number: int, share: float, front: float, side: float) -> None:
    """The rest has the area that was asked for, and the widths their proportion."""
    whole = SAMPLES[number]
    wanted = share * area(whole)
    pieces = setback(whole, 1.0, front=front, side=side, area=wanted)
    assert total(by_word(pieces, "shape")) == pytest.approx(wanted, abs=1e-9 * area(whole))
    assert_parted(whole, [piece.solid for piece in pieces])


def test_areas_that_cannot_be_left() -> None:
    """More than there is, or less than the chosen edges can take, is told."""
    for asked in ({"area": 81.0}, {"area": -1.0}, {"distance": 0.0, "area": 40.0}):
        with pytest.raises(GeometryError, match="area"):
            setback(YARD, **{"distance": 1.0, **asked})


# --- offset -----------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(0, len(SAMPLES), 2))
def test_offset_and_its_border(number: int) -> None:
    """Inward, inside and border are the whole; outward, the whole and the border are inside."""
    whole = SAMPLES[number]
    for distance in (-1.3, -0.2, 0.0, 0.3, 2.0):
        pieces = offset(whole, distance)
        inside, border = by_word(pieces, "inside"), by_word(pieces, "border")
        if distance <= 0:
            assert_parted(whole, inside + border)
            continue
        assert total(inside) == pytest.approx(area(whole) + total(border), rel=1e-9)
        other = shapely.buffer(
            shape_of_face(whole), distance, join_style="mitre", mitre_limit=5
        ).area
        assert total(inside) == pytest.approx(other, rel=2e-3)


def test_offset_of_an_ell() -> None:
    """Outward and back is the same polygon; a hole shrinks when the polygon grows."""
    grown = by_word(offset(ELL, 1), "inside")[0]
    assert area(grown) == 96
    back = by_word(offset(grown, -1), "inside")[0]
    assert np.array_equal(back.vertices, ELL.vertices)
    frame = polygon([(0, 0), (9, 0), (9, 9), (0, 9)], [[(3, 3), (3, 6), (6, 6), (6, 3)]])
    assert area(by_word(offset(frame, 1), "inside")[0]) == 121 - 1
    assert area(by_word(offset(frame, 2), "inside")[0]) == 169


# --- the largest rectangle, arms, areas ---------------------------------------------------------


@pytest.mark.parametrize("number", range(len(SAMPLES)))
def test_inner_rectangle(number: int) -> None:
    """It lies within, the rest is around it, and none through lines close together is larger."""
    whole = SAMPLES[number]
    pieces = inner_rect(whole)
    assert_parted(whole, [piece.solid for piece in pieces])
    best = area(by_word(pieces, "shape")[0])
    assert best >= 0.97 * _largest_on_a_grid(shape_of_face(whole))


def _largest_on_a_grid(shape: shapely.Polygon, lines: int = 40) -> float:
    """The largest rectangle on a grid, by trying all pairs of columns (an oracle, slow)."""
    x0, y0, x1, y1 = shape.bounds
    xs, ys = np.linspace(x0, x1, lines + 1), np.linspace(y0, y1, lines + 1)
    low = np.stack(np.meshgrid(xs[:-1], ys[:-1], indexing="ij"), axis=-1).reshape(-1, 2)
    high = np.stack(np.meshgrid(xs[1:], ys[1:], indexing="ij"), axis=-1).reshape(-1, 2)
    shapely.prepare(shape)
    full = shapely.covers(shape, shapely.box(*low.T, *high.T)).reshape(lines, lines)
    best = 0
    for first in range(lines):
        free = np.ones(lines, bool)
        for last in range(first, lines):
            free &= full[last]
            runs = np.diff(np.flatnonzero(np.concatenate([[True], ~free, [True]]))) - 1
            best = max(best, int(runs.max()) * (last - first + 1))
    return best * (xs[1] - xs[0]) * (ys[1] - ys[0])


def test_inner_rectangle_is_exact_along_the_axes() -> None:
    """Numbers by hand, with a hole; coordinates are those of corners."""
    holed = polygon([(0, 0), (10, 0), (10, 8), (0, 8)], [[(3, 3), (3, 5), (5, 5), (5, 3)]])
    (rectangle,) = by_word(inner_rect(holed), "shape")
    assert sorted(map(tuple, rectangle.vertices[:, :2].tolist())) == [
        (5, 0), (5, 8), (10, 0), (10, 8),
    ]  # fmt: skip
    assert [area(piece.solid) for piece in inner_rect(unit_square())] == [1]


def test_inner_rectangle_of_convex_polygons_is_the_largest() -> None:
    """By hand in triangles and a rhombus; else none on fine lines is larger, in any turn."""
    for turn in ([(0, 0), (6, 0), (0, 4)], [(0, 0), (6, 0), (6, 4)], [(3, 0), (6, 2), (0, 2)]):
        low, right, up, high = largest_rectangle([np.array(turn, np.float64)])
        whole = area(polygon(turn))
        assert (up - low) * (high - right) == pytest.approx(whole / 2, rel=1e-9)
    rhombus = np.array([(0, -2), (5, 0), (0, 2), (-5, 0)], np.float64)
    assert largest_rectangle([rhombus]) == pytest.approx((-2.5, -1, 2.5, 1), rel=1e-5)
    chance = np.random.default_rng(6)
    for _ in range(20):
        points = chance.uniform(-5, 5, (int(chance.integers(4, 12)), 2)) * (1, chance.uniform(0, 1))
        hull = shapely.geometry.polygon.orient(shapely.MultiPoint(points).convex_hull)
        low, right, up, high = largest_rectangle([np.array(hull.exterior.coords)[:-1]])
        assert hull.buffer(1e-9).covers(shapely.box(low, right, up, high))
        best = (up - low) * (high - right)
        assert best >= _largest_on_a_grid(hull) * (1 - 1e-9)


@pytest.mark.parametrize("number", range(0, len(SAMPLES), 2))
def test_arms_part_the_polygon(number: int) -> None:
    """L, U and O with their rest are the whole."""
    whole = SAMPLES[number]
    for pieces in (shape_l(whole, 2, 3), shape_u(whole, 2, 1, 3), shape_o(whole, 1, 2, 1, 0.5)):
        assert_parted(whole, [piece.solid for piece in pieces])
        assert {word for piece in pieces for word in piece.words} <= {"shape", "rest", "remainder"}


def test_arms_of_a_yard() -> None:
    """Numbers by hand; arms that fill the box leave no rest, arms of no width no shape."""
    assert [area(piece.solid) for piece in shape_l(YARD, 3, 4)] == [50, 30]
    assert [area(piece.solid) for piece in shape_u(YARD, 3, 4, 2)] == [60, 20]
    ring, court = shape_o(YARD, 1, 2, 3, 4)
    assert (len(ring.solid.rings) - 1, area(ring.solid), area(court.solid)) == (2, 65, 15)
    assert [piece.words for piece in shape_l(YARD, 8, 1)] == [{"shape"}]
    assert [piece.words for piece in shape_l(YARD, 0, 0)] == [{"rest", "remainder"}]
    with pytest.raises(GeometryError, match="left arm is -1"):
        shape_l(YARD, 2, -1)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_areas_are_met(axis: str) -> None:
    """What lies between the lines has its area, and all is the whole, for any outline."""
    chance = np.random.default_rng(5)
    for whole in SAMPLES:
        wanted = chance.dirichlet(np.ones(4)) * area(whole)
        lines = area_cuts(whole, axis, wanted.tolist()).tolist()
        pieces = [slab(whole, "xy".index(axis), *span) for span in pairwise(lines)]
        parts = [piece for piece in pieces if piece is not None]
        assert [area(part) for part in parts] == pytest.approx(wanted, abs=1e-9 * area(whole))
        assert_parted(whole, parts)


def test_areas_that_do_not_fit() -> None:
    """A last piece is cut, none is made of nothing, and what is left over makes none."""
    cuts = area_cuts(YARD, "x", [20, 0, -3, 50, 40, 5])
    parts = [slab(YARD, 0, a, b) if a < b else None for a, b in pairwise(cuts.tolist())]
    assert [0 if each is None else area(each) for each in parts] == [20, 0, 0, 50, 10, 0]
    assert area_cuts(YARD, "y", [40, 40]).tolist() == [0, 4, 8]


def test_many_corners_need_little_memory() -> None:
    """Areas are found by looking at some lines of ten thousand, not at all of them."""
    angles = np.arange(10_000) * 2 * np.pi / 10_000
    radii = 100 + 3 * np.sin(50 * angles)
    whole = polygon(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1))
    tracemalloc.start()
    lines = area_cuts(whole, "x", [area(whole) / 2] * 2)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert lines == pytest.approx([-100 - 3 * np.sin(0), 0, 100], abs=4)
    assert area(slab(whole, 0, float(lines[0]), float(lines[1])) or whole) == pytest.approx(
        area(whole) / 2, rel=1e-9
    )
    assert peak < 30e6


# --- texture coordinates and tags ---------------------------------------------------------------


def test_parts_keep_tags_height_and_affine_uv() -> None:
    """Parts bear the tags of the whole, at its height; uv that is a map of places goes on."""
    whole = polygon([(0, 0, 2), (10, 0, 2), (10, 8, 2), (0, 8, 2)], tags=["lot"])
    whole = replace(whole, uv=whole.vertices[:, :2] * [0.1, 0.25] + [3, 4])
    bent = replace(whole, uv=np.array([(0, 0), (1, 0), (1, 1), (0, 2)], np.float64))
    for cut in (lambda s: setback(s, 1), lambda s: shape_o(s, 1, 1, 1, 1), inner_rect):
        for part in (piece.solid for piece in cut(whole)):
            assert part.uv == pytest.approx(
                part.vertices[part.corners, :2] * [0.1, 0.25] + [3, 4], abs=1e-12
            )
            assert (part.vertices[:, 2] == 2).all()
            assert part.tags == (frozenset({"lot"}),)
        assert all(piece.solid.uv is None for piece in cut(bent))


# --- what is no level polygon -------------------------------------------------------------------


@pytest.mark.parametrize("cut", [lambda s: setback(s, 1), lambda s: offset(s, 1), inner_rect])
def test_only_level_polygons(cut) -> None:  # type: ignore[no-untyped-def]
    """Solids, upright faces and faces that look down are refused, with what to do."""
    upright = polygon([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)])
    for wrong in (unit_box(), upright, polygon([(0, 0), (0, 1), (1, 1), (1, 0)])):
        with pytest.raises(GeometryError) as caught:
            cut(wrong)
        assert caught.value.hint
