"""Cuts by planes: what they keep, where their vertices lie, what they close, and how fast."""

from __future__ import annotations

from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from geometry.random_shapes import mesh_of, polygons, prisms
from hypothesis import given
from hypothesis import strategies as st

from ipmlang.geometry.raising import extrude
from ipmlang.geometry.roofs import roof_hip
from ipmlang.geometry.slabs import cut, slab, slabs, trim
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

GABLE = polygon([(0, 0), (10, 0), (10, 6), (5, 9), (0, 6)])


@st.composite
def cuts_of(draw: st.DrawFn, solid: Solid, axis: int) -> list[float]:
    """Cuts from end to end of a solid; whole numbers often lie on its vertices."""
    low, high = (float(bound[axis]) for bound in bounds(solid))
    inner = draw(st.lists(st.integers(-4, 8) | st.floats(low, high), max_size=4))
    return [low, *sorted(min(max(float(each), low), high) for each in inner), high]


@given(st.data(), polygons(), st.integers(0, 1))
def test_slabs_of_a_polygon_keep_its_area(data: st.DataObject, plan: Solid, axis: int) -> None:
    cuts = data.draw(cuts_of(plan, axis))
    parts = slabs(plan, axis, cuts)
    assert len(parts) == len(cuts) - 1
    assert sum(area(part) for part in parts if part) == pytest.approx(area(plan), rel=1e-9)
    for part, low, high in zip(parts, cuts, cuts[1:], strict=False):
        if part:
            assert bounds(part)[0][axis] >= low - 1e-8
            assert bounds(part)[1][axis] <= high + 1e-8
            assert (normals(part)[:, 2] > 0.999).all()


@given(st.data(), prisms(), st.integers(0, 2))
def test_slabs_of_a_solid_are_closed_and_keep_its_volume(
    data: st.DataObject, solid: Solid, axis: int
) -> None:
    cuts = data.draw(cuts_of(solid, axis))
    parts = [part for part in slabs(solid, axis, cuts) if part]
    assert all(is_closed(part) for part in parts)
    assert sum(volume(part) for part in parts) == pytest.approx(volume(solid), rel=1e-9)
    again = [half for part in parts for half in slabs(part, (axis + 1) % 3, [-9, 1, 9]) if half]
    assert all(is_closed(half) for half in again)
    assert sum(volume(half) for half in again) == pytest.approx(volume(solid), rel=1e-9)


@given(prisms(), st.tuples(*[st.integers(-2, 2)] * 3).filter(any), st.integers(0, 99))
def test_any_plane_cuts_in_two(solid: Solid, normal: tuple[int, int, int], vertex: int) -> None:
    point = solid.vertices[vertex % len(solid.vertices)]
    parts = [part for part in cut(solid, point, normal) if part]
    assert all(is_closed(part) for part in parts)
    assert sum(volume(part) for part in parts) == pytest.approx(volume(solid), rel=1e-9)


@given(prisms(), st.floats(-3, 3))
def test_cuts_agree_with_trimesh(solid: Solid, at: float) -> None:
    below, _ = cut(solid, (at, 0, 0), (1, 0.5, 0.25))
    oracle = mesh_of(solid).slice_plane((at, 0, 0), (-1, -0.5, -0.25), cap=False)
    theirs = oracle.area if len(oracle.faces) else 0.0
    own = [n for n, tags in enumerate(below.tags) if "split.cut" not in tags] if below else []
    ours = area(chosen(below, own)) if below else 0.0
    assert ours == pytest.approx(theirs, rel=1e-6, abs=1e-6)


def test_vertices_on_a_cut_have_its_coordinate() -> None:
    solid = extrude(polygon([(0, 0), (7, 0.1), (3, 5.3)]), 1)
    for part in cut_in_thirds(solid):
        on = np.abs(part.vertices[:, 0] - 1 / 3) < 1e-6
        assert (part.vertices[on, 0] == 1 / 3).all()


def cut_in_thirds(solid: Solid) -> list[Solid]:
    parts = slabs(solid, 0, [0, 1 / 3, 7])
    assert all(parts)
    return [part for part in parts if part]


