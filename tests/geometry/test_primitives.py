"""Primitives: closed, outward, filling their box, with faces named in order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from ipmlang.geometry.primitives import cone, cylinder, disk, sphere
from ipmlang.geometry.solid import Solid, area, bounds, is_closed, normals, volume


@pytest.mark.parametrize("make", [cylinder, cone, sphere])
@pytest.mark.parametrize("sides", [3, 4, 5, 6, 17, 32])
def test_solids_are_closed_and_fill_the_unit_box(make: Callable[[int], Solid], sides: int) -> None:
    solid = make(sides)
    assert is_closed(solid)
    assert volume(solid) > 0
    np.testing.assert_array_equal(bounds(solid), [(0, 0, 0), (1, 1, 1)])
    assert Counter(word for tags in solid.tags for word in tags)[f"{make.__name__}.side"] == (
        sides * max(2, sides // 2) if make is sphere else sides
    )
    if make is not sphere:  # the first side looks to the front
        outward = normals(solid)[:, 1]
        first = next(k for k, tags in enumerate(solid.tags) if f"{make.__name__}.side" in tags)
        assert outward[first] <= outward.min() + 1e-9


@pytest.mark.parametrize(
    ("make", "whole"), [(cylinder, np.pi / 4), (cone, np.pi / 12), (sphere, np.pi / 6)]
)
def test_volumes_come_near_to_those_of_round_bodies(
    make: Callable[[int], Solid], whole: float
) -> None:
    assert volume(make(200)) == pytest.approx(whole, rel=1e-3)
    assert volume(make(4)) == pytest.approx({cylinder: 1, cone: 1 / 3, sphere: 1 / 3}[make])


def test_the_first_side_looks_to_the_front() -> None:
    np.testing.assert_allclose(normals(cylinder(8))[2], (0, -1, 0), atol=1e-12)
    assert cylinder(8).tags[:2] == ({"cylinder.bottom"}, {"cylinder.top"})
    assert cone(5).tags[0] == {"cone.bottom"}
    np.testing.assert_allclose(normals(cylinder(7))[:2, 2], (-1, 1))


def test_a_disk_faces_up() -> None:
    np.testing.assert_array_equal(bounds(disk(6)), [(0, 0, 0), (1, 1, 0)])
    assert normals(disk(6))[0, 2] == 1
    assert area(disk(200)) == pytest.approx(np.pi / 4, rel=1e-3)
