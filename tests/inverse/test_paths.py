"""Curves that turtles drew as one path: the rules that drew them, and the path back as it was."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from inverse.textbook import SYSTEMS, Complexes, drawn

import ipmlang
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse import infer
from ipmlang.inverse.compare import compare

SIZE = 437.0


def on_page(name: str) -> tuple[Complexes, Complexes]:
    """The segments of a textbook system, y down, on a page."""
    start, end = drawn(SYSTEMS[name])
    every = np.concatenate([start, end])
    scale = SIZE / max(np.ptp(every.real), np.ptp(every.imag))
    corner = complex(every.real.min(), every.imag.max())
    return tuple(np.conj(each - corner) * scale + 10 + 10j for each in (start, end))


def data_of(start: Complexes, end: Complexes, decimals: int) -> str:
    """What a program writes that lifts its pen where a segment starts elsewhere."""

    def told(point: complex) -> str:
        return f"{point.real:.{decimals}f},{point.imag:.{decimals}f}"

    anew = np.concatenate([[True], np.abs(start[1:] - end[:-1]) > 1e-6])
    pairs = zip(start.tolist(), end.tolist(), anew.tolist(), strict=True)
    return "".join(
        (f"M{told(one)}" if lifts else "") + f"L{told(two)}" for one, two, lifts in pairs
    )


def page(body: str) -> str:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE + 20:g} {SIZE + 20:g}">'
    return f"{head}{body}</svg>"


def given_back(source: Path, folder: Path) -> ipmlang.Inference:
    """The grammar, once its file has been run, and what came out read again."""
    found = infer(source)
    found.save(folder / "x.ipm")
    ipmlang.save(ipmlang.load(folder / "x.ipm").run(), folder / "x.svg")
    given, again = (split_compound(read_svg(each)) for each in (source, folder / "x.svg"))
    assert compare(given, again).agrees(1e-6), found.text
    assert len(read_svg(folder / "x.svg").elements) == len(read_svg(source).elements)
    return found


@pytest.mark.parametrize("decimals", [1, 3, 6])
@pytest.mark.parametrize(
    "name",
    ["Koch curve", "dragon, 1.10a", "Hilbert", "Gosper, 1.11a", "weed, 1.24a", "shrinking tree"],
)
def test_a_path_comes_back_as_the_rules_that_drew_it(
    name: str, decimals: int, tmp_path: Path
) -> None:
    source = tmp_path / "drawn.svg"
    data = data_of(*on_page(name), decimals)
    source.write_text(page(f'<path d="{data}" fill="none" stroke="#06c" stroke-width="0.4"/>'))
    found = given_back(source, tmp_path)
    assert found.report.tokens < 90, found.text
    assert "asset" not in found.text and "path {" in found.text
    assert found.report.tokens_flat > 20 * found.report.tokens


def test_a_closed_curve_is_a_polygon(tmp_path: Path) -> None:
    start, _ = on_page("Koch snowflake")
    points = " ".join(f"{point.real:.4f},{point.imag:.4f}" for point in start.tolist())
    source = tmp_path / "drawn.svg"
    source.write_text(page(f'<polygon points="{points}" fill="teal" stroke="#000"/>'))
    found = given_back(source, tmp_path)
    assert "polygon { F - - F - - F }" in found.text
    assert found.report.tokens < 60


def test_other_elements_stay_beside_a_curve(tmp_path: Path) -> None:
    data = data_of(*on_page("quadratic Koch, 1.7b"), 4)
    source = tmp_path / "drawn.svg"
    body = (
        f'<rect width="9" height="5"/><path d="{data}" fill="#fea" stroke="#000"/><circle r="4"/>'
    )
    source.write_text(page(body))
    found = given_back(source, tmp_path)
    assert "asset rect, circle in" in found.text and "path { F }" in found.text


def test_curves_without_a_rule_stay_terminals(tmp_path: Path) -> None:
    random = np.random.default_rng(7)
    source = tmp_path / "drawn.svg"
    coast = np.cumsum(random.normal(size=(400, 2)), axis=0) * 5 + 200
    walk = np.cumsum([(1, 0), (0, 1), (-1, 0), (0, -1)] * random.integers(0, 9, (4, 1)), axis=0)
    for points in (coast, np.cumsum(walk[random.integers(0, 4, 300)], axis=0)):
        told = " ".join(f"{x:.2f},{y:.2f}" for x, y in points.tolist())
        source.write_text(page(f'<polyline points="{told}" fill="none" stroke="#000"/>'))
        found = given_back(source, tmp_path)
        assert found.report.rules == 0 and "polyline" in found.text


def curve(name: str, place: complex, size: float, turn: float, style: str) -> str:
    """A textbook curve of one line somewhere on the page."""
    start, end = drawn(SYSTEMS[name])
    points = np.append(start, end[-1])
    points = (points - points.mean()) / np.ptp(points.real) * np.exp(1j * np.radians(turn)) * size
    told = " ".join(f"{p.real:.5f},{-p.imag:.5f}" for p in (points + place.conjugate()).tolist())
    return f'<polyline points="{told}" {style}/>'


def test_a_curve_that_is_drawn_often_is_one_rule(tmp_path: Path) -> None:
    source = tmp_path / "drawn.svg"
    flakes = [
        curve("Koch curve", 100 + 60 * k + (80 + 50 * j) * 1j, 50, 0, 'fill="#9cf"')
        for k in range(5)
        for j in range(3)
    ]
    source.write_text(page("".join(flakes)))
    found = given_back(source, tmp_path)
    assert "asset" not in found.text
    assert "polyline" in found.text and "path { Polyline(5) }" in found.text
    assert found.report.tokens < 140, found.text


def test_curves_stand_among_rules_of_other_kinds(tmp_path: Path) -> None:
    source = tmp_path / "drawn.svg"
    dots = "".join(f'<circle cx="{20 + 8 * k}" cy="440" r="3"/>' for k in range(50))
    lines = 'fill="none" stroke="#000"'
    curves = [
        curve("Hilbert", 120 + 120j, 200, 0, lines),
        curve("dragon, 1.10a", 330 + 200j, 150, 20, lines),
    ]
    source.write_text(page(dots + "".join(curves)))
    found = given_back(source, tmp_path)
    assert "Polyline(5)" in found.text and "Polyline2(" in found.text
    assert "asset circle in" in found.text
    assert found.report.tokens < 300, found.text


@pytest.mark.parametrize("decimals", [1, 3, 8])
def test_a_bracketed_plant_beside_a_curve_are_both_rules(decimals: int, tmp_path: Path) -> None:
    """The plant is one path, its pen lifted at each branch; a rounded page keeps its decimals."""
    named = (("Koch curve", "#222"), ("weed, 1.24a", "green"), ("dragon, 1.10a", "#a00"))
    curves = [
        f'<path d="{data_of(*on_page(name), decimals)}" fill="none" stroke="{stroke}"/>'
        for name, stroke in named
    ]
    dots = "".join(f'<rect x="{20 + 8 * k}" y="440" width="6" height="5"/>' for k in range(50))
    source = tmp_path / "drawn.svg"
    source.write_text(page(curves[0] + dots + "".join(curves[1:])))
    found = given_back(source, tmp_path)
    assert found.text.count("path {") == 3, found.text
    assert found.text.count("asset") == 1 and "asset rect in" in found.text
    assert (f"decimals {decimals}" in found.text) == (decimals < 4)
    assert found.report.tokens < 350


GROWING = {
    "square spiral": (60, 90.0, lambda k: 4.0 * (k + 1), "{ F(4 + 4 * i) +(90) }"),
    "in pairs": (
        40,
        90.0,
        lambda k: 8.0 * (k // 2 + 1),
        "{ F(8 + 8 * i) +(90) F(8 + 8 * i) +(90) }",
    ),
    "triangles": (50, 121.0, lambda k: 4.0 + 5.0 * k, "{ F(4 + 5 * i) +(121) }"),
    "by a ratio": (60, -30.0, lambda k: 4 * 1.06**k, "{ F(4) -(30) *(1.06) }"),
    "shrinking": (40, 75.0, lambda k: 90 * 0.95**k, "{ F(90) +(75) *(0.95) }"),
}


def walked(count: int, turn: float, length: Callable[[int], float]) -> Complexes:
    """Corners (count + 1,) of a line that turns by so many degrees after each segment, y up."""
    steps = [length(k) * np.exp(1j * np.deg2rad(turn * k)) for k in range(count)]
    return np.asarray(SIZE / 2 * (1 + 1j) + np.concatenate([[0j], np.cumsum(steps)]))


@pytest.mark.parametrize("decimals", [3, 9])
@pytest.mark.parametrize("name", GROWING)
def test_lines_that_grow_are_a_repeat_with_growth(name: str, decimals: int, tmp_path: Path) -> None:
    count, turn, length, said = GROWING[name]
    points = walked(count, turn, length)
    told = " ".join(f"{z.real:.{decimals}f},{SIZE - z.imag:.{decimals}f}" for z in points.tolist())
    source = tmp_path / "drawn.svg"
    source.write_text(page(f'<polyline points="{told}" fill="none" stroke="#000"/>'))
    found = given_back(source, tmp_path)
    assert f"path {{ repeat(i < {count // said.count('F')}) {said} }}" in " ".join(
        found.text.split()
    ), found.text
    assert found.report.tokens < 70


def test_lines_that_hardly_grow_are_none_of_these(tmp_path: Path) -> None:
    lengths = np.random.default_rng(1).uniform(0.9, 1.1, 60).tolist()
    points = walked(60, 90.0, lambda k: 4.0 * (k + 1) * lengths[k])
    told = " ".join(f"{z.real:.3f},{SIZE - z.imag:.3f}" for z in points.tolist())
    source = tmp_path / "drawn.svg"
    source.write_text(page(f'<polyline points="{told}" fill="none" stroke="#000"/>'))
    assert "path {" not in given_back(source, tmp_path).text


def gear(teeth: int, decimals: int) -> list[tuple[float, float]]:
    """A closed outline of four corners a tooth."""
    angles = np.arange(teeth)[:, None] * 2 * np.pi / teeth + np.array([0, 0.02, 0.05, 0.08])
    points = np.array([100, 120, 120, 100]) * np.exp(1j * angles) + 200 + 200j
    points = points.ravel().round(decimals)
    return [(point.real, point.imag) for point in points.tolist()]


def steps(*moves: tuple[float, float], times: int) -> list[tuple[float, float]]:
    """Points of moves that repeat."""
    points = np.cumsum([(20, 200), *list(moves) * times], axis=0)
    return [(x, y) for x, y in points.tolist()]


CASTLE = [*[(0, -10), (10, 0), (0, 10), (10, 0)] * 5, (0, -40), (60, 0), (0, 40)]
REPEATING = {
    "zigzag": (steps((8, 15), (8, -15), times=25), "repeat(i < 25) { F + F - }", 45),
    "stairs": (steps((7, 0), (0, 5), times=20), "repeat(i < 20) {", 45),
    "meander": (
        steps((0, -40), (40, 0), (0, 30), (-20, 0), (0, -15), (10, 0), (0, 25), (20, 0), times=9),
        "repeat(i < 9) {",
        75,
    ),
    "castle": (steps(*CASTLE, times=3), "repeat(j < 5) { F - F - F + F + }", 75),
}


@pytest.mark.parametrize("name", REPEATING)
def test_what_repeats_along_a_line_is_repeated(name: str, tmp_path: Path) -> None:
    points, said, most = REPEATING[name]
    told = " ".join(f"{x:g},{y:g}" for x, y in points)
    source = tmp_path / "drawn.svg"
    source.write_text(page(f'<polyline points="{told}" fill="none" stroke="#000"/>'))
    found = given_back(source, tmp_path)
    assert said in found.text, found.text
    assert found.report.tokens <= most


@pytest.mark.parametrize("decimals", [2, 5])
@pytest.mark.parametrize("teeth", [12, 31, 48])
def test_a_gear_is_its_tooth_repeated(teeth: int, decimals: int, tmp_path: Path) -> None:
    told = " ".join(f"{x:.{decimals}f},{y:.{decimals}f}" for x, y in gear(teeth, decimals))
    source = tmp_path / "drawn.svg"
    source.write_text(page(f'<polygon points="{told}" fill="#ccc" stroke="#000"/>'))
    found = given_back(source, tmp_path)
    assert f"repeat(i < {teeth}) {{" in found.text, found.text
    assert "polygon {" in found.text
