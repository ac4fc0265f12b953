"""Buildings whose parts are read from files, resized as a whole: every point goes where the stretch
of the whole takes it, turned parts too, the text stays as short as it was, and back again it is
the same.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from ipmlang import edit
from ipmlang.edit.buildings import Wanted, resize
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import tolerance
from ipmlang.edit.draft import Draft
from ipmlang.inverse.frames import linear

FILES = Path(__file__).parent / "buildings"
GATE = """ipm 1
asset brick in "brick.obj"
table places(x, z, rz) =
    0, 0, 0
    6, 0, 0
    0, 0.5, 30
    6, 0.5, 150
Gate --> repeat(at places) { brick } [translate(3, 4, 0) rotate(0, 0, 60) Pier] Pier
Pier --> brick [translate(0, 0, 0.5) rotate(0, 0, 180) mirror brick]
start Gate on box(8, 5, 1)
"""


def gate(folder: Path) -> Draft:
    shutil.copy(FILES / "brick.obj", folder)
    return edit.read_text(GATE, folder=folder)


def points(tree: Tree) -> np.ndarray:
    """(n, 3) all that is drawn, sorted."""
    frames, found = linear(tree.terminals.frames), []
    for row, number in enumerate(tree.scene.instances.asset.tolist()):
        own = tree.meshes[number].vertices @ frames[row].T
        found.append(own + tree.terminals.frames.position[row])
    flat = np.round(np.concatenate(found), 4)
    return flat[np.lexsort(flat.T)]


@pytest.mark.parametrize("factor", [0.5, 1.5])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_every_point_of_a_whole_goes_where_the_stretch_takes_it(
    tmp_path: Path, axis: str, factor: float
) -> None:
    draft = gate(tmp_path)
    before, k = points(grown(draft)), "xyz".index(axis)
    after = grown(resize(draft, None, Wanted(**{axis: factor}, factors=True)))
    wanted = before.copy()
    wanted[:, k] = before[:, k].min() + (before[:, k] - before[:, k].min()) * factor
    wanted = wanted[np.lexsort(np.round(wanted, 3).T)]
    found = points(after)[np.lexsort(np.round(points(after), 3).T)]
    assert np.abs(found - wanted).max() < 2e-3
    low = np.abs(found[:, None] - wanted).max(axis=2).min(axis=0)
    assert low.max() <= 1e-4 + 2 * tolerance(after)


def test_what_is_stretched_keeps_its_name_and_its_rules(tmp_path: Path) -> None:
    draft = gate(tmp_path)
    made = resize(draft, None, Wanted(z=1.5, factors=True))
    assert 'asset brick in "brick.obj" stretch (1, 1, 1.5)' in made.text
    assert "on box(8, 5, 1.5)" in made.text
    assert len(made.text) < len(draft.text) + 40
    back = resize(made, None, Wanted(z=1 / 1.5, factors=True))
    assert back.text == draft.text


def test_a_model_that_is_stretched_too_far_stands_there_twice(tmp_path: Path) -> None:
    draft = gate(tmp_path)
    made = resize(draft, None, Wanted(x=2.0, factors=True))
    assert 'attr gate_count : int = 2 in 1.. "times that Gate repeats along x"' in made.text
    assert "start GateRow on box(16, 5, 1)" in made.text
    assert "stretch" not in made.text
    assert len(grown(made).owner) == 2 * len(grown(draft).owner)
    back = resize(made, None, Wanted(x=0.5, factors=True))
    assert "gate_count : int = 1" in back.text
    assert np.array_equal(points(grown(back)), points(grown(draft)))


def test_a_model_is_not_put_on_its_own_roof_that_is_none(tmp_path: Path) -> None:
    text = GATE.replace("[translate(0, 0, 0.5) rotate(0, 0, 180) mirror brick]", "")
    shutil.copy(FILES / "brick.obj", tmp_path)
    draft = edit.read_text(text.replace(" Pier\nPier", " [translate(0, 0, 1) *(0.3) Pier]\nPier"),
                           folder=tmp_path)  # fmt: skip
    made = resize(draft, None, Wanted(z=2.5, factors=True))
    assert "stretch (1, 1, 2.5)" in made.text
    assert len(grown(made).owner) == len(grown(draft).owner)


def test_a_whole_as_many_times_as_large_along_all_axes_is_scaled(tmp_path: Path) -> None:
    draft = gate(tmp_path)
    made = resize(draft, None, Wanted(1.5, 1.5, 1.5, factors=True))
    start = made.text.splitlines()[-1]
    assert re.fullmatch(r"start \[.*\*\(1\.5\) Gate\] on box\(12, 7\.5, 1\.5\)", start)
    assert made.text.splitlines()[:-1] == draft.text.splitlines()[:-1]
    before, after = (np.ptp(points(grown(each)), axis=0) for each in (draft, made))
    assert np.allclose(after, 1.5 * before)


HOUSES = """ipm 1
attr houses : int = 3 in 1..
Row    --> split x { { ~6: House }* }
House  -->
    [size(6, 8, 9) cube Wall] repeat(i < 3) { [translate(1, -0.1, 1 + 3 * i) Opening] }
    [translate(3.5, -0.1, 4) Opening]
