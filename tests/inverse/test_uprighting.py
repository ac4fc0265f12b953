"""Houses that stand askew, each in its own way, are drawn upright and placed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang import infer
from ipmlang.inverse.models import observed

HEADINGS = (21.4, -17.2, 105.7, 70.8, 48.7)
BOX = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
QUADS = ((1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (2, 4, 8, 6), (4, 3, 7, 8), (3, 1, 5, 7))
HOUSE = (
    ((0, 0, 0), (6, 8, 5)),
    ((1, -0.2, 1), (1, 0.1, 1.5)),
    ((3, -0.2, 1), (1, 0.1, 1.5)),
    ((5, -0.2, 0), (0.8, 0.1, 2)),
)


@pytest.fixture(scope="module")
def village(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five houses with two windows and a door each."""
    lines: list[str] = []
    count = 0
    for number, degrees in enumerate(HEADINGS):
        cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
        for low, size in HOUSE:
            points = (BOX * size + low) @ turn.T + (20 * number, 3 * number % 7, 0)
            lines += ["o part"]
            lines += ["v {:.7f} {:.7f} {:.7f}".format(*point) for point in points.tolist()]
            lines += ["f " + " ".join(str(count + k) for k in quad) for quad in QUADS]
            count += 8
    path = tmp_path_factory.mktemp("village") / "village.obj"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_shapes_are_as_large_as_they_are_made(village: Path) -> None:
    parts, _ = observed(village, "z", 1e-6)
    found = sorted(tuple(sorted(each.size.round(4).tolist())) for each in parts.classes)
    assert found == sorted({tuple(sorted(map(float, size))) for _, size in HOUSE})


def test_a_house_is_drawn_along_its_own_axes(village: Path) -> None:
    text = infer(village, up="z").text
    house = text[text.index("Village ") :].split("\n", 1)[1]
    assert house.count("-->") == 1, "five houses are one rule"
    assert "translate(0, 2, 0)" in house or "translate(2, 0, 0)" in house
