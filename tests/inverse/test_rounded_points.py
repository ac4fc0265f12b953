"""Drawings whose program rounded coordinates: the rules that drew them, and every digit back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from inverse.textbook import SYSTEMS, Complexes, drawn

from ipmlang.compiler import ast, compile_text
from ipmlang.formats.svg import read_svg
from ipmlang.inverse import infer
from ipmlang.inverse.compare import compare
from ipmlang.inverse.prove import derived
from ipmlang.inverse.recursion import fold
from ipmlang.runtime import derive
from ipmlang.runtime.export.sheet import drawing_of

SIZE = 437.0
HEAD = "ipm 1\ncanvas (0, 0, 10, 10)"


def page(name: str, decimals: int) -> str:
    """The drawing of a textbook system on a page, y down, its numbers rounded."""
    start, end = drawn(SYSTEMS[name])
    every = np.concatenate([start, end])
    scale = SIZE / max(np.ptp(every.real), np.ptp(every.imag))
    left, top = every.real.min(), every.imag.max()

    def numbers(point: complex, ends: str) -> str:
        x, y = (point.real - left) * scale + 10, (top - point.imag) * scale + 10
        return f'x{ends}="{x:.{decimals}f}" y{ends}="{y:.{decimals}f}"'

    lines = "".join(
        f"<line {numbers(one, '1')} {numbers(other, '2')}/>"
        for one, other in zip(start.tolist(), end.tolist(), strict=True)
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE + 20:g} {SIZE + 20:g}">'
    return f'{head}<g stroke="#000">{lines}</g></svg>'


@pytest.mark.parametrize("decimals", [1, 2, 3])
@pytest.mark.parametrize("name", ["Koch curve", "dragon, 1.10a", "weed, 1.24a", "plant, 1.24f"])
def test_rounded_drawings_come_back_to_the_last_digit(
    name: str, decimals: int, tmp_path: Path
) -> None:
    path = tmp_path / "drawn.svg"
    path.write_text(page(name, decimals), encoding="utf-8")
    found = infer(path)
    assert found.report.max_error < 1e-12, found.text
    assert found.report.tokens < 80, found.text
    (canvas,) = (each for each in found.grammar.items if isinstance(each, ast.Canvas))
    assert canvas.decimals == decimals
    again = derived(found.text, found.parts.decode(), "drawn")
    assert compare(read_svg(path), again).agrees()


@pytest.mark.parametrize("decimals", [2, 3, 4])
def test_far_jumps_of_deep_trees_may_be_off_with_their_segments(decimals: int) -> None:
    """From a leaf back to the trunk it is twenty times as far as the leaf is long."""
    found: list[tuple[complex, complex]] = []

    def grow(at: complex, along: complex, left: int) -> None:
        found.append((at, at + along))
        for angle, scale in ((28, 0.75), (-20, 0.8)) if left else ():
            grow(at + along, along * scale * np.exp(1j * np.deg2rad(angle)), left - 1)

    grow(300 + 20j, 120j, 8)
    start, end = np.round(np.array(found), decimals).T
    extent = abs(complex(np.ptp(end.real), np.ptp(end.imag)))
    grain = 10.0**-decimals
    tree = fold(start, end, tolerance=0.75 * grain / extent, grain=grain)
    assert tree is not None and tree.steps == 9 and len(tree.rules) == 1


def test_lengths_that_are_no_multiples_are_told_in_units(tmp_path: Path) -> None:
    steps = np.tile([8.4 * np.exp(-1j * np.deg2rad(20)), 12.3 * np.exp(1j * np.deg2rad(37))], 15)
    points = 10 + 150j + np.concatenate([[0], np.cumsum(steps)])
    line = " ".join(f"{each.real:.1f},{each.imag:.1f}" for each in points.tolist())
    path = tmp_path / "zigzag.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300">'
        f'<path d="M{line}" fill="none" stroke="#000"/></svg>'
    )
    assert "{ F(8.4) - F(12.3) + }" in infer(path).text


def test_all_points_round_to_what_was_given() -> None:
    start, end = (np.round(each * 3.1234567 + 0.77, 1) for each in drawn(SYSTEMS["Koch curve"]))
    found = fold(start, end, tolerance=0.075 / abs(np.ptp(start.real)), grain=0.1)
    assert found is not None and found.steps == 5
    assert fold(*_one_off(start, end), tolerance=0.075 / abs(np.ptp(start.real)), grain=0.1) is None


def _one_off(start: Complexes, end: Complexes) -> tuple[Complexes, Complexes]:
    """One end moved by a digit."""
    end = end.copy()
    end[500] += 0.1
    return start, end


def test_decimals_round_points_and_centres() -> None:
    text = """ipm 1
canvas (0, 0, 10, 10) decimals 1
start F(1.26) +(33) F(1) [at(2.34567, 3.45678) Ring] polygon { +(10) F(2.22) +(90) F(2) vertex }
Ring --> nil
"""
    drawing = drawing_of(derive(compile_text(text)[1]))
    points = np.concatenate(
        [each.outline.coords[:, :2] for each in drawing.elements if each.outline]
    )
    assert len(points) > 3
    np.testing.assert_allclose(points * 10, np.round(points * 10), atol=1e-9)


def test_decimals_leave_arcs_and_round_the_middles_of_circles(tmp_path: Path) -> None:
    parts = (
        '<svg xmlns="http://www.w3.org/2000/svg"><circle id="ring" r="1.234"/>'
        '<path id="bow" d="M0 0A1.234 1.234 0 0 1 1.5 0.3" fill="none" stroke="#000"/></svg>'
    )
    (tmp_path / "a.parts.svg").write_text(parts, encoding="utf-8")
    text = 'asset ring, bow in "a.parts.svg"\nstart at(2.345, 3.456) ring bow\n'
    made = [
        drawing_of(derive(compile_text(f"{HEAD}{told}\n{text}", folder=tmp_path)[1]))
        for told in ("", " decimals 1")
    ]
    (ring, bow), (rounded, same) = ([each.outline for each in one.elements] for one in made)
    assert ring and bow and rounded and same
    np.testing.assert_array_equal(bow.coords, same.coords)
    np.testing.assert_allclose(rounded.coords[:, 0], [[2.3, 6.5]] * len(rounded.kind))
    np.testing.assert_array_equal(ring.coords[:, 1:], rounded.coords[:, 1:])
