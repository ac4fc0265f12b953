"""Unions, differences, intersections; merged faces; the triangles they are made from."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
import shapely
from geometry.random_shapes import mesh_of, prisms
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.geometry.booleans import boolean
from ipmlang.geometry.converting import reversed_normals
from ipmlang.geometry.merging import merged_faces
from ipmlang.geometry.parts import faces
from ipmlang.geometry.primitives import cylinder, sphere
from ipmlang.geometry.raising import extrude
from ipmlang.geometry.slabs import cut, slabs
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    area,
    bounds,
    is_closed,
    placed,
    polygon,
    solid_of,
    tagged,
    unit_box,
    unit_square,
    volume,
)
from ipmlang.geometry.triangles import triangles

Cells = np.ndarray
CORNER = st.tuples(*[st.integers(0, 4)] * 3)
SIZE = st.tuples(*[st.integers(1, 4)] * 3)
HOW = {"union": np.logical_or, "subtract": lambda a, b: a & ~b, "intersect": np.logical_and}


def _cells(corner: tuple[int, ...], size: tuple[int, ...]) -> Cells:
    found = np.zeros((9, 9, 9), bool)
    found[tuple(slice(a, a + n) for a, n in zip(corner, size, strict=True))] = True
    return found


@given(st.lists(st.tuples(CORNER, SIZE), min_size=1, max_size=5), st.sampled_from([*HOW]))
def test_boxes_join_as_their_cells_do(
    boxes: list[tuple[tuple[int, ...], tuple[int, ...]]], kind: str
) -> None:
    found = boolean([placed(unit_box(), size, corner) for corner, size in boxes], kind)
    cells = reduce(HOW[kind], (_cells(*box) for box in boxes)).sum()
    assert (found is None) == (cells == 0)
    if found is not None:
        assert is_closed(found)
        assert volume(found) == pytest.approx(cells, rel=1e-9)
        parts = [part for part in slabs(found, 1, [0, 1.5, 2, 9]) if part]
        parts = [half for part in parts for half in cut(part, (2, 2, 2), (1, 1, -1)) if half]
        assert all(is_closed(part) for part in parts)
        assert sum(volume(part) for part in parts) == pytest.approx(cells, rel=1e-9)


@given(prisms(), prisms())
def test_two_volumes_make_a_union_and_an_intersection(one: Solid, other: Solid) -> None:
    other = placed(other, (0.7, 0.9, 1.1), (0.3, 0.1, -0.2))
    found = {kind: boolean([one, other], kind) for kind in HOW}
    size = {kind: volume(each) if each else 0 for kind, each in found.items()}
    assert all(is_closed(each) for each in found.values() if each)
    near = 1e-9 * (volume(one) + volume(other))
    assert size["union"] + size["intersect"] == pytest.approx(volume(one) + volume(other), abs=near)
    assert size["subtract"] + size["intersect"] == pytest.approx(volume(one), abs=near)


def test_faces_in_one_plane_with_the_same_tags_become_one() -> None:
    base = tagged(unit_box(), "house")
    other = placed(base, (1, 1, 1), (1, 0, 0))
    found = boolean([base, other], "union")
    assert found is not None
    assert (len(found), len(found.vertices), volume(found)) == (6, 8, 2)
    mixed = boolean([unit_box(), other], "union")
    assert mixed is not None
    assert len(mixed) == 10


def test_tags_stay_with_the_faces_they_come_from() -> None:
    hole = tagged(placed(cylinder(6), (0.5, 0.5, 2), (0.25, 0.25, -0.5)), "hole")
    found = boolean([unit_box(), hole], "subtract")
    assert found is not None
    assert sum("hole" in tags for tags in found.tags) == 6
    assert sum("cylinder.side" in tags for tags in found.tags) == 6
    assert len(found) == 12
    assert sorted(np.diff(found.faces).tolist()) == [1] * 10 + [2] * 2
    assert volume(found) == pytest.approx(1 - volume(cylinder(6)) / 4)


def test_parts_inside_out_count_as_the_right_way_out() -> None:
    found = boolean([reversed_normals(unit_box()), unit_box()], "intersect")
    assert found is not None
    assert volume(found) == pytest.approx(1)


def test_split_vertices_are_welded() -> None:
    box = unit_box()
    apart = solid_of(box.vertices[box.corners], np.arange(24).reshape(6, 1, 4).tolist())
    found = boolean([apart], "union")
    assert found is not None
    assert (len(found), is_closed(found)) == (6, True)


def test_open_parts_are_named() -> None:
    with pytest.raises(GeometryError, match="part 2 has open edges") as caught:
        boolean([unit_box(), unit_square()], "subtract")
    assert "extrude" in (caught.value.hint or "")


def test_where_parts_only_touch_nothing_is_shared() -> None:
    assert boolean([unit_box(), placed(unit_box(), (1, 1, 1), (1, 0, 0))], "intersect") is None
    assert boolean([unit_box(), unit_box()], "subtract") is None
    assert boolean([], "union") is None


@given(prisms())
def test_triangles_fill_all_faces_and_use_all_vertices(solid: Solid) -> None:
    corners, face = triangles(solid)
    points = solid.vertices[corners]
    across = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(area(solid), rel=1e-9)
    assert set(face.tolist()) == set(range(len(solid)))
    assert mesh_of(solid).volume == pytest.approx(volume(solid), rel=1e-9)


@given(prisms())
def test_triangles_merge_back_into_polygons(solid: Solid) -> None:
    corners, face = triangles(solid)
    apart = solid_of(solid.vertices, corners[:, None].tolist(), [solid.tags[n] for n in face])
    found = merged_faces(apart)
    assert len(found) <= len(solid)
    assert is_closed(found)
    assert volume(found) == pytest.approx(volume(solid), rel=1e-6)
    assert area(found) == pytest.approx(area(solid), rel=1e-6)
    np.testing.assert_allclose(bounds(found), bounds(solid), atol=1e-6)


def test_holes_come_back_and_round_bodies_stay() -> None:
    court = extrude(
        polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 3), (3, 3), (3, 1)]]), 2
    )
    corners, face = triangles(court)
    apart = solid_of(court.vertices, corners[:, None].tolist(), [court.tags[n] for n in face])
    found = merged_faces(apart)
    assert sorted(np.diff(found.faces).tolist()) == [1] * 8 + [2] * 2
    assert (len(faces(apart)), len(faces(apart, merge=True))) == (len(apart), 10)
    assert len(merged_faces(sphere(24))) == len(sphere(24))


def test_seams_of_textures_stay() -> None:
    strip = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
    two = solid_of(strip, [[[0, 1, 4, 3]], [[1, 2, 5, 4]]])
    flat = two.vertices[two.corners][:, :2]
    smooth = merged_faces(_with_uv(two, flat))
    assert (len(smooth), len(smooth.corners)) == (1, 4)
    assert smooth.uv is not None
    np.testing.assert_array_equal(smooth.uv, smooth.vertices[smooth.corners][:, :2])
    seam = flat.copy()
    seam[4:] += 3
    assert len(merged_faces(_with_uv(two, seam))) == 2


def test_a_part_that_touches_itself_is_joined_right() -> None:
    bend = [(2, 5), (2, 4), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (3, 1), (3, 2), (5, 2), (5, 3),
            (7, 3), (7, 4), (5, 4), (4, 4), (4, 5)]  # fmt: skip
    touching = extrude(polygon(bend, [[(3, 4), (4, 4), (4, 3), (3, 3)]]), 2)
    other = placed(unit_box(), (2.5, 2.6, 2), (1.2, 2.1, 0))
    shared = boolean([touching, other], "intersect")
    both = boolean([touching, other], "union")
    assert shared is not None
    assert both is not None
    flat = shapely.Polygon(bend, [[(3, 4), (4, 4), (4, 3), (3, 3)]])
    cut = flat.intersection(shapely.box(1.2, 2.1, 3.7, 4.7)).area * 2
    assert volume(shared) == pytest.approx(cut, rel=1e-8)
    assert volume(both) == pytest.approx(volume(touching) + 13 - cut, rel=1e-8)


def _with_uv(solid: Solid, uv: np.ndarray) -> Solid:
    return replace(solid, uv=uv)
