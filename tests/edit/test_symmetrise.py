"""Nearly equal parameters made equal; offsets from tables left out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ipmlang import edit
from ipmlang.edit import Tolerances

GRID = """\
ipm 1
table T(dx, dy, turn) =
    (0.2, -0.1, 3)
    (-0.3, 0.2, -2)
    (0.1, 0.1, 1)
Window --> F(2)
Row --> repeat(i < 3) with r in T { [at(r.dx, r.dy, r.turn) Window] f(13 + r.dx) }
Grid --> [Row] [at(0, 52.1) Row] [at(0, 103.9) Row]
start Grid
"""


def test_a_jittered_grid_becomes_a_regular_one(tmp_path: Path) -> None:
    out = tmp_path / "grid.ipm"
    edit.save(edit.symmetrise(edit.read_text(GRID), Tolerances(length=0.5)), out)
    text = out.read_text(encoding="utf-8")
    assert "table" not in text
    assert "repeat(i < 3) { [Window] f(13) }" in text


def test_equal_within_the_tolerance_and_no_further(tmp_path: Path) -> None:
    text = "ipm 1\nA --> f(12.9) F(13.1) +(44.8) f(14) -(45.1) *(0.999) F(-13) +(17.14)\nstart A"
    draft = edit.symmetrise(edit.read_text(text), Tolerances(length=0.3, angle=0.5))
    assert "A --> f(13) F(13) +(45) f(14) -(45) *(1) F(-13) +(17.14)" in draft.text


def test_only_what_can_be_compared_becomes_equal() -> None:
    text = "ipm 1\nA --> f(30.1) [at(30.2, 9) F(29.9)] B\nB --> [at(30.4, 8) F(1)]\nstart A"
    found = edit.symmetrise(edit.read_text(text), Tolerances(length=1)).text
    assert "A --> f(30) [at(30.2, 9) F(30)] B" in found
    assert "at(30.4, 8)" in found


def test_what_is_nearly_nothing_is_nothing() -> None:
    draft = edit.read_text("ipm 1\nA --> [at(0.0004, 40) F(20)] [at(-39.9997, 0) F(20)]\nstart A")
    assert "A --> [at(0, 40) F(20)] [at(-40, 0) F(20)]" in edit.symmetrise(draft).text


def test_attributes_and_tables_that_motions_take_snap_too() -> None:
    text = """\
ipm 1
table Places(x, y) =
    (10.01, 5)
    (9.99, 5)
attr step : float = 10.02 in 1..
A --> repeat(r in Places) { [at(r.x, r.y) F(9.98)] f(step) }
start A
"""
    found = edit.symmetrise(edit.read_text(text), Tolerances(length=0.1)).text
    assert "10, 5\n    10, 5\n" in found
    assert "attr step : float = 10 in 1.." in found


def test_places_of_rows_snap_too() -> None:
    text = "ipm 1\ntable T(x, rz) = 10.01, 89.9 9.99, 0\nA --> repeat(at T) { F(3) }\nstart A"
    found = edit.symmetrise(edit.read_text(text), Tolerances(length=0.1)).text
    assert "10, 90\n    10, 0\n" in found


def test_even_steps_become_one_where_nothing_sees_the_end() -> None:
    rows = "Row --> repeat(i < 3) steps (13.1, 12.9) { [F(1)] }"
    alone = edit.read_text(f"ipm 1\n{rows}\nstart [Row] [at(0, 9) Row]")
    followed = edit.read_text(f"ipm 1\n{rows}\nstart Row F(9)")
    tolerances = Tolerances(length=0.5)
    assert "repeat(i < 3) { [F(1)] f(13) }" in edit.symmetrise(alone, tolerances).text
    assert "steps (13, 13)" in edit.symmetrise(followed, tolerances).text


def test_a_residual_goes_and_its_paint_stays(
    tmp_path: Path, where: Callable[[Path, str], NDArray[np.float64]]
) -> None:
    text = """\
ipm 1
table T(x, color) =
    (0.5, "red")
    (-0.5, "blue")
residual T
start F(4) F(4)
"""
    out = tmp_path / "out.ipm"
    edit.save(edit.symmetrise(edit.read_text(text)), out)
    assert np.allclose(where(out, "F")[:, 0], [0, 4])
    assert '"red"' in out.read_text(encoding="utf-8")
    plain = edit.read_text(
        text.replace(", color", "").replace(', "red"', "").replace(', "blue"', "")
    )
    assert "residual" not in edit.symmetrise(plain).text
    assert "table" not in edit.symmetrise(plain).text


@pytest.mark.parametrize("name", ["house", "star"])
def test_once_is_enough(folder: Path, name: str) -> None:
    once = edit.symmetrise(edit.read(folder / f"{name}.ipm"))
    assert edit.symmetrise(once).text == once.text


def test_a_residual_of_some_terminals_goes_whole_where_it_says_nothing_of_paint() -> None:
    text = "ipm 1\ntable T(of, x) = (1, 2)\nresidual T\nstart F f F\n"
    assert "residual" not in edit.symmetrise(edit.read_text(text)).text
    painted = text.replace("(of, x) = (1, 2)", "(of, x, layer) = (1, 2, 0)")
    assert "table T(of, layer) =" in edit.symmetrise(edit.read_text(painted)).text