def test_a_cut_beside_a_face_leaves_no_sliver() -> None:
    low, high = slabs(unit_box(), 2, [0, 1 - 1e-12, 1])
    assert high is None
    assert low is not None
    assert len(low) == 6
    assert volume(low) == pytest.approx(1, rel=1e-9)


def test_a_cut_along_a_ledge_is_clean() -> None:
    stair = extrude(polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]), 1)
    low, high = slabs(stair, 1, [0, 1, 2])
    assert low is not None
    assert high is not None
    assert (volume(low), volume(high)) == (2, 1)
    assert sum("split.cut" in tags for tags in low.tags) == 1
    assert area(chosen(low, [len(low) - 1])) == 1


def test_a_courtyard_falls_into_two_wings() -> None:
    court = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 3), (3, 3), (3, 1)]])
    middle = slab(extrude(court, 2), 0, 1.5, 2.5)
    assert middle is not None
    assert volume(middle) == 4
    assert sum("split.cut" in tags for tags in middle.tags) == 4
    flat = slab(court, 0, 1.5, 2.5)
    assert flat is not None
    assert (len(flat), area(flat)) == (2, 2)


def test_open_meshes_stay_open_and_tags_stay() -> None:
    wall = tagged(GABLE, "street")
    parts = [part for part in slabs(wall, 1, [0, 3, 9]) if part]
    assert [part.tags for part in parts] == [(frozenset({"street"}),)] * 2
    shell = solid_of(unit_box().vertices, [[[0, 1, 5, 4]], [[1, 3, 7, 5]]])
    low = slab(shell, 2, 0, 0.5)
    assert low is not None
    assert (len(low), area(low)) == (2, 1)


def test_what_lies_in_a_cut_belongs_above() -> None:
    below, above = slabs(unit_square(), 2, [-1, 0, 1])
    assert below is None
    assert above is not None
    assert slabs(unit_square(), 2, [-1, 0])[0] is not None


def test_texture_coordinates_follow() -> None:
    square = replace(unit_square(), uv=np.array([(0.0, 0), (8, 0), (8, 4), (0, 4)]))
    part = slab(square, 0, 0.25, 0.5)
    assert part is not None
    assert part.uv is not None
    np.testing.assert_allclose(part.uv, part.vertices[part.corners][:, :2] * (8, 4))


def test_trim_keeps_what_is_below_all_planes() -> None:
    part = trim(unit_box(), [((0.5, 0, 0), (1, 0, 0)), ((0, 0, 0.5), (0, 0, 1))])
    assert part is not None
    assert volume(part) == pytest.approx(0.25)
    assert trim(unit_box(), [((-1, 0, 0), (1, 0, 0))]) is None


def test_a_plane_needs_a_direction() -> None:
    with pytest.raises(GeometryError, match="no direction"):
        cut(unit_box(), (0, 0, 0), (0, 0, 0))


def test_slabs_are_fast() -> None:
    assert _best(lambda: slabs(GABLE, 1, np.linspace(0, 9, 11).tolist())) < 0.004
    angles = np.linspace(0, 2 * np.pi, 98, endpoint=False)
    radii = 5 + np.where(np.arange(98) % 2, 1.5, 0)
    tower = extrude(polygon(np.stack([np.cos(angles), np.sin(angles)], 1) * radii[:, None]), 10)
    assert _best(lambda: slabs(tower, 2, [0, 2, 4, 6, 8, 10])) < 0.04


def _best(work: object) -> float:
    times = []
    for _ in range(5):
        begin = process_time()
        work()  # type: ignore[operator]
        times.append(process_time() - begin)
    return min(times)


@pytest.mark.parametrize("at", [0.0, -0.2, 0.1, 1.0])
def test_a_roof_that_touches_itself_along_a_line_is_closed_again(at: float) -> None:
    # Its slopes go through the edges of its underside: at that height it hangs on lines alone.
    hall = polygon([(0, 0), (6, 0), (6, 4), (4, 4), (4, 6), (0, 6)])
    roof = roof_hip(hall, 35, 0.5)
    parts = [part for part in slabs(roof, 2, [-9, at, 9]) if part]
    assert len(parts) == 2
    assert all(is_closed(part) for part in parts)
    assert sum(volume(part) for part in parts) == pytest.approx(volume(roof), rel=1e-9)
