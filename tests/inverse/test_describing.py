"""Words for shapes of which the file says nothing."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.formats.mesh_types import Mesh, triangle_mesh
from ipmlang.inverse.parts.describing import place_word, shape_word

WHOLE = np.array([[0.0, 0, 0], [10, 8, 20]])


def _prism(sides: int, height: float, top: float = 1.0) -> Mesh:
    """Upright, with a top that is so many times as wide as the foot."""
    angle = 2 * np.pi * np.arange(sides) / sides
    foot = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    points = np.concatenate([foot, foot * [top, top, 1] + [0, 0, height]])
    points = points - points.min(axis=0)
    after = (np.arange(sides) + 1) % sides
    k = np.arange(sides)
    quads = np.stack([k, after, after + sides, k + sides], axis=1)
    fans = [(0, a + 1, a) for a in range(1, sides - 1)]
    fans += [(sides, sides + a, sides + a + 1) for a in range(1, sides - 1)]
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]], np.array(fans)])
    return triangle_mesh(points, triangles)


def _lying(mesh: Mesh) -> Mesh:
    return triangle_mesh(mesh.vertices[:, [2, 0, 1]], mesh.corners.reshape(-1, 3))


@pytest.mark.parametrize(
    ("mesh", "word"),
    [
        (_prism(8, 2.0), "Drum"),
        (_lying(_prism(8, 2.0)), "Roll"),
        (_prism(8, 2.0, 0.1), "Cone"),
        (_prism(8, 30.0), "Post"),
        (_prism(8, 0.1), "Slab"),
        (_prism(4, 1.5, 0.8), "Block"),
        (_prism(3, 1.5), "Part"),
    ],
)
def test_forms_have_words(mesh: Mesh, word: str) -> None:
    assert shape_word(mesh) == word


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [
        ((0, 0, 0), (10, 8, 1), "Base"),
        ((0, 0, 0), (10, 8, 15), "Body"),
        ((0, 0, 17), (10, 8, 20), "Roof"),
        ((0, 3, 4), (1, 5, 12), "LeftPart"),
        ((9, 3, 4), (10, 5, 12), "RightPart"),
        ((4, 0, 4), (6, 1, 12), "FrontPart"),
        ((4, 7, 4), (6, 8, 12), "BackPart"),
        ((4, 3, 19), (6, 5, 20), "TopPart"),
        ((4, 3, 0), (6, 5, 2), "LowPart"),
        ((4, 3, 8), (6, 5, 12), "Part"),
    ],
)
def test_what_stands_once_is_called_by_its_place(
    low: tuple[float, ...], high: tuple[float, ...], word: str
) -> None:
    assert place_word(np.array(low, float), np.array(high, float), WHOLE, "Part") == word
