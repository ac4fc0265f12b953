"""Polygons raised to solids: volumes, closedness, orientation, tags and order of faces."""

from __future__ import annotations

import numpy as np
import pytest
from geometry.random_shapes import mesh_of, polygons
from hypothesis import assume, given
from hypothesis import strategies as st

from ipmlang.geometry.converting import reversed_normals
from ipmlang.geometry.raising import extrude, taper
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    area,
    bounds,
    chosen,
    is_closed,
    normals,
    polygon,
    solid_of,
    tagged,
    unit_box,
    unit_square,
    volume,
)

HEIGHTS = st.sampled_from([0.1, 3.0, -2.0])


@given(polygons(), HEIGHTS)
def test_the_volume_is_area_times_height(plan: Solid, height: float) -> None:
    solid = extrude(plan, height)
    assert is_closed(solid)
    assert volume(solid) == pytest.approx(area(plan) * abs(height), rel=1e-12)
    assert mesh_of(solid).volume == pytest.approx(volume(solid), rel=1e-9)


@given(
    polygons(), HEIGHTS, st.tuples(st.integers(-2, 2), st.integers(-2, 2), st.sampled_from([-1, 1]))
)
def test_any_direction_keeps_the_faces_outward(
    plan: Solid, height: float, direction: tuple[int, int, int]
) -> None:
    solid = extrude(plan, height, direction)
    lean = abs(direction[2]) / np.linalg.norm(direction)
    assert is_closed(solid)
    assert volume(solid) == pytest.approx(area(plan) * abs(height) * lean, rel=1e-9)


def test_a_square_makes_a_box_in_its_order() -> None:
    box = extrude(unit_square(), 1)
    np.testing.assert_array_equal(normals(box), normals(unit_box()))
    assert [min(tags) for tags in box.tags] == [
        "extrude.bottom", "extrude.top", *["extrude.side"] * 4
    ]  # fmt: skip


def test_downward_the_top_is_where_it_came_to() -> None:
    pit = extrude(tagged(unit_square(), "lot"), -2)
    assert pit.tags[1] == {"extrude.top", "lot"}
    assert normals(pit)[:2, 2].tolist() == [1, -1]
    assert volume(pit) == 2


def test_faces_that_share_an_edge_get_no_side_there() -> None:
    strip = solid_of(
        [(0, 0, 0), (1, 0, 0), (2, 0, 1), (0, 1, 0), (1, 1, 0), (2, 1, 1)],
        [[[0, 1, 4, 3]], [[1, 2, 5, 4]]],
    )
    slab = extrude(strip, 0.5, (0, 0, 1))
    assert len(slab) == 2 + 2 + 6
    assert is_closed(slab)
    assert volume(slab) == pytest.approx(1)


def test_a_wall_becomes_thick() -> None:
    front = chosen(unit_box(), [2])
    thick = extrude(front, 0.25)
    assert thick.vertices[:, 1].min() == -0.25
    assert volume(thick) == 0.25


def test_holes_get_sides() -> None:
    court = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 3), (3, 3), (3, 1)]])
    solid = extrude(court, 2)
    assert (len(solid), volume(solid)) == (10, 24)


@pytest.mark.parametrize(
    ("solid", "height", "direction", "message"),
    [
        (unit_square(), 0, None, "height is 0"),
        (unit_square(), 1, (1, 0, 0), "direction lies"),
        (unit_box(), 1, None, "look all ways"),
        (polygon([(0, 0), (1, 0), (2, 0)]), 1, None, "no polygon"),
    ],
)
def test_what_encloses_nothing_is_said(
    solid: Solid, height: float, direction: tuple[float, ...] | None, message: str
) -> None:
    with pytest.raises(GeometryError, match=message) as caught:
        extrude(solid, height, direction)
    assert caught.value.hint


@given(polygons())
def test_turning_twice_is_nothing(plan: Solid) -> None:
    assert (reversed_normals(reversed_normals(plan)).corners == plan.corners).all()
    assert normals(reversed_normals(plan))[0, 2] == pytest.approx(-1)


@given(polygons(), st.sampled_from([None, 0.0, 0.2, 50.0]), HEIGHTS)
def test_what_tapers_is_closed_and_as_high_as_said(
    plan: Solid, inset: float | None, height: float
) -> None:
    try:
        solid = taper(plan, height, inset)
    except GeometryError:
        assume(False)  # the outline touches itself, which has no skeleton
    assert is_closed(solid)
    low, high = bounds(solid)
    assert (low[2], high[2]) == (min(0, height), max(0, height))
    full = area(plan) * abs(height)
    assert full * 1e-3 < volume(solid) <= full * (1 + 1e-9)
    assert mesh_of(solid).volume == pytest.approx(volume(solid), rel=1e-6)


def test_a_square_tapers_to_a_point_or_to_a_smaller_square() -> None:
    square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], tags=["lot"])
    point, frustum = taper(square, 3), taper(square, 3, 1)
    assert volume(point) == pytest.approx(16)
    assert volume(frustum) == pytest.approx(28)
    assert frustum.tags == (
        {"taper.bottom", "lot"}, {"taper.top", "lot"}, *[{"taper.side"}] * 4
    )  # fmt: skip
    np.testing.assert_allclose(normals(frustum)[2:4, :2] * 10**0.5, [(0, -3), (3, 0)], atol=1e-9)
    assert volume(taper(square, 3, 2)) == pytest.approx(16)


def test_wings_and_courtyards_taper_as_hip_roofs_do() -> None:
    wings = [(0, 0), (9, 0), (9, 9), (6, 9), (6, 3), (3, 3), (3, 9), (0, 9)]
    assert volume(taper(polygon(wings), 3)) == pytest.approx(90)
    court = polygon([(0, 0), (6, 0), (6, 6), (0, 6)], [[(2, 2), (2, 4), (4, 4), (4, 2)]])
    solid = taper(court, 1, 0.5)
    assert sum("taper.side" in tags for tags in solid.tags) == 8
    wedges, corners = (4 * 6 + 4 * 2) * 0.5 / 2, 4 * 0.5**2 / 3 - 4 * 0.5**2 / 3
    assert volume(solid) == pytest.approx(32 - wedges + corners)


@pytest.mark.parametrize(
    ("solid", "height", "inset", "message"),
    [
        (unit_square(), 0, None, "height is 0"),
        (unit_square(), 1, -1, "draw out"),
        (unit_box(), 1, None, "one polygon"),
    ],
)
def test_what_cannot_taper_is_said(
    solid: Solid, height: float, inset: float | None, message: str
) -> None:
    with pytest.raises(GeometryError, match=message) as caught:
        taper(solid, height, inset)
    assert caught.value.hint
