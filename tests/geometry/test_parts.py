"""Faces as parts: their order, their words, their axes and boxes."""

from __future__ import annotations

import numpy as np
import pytest
from geometry.random_shapes import prisms
from hypothesis import given

from ipmlang.geometry.parts import LOOKS, face_scopes, face_words, faces
from ipmlang.geometry.raising import extrude
from ipmlang.geometry.solid import (
    BOX_TAGS,
    Solid,
    area,
    normals,
    placed,
    polygon,
    solid_of,
    tagged,
    unit_box,
    unit_square,
)

BOX_AXES = {
    "bottom": [(1, 0, 0), (0, -1, 0), (0, 0, -1)],
    "top": [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "front": [(1, 0, 0), (0, 0, 1), (0, -1, 0)],
    "right": [(0, 1, 0), (0, 0, 1), (1, 0, 0)],
    "back": [(-1, 0, 0), (0, 0, 1), (0, 1, 0)],
    "left": [(0, -1, 0), (0, 0, 1), (-1, 0, 0)],
}


def test_a_box_has_the_faces_and_axes_that_the_language_says() -> None:
    pieces = faces(placed(unit_box(), (8, 11, 10), (1, 2, 3)))
    assert [next(iter(piece.words & set(LOOKS))) for piece in pieces] == list(BOX_TAGS)
    for piece, name in zip(pieces, BOX_TAGS, strict=True):
        np.testing.assert_array_equal(piece.axes, BOX_AXES[name])
        assert ("side" in piece.words) == (name not in ("top", "bottom"))
        assert ("vertical" in piece.words) == ("side" in piece.words)
        assert {"all"} <= piece.words


@given(prisms())
def test_the_parts_have_the_faces_of_the_whole(solid: Solid) -> None:
    pieces = faces(solid)
    assert len(pieces) == len(solid)
    assert sum(area(piece.solid) for piece in pieces) == pytest.approx(area(solid), rel=1e-12)
    axes = np.array([piece.axes for piece in pieces])
    unit = np.broadcast_to(np.eye(3), axes.shape)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), unit, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(axes), 1)
    np.testing.assert_allclose(axes[:, 2], normals(solid), atol=1e-12)


@given(prisms())
def test_scopes_are_the_boxes_of_the_parts(solid: Solid) -> None:
    scopes = face_scopes(solid)
    for n, piece in enumerate(faces(solid)):
        own = (piece.solid.vertices - scopes.origins[n]) @ scopes.axes[n].T
        np.testing.assert_allclose(own.min(axis=0), 0, atol=1e-9)
        np.testing.assert_allclose(own.max(axis=0), scopes.sizes[n], atol=1e-9)
        assert scopes.sizes[n][2] == pytest.approx(0, abs=1e-9)


def test_x_runs_along_the_lowest_edge_the_longest_of_several() -> None:
    slope = solid_of([(0, 0, 0), (4, 0, 0), (3, 2, 2), (1, 2, 2)], [[[2, 3, 0, 1]]])
    np.testing.assert_allclose(faces(slope)[0].axes[0], (1, 0, 0))
    notched = polygon([(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (5, 0), (5, 3), (0, 3)])
    wall = solid_of(notched.vertices[:, [0, 2, 1]], [[list(range(8))]])
    np.testing.assert_allclose(faces(wall)[0].axes, BOX_AXES["front"])


def test_level_faces_keep_the_parents_x_or_take_the_longest_edge() -> None:
    cut = polygon([(0, 0), (1, 0), (9, 8), (0, 8)])
    np.testing.assert_allclose(faces(cut)[0].axes, np.eye(3))
    turn = np.array([[0.8, 0.6], [-0.6, 0.8]])
    turned = polygon(np.array([(0, 0), (5, 0), (5, 2), (0, 2)]) @ turn)
    for face in faces(extrude(turned, 1))[:2]:
        np.testing.assert_allclose(face.axes[0], (0.8, 0.6, 0), atol=1e-12)


@pytest.mark.parametrize(
    ("slope", "look", "lean"),
    [(0.5, "top", "horizontal"), (30, "top", "aslant"), (45, "front", "aslant"),
     (89.5, "front", "vertical"), (150, "bottom", "aslant")],
)  # fmt: skip
def test_words_go_by_slope(slope: float, look: str, lean: str) -> None:
    angle = np.radians(slope)
    up = (0, np.cos(angle), np.sin(angle))
    face = solid_of([(0, 0, 0), (1, 0, 0), (1, *up[1:]), up], [[[0, 1, 2, 3]]])
    (words,) = face_words(face)
    assert {look, lean} <= words
    assert len(words) == 3 + (look == "front")


def test_diagonal_walls_look_to_the_front_or_the_back() -> None:
    diamond = extrude(polygon([(0, -1), (1, 0), (0, 1), (-1, 0)]), 1)
    words = [piece.words for piece in faces(diamond)[2:]]
    assert ["front" in each for each in words] == [True, False, False, True]


def test_tags_are_words() -> None:
    roof = faces(extrude(tagged(unit_square(), "street"), 1))
    assert {"street", "extrude.top", "top"} <= roof[1].words
    assert "street" not in roof[2].words


def test_texture_coordinates_and_holes_go_along() -> None:
    court = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (1, 3), (3, 3), (3, 1)]])
    top = faces(extrude(court, 2))[1].solid
    assert (area(top), len(top.rings)) == (12, 3)
    assert [len(piece.solid) for piece in faces(court)] == [1]
