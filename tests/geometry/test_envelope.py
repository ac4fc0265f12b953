"""Envelopes are closed, lie below every plane of light, and fill what is below all of them."""

from __future__ import annotations

from math import radians, tan

import numpy as np
import pytest
import shapely
from geometry.footprint_samples import samples, shape_of_face, shapes

from ipmlang.geometry.envelope import envelope
from ipmlang.geometry.setbacks import setback
from ipmlang.geometry.solid import (
    GeometryError,
    Solid,
    area_vectors,
    bounds,
    is_closed,
    placed,
    polygon,
    unit_square,
    volume,
)

LOT = polygon([(0, 0), (20, 0), (20, 30), (0, 30)])


def of_kind(solid: Solid, word: str) -> list[int]:
    """The faces with a tag."""
    return [face for face, tags in enumerate(solid.tags) if f"envelope.{word}" in tags]


def test_upright_sides() -> None:
    """Without an angle it is the prism over what the building lines leave."""
    found = envelope(LOT, 10, front=5, side=2, back=3)
    assert is_closed(found)
    assert volume(found) == pytest.approx(16 * 22 * 10)
    kinds = [len(of_kind(found, word)) for word in ("bottom", "side", "top", "slope")]
    assert kinds == [1, 4, 1, 0]


def test_planes_of_light() -> None:
    """Slopes rise from the building lines; the top is what is left at the height."""
    found = envelope(LOT, 6, front=2, angle=45)
    assert is_closed(found)
    assert volume(found) == pytest.approx(6 / 6 * (20 * 28 + 4 * 14 * 22 + 8 * 16))
    assert [len(of_kind(found, word)) for word in ("bottom", "slope", "top")] == [1, 4, 1]
    peaked = envelope(LOT, 60, angle=45)
    assert (bounds(peaked)[1][2], of_kind(peaked, "top")) == (pytest.approx(10), [])


@pytest.mark.parametrize("number", range(24))
def test_any_lot(number: int) -> None:
    """Closed over every footprint; its height over each point is the least of what is allowed."""
    lot = placed(samples(24, seed=11)[number], (1, 1, 1), (0, 0, 2.5))
    found = envelope(lot, 1.2, front=0.3, angle=50)
    assert is_closed(found)
    assert bounds(found)[0][2] == 2.5
    assert bounds(found)[1][2] <= 3.7 + 1e-9
    assert all(area_vectors(found)[of_kind(found, "slope"), 2] > 0)
    rest = [p.solid for p in setback(lot, 0, front=0.3) if "shape" in p.words]
    floor = sum(shape.area for shape in shapes(rest))
    down = -area_vectors(found)[of_kind(found, "bottom"), 2].sum()
    assert down == pytest.approx(floor, rel=1e-9)
    _assert_heights(found, rest)


def _assert_heights(found: Solid, rest: list[Solid]) -> None:
    """Over points chosen at random: the height is that of the nearest edge, up to the full one.

    (A mitred corner that juts in makes it less than the distance to that corner would.)
    """
    faces = [shape_of_face(found, k) for k in of_kind(found, "slope") + of_kind(found, "top")]
    chance = np.random.default_rng(3)
    for part in shapes(rest):
        x0, y0, x1, y1 = part.bounds
        spots = [shapely.Point(p) for p in chance.uniform((x0, y0), (x1, y1), (40, 2))]
        for spot in (each for each in spots if part.contains(each)):
            allowed = min(1.2, part.boundary.distance(spot) * tan(radians(50)))
            height = _height(found, faces, spot)
            assert height <= allowed + 1e-7
            assert height >= allowed * 0.3


def _height(found: Solid, faces: list[shapely.Polygon], spot: shapely.Point) -> float:
    kinds = of_kind(found, "slope") + of_kind(found, "top")
    over = int(np.argmin([face.distance(spot) for face in faces]))
    normal = area_vectors(found)[kinds[over]]
    first = found.vertices[found.corners[found.rings[found.faces[kinds[over]]]]]
    return float(first[2] - normal[:2] @ (np.array([spot.x, spot.y]) - first[:2]) / normal[2] - 2.5)


def test_what_cannot_be_built() -> None:
    """No height, an angle that is none, and lines that leave nothing are told."""
    for wrong in ({"height": 0.0}, {"angle": 0.0}, {"angle": 120.0}, {"side": 0.6}, {"back": -1.0}):
        with pytest.raises(GeometryError):
            envelope(unit_square(), **{"height": 3.0, **wrong})
