"""Models that are hardly any: nothing to tell apart, nothing to see, numbers that are none."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from bench.bench_growth import CORNERS, FACES

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.inverse import infer

Box = tuple[Sequence[float], Sequence[float]]
ROW: list[Box] = [((3 * k, 0, 0), (1, 1, 1)) for k in range(6)]


def text(boxes: Sequence[Box]) -> str:
    """Boxes as an OBJ file."""
    lines = []
    for low, size in boxes:
        lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in np.array(low) + CORNERS * size]
    for index in range(len(boxes)):
        lines += ["f " + " ".join(str(8 * index + each + 1) for each in face) for face in FACES]
    return "\n".join(lines)


def stone(around: int) -> str:
    """One shell of triangles without any regularity."""
    far = np.random.default_rng(3).uniform(0.9, 1, (around, around))
    angles = np.arange(around) * 2 * np.pi / around
    heights = np.linspace(0.01, np.pi - 0.01, around)
    lines = [
        f"v {r * np.cos(a) * np.sin(b):.6f} {r * np.sin(a) * np.sin(b):.6f} {r * np.cos(b):.6f}"
        for a, row in zip(angles, far, strict=True)
        for b, r in zip(heights, row, strict=True)
    ]
    for i in range(around):
        for j in range(around - 1):
            one, two = i * around + j + 1, (i + 1) % around * around + j + 1
            lines += [f"f {one} {two} {two + 1}", f"f {one} {two + 1} {one + 1}"]
    return "\n".join(lines)


def written(folder: Path, content: str) -> Path:
    path = folder / "model.obj"
    path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (text(ROW[:1]), "one-piece"),
        (text([ROW[0], ROW[0]]), "one-piece"),
        (stone(60), "one-piece"),
        ("v 0 0 0", "unreadable"),
        ("", "unreadable"),
        (text([((3 * k, 0, 0), (0, 0, 0)) for k in range(4)]), "unreadable"),
        (text(ROW).replace("v ", "v nan "), "unreadable"),
    ],
    ids=["one", "twice the same", "shell", "a point", "empty", "points", "no numbers"],
)
def test_nothing_to_say(tmp_path: Path, content: str, code: str) -> None:
    with pytest.raises(IpmError) as caught:
        infer(written(tmp_path, content))
    assert [each.code for each in caught.value.diagnostics] == [code]


def test_one_shell_is_told_about_docking(tmp_path: Path) -> None:
    with pytest.raises(IpmError) as caught:
        infer(written(tmp_path, stone(40)))
    (found,) = caught.value.diagnostics
    assert "3,120 triangles" in found.message or "3120 triangles" in found.message
    assert found.hint is not None and "docking" in found.hint


@pytest.mark.parametrize("wrong", ["nan", "inf", "1e300"])
@pytest.mark.filterwarnings("error")
def test_a_vertex_without_a_value_costs_its_faces_alone(tmp_path: Path, wrong: str) -> None:
    found = infer(written(tmp_path, text(ROW).replace("v 3 0 0", f"v {wrong} 0 0", 1)))
    assert found.report.elements == 6
    assert any("3 times" in note for note in found.report.notes)


def test_boxes_without_volume_are_shapes(tmp_path: Path) -> None:
    boxes: list[Box] = [((3 * k, 0, 0), (1, 1, k % 2)) for k in range(8)]
    report = infer(written(tmp_path, text(boxes))).report
    assert report.elements == 8 and report.max_error < 1e-6


def test_components_that_contain_each_other(tmp_path: Path) -> None:
    boxes: list[Box] = [
        ((10 * k + inner, inner, inner), (8 - 2 * inner,) * 3)
        for k in range(6)
        for inner in (0, 1, 2)
    ]
    report = infer(written(tmp_path, text(boxes))).report
    assert (report.elements, report.labels) == (18, 3)
    assert report.tokens < 0.5 * report.tokens_flat
