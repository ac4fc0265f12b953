"""Cells of a board in reading order are one loop over a grid, with what differs in its table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.inverse import infer
from ipmlang.inverse.gridded_tables import grid_of

COLORS = ("#ebedf0", "#9be9a8", "#40c463", "#30a14e", "#216e39")


def nodes(count: int, across: int, skipped: int = 0) -> tuple[np.ndarray, np.ndarray]:
    node = np.arange(skipped, skipped + count)
    return node % across, node // across


@pytest.mark.parametrize(
    ("along", "down", "aside"),
    [(3, -4j, 0), (2j, 5, 0), (3 + 1j, -1 + 3j, 0), (4, -3j, 2)],
    ids=["rows", "columns", "skewed", "staggered"],
)
@pytest.mark.parametrize(("count", "across"), [(24, 6), (23, 5), (12, 12)])
@pytest.mark.parametrize("skipped", [0, 2])
def test_even_lines_are_a_grid(
    along: complex, down: complex, aside: complex, count: int, across: int, skipped: int
) -> None:
    i, j = nodes(count, across, skipped)
    places = 7 + 9j + along * i + down * j + aside * (j % 2)
    found = grid_of(places, 1e-6)
    assert found is not None
    at = found.origin + found.formula.frames().position[found.skipped :]
    np.testing.assert_allclose(at, places, atol=1e-6)


def test_what_is_no_grid_stays() -> None:
    i, j = nodes(24, 6)
    places = 3.0 * i - 4j * j
    moved = places.copy()
    moved[10] += 0.01
    shuffled = np.random.default_rng(1).permutation(places)
    for each in (moved, shuffled, places[:7], np.zeros(24, np.complex128), np.delete(places, 9)):
        assert grid_of(np.asarray(each), 1e-6) is None


def test_a_board_of_five_colors_is_a_grid_of_shapes(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    cells = "".join(
        f'<rect x="{13 * week}" y="{13 * day}" width="10" height="10" '
        f'fill="{COLORS[random.integers(5)]}"/>'
        for week in range(30)
        for day in range(7)
    )
    path = tmp_path / "board.svg"
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 100">'
    path.write_text(f"{head}{cells}</svg>", encoding="utf-8")
    found = infer(path)
    assert found.report.max_error < 1e-9
    assert found.report.tokens < 210 + 80, found.text
    assert "at(5 + 13 * floor(k / 7), 95 - 13 * mod(k, 7)) r.shape" in found.text
    assert (found.report.rules, found.report.explained) == (1, 1.0)
