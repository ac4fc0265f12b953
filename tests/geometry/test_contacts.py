"""Pairs of boxes and of solids: each way of comparing them against the other, and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ipmlang.geometry.contacts import Contact, Form, contact, distance, form_of, thin
from ipmlang.geometry.hierarchy import Tree, gaps
from ipmlang.geometry.oriented import Boxes, distances, lies_within, meetings
from ipmlang.geometry.roofs import roof_hip
from ipmlang.geometry.solid import Floats, Solid, placed, polygon, unit_box, unit_square

INSIDE = Contact(inside=True, overlaps=True, touches=False)
OVER = Contact(inside=False, overlaps=True, touches=False)
NEXT = Contact(inside=False, overlaps=False, touches=True)
APART = Contact(inside=False, overlaps=False, touches=False)
ON = Contact(inside=True, overlaps=False, touches=True)  # within the boundary


def turns(random: np.random.Generator, count: int) -> Floats:
    """Axes (count, 3, 3) turned at random."""
    q, r = np.linalg.qr(random.normal(size=(count, 3, 3)))
    q *= np.sign(np.einsum("nii->ni", r))[:, None]
    q[:, :, 0] *= np.linalg.det(q)[:, None]
    return np.swapaxes(q, 1, 2)


def boxes(random: np.random.Generator, count: int, spread: float) -> Boxes:
    middle = random.uniform(-spread, spread, (count, 3))
    return Boxes(middle, turns(random, count), random.uniform(0.1, 1.0, (count, 3)))


def as_form(all_: Boxes, row: int) -> Form:
    """A box as a solid, a rectangle where it is flat."""
    half, axes = all_.half[row], all_.axes[row]
    flat = np.flatnonzero(half <= 0)
    solid = unit_box() if not len(flat) else unit_square()
    vertices = solid.vertices
    if len(flat):
        x, y, zero = unit_square().vertices.T
        columns = {0: (zero, x, y), 1: (x, zero, y), 2: (x, y, zero)}[int(flat[0])]
        vertices = np.stack(columns, axis=1)
    local = np.where(half > 0, vertices * 2 - 1, 0.0) * half
    return form_of(replace(solid, vertices=local @ axes + all_.middle[row]))


def compare(a: Boxes, b: Boxes) -> None:
    """Boxes as boxes and as solids say the same."""
    overlap, meet = meetings(a, b)
    within, apart = lies_within(a, b), distances(a, b)
    for row in range(len(a)):
        pair = as_form(a, row), as_form(b, row)
        expected = Contact(
            bool(within[row]), bool(overlap[row]), bool(meet[row] and not overlap[row])
        )
        assert contact(*pair) == expected, row
        assert distance(*pair) == pytest.approx(float(apart[row]), abs=1e-9)


def test_turned_boxes_are_like_solids() -> None:
    random = np.random.default_rng(3)
    a, b = boxes(random, 60, 1.5), boxes(random, 60, 1.5)
    a.half[::5] *= 0.1
    compare(a, b)


def test_a_distance_is_the_least_over_both_boxes() -> None:
    """Against a slow search for the nearest points."""
    from scipy.optimize import lsq_linear

    random = np.random.default_rng(4)
    a, b = boxes(random, 40, 2.0), boxes(random, 40, 2.0)
    found = distances(a, b)
    for row in range(40):
        columns = [a.axes[row].T * a.half[row], -b.axes[row].T * b.half[row]]
        matrix, target = np.concatenate(columns, axis=1), b.middle[row] - a.middle[row]
        best = lsq_linear(matrix, target, bounds=(-1, 1), tol=1e-14)
        assert np.linalg.norm(matrix @ best.x - target) == pytest.approx(found[row], abs=1e-7)


cells = st.tuples(*[st.integers(0, 3)] * 3)


@settings(max_examples=150, deadline=None)
@given(cells, cells, cells, cells)
def test_what_shares_planes_is_told_apart(
    corner: tuple[int, ...], size: tuple[int, ...], other: tuple[int, ...], extent: tuple[int, ...]
) -> None:
    """On a grid boxes and rectangles touch, cross and lie on each other in every way."""
    sizes = np.array([size, extent], float)
    sizes[(sizes > 0).sum(axis=1) < 2] = (1.0, 2.0, 3.0)
    middle = np.array([corner, other]) + sizes / 2
    both = Boxes(middle, np.tile(np.eye(3), (2, 1, 1)), sizes / 2)
    compare(both.take(slice(0, 1)), both.take(slice(1, 2)))


def block(low: tuple[float, ...], high: tuple[float, ...]) -> Form:
    return form_of(placed(unit_box(), np.subtract(high, low), low))


def ell() -> Solid:
    """An L of height 2: the notch is x > 1 and y > 1."""
    from ipmlang.geometry.raising import extrude

    return extrude(polygon([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]), 2.0)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ((0.2, 0.2, 0.2), (0.8, 0.8, 0.8), INSIDE),
        ((0, 0, 0), (1, 3, 2), INSIDE),
        ((0, 0, 0), (3, 3, 2), OVER),  # the box around it
        ((1, 1, 0), (3, 3, 2), NEXT),  # fills the notch
        ((1.5, 1.5, 0), (3, 3, 2), APART),  # stands in the notch
        ((0.5, 0.5, 1.5), (0.7, 0.7, 2.5), OVER),
    ],
)
def test_a_box_and_a_solid_with_a_notch(
    low: tuple[float, ...], high: tuple[float, ...], expected: Contact
) -> None:
    assert contact(block(low, high), form_of(ell())) == expected


@pytest.mark.parametrize(
    ("move", "expected"),
    [
        ((0.0, 0.0, 0.0), ON),  # in its floor
        ((0.0, 0.0, 1.0), INSIDE),
        ((0.5, 0.5, 1.0), OVER),  # reaches into the notch
        ((1.2, 1.2, 1.0), APART),
        ((-1.0, 0.0, 1.0), NEXT),
    ],
)
def test_a_polygon_and_a_solid_with_a_notch(
    move: tuple[float, float, float], expected: Contact
) -> None:
    square = placed(unit_square(), (1, 1, 1), move)
    assert contact(form_of(square), form_of(ell())) == expected


def test_points_and_segments() -> None:
    solid, lake = form_of(ell()), form_of(polygon([(0, 0), (4, 0), (2, 3)]))

    def line(*ends: tuple[float, float, float]) -> Form:
        return thin(np.array(ends[0]), np.array(ends[-1]))

    assert contact(line((0.5, 0.5, 1)), solid) == INSIDE
    assert contact(line((2, 2, 1)), solid) == APART
    assert contact(line((1, 2, 1)), solid) == ON
    assert contact(line((0.5, 2.5, 1), (2.5, 0.5, 1)), solid) == OVER  # ends in, middle out
    assert contact(line((2, 1, 0)), lake) == ON
    assert contact(line((2, 1, -1), (2, 1, 1)), lake) == OVER
    assert contact(line((0, 3, 0)), lake) == APART
    assert distance(line((2, 2, 1)), solid) == pytest.approx(1.0)


def test_a_roof_and_what_stands_in_it() -> None:
    roof = form_of(roof_hip(polygon([(0, 0), (8, 0), (8, 6), (0, 6)]), 45))
    assert contact(block((3.5, 2.5, 0), (4.5, 3.5, 1)), roof) == INSIDE
    assert contact(block((3.5, 2.5, 0), (4.5, 3.5, 9)), roof) == OVER
    assert contact(block((0, 0, -2), (8, 6, 0)), roof) == NEXT
    assert contact(block((0, 0, 1), (0.5, 0.5, 2)), roof) == APART


def test_mirrored_geometry_is_compared_the_same() -> None:
    turned = replace(ell(), vertices=ell().vertices * (-1, 1, 1))  # inside out
    assert contact(block((-1, 0, 0), (0, 1, 1)), form_of(turned)) == INSIDE


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 70))
def test_the_tree_finds_what_a_search_through_all_finds(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    low, other = random.uniform(0, 10, (count, 3)), random.uniform(0, 10, (40, 3))
    high, end = low + random.uniform(0, 2, (count, 3)), other + random.uniform(0, 2, (40, 3))
    reach = random.uniform(0, 2, 40)
    found = set(
        zip(*(each.tolist() for each in Tree(low, high).within(other, end, reach)), strict=True)
    )
    rows, columns = np.divmod(np.arange(40 * count), count)
    near = gaps(other[rows], end[rows], low[columns], high[columns]) <= reach[rows]
    assert found == set(zip(rows[near].tolist(), columns[near].tolist(), strict=True))
