"""What stands for a geometry: its box, outline, plane, and the axes that its faces suggest."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from geometry.random_shapes import polygons
from hypothesis import given

from ipmlang.geometry.aligning import alignment
from ipmlang.geometry.converting import converted
from ipmlang.geometry.primitives import cone, sphere
from ipmlang.geometry.raising import extrude
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    area,
    bounds,
    chosen,
    is_closed,
    normals,
    placed,
    polygon,
    solid_of,
    unit_box,
    unit_square,
    volume,
)


def test_the_box_of_a_solid_and_of_a_polygon() -> None:
    box = converted(placed(sphere(8), (4, 3, 2), (1, 1, 1)), "box")
    assert is_closed(box)
    assert volume(box) == pytest.approx(24)
    for axis in range(3):
        wall = unit_square().vertices[:, np.roll([0, 1, 2], axis - 2)]
        flat = converted(solid_of(wall, [[[0, 1, 2, 3]]]), "box")
        assert np.abs(normals(flat)[0, axis]) == 1
        np.testing.assert_array_equal(bounds(flat), bounds(solid_of(wall, [[[0, 1, 2, 3]]])))


@given(polygons())
def test_the_outline_of_a_prism_is_its_polygon(plan: Solid) -> None:
    found = converted(placed(extrude(plan, 2), (1, 1, 1), (0, 0, 3)), "outline")
    assert area(found) == pytest.approx(area(plan), rel=1e-9)
    assert (found.vertices[:, 2] == 3).all()
    assert (normals(found)[:, 2] == 1).all()


def test_the_outline_covers_what_hangs_over() -> None:
    shade = placed(cone(4), (4, 4, 1), (-1.5, -1.5, 1))
    roofed = solid_of(
        np.concatenate([unit_box().vertices, shade.vertices]),
        [[each.tolist()] for each in unit_box().corners.reshape(6, 4)]
        + [[(ring + 8).tolist()] for ring in np.split(shade.corners, shade.rings[1:-1])],
    )
    assert area(converted(roofed, "outline")) == pytest.approx(16)


def test_the_plane_is_that_of_the_largest_face() -> None:
    found = converted(extrude(polygon([(0, 0), (4, 0), (0, 4)]), 0.5), "plane")
    assert np.abs(normals(found)[0, 2]) == 1
    assert area(found) == 16
    assert shapely.Polygon(found.vertices).is_valid


def test_nothing_and_lines_cannot_be_converted() -> None:
    with pytest.raises(GeometryError, match="nothing"):
        converted(chosen(unit_box(), []), "box")
    with pytest.raises(GeometryError, match="no box"):
        converted(solid_of([(0, 0, 0), (1, 0, 0)], [[[0, 1]]]), "box")
    with pytest.raises(GeometryError, match="covers nothing"):
        converted(chosen(unit_box(), [2]), "outline")


def test_the_scope_is_aligned_to_the_largest_face() -> None:
    wall = polygon([(0, 0), (2, 0), (9, 1), (9, 4), (0, 4)])
    wall = solid_of(wall.vertices[:, [0, 2, 1]], [[list(range(5))]])
    np.testing.assert_allclose(alignment(wall), [(1, 0, 0), (0, 0, 1), (0, -1, 0)])
    np.testing.assert_allclose(alignment(wall, "longest"), [(-1, 0, 0), (0, 0, -1), (0, -1, 0)])
    turned = solid_of(wall.vertices, [[[1, 2, 3, 4, 0]]])
    first = np.array([7, 0, 1]) / 50**0.5
    np.testing.assert_allclose(alignment(turned, "first")[0], first)
    np.testing.assert_allclose(np.linalg.det(alignment(turned, "first")), 1)
    with pytest.raises(GeometryError, match="no face"):
        alignment(solid_of([(0, 0, 0), (1, 0, 0)], [[[0, 1]]]))
