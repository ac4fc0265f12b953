"""Edges and vertices as parts: how many, their words, their axes; what roofs call theirs."""

from __future__ import annotations

from collections import Counter

import numpy as np
from geometry.random_shapes import prisms
from hypothesis import given

from ipmlang.geometry.parts import edges, vertices
from ipmlang.geometry.raising import extrude
from ipmlang.geometry.roofs import roof_gable, roof_hip, roof_mansard
from ipmlang.geometry.solid import Solid, area, polygon, unit_box, unit_square

HALL = polygon([(0, 0), (6, 0), (6, 4), (0, 4)])
WING = polygon([(0, 0), (9, 0), (9, 4), (4, 4), (4, 8), (0, 8)])


def _counts(solid: Solid) -> Counter[str]:
    return Counter(word for piece in edges(solid) for word in piece.words)


def test_a_box_has_twelve_edges() -> None:
    counts = _counts(unit_box())
    assert (counts["all"], counts["vertical"], counts["horizontal"]) == (12, 4, 8)
    assert (counts["top"], counts["bottom"], counts["front"], counts["side"]) == (4, 4, 4, 12)
    front = next(piece for piece in edges(unit_box()) if {"front", "top"} <= piece.words)
    assert front.axes is not None
    np.testing.assert_allclose(np.abs(front.axes[0]), (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(front.axes[2], (0, -(0.5**0.5), 0.5**0.5))
    assert (len(front.solid), len(front.solid.corners), area(front.solid)) == (1, 2, 0)


@given(prisms())
def test_each_edge_is_there_once_with_unit_axes(solid: Solid) -> None:
    pieces = edges(solid)
    assert len(pieces) == len(solid.corners) // 2
    axes = np.array([piece.axes for piece in pieces])
    unit = np.broadcast_to(np.eye(3), axes.shape)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), unit, atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(axes), 1)
    ends = np.array([piece.solid.vertices for piece in pieces])
    assert len(np.unique(np.sort(ends.reshape(-1, 6).view("f8,f8,f8"), axis=1), axis=0)) <= len(
        ends
    )


def test_a_polygon_has_the_edges_of_its_outline() -> None:
    assert _counts(unit_square())["all"] == 4
    assert all("top" in piece.words for piece in edges(unit_square()))


def test_roofs_name_their_edges() -> None:
    hip = _counts(roof_hip(HALL, 40))
    assert (hip["ridge"], hip["hip"], hip["valley"], hip["eave"]) == (1, 4, 0, 4)
    gable = _counts(roof_gable(HALL, 40))
    assert (gable["ridge"], gable["hip"], gable["eave"]) == (1, 0, 2)
    wing = _counts(roof_hip(WING, 40))
    assert (wing["ridge"], wing["valley"], wing["eave"]) == (2, 1, 6)
    over = _counts(roof_hip(HALL, 40, 0.5))
    assert (over["ridge"], over["hip"], over["eave"]) == (1, 4, 4)


def test_the_bend_of_a_mansard_roof_is_no_ridge() -> None:
    counts = _counts(roof_mansard(HALL, 70, 1, 25))
    assert (counts["ridge"], counts["eave"], counts["hip"]) == (1, 4, 8)


def test_a_ridge_looks_up() -> None:
    ridge = next(piece for piece in edges(roof_hip(HALL, 40)) if "ridge" in piece.words)
    assert ridge.axes is not None
    np.testing.assert_allclose(ridge.axes[2], (0, 0, 1), atol=1e-9)
    np.testing.assert_allclose(np.ptp(ridge.solid.vertices, axis=0), (2, 0, 0), atol=1e-9)


def test_vertices_are_points_at_the_top_or_the_bottom() -> None:
    pieces = vertices(extrude(HALL, 2))
    assert len(pieces) == 8
    assert Counter(word for piece in pieces for word in piece.words) == {
        "all": 8, "top": 4, "bottom": 4
    }  # fmt: skip
    assert all(piece.solid.vertices.shape == (1, 3) for piece in pieces)
    assert [piece.solid.vertices[0].tolist() for piece in pieces][:1] == [[0, 0, 0]]
