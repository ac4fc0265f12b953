"""Scattered points: where they lie, how evenly, from their own uniforms alone."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from geometry.random_shapes import mesh_of, prisms
from hypothesis import given, settings

from ipmlang.geometry.primitives import cone, sphere
from ipmlang.geometry.raising import extrude, taper
from ipmlang.geometry.scattering import scatter
from ipmlang.geometry.slabs import slab
from ipmlang.geometry.solid import (
    Floats,
    GeometryError,
    Solid,
    placed,
    polygon,
    unit_box,
    unit_square,
    volume,
)

COURT = extrude(polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 3), (3, 3), (3, 1)]]), 2)


def _uniforms(count: int) -> Floats:
    """Points of a lattice that fills the cube evenly (a Korobov rule): better than chance."""
    steps = np.array([1 / count, 0.7548776662466927, 0.5698402909980532])
    return (np.arange(count)[:, None] * steps + 0.5 / count) % 1


def _winding(solid: Solid, points: Floats) -> Floats:
    """How often the surface goes around each point: 1 inside (Oosterom and Strackee, 1983)."""
    corners = mesh_of(solid).triangles
    a, b, c = (corners[None] - points[:, None, None]).transpose(2, 0, 1, 3)
    la, lb, lc = (np.linalg.norm(each, axis=2) for each in (a, b, c))
    top = np.einsum("nti,nti->nt", a, np.cross(b, c))
    low = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.arctan2(top, low).sum(axis=1) / (2 * np.pi)


def _distance(solid: Solid, points: Floats) -> Floats:
    """How far from the nearest triangle each point is, where it lies over one."""
    a, b, c = mesh_of(solid).triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    square = np.einsum("ti,ti->t", normal, normal)
    off = points[:, None] - a
    one = np.einsum("nti,ti->nt", np.cross(b - a, off), normal) / square
    other = np.einsum("nti,ti->nt", np.cross(off, c - a), normal) / square
    over = (one > -1e-9) & (other > -1e-9) & (one + other < 1 + 1e-9)
    height = np.abs(np.einsum("nti,ti->nt", off, normal)) / np.sqrt(square)
    return np.where(over, height, np.inf).min(axis=1)


@settings(max_examples=30)
@given(prisms())
def test_points_lie_in_the_volume_and_on_the_surface(solid: Solid) -> None:
    inside = scatter(solid, 64, "volume", _uniforms(64))
    assert (_winding(solid, inside) > 0.5 - 1e-6).all()
    on = scatter(solid, 32, "surface", _uniforms(32))
    assert _distance(solid, on).max() < 1e-9


@pytest.mark.parametrize(
    "solid",
    [unit_box(), COURT, cone(12), placed(sphere(16), (1, 2, 3), (5, 5, 5)),
     taper(polygon([(0, 0), (9, 0), (9, 9), (6, 9), (6, 3), (3, 3), (3, 9), (0, 9)]), 3)],
)  # fmt: skip
def test_points_are_even(solid: Solid) -> None:
    points = scatter(solid, 20_000, "volume", _uniforms(20_000))
    mesh = mesh_of(solid)
    size = np.ptp(solid.vertices, axis=0).max()
    np.testing.assert_allclose(points.mean(axis=0), mesh.center_mass, atol=0.002 * size)
    for axis in range(3):
        low, high = np.quantile(solid.vertices[:, axis], [0, 1])
        middle = low + 0.4 * (high - low)
        part = slab(solid, axis, low, middle)
        share = volume(part) / volume(solid) if part else 0.0
        assert (points[:, axis] < middle).mean() == pytest.approx(share, abs=0.005)


def test_points_on_the_surface_are_even_by_area() -> None:
    points = scatter(placed(unit_box(), (4, 1, 1), (0, 0, 0)), 9_000, "surface", _uniforms(9_000))
    ends = (points[:, 0] < 1e-12) | (points[:, 0] > 4 - 1e-12)
    assert ends.mean() == pytest.approx(2 / 18, abs=0.005)
    np.testing.assert_allclose(points.mean(axis=0), (2, 0.5, 0.5), atol=0.02)


def test_a_point_hangs_on_its_own_uniforms() -> None:
    many = _uniforms(300)
    whole = scatter(COURT, 300, "volume", many)
    np.testing.assert_array_equal(scatter(COURT, 1, "volume", many[57:58])[0], whole[57])


def test_extremes_stay_inside() -> None:
    corners = np.array(np.meshgrid(*[[0, 0.5, 1 - 2**-24]] * 3)).reshape(3, -1).T
    for solid in (unit_box(), COURT, cone(7), sphere(9)):
        points = scatter(solid, len(corners), "volume", corners)
        assert np.isfinite(points).all()
        low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        assert ((points >= low - 1e-9) & (points <= high + 1e-9)).all()


def test_the_scope_and_nothing() -> None:
    box = placed(unit_square(), (4, 2, 1), (0, 0, 0))
    np.testing.assert_array_equal(scatter(box, 1, "scope", np.full((1, 3), 0.5)), [(2, 1, 0)])
    assert scatter(box, 0, "surface", np.zeros((0, 3))).shape == (0, 3)


def test_what_has_no_inside_is_said() -> None:
    with pytest.raises(GeometryError, match="closed"):
        scatter(unit_square(), 1, "volume", np.zeros((1, 3)))
    with pytest.raises(GeometryError, match="surface"):
        scatter(polygon([(0, 0), (1, 0), (2, 0)]), 1, "surface", np.zeros((1, 3)))


def test_scattering_is_fast() -> None:
    begin = process_time()
    scatter(sphere(24), 2_000, "volume", _uniforms(2_000))
    assert process_time() - begin < 2
