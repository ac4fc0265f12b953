"""Rings, spirals and rows whose program rounded coordinates: the rule that placed them, every digit
back, and edits that follow the rule.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler import ast
from ipmlang.formats.svg import read_svg
from ipmlang.inverse import Inference, infer
from ipmlang.inverse.prove import derived
from ipmlang.inverse.unrounded import unrounded

SIZE = 400


def page(path: Path, shapes: Iterable[str]) -> Path:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE} {SIZE}">'
    path.write_text(f"{head}{''.join(shapes)}</svg>", encoding="utf-8")
    return path


def circle(x: float, y: float, decimals: int) -> str:
    return f'<circle cx="{x:.{decimals}f}" cy="{y:.{decimals}f}" r="3"/>'


def polygon(points: Iterable[tuple[float, float]], decimals: int) -> str:
    told = " ".join(f"{x:.{decimals}f},{y:.{decimals}f}" for x, y in points)
    return f'<polygon points="{told}"/>'


def around(radius: float, turns: float) -> tuple[float, float]:
    """A point about the middle of the page."""
    return 200 + radius * cos(2 * pi * turns), 200 + radius * sin(2 * pi * turns)


def florets(count: int, decimals: int) -> list[str]:
    places = [around(8 * sqrt(i + 0.5), 137.508 * i / 360) for i in range(count)]
    return [circle(x, y, decimals) for x, y in places]


def found_again(path: Path, decimals: int) -> Inference:
    """What is inferred, after every digit has come back."""
    found = infer(path)
    (canvas,) = (each for each in found.grammar.items if isinstance(each, ast.Canvas))
    assert canvas.decimals == decimals, found.text
    drawn = derived(found.text, found.parts.decode(), path.stem)
    for one, other in zip(read_svg(path).elements, drawn.elements, strict=True):
        assert one.outline is not None and other.outline is not None
        np.testing.assert_allclose(
            one.outline.coords[:, 0], other.outline.coords[:, 0], rtol=0, atol=1e-12
        )
    return found


@pytest.mark.parametrize("decimals", [1, 2, 3])
def test_phyllotaxis_is_its_angle_and_its_spread(decimals: int, tmp_path: Path) -> None:
    found = found_again(page(tmp_path / "sun.svg", florets(90, decimals)), decimals)
    assert "[+(-137.508 * i) f(8 * sqrt(i + 0.5)) -(-137.508 * i) circle]" in found.text
    assert "start at(200, 200) CircleSpiral" in found.text


def test_corners_that_were_rounded_are_one_shape_in_a_ring(tmp_path: Path) -> None:
    rays = [(around(190, i / 36), around(190, (i + 0.5) / 36)) for i in range(36)]
    shapes = [polygon([(200, 200), *each], 1) for each in rays]
    found = found_again(page(tmp_path / "rays.svg", shapes), 1)
    assert found.report.tokens < 65, found.text
    assert found.parts.count(b"<path") == 1


def test_grid_of_an_odd_size_is_told_by_its_steps(tmp_path: Path) -> None:
    step = 370 / 13
    shapes = [circle(15 + step * i, 15 + step * j, 3) for j in range(13) for i in range(13)]
    found = found_again(page(tmp_path / "dots.svg", shapes), 3)
    assert found.report.tokens < 95, found.text


def test_shapes_keep_the_symmetry_that_rounding_took(tmp_path: Path) -> None:
    """Stars of eight units at two decimals: no corner is where a turn brings another one."""
    middles = [around(150, i / 12) for i in range(12)]
    reach = [(9.0 if k % 2 else 21.0, k / 10 - 0.25) for k in range(10)]
    stars = [
        [(x + r * cos(2 * pi * t), y + r * sin(2 * pi * t)) for r, t in reach] for x, y in middles
    ]
    found = found_again(page(tmp_path / "stars.svg", (polygon(each, 2) for each in stars)), 2)
    assert found.parts.count(b"<path") == 1 and found.report.tokens < 70, found.text


def test_what_was_rounded_the_other_way_is_moved(tmp_path: Path) -> None:
    """Of a step of 8.0625 every fourth place is the middle of two decimals."""
    places = [f"{10 + 8.0625 * i:.2f}" for i in range(40)]
    assert places[30] == "251.88"
    places[30] = "251.87"
    shapes = [f'<circle cx="{x}" cy="60" r="3"/>' for x in places]
    found = found_again(page(tmp_path / "row.svg", shapes), 2)
    (table,) = (each for each in found.grammar.items if isinstance(each, ast.Table))
    assert table.columns == ("of", "x", "y") and len(table.rows) == 1, found.text


def test_what_stands_anywhere_stays_there(tmp_path: Path) -> None:
    places = np.random.default_rng(3).uniform(10, 390, (60, 2)).tolist()
    path = page(tmp_path / "any.svg", (circle(x, y, 2) for x, y in places))
    assert unrounded(read_svg(path)) is None


def test_plain_coordinates_were_not_rounded(tmp_path: Path) -> None:
    shapes = [circle(20 + 12.5 * i, 40 + 12.5 * j, 1) for j in range(5) for i in range(9)]
    assert unrounded(read_svg(page(tmp_path / "plain.svg", shapes))) is None


def test_drawing_follows_an_edit_and_is_rounded_again(tmp_path: Path) -> None:
    found = infer(page(tmp_path / "sun.svg", florets(60, 2)))
    found.save(tmp_path / "sun.ipm")
    text = (tmp_path / "sun.ipm").read_text().replace("137.508", "99.5")
    (tmp_path / "sun.ipm").write_text(text)
    scene = ipmlang.load(tmp_path / "sun.ipm").run(attrs={"circle_spiral_count": 70})
    ipmlang.save(scene, tmp_path / "more.svg")
    drawn = read_svg(tmp_path / "more.svg").elements
    assert len(drawn) == 70 and drawn[69].outline is not None
    wanted = around(8 * sqrt(69.5), 99.5 * 69 / 360)
    middle = drawn[69].outline.coords[:, 0].mean(axis=0)
    np.testing.assert_allclose(middle, np.round(wanted, 2), atol=1e-9)
