"""Rings as people draw them become sound polygons, or a message that says where they are not."""

from __future__ import annotations

import numpy as np
import pytest
from geometry.footprint_samples import samples

from ipmlang.geometry.footprints import footprint
from ipmlang.geometry.solid import GeometryError, area, area_vectors, ring_points

SQUARE = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
MENDED = {
    "nothing": ([SQUARE], [16], []),
    "closing point": ([[*SQUARE, SQUARE[0]]], [16], []),
    "clockwise": ([SQUARE[::-1]], [16], ["the outline ran clockwise: turned round"]),
    "repeated": ([[SQUARE[0], *SQUARE]], [16], ["1 repeated point left out"]),
    "nearly repeated": ([[*SQUARE[:2], (4.0, 1e-10), *SQUARE[2:]]], [16], ["1 repeated"]),
    "on an edge": ([[SQUARE[0], (2.0, 0.0), *SQUARE[1:]]], [16], ["1 point in the middle"]),
    "spike": ([[*SQUARE[:3], (2, 4), (2, 7), (2, 4), (0, 4)]], [16], ["repeated", "spike"]),
    "tiny edge stays": ([[*SQUARE[:3], (1e-3, 4), (0, 3.999)]], [16 - 5e-7], []),
    "hourglass": ([[(0, 0), (2, 2), (4, 0), (4, 4), (2, 2), (0, 4)]], [4, 4], ["2 polygons"]),
    "corner on edge": ([[(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)]], [4, 4], ["2 polygons"]),
    "loop inside": ([[*SQUARE, (0, 0), (1, 3), (3, 1)]], [12], ["touch"]),
    "keyhole": ([[*SQUARE, (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)]], [12], ["touch"]),
    "hole at a corner": ([SQUARE, [(0, 0), (1, 2), (2, 1)]], [14.5], []),
    "hole at an edge": ([SQUARE, [(0, 1), (1, 1), (1, 3), (0, 3)]], [14], ["touch"]),
    "hole from corner to corner": ([SQUARE, [(0, 0), (1, 2), (4, 4), (2, 1)]], [6, 6], ["2 poly"]),
    "holes side by side": (
        [SQUARE, [(1, 1), (2, 1), (2, 2), (1, 2)], [(2, 1), (3, 1), (3, 2), (2, 2)]],
        [14], ["touch"],
    ),
    "flat hole": ([SQUARE, [(1, 1), (2, 2), (3, 3)]], [16], ["hole 1 has no area: left out"]),
}  # fmt: skip
REFUSED = {
    "bow": ([[(0, 0), (4, 4), (4, 0), (0, 4)]], "crosses itself at (2, 2)"),
    "hole across": ([SQUARE, [(-1, 1), (1, 1), (1, 3), (-1, 3)]], "crosses itself at (0, 1)"),
    "hole outside": ([SQUARE, [(5, 1), (6, 1), (6, 3)]], "lies outside the outline"),
    "hole in a hole": (
        [SQUARE, [(1, 1), (3, 1), (3, 3), (1, 3)], [(1.5, 1.5), (2, 1.5), (2, 2)]], "lie on each",
    ),
    "same hole twice": ([SQUARE, *[[(1, 1), (2, 1), (2, 2)]] * 2], "twice along its edge"),
    "line": ([[(0, 0), (1, 1), (2, 2)]], "no area"),
    "point": ([[(1, 1), (1, 1), (1, 1)]], "all points of the polygon are the same"),
    "two points": ([[(0, 0), (1, 1)]], "needs three points or more, and has 2"),
    "nothing": ([], "needs a ring"),
    "not a number": ([[(0, 0), (1, float("nan")), (2, 2)]], "point 2 of the outline"),
    "not flat": ([[(0, 0, 0), (4, 0, 1), (4, 4, 1.1), (0, 4, 0)]], "not flat: point 4 lies 0.024"),
}  # fmt: skip


@pytest.mark.parametrize("name", MENDED)
def test_mended_with_a_note(name: str) -> None:
    """What has one reading is mended: each polygon has its area, each mend its note."""
    rings, areas, notes = MENDED[name]
    found, said = footprint(rings)
    assert sorted(area(each) for each in found) == pytest.approx(areas, rel=1e-12)
    assert all(area_vectors(each)[0, 2] > 0 for each in found)
    assert len(said) >= len(notes) and bool(said) == bool(notes)
    assert all(any(note in each for each in said) for note in notes)


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_the_place(name: str) -> None:
    """What has no single reading is refused, in words that name the place."""
    rings, message = REFUSED[name]
    with pytest.raises(GeometryError) as caught:
        footprint(rings)
    assert message in caught.value.message


def test_no_point_is_moved() -> None:
    """Every corner of the result is a corner of the input, to the last bit."""
    for solid in samples(40):
        rings = [ring[:, :2] for ring in ring_points(solid, 0)]
        drawn = [np.concatenate([ring[::-1], ring[-1:]]) for ring in rings]
        (found,), _ = footprint(drawn)
        given = {tuple(point) for ring in rings for point in ring.tolist()}
        assert {tuple(point) for point in found.vertices[:, :2].tolist()} <= given
        assert area(found) == pytest.approx(area(solid), rel=1e-9)


def test_a_fine_circle_keeps_its_area() -> None:
    """Points that each bend little are left out only as far as all of them together bend little."""
    angles = np.linspace(0, 2 * np.pi, 40_000, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    (found,), _ = footprint([circle])
    assert area(found) == pytest.approx(np.pi, rel=1e-7)


def test_faces_in_space() -> None:
    """A sloping face looks up, a vertical one keeps its side; far from 0 nothing is lost."""
    sloping = [(0, 0, 0), (4, 0, 1), (4, 4, 1), (0, 4, 0)]
    assert area_vectors(footprint([sloping])[0][0])[0, 2] > 0
    assert area_vectors(footprint([sloping[::-1]])[0][0])[0, 2] > 0
    wall = [(0, 0, 0), (4, 0, 0), (4, 0, 3), (0, 0, 3)]
    assert area_vectors(footprint([wall])[0][0])[0, 1] == pytest.approx(-12)
    assert area_vectors(footprint([wall[::-1]])[0][0])[0, 1] == pytest.approx(12)
    far = [(x + 5e5, y + 5e6) for x, y in SQUARE]
    assert area(footprint([far])[0][0]) == 16
