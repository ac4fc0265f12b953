"""Roofs: closed, on their polygon, of planes at the angles asked for, of the shapes expected."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, radians, tan

import numpy as np
import pytest
from made_footprints import (
    COURT,
    L_SHAPE,
    NAMED,
    NEAR_RECTANGLE,
    PLUS,
    SQUARE,
    T_SHAPE,
    U_SHAPE,
    Rings,
    area_of,
    rectilinear,
    regular,
    rings_of,
    rotated,
    star,
    turned,
    with_courtyards,
)
from numpy.random import default_rng

from ipmlang.geometry.roofs import (
    roof_gable,
    roof_hip,
    roof_mansard,
    roof_pyramid,
    roof_shed,
)
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    area_vectors,
    is_closed,
    normals,
    polygon,
    ring_points,
    unit_box,
    volume,
)

ROOFS: dict[str, Callable[[Solid, float], Solid]] = {
    "hip": lambda base, overhang: roof_hip(base, 35, overhang),
    "gable": lambda base, overhang: roof_gable(base, 35, overhang),
    "gable along x": lambda base, overhang: roof_gable(base, 35, overhang, 0),
    "gable along y": lambda base, overhang: roof_gable(base, 35, overhang, 90),
    "shed": lambda base, overhang: roof_shed(base, 20, overhang),
    "shed at 30": lambda base, overhang: roof_shed(base, 20, overhang, 30),
    "mansard": lambda base, overhang: roof_mansard(base, 70, 2, 25, overhang),
}


def lot(rings: Rings, z: float = 2.0) -> Solid:
    spatial = [[(x, y, z) for x, y in ring] for ring in rings]
    return polygon(spatial[0], spatial[1:])


def of(roof: Solid, tag: str) -> list[int]:
    return [face for face in range(len(roof)) if tag in roof.tags[face]]


def check(roof: Solid, rings: Rings, z: float = 2.0) -> None:
    """What is claimed of every roof, from its input alone."""
    assert is_closed(roof)
    assert volume(roof) > 0
    vectors, unit = area_vectors(roof), normals(roof)
    size = float(np.ptp(roof.vertices, axis=0).max())
    for face in range(len(roof)):
        points = np.concatenate(ring_points(roof, face))
        if np.hypot(*vectors[face, :2]) + abs(vectors[face, 2]) > 1e-6 * size**2:
            assert np.abs((points - points.mean(axis=0)) @ unit[face]).max() <= 1e-9 * size
    assert vectors[of(roof, "roof.slope"), 2].min() >= -1e-9 * size**2
    bottom = of(roof, "roof.bottom")
    assert -vectors[bottom, 2].sum() == pytest.approx(area_of(rings), rel=1e-9)
    assert (np.concatenate(ring_points(roof, bottom[0]))[:, 2] == z).all()
    covered = vectors[of(roof, "roof.slope"), 2].sum()
    under = -vectors[[*bottom, *of(roof, "roof.soffit")], 2].sum()
    assert covered == pytest.approx(under, rel=1e-9)
    known = {"roof.slope", "roof.gable", "roof.side", "roof.bottom", "roof.soffit"}
    assert all(len(tags & known) == 1 for tags in roof.tags)


@pytest.mark.parametrize("overhang", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("kind", ROOFS)
@pytest.mark.parametrize("name", NAMED)
def test_every_roof_over_every_shape(name: str, kind: str, overhang: float) -> None:
    check(ROOFS[kind](lot(NAMED[name]), overhang), NAMED[name])


@pytest.mark.parametrize("kind", ROOFS)
def test_every_roof_over_what_comes(kind: str) -> None:
    for k in range(12):
        make = [rectilinear, rotated, star, with_courtyards][k % 4]
        rings = rings_of(make(default_rng([21, k])))
        for overhang in (0.0, 0.4):
            check(ROOFS[kind](lot(rings), overhang), rings)


@pytest.mark.parametrize(("a", "b"), [(10, 6), (7.3, 7.2), (100, 1)])
@pytest.mark.parametrize("degrees", [5, 35, 60, 85])
def test_a_hip_roof_over_a_rectangle(a: float, b: float, degrees: float) -> None:
    roof = roof_hip(lot([[(0, 0), (a, 0), (a, b), (0, b)]]), degrees)
    high = roof.vertices[roof.vertices[:, 2] > 2]
    assert len(high) == 2
    assert high[:, 2] - 2 == pytest.approx(b / 2 * tan(radians(degrees)), rel=1e-9)
    assert np.ptp(high[:, 0]) == pytest.approx(a - b, rel=1e-9)
    slopes = normals(roof)[of(roof, "roof.slope"), 2]
    assert slopes == pytest.approx(cos(radians(degrees)))


def test_slopes_of_their_own_angles() -> None:
    angles = [30.0, 60.0, 45.0, 20.0, 50.0, 35.0]
    for overhang in (0.0, 0.5):
        roof = roof_hip(lot(L_SHAPE), angles, overhang)
        check(roof, L_SHAPE)
        slopes = normals(roof)[of(roof, "roof.slope"), 2]
        assert slopes == pytest.approx([cos(radians(angle)) for angle in angles])


def test_eaves_lie_level_below_the_plane() -> None:
    roof = roof_hip(lot(SQUARE), 45, 0.5)
    assert roof.vertices[:, 2].min() == pytest.approx(1.5)
    assert roof.vertices[:, :2].min() == pytest.approx(-0.5)
    assert roof.vertices[:, 2].max() == pytest.approx(4.0)  # as without an overhang
    assert len(of(roof, "roof.soffit")) == 5  # the ring below, and four sides up to the walls


def test_an_overhang_closes_a_narrow_court() -> None:
    roof = roof_hip(lot(COURT), 30, 2.5)
    check(roof, COURT)
    assert len(of(roof, "roof.slope")) == 4
    roof = roof_gable(lot(U_SHAPE), 30, 2.0)
    check(roof, U_SHAPE)


@pytest.mark.parametrize(
    ("rings", "ridge", "count"),
    [
        (NAMED["rectangle"], None, 2),
        (NAMED["rectangle"], 0, 2),
        (NAMED["rectangle"], 90, 2),
        (NEAR_RECTANGLE, None, 2),
        (SQUARE, None, 2),
        (L_SHAPE, None, 2),
        (U_SHAPE, None, 2),
        (T_SHAPE, None, 3),
        (PLUS, None, 4),
        (PLUS, 0, 2),
        (COURT, None, 0),
        (COURT, 90, 2),
        ([regular(200)], None, 2),
        (NAMED["triangle"], None, 1),
    ],
)
def test_gables_stand_where_wings_end(rings: Rings, ridge: float | None, count: int) -> None:
    for angle in (0.0, 0.4, 2.0):
        own = None if ridge is None else ridge + float(np.degrees(angle))
        roof = roof_gable(lot(turned(rings, angle)), 40, 0, own)
        gables = of(roof, "roof.gable")
        assert len(gables) == count
        assert np.abs(normals(roof)[gables, 2]).max(initial=0) < 1e-9


def test_a_ridge_runs_as_asked() -> None:
    along = roof_gable(lot(NAMED["rectangle"]), 45)
    across = roof_gable(lot(NAMED["rectangle"]), 45, ridge=90)
    for roof, axis, length, height in ((along, 0, 10, 3), (across, 1, 6, 5)):
        high = roof.vertices[roof.vertices[:, 2] > 2]
        assert np.ptp(high[:, axis]) == pytest.approx(length)
        assert high[:, 2] - 2 == pytest.approx(height)


def test_a_side_in_two_pieces_is_one_gable() -> None:
    rings: Rings = [[(0, 0), (10, 0), (10, 2), (10, 6), (0, 6)]]
    roof = roof_gable(lot(rings), 40)
    check(roof, rings)
    assert len(of(roof, "roof.gable")) == 3


def test_a_shed_rises_from_its_front() -> None:
    roof = roof_shed(lot(NAMED["rectangle"]), 45)
    (slope,) = of(roof, "roof.slope")
    assert normals(roof)[slope] == pytest.approx([0, -(0.5**0.5), 0.5**0.5])
    assert len(of(roof, "roof.side")) == 3  # none at the front, where it has no height
    assert volume(roof) == pytest.approx(10 * 6 * 6 / 2)
    turned_roof = roof_shed(lot(NAMED["rectangle"]), 45, ridge=90)
    assert normals(turned_roof)[of(turned_roof, "roof.slope")[0]][0] > 0


def test_a_pyramid_has_one_apex() -> None:
    roof = roof_pyramid(lot(SQUARE), 3)
    check(roof, SQUARE)
    assert volume(roof) == pytest.approx(16)
    for k in range(10):
        rings = rings_of(star(default_rng([5, k])))
        check(roof_pyramid(lot(rings), 3), rings)
    off: Rings = [[(0, 0), (9, 0), (9, 1), (1, 1), (1, 9), (0, 9)]]  # its centroid is outside
    check(roof_pyramid(lot(off), 1), off)


def test_a_mansard_bends_at_its_height() -> None:
    roof = roof_mansard(lot(NAMED["rectangle"]), 60, 2, 30)
    lower, upper = of(roof, "roof.lower"), of(roof, "roof.upper")
    assert len(lower) == len(upper) == 4
    assert normals(roof)[lower, 2] == pytest.approx(0.5)
    assert normals(roof)[upper, 2] == pytest.approx(cos(radians(30)))
    for faces, low, high in ((lower, 2, 4), (upper, 4, 4 + (3 - 2 / tan(radians(60))) * tan(
        radians(30)))):  # fmt: skip
        heights = np.concatenate([ring_points(roof, face)[0][:, 2] for face in faces])
        assert (heights.min(), heights.max()) == pytest.approx((low, high))
    assert not of(roof_mansard(lot(SQUARE), 30, 9, 20), "roof.upper")


def test_a_mansard_over_wings_that_part_above_the_bend() -> None:
    dumbbell: Rings = [
        [
            *((0, 0), (6, 0), (6, 2), (10, 2), (10, 0), (16, 0)),
            *((16, 6), (10, 6), (10, 4), (6, 4), (6, 6), (0, 6)),
        ]
    ]
    roof = roof_mansard(lot(dumbbell), 45, 1.5, 30)
    check(roof, dumbbell)
    assert len(of(roof, "roof.upper")) == 10  # the sides at the neck are two each
    check(roof_mansard(lot(dumbbell), 45, 1.0, 30), dumbbell)  # just where the neck ends


BASE = lot(SQUARE)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: roof_hip(BASE, 0), "slope by 0"),
        (lambda: roof_hip(BASE, 90), "slope by 90"),
        (lambda: roof_hip(BASE, [30, 30]), "4 edges need 4 angles"),
        (lambda: roof_hip(BASE, [30, 30, 30, -3]), "slope by -3"),
        (lambda: roof_gable(BASE, -5), "slope by -5"),
        (lambda: roof_gable(BASE, 30, -1), "overhang"),
        (lambda: roof_gable(BASE, 30, 0, float("nan")), "angle"),
        (lambda: roof_shed(BASE, float("nan")), "slope by nan"),
        (lambda: roof_pyramid(BASE, 0), "above 0"),
        (lambda: roof_pyramid(lot(COURT), 1), "courtyard"),
        (lambda: roof_pyramid(lot(U_SHAPE), 1), "no apex"),
        (lambda: roof_mansard(BASE, 60, -1, 30), "above 0"),
        (lambda: roof_mansard(BASE, 60, 1, 95), "slope by 95"),
        (lambda: roof_hip(unit_box(), 30), "6 faces"),
        (lambda: roof_hip(lot([SQUARE[0][::-1]]), 30), "face up"),
        (lambda: roof_hip(polygon([(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 1)]), 30), "level"),
        (lambda: roof_hip(lot([[(0, 0), (4, 3), (5, 0), (0, 3)]]), 30), "crosses itself"),
        (lambda: roof_hip(lot([[(0, 0), (4, 0), (8, 0)]]), 30), "no area"),
    ],
)
def test_bad_input(make: Callable[[], Solid], message: str) -> None:
    with pytest.raises(GeometryError, match=message) as caught:
        make()
    assert not caught.value.message[0].isupper()
