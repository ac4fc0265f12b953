"""Shapes that are others made larger or smaller: found, joined where it pays, never falsely."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.inverse import Inference, infer
from ipmlang.inverse.frames import apply
from ipmlang.inverse.parts import observe
from ipmlang.inverse.parts.scaling import as_one

WEDGE = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 1.5], [0, 1, 1.5]], float)
WEDGE_FACES = [(0, 3, 2, 1), (0, 1, 4), (3, 5, 2), (1, 2, 5, 4), (0, 4, 5, 3)]
PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 2]], float)
PYRAMID_FACES = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
BOX = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], float) * [1.0, 0.3, 0.5]
BOX_FACES = [
    (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
]  # fmt: skip


class _Model:
    """Solids put one after the other, written as an OBJ without names."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._count = 1

    def put(
        self, points: np.ndarray, faces: list[tuple[int, ...]], at: tuple[float, ...], size: float
    ) -> None:
        for x, y, z in points * size + np.array(at):
            self._lines.append(f"v {x!r} {y!r} {z!r}".replace("np.float64(", "").replace(")", ""))
        for face in faces:
            self._lines.append("f " + " ".join(str(self._count + each) for each in face))
        self._count += len(points)

    def save(self, folder: Path) -> Path:
        path = folder / "model.obj"
        path.write_text("\n".join(self._lines), encoding="utf-8")
        return path


def test_copies_of_other_sizes_are_told_with_exact_factors(tmp_path: Path) -> None:
    model = _Model()
    for k, size in enumerate((1.0, 1.0, 0.4, 2.5)):
        model.put(WEDGE, WEDGE_FACES, (7.0 * k, 0, 0), size)
    parts = observe(model.save(tmp_path), up="z")
    assert len(parts.classes) == 3
    factors = sorted(float(each.frame.scale[0]) for each in parts.likenesses)
    assert factors == pytest.approx([0.4, 2.5], abs=1e-9)
    joined = as_one(parts, parts.likenesses)
    assert sorted(len(each.members) for each in joined.classes) == [0, 0, 4]
    whole = parts.classes[parts.likenesses[0].of].mesh.vertices
    for row in range(4):
        every = apply(joined.frames[np.full(len(whole), row)], whole)
        assert np.allclose(every.min(axis=0), parts.low[row], atol=1e-9)
        assert np.allclose(every.max(axis=0), parts.high[row], atol=1e-9)


def test_nearly_the_same_is_not_scaled(tmp_path: Path) -> None:
    model = _Model()
    model.put(WEDGE, WEDGE_FACES, (0, 0, 0), 1.0)
    model.put(WEDGE, WEDGE_FACES, (5, 0, 0), 1.002)  # a copy that was measured, not scaled
    model.put(WEDGE * [1, 1, 1.001], WEDGE_FACES, (10, 0, 0), 2.0)  # other proportions
    model.put(BOX, BOX_FACES, (15, 0, 0), 1.0)
    model.put(BOX * [1, 1.01, 1], BOX_FACES, (20, 0, 0), 3.0)
    parts = observe(model.save(tmp_path), up="z")
    assert len(parts.classes) == 5
    assert parts.likenesses == ()


def _inferred(path: Path) -> Inference:
    found = infer(path, up="z")
    assert found.report.max_error <= 1e-6
    return found


def test_a_row_that_grows_by_as_much_is_one_repeat(tmp_path: Path) -> None:
    model = _Model()
    for k in range(6):
        model.put(WEDGE, WEDGE_FACES, (4.0 * k, 0.5 * k, 0), 1 + 0.25 * k)
    text = _inferred(model.save(tmp_path)).text
    assert text.count("asset") == 1 and text.count("repeat(") == 1
    assert "0.25 * i" in text or "0.2 * i" in text


@pytest.mark.parametrize("ratio", [0.8, 1.3])
def test_a_row_that_grows_by_a_factor_is_one_repeat(tmp_path: Path, ratio: float) -> None:
    model = _Model()
    for k in range(6):
        low = 10 * (ratio**k - 1) / (ratio - 1)
        model.put(WEDGE, WEDGE_FACES, (low, 3 * k, 2.0), 3 * ratio**k)
    text = _inferred(model.save(tmp_path)).text
    assert text.count("repeat(") == 1 and "pow(" in text
    assert "asset Part in" in text  # no copy's own place


def test_a_group_in_two_sizes_is_one_rule(tmp_path: Path) -> None:
    model = _Model()
    spots = [(0, 0, 1.0), (9, 2, 1.0), (20, -3, 0.6), (3, 11, 0.6), (14, 8, 1.7)]
    for x, y, size in spots:
        for points, faces, inside in (
            (WEDGE, WEDGE_FACES, (0, 0, 0)),
            (PYRAMID, PYRAMID_FACES, (2.5, 0.2, 0)),
            (BOX, BOX_FACES, (0.1, 1.4, 0)),
            (BOX * 0.5, BOX_FACES, (1.1, 2.3, 0.4)),
        ):
            model.put(points, faces, tuple(size * np.array(inside) + (x, y, 0)), size)
    found = _inferred(model.save(tmp_path))
    assert found.report.terminals <= 4
    assert found.report.rules == 1 and found.report.explained == 1.0


def test_scaled_copies_that_nothing_repeats_stay_shapes_of_their_own(tmp_path: Path) -> None:
    model = _Model()
    for k in range(8):
        model.put(WEDGE, WEDGE_FACES, (4.0 * k, 0, 0), 1.0)
        model.put(WEDGE, WEDGE_FACES, (9.0 * k, 7.0, 0), 3.1)
    found = _inferred(model.save(tmp_path))
    assert found.report.terminals == 2 and "*(" not in found.text
