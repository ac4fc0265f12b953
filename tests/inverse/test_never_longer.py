"""No grammar is longer than one placement per part, however few parts there are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.inverse import infer

BOX = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], float)
FACES = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]


def _obj(folder: Path, boxes: list[tuple[tuple[float, ...], tuple[float, ...]]]) -> Path:
    lines = []
    for count, (low, size) in enumerate(boxes):
        lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in (BOX * size + low).tolist()]
        lines += ["f " + " ".join(str(8 * count + each) for each in face) for face in FACES]
    path = folder / "boxes.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def _boxes(count: int, kind: str) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    """A row of boxes; with a floor that spans them, with a second storey, or with a second row
    turned by a quarter.
    """
    made: list[tuple[tuple[float, ...], tuple[float, ...]]] = [
        ((2.0 * k, 0, 0), (1, 0.3, 0.5)) for k in range(count)
    ]
    if kind == "floor":
        made.append(((0, 0, -0.5), (2.0 * count, 1, 0.4)))
    if kind == "storeys":
        made += [((2.0 * k, 0, 3), (1, 0.3, 0.5)) for k in range(count)]
    if kind == "corner":
        made += [((0, 2.0 * k + 3, 0), (0.3, 1, 0.5)) for k in range(count)]
    return made


@pytest.mark.parametrize("kind", ["row", "floor", "storeys", "corner"])
@pytest.mark.parametrize("count", [2, 3, 4, 6])
def test_no_grammar_is_longer_than_one_placement_per_part(
    tmp_path: Path, kind: str, count: int
) -> None:
    report = infer(_obj(tmp_path, _boxes(count, kind)), up="z").report
    assert report.tokens <= report.tokens_flat
    assert report.max_error <= 1e-6


def test_a_count_is_lifted_where_there_is_room_for_it(tmp_path: Path) -> None:
    found = infer(_obj(tmp_path, _boxes(9, "row")), up="z")
    assert "attr bays : int = 9" in found.text


def test_a_short_row_is_a_row_though_its_count_would_not_pay(tmp_path: Path) -> None:
    found = infer(_obj(tmp_path, _boxes(3, "row")), up="z")
    assert "attr" not in found.text
