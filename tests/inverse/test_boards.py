"""Things of any size on grids, painted line by line: one formula, and a number for each thing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from ipmlang.inverse import Inference, infer
from ipmlang.inverse.boards.coordinates import coordinate
from ipmlang.inverse.boards.raster import Raster, rasters

HALFTONE = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg" / "vpype_halftone.svg"
ACROSS, LINES = 30, 24

Drawn = Callable[[int, int, float], str]  # what stands at step i of line j, with a random number


def _inferred(folder: Path, drawn: Drawn, before: str = "") -> Inference:
    random = np.random.default_rng(3)
    shapes: Iterator[str] = (
        drawn(i, j, float(random.random())) for j in range(LINES) for i in range(ACROSS)
    )
    path = folder / "board.svg"
    page = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300">'
    path.write_text(f"{page}{before}{''.join(shapes)}</svg>", encoding="utf-8")
    return infer(path)


def _staggered(i: int, j: int, size: float) -> str:
    return (
        f'<circle cx="{10 + 12 * i + 6 * (j % 2)}" cy="{10 + 11 * j}" r="{0.5 + 4 * size:.2f}" '
        'fill="none" stroke="#333" stroke-width="0.7"/>'
    )


def _with_holes(i: int, j: int, size: float) -> str:
    side = round(1 + 9 * size, 1)
    if size < 0.15 and (i, j) not in ((0, 0), (ACROSS - 1, LINES - 1)):
        return ""
    corner = f'x="{round(20 + 12 * i - side / 2, 2)}" y="{round(20 + 11 * j - side / 2, 2)}"'
    return f'<rect {corner} width="{side}" height="{side}"/>'


def _rounded(i: int, j: int, size: float) -> str:
    middle = f'cx="{10 + 7.137 * i:.1f}" cy="{10 + 7.137 * j:.1f}"'
    return f'<circle {middle} r="{1 + 2 * size:.2f}"/>'


def _from_the_top(i: int, j: int, size: float) -> str:
    """As programs write it that round the point in which a path begins."""
    radius = round(1 + 2 * size, 3)
    top = f"M{10 + 9.1 * i:.1f},{10.04 + 9.137 * j - radius:.1f}"
    return f'<path d="{top}a{radius} {radius} 0 1 0 0.0001 0Z" fill="none" stroke="#000"/>'


@pytest.mark.parametrize("drawn", [_staggered, _with_holes, _rounded, _from_the_top])
def test_one_number_for_each_thing(tmp_path: Path, drawn: Drawn) -> None:
    found = _inferred(tmp_path, drawn, '<rect width="400" height="300" fill="#eee"/>')
    assert found.report.tokens < ACROSS * LINES + 150
    assert found.report.explained > 0.95
    assert found.report.max_error <= 1e-6


def test_sizes_of_two_colours_name_the_shape(tmp_path: Path) -> None:
    def drawn(i: int, j: int, size: float) -> str:
        color = "red" if size * 10 % 1 < 0.3 else "blue"
        return _rounded(i, j, size).replace("/>", f' fill="{color}"/>')

    found = _inferred(tmp_path, drawn)
    assert "r.shape" in found.text
    assert found.report.tokens < 2 * ACROSS * LINES + 150


def test_sizes_that_a_rule_says_stay_a_rule(tmp_path: Path) -> None:
    def drawn(i: int, j: int, _: float) -> str:
        return f'<circle cx="{10 + 12 * i}" cy="{10 + 12 * j}" r="{1 + 0.1 * i:.1f}"/>'

    assert _inferred(tmp_path, drawn).report.tokens < 150


def test_what_stands_beside_a_board_has_rules(tmp_path: Path) -> None:
    stripes = "".join(f'<rect y="{37 * k}" width="640" height="18"/>' for k in range(7))
    stars = "".join(
        f'<circle r="5" cx="{round(16.4 + 60.8 * i + 30.6 * (j % 2))}" cy="{round(12 + 25.83 * j)}"'
        ' fill="#fff"/>'
        for j in range(9)
        for i in range(6 - j % 2)
    )
    path = tmp_path / "flag.svg"
    page = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 480">'
    path.write_text(f"{page}{stripes}{stars}</svg>", encoding="utf-8")
    found = infer(path)
    assert "round(" in found.text and "RectColumn -->" in found.text
    assert found.report.rules == 2
    assert found.report.explained == 1.0


def test_a_scattered_drawing_has_no_raster() -> None:
    random = np.random.default_rng(1)
    places = random.uniform(0, 9, 200) + 1j * random.uniform(0, 9, 200)
    assert rasters(places, np.zeros(200, np.int64)) == []


@pytest.mark.skipif(not HALFTONE.is_file(), reason="the shared drawings are not there")
def test_the_halftone_is_one_board() -> None:
    report = infer(HALFTONE).report
    assert report.tokens < 2900
    assert report.explained == 1.0
    assert report.max_error <= 1e-6


Point = tuple[float, float]


def _box(random: np.random.Generator, hidden: bool) -> str:
    """A box from its front corner, seen from above; the lines behind it are dashed."""
    x, y, wide, high, deep = random.uniform((20, 20, 5, 5, 5), (380, 280, 40, 20, 30))
    axes = np.array([[wide * 0.86, -wide * 0.5], [-deep * 0.7, -deep * 0.5], [0.0, -high]])

    def corner(*which: int) -> Point:
        at = np.array([x, y]) + axes[list(which)].sum(axis=0)
        return round(float(at[0]), 5), round(float(at[1]), 5)

    seen = [((), (2,)), ((), (0,)), ((), (1,)), ((0,), (0, 2)), ((2,), (0, 2)), ((2,), (1, 2))]
    seen += [((1,), (1, 2)), ((1, 2), (0, 1, 2)), ((0, 2), (0, 1, 2))]
    behind = [((0,), (0, 1)), ((1,), (0, 1)), ((0, 1), (0, 1, 2))]
    lines = behind if hidden else seen
    dashes = ' stroke-dasharray="1 2"' if hidden else ""
    ends = [(*corner(*one), *corner(*other)) for one, other in lines]
    return "".join(
        f'<line x1="{a}" y1="{b}" x2="{c}" y2="{d}" stroke="#000"{dashes}/>' for a, b, c, d in ends
    )


def test_boxes_of_all_sizes_are_one_rule_of_three_lengths(tmp_path: Path) -> None:
    path = tmp_path / "boxes.svg"
    drawn = []
    for hidden in (False, True):
        random = np.random.default_rng(7)
        drawn += [_box(random, hidden) for _ in range(40)]
    page = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300">'
    path.write_text(f"{page}{''.join(drawn)}</svg>", encoding="utf-8")
    found = infer(path)
    assert "Figure(a, b, c)" in found.text
    assert found.report.explained == 1.0
    assert found.report.tokens < 40 * 6 + 280, found.text
    assert found.report.max_error <= 1e-6


BOXES = HALFTONE.with_name("cad_packed_boxes.svg")


@pytest.mark.skipif(not BOXES.is_file(), reason="the shared drawings are not there")
def test_packed_boxes_are_one_rule_of_three_lengths() -> None:
    report = infer(BOXES).report
    assert report.tokens < 600
    assert report.explained == 1.0


def test_no_place_is_left_on_a_tie() -> None:
    raster = Raster(0, 200, 100, np.arange(200))
    written = np.round(5.0001 + 5.0137 * raster.i - 1e-6, 2)
    still, size = np.ones(200, np.bool_), np.zeros(200)
    made = coordinate(raster, written + 5e-5, size, still, 0.0, 2.3e-4)
    assert made is not None
    assert made.decimals == 2
    before = 100 * (made.terms[0] + made.terms[1] * raster.i)
    assert np.abs(before % 1 - 0.5).min() > 1e-4
    assert np.abs(made.at(raster) - written).max() < 1e-9
