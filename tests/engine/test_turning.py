"""`rotate` about a point of the scope: what a pivot is for elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.runtime.export.placing import frame_matrices
from ipmlang.runtime.scene import Scene

SHARES = {"bottom": (0.5, 0.5, 0.0), "middle": (0.5, 0.5, 0.5), "top": (0.5, 0.5, 1.0)}


def drawn(body: str) -> Scene:
    rule = f"Lot --> translate(1, 2, 3) rotate(10, 20, 30) {body} P"
    text = f"ipm 1\n{rule}\nstart Lot on box(4, 6, 2)\n"
    return ipmlang.parse(text).run()


def matrix(scene: Scene) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    found: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = frame_matrices(
        scene.instances, np.arange(1)
    )[0]
    return found


@pytest.mark.parametrize("about", SHARES)
@pytest.mark.parametrize("mirror", ["", "mirrorScope(y)"])
def test_the_point_stays_and_the_rest_turns(about: str, mirror: str) -> None:
    before = matrix(drawn(mirror))
    after = matrix(drawn(f"{mirror} rotate(20, 0, 45, about: {about})"))
    bare = matrix(drawn(f"{mirror} rotate(20, 0, 45)"))
    point = np.append(np.array(SHARES[about]) * (4, 6, 2), 1)
    assert np.allclose(before @ point, after @ point)
    assert np.allclose(after[:, :3], bare[:, :3])


def test_a_half_turn_about_the_middle_gives_the_same_box() -> None:
    turned, plain = matrix(drawn("rotate(0, 0, 180, about: middle)")), matrix(drawn(""))
    assert np.allclose(turned @ (0, 0, 0, 1), plain @ (4, 6, 0, 1))
    assert np.allclose(turned @ (4, 6, 2, 1), plain @ (0, 0, 2, 1))


def test_each_shape_has_an_angle_of_its_own() -> None:
    text = (
        "ipm 1\nLot --> split x { { ~1: Bar }* }\n"
        "Bar --> rotate(0, 0, 10 * split.index, about: middle) P\nstart Lot on box(9, 1, 0)\n"
    )
    table = ipmlang.parse(text).run().instances
    matrices = frame_matrices(table, np.arange(9))
    middles = matrices @ (0.5, 0.5, 0, 1)
    assert np.allclose(middles[:, 0], np.arange(9) + 0.5)
    angles = np.degrees(np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0]))
    assert angles == pytest.approx(10.0 * np.arange(9))


def test_a_mirrored_scope_moves_along_its_own_axes() -> None:
    plain, moved = (
        matrix(drawn("mirrorScope(x)")),
        matrix(drawn("mirrorScope(x) translate(1, 2, 3)")),
    )
    assert np.allclose(moved[:, 3], plain @ (1, 2, 3, 1))
