"""A building's own axes are found from its level edges, and one turn at the root says them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipmlang.formats.mesh_types import Mesh, triangle_mesh
from ipmlang.inverse import infer
from ipmlang.inverse.parts.axes import askew, straightened

FACES = [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip


def box(size: tuple[float, float, float]) -> Mesh:
    """A box of triangles."""
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], np.float64)
    return triangle_mesh(corners * np.array(size), np.array(FACES))


@pytest.mark.parametrize("degrees", [-44.0, -12.5, 0.3, 33.69, 45.0])
def test_a_box_that_stands_askew_says_by_how_much(degrees: float) -> None:
    """To a billionth of a degree, in either direction, and turned back it keeps to the world."""
    turned = straightened(box((7, 3, 2)), -degrees)
    assert askew(turned) == pytest.approx(degrees, abs=1e-9)
    assert askew(straightened(turned, askew(turned))) == 0


def test_what_has_no_axes_is_left_as_it_is() -> None:
    """A box in the world's axes, and one of which nothing is level."""
    straight = box((7, 3, 2))
    assert askew(straight) == 0
    tilt = np.linalg.qr(np.array([[1.0, 2, 3], [2, 1, 1], [3, 5, 1]]))[0]
    assert askew(replace(straight, vertices=straight.vertices @ tilt)) == 0


def test_a_row_that_stands_askew_is_printed_with_one_turn(tmp_path: Path) -> None:
    """The steps of the row are along an axis."""
    lines = []
    for k in range(6):
        own = box((1, 2, 3))
        own = straightened(replace(own, vertices=own.vertices + np.array([4.0 * k, 0, 0])), -20.0)
        lines += [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in own.vertices.tolist()]
        lines += [f"f {a + 8 * k + 1} {b + 8 * k + 1} {c + 8 * k + 1}" for a, b, c in FACES]
    path = tmp_path / "row.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    found = infer(path, up="z")
    assert found.text.count("rotate(") == 1
    assert "rotate(0, 0, 20)" in found.text
