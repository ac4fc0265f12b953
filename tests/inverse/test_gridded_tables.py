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


def test_a_grid_that_needs_no_table_is_lines_of_as_many(tmp_path: Path) -> None:
    """Two grids of different shapes, too few for attributes: each is a loop in a loop."""
    marks = ("M{} {}h4l-2 3z", "M{} {}h3v1h-2v2h-1z")
    paths = "".join(
        f'<path d="{mark.format(30 * i + 15 * half, 30 * j + 15 * half)}"/>'
        for half, mark in enumerate(marks)
        for j in range(5 - half)
        for i in range(5 - half)
    )
    path = tmp_path / "marks.svg"
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 150 150">'
    path.write_text(f"{head}{paths}</svg>", encoding="utf-8")
    text = infer(path).text
    assert "repeat(j < 5) { repeat(i < 5) {" in text and "repeat(j < 4) { repeat(i < 4) {" in text
    assert "mod(" not in text


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


SHAPES = (
    '<circle cx="{}" cy="{}" r="{}"/>',
    '<rect x="{0}" y="{1}" width="{2}" height="{2}"/>',
    '<path d="M{0} {1}l{2} 9l-20 3z"/>',
)


def sheet(frames: int, across: int, *, clipped: bool = True, off: float = 0.0) -> str:
    """Icons, each of its own shapes in a frame, behind a title in a frame too."""
    random = np.random.default_rng(5)
    drawn = [
        '<clipPath id="c"><path d="M0 0h40v30h-40z"/></clipPath>',
        '<g clip-path="url(#c)" transform="translate(3,7)"><path d="M3 3h7l4 9z"/></g>',
    ]
    for k in range(frames):
        x, y = 50 * (k % across) + off * (k == 4), 60 + 45 * (k // across)
        clip = 'clip-path="url(#c)"' if clipped else 'opacity=".5"'
        drawn.append(f'<g id="icon{k}" {clip} transform="translate({x},{y})">')
        drawn.append('<path d="M1 1h38v28h-38z" fill="none"/><path d="M3 3h9v4l-4-2z"/>')
        for n in range(3):
            numbers = random.integers(2, 30, 3)
            drawn.append(SHAPES[(k + n) % 3].format(*numbers))
        drawn.append("</g>")
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300">' + "".join(drawn) + "</svg>"
    )


def test_a_sheet_of_clipped_icons_is_a_table_of_their_names(tmp_path: Path) -> None:
    path = tmp_path / "sheet.svg"
    path.write_text(sheet(12, 4), encoding="utf-8")
    found = infer(path)
    text = found.text
    names = " ".join(f"Icon{k}" for k in range(12))
    assert f"table Panels(shape) = {names}" in " ".join(text.split())
    assert 'effect("sheet.parts.svg#clip") r.shape]' in text
    assert text.count("effect(") == 2  # the title has the other
    assert "repeat(k < 12) with r in Panels" in text


@pytest.mark.parametrize("drawn", [sheet(7, 7), sheet(12, 4, off=0.7)], ids=["few", "askew"])
def test_icons_that_stand_on_no_grid_are_written_where_they_stand(
    tmp_path: Path, drawn: str
) -> None:
    path = tmp_path / "sheet.svg"
    path.write_text(drawn, encoding="utf-8")
    assert "table Panels" not in infer(path).text