Opening --> [size(1.4, 0.1, 1.6) cube Pane] [translate(0, 0, -0.1) size(1.4, 0.1, 0.1) cube Sill]
start Row on box(6 * houses, 8, 9)
"""


@pytest.mark.parametrize(("axis", "size"), [("x", 2.0), ("z", 2.0), ("z", 1.0)])
def test_all_of_a_kind_get_the_size_and_what_holds_them_stays(axis: str, size: float) -> None:
    draft = edit.read_text(HOUSES)
    made = resize(draft, "Pane", Wanted(**{axis: size}), parameters=False)
    low, high = grown(made).boxes(np.eye(3))
    rows = [k for k, label in enumerate(grown(made).terminals.labels) if label == "Pane"]
    assert len(rows) == 12
    assert (high - low)[rows, "xyz".index(axis)] == pytest.approx([size] * 12, rel=1e-6)
    rows = [k for k, label in enumerate(grown(made).terminals.labels) if label == "Sill"]
    assert (high - low)[rows, 2] == pytest.approx([0.1] * 12, rel=1e-6)


def test_rules_above_what_changed_alike_stay(tmp_path: Path) -> None:
    draft = edit.read_text(HOUSES)
    made = resize(draft, "Pane", Wanted(z=2.0), parameters=False)
    for line in ("Row     --> split x { { ~6: House }* }", "start Row on box(6 * houses, 8, 9)"):
        assert line in draft.text
        assert line in made.text


PORTICO = """ipm 1
Portico --> [size(9, 9, 1) cube Floor] Side [translate(0, 8, 0) Side] [translate(0, 0, 7) size(9, 9, 1) cube Beam]
Side    --> repeat(i < 3) { [translate(4 * i, 0, 1) Column] }
Column  -->
    [size(1, 1, 0.3) cube Base] [translate(0.2, 0.2, 0.3) size(0.6, 0.6, 5.3) cube Shaft]
    [translate(0, 0, 5.6) size(1, 1, 0.4) cube Capital]
start Portico
"""  # noqa: E501


@pytest.mark.parametrize("axis", ["x", "z"])
def test_parts_of_what_is_resized_keep_their_shares_of_it(axis: str) -> None:
    draft, k = edit.read_text(PORTICO), "xyz".index(axis)
    made = resize(draft, "Side", Wanted(**{axis: 1.79}, factors=True), parameters=False)
    before, after = grown(draft), grown(made)
    rows = [n for n, name in enumerate(before.terminals.labels) if name not in ("Floor", "Beam")]
    old, new = (
        (high - low)[rows, k] for low, high in (each.boxes(np.eye(3)) for each in (before, after))
    )
    assert new / old == pytest.approx(np.full(len(rows), 1.79), rel=1e-6)
