"""Buildings resized along each axis, whole and in part: nothing that touched comes apart, nothing
turns inside out, what stood in something else stays in it, and back again all is as it was.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from ipmlang import edit
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.load import Loaded
from ipmlang.edit import saving
from ipmlang.edit.buildings import dividing, growing
from ipmlang.edit.buildings.contacts import gaps, neighbours
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.resizing import Wanted, resize
from ipmlang.edit.buildings.soundness import came_apart
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import selected, tolerance
from ipmlang.edit.draft import Draft

FILES = Path(__file__).parent / "buildings"
WHOLE = {"wall": "Castle", "floors": "Lot", "round": "Keep", "bricks": "Pile", "court": "Court"}
PART = {
    "wall": ("Window", 3), "floors": ("Bay", 2), "round": ("Drum", 1), "bricks": ("Course", 2),
    "court": ("Bay", 2),
}  # fmt: skip
FACTORS = (0.3, 1.5, 4.0)
AXES = ("x", "y", "z")


def draft_of(name: str, folder: Path) -> Draft:
    target = folder / "files"
    if not target.exists():
        shutil.copytree(FILES, target)
    return edit.read(target / f"{name}.ipm")


def resized(draft: Draft, select: str, axis: str, factor: float, number: int | None) -> Draft:
    """The draft after a resize of places and sizes: attributes are tested elsewhere."""
    sizes = {axis: factor}
    wanted = Wanted(sizes.get("x"), sizes.get("y"), sizes.get("z"), factors=True)
    return resize(draft, select, wanted, number=number, parameters=False)


def check_holds(before: Tree, after: Tree) -> None:
    """What touched touches, sizes are positive, what stood within something stays there."""
    near = tolerance(before)
    old, new = before.boxes(np.eye(3)), after.boxes(np.eye(3))
    flat = (before.terminals.high - before.terminals.low).min() <= 0
    extent = after.terminals.high - after.terminals.low
    assert (extent >= 0).all() and (flat or (extent > 0).all())
    assert not came_apart(before, after, near)
    if len(old[0]) != len(new[0]):
        return
    pairs = neighbours(*old, near)
    allowed = 1e-6 * np.linalg.norm(new[1].max(axis=0) - new[0].min(axis=0)) + 2 * near
    assert gaps(*new, pairs).max(initial=0.0) <= allowed
    for i, j in (pairs.T, pairs[:, ::-1].T):
        inside = ((old[0][j] <= old[0][i] + near) & (old[1][i] <= old[1][j] + near)).all(axis=1)
        i, j = i[inside], j[inside]
        assert (new[0][j] <= new[0][i] + allowed).all()
        assert (new[1][i] <= new[1][j] + allowed).all()


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", WHOLE)
def test_the_whole_is_resized(tmp_path: Path, name: str, axis: str, factor: float) -> None:
    draft = draft_of(name, tmp_path)
    before = grown(draft)
    made = resized(draft, WHOLE[name], axis, factor, None)
    after = grown(made)
    check_holds(before, after)
    wide = [np.ptp(np.stack(tree.boxes(np.eye(3))), axis=(0, 1)) for tree in (before, after)]
    k = AXES.index(axis)
    assert wide[1][k] == pytest.approx(factor * wide[0][k], rel=0.15)
    others = [other for other in range(3) if other != k]
    assert wide[1][others] == pytest.approx(wide[0][others], rel=1e-6)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", PART)
def test_a_part_is_resized(tmp_path: Path, name: str, axis: str, factor: float) -> None:
    draft = draft_of(name, tmp_path)
    select, number = PART[name]
    before = grown(draft)
    size = box_size(before, select, number)
    k = AXES.index(axis)
    if size[k] <= 0:
        pytest.skip("it is flat along that axis")
    made = resized(draft, select, axis, factor, number)
    check_holds(before, grown(made))


def test_one_of_many_is_resized_and_its_twins_are_not(tmp_path: Path) -> None:
    """The wings share a rule for their bays: that of the others must not change with one."""
    draft = draft_of("court", tmp_path)
    before = grown(draft)
    after = grown(resized(draft, "Bay", "y", 0.5, 2))
    frames = [k for k, label in enumerate(before.terminals.labels) if label == "Frame"]
    ratio = [
        np.ptp(np.stack(after.boxes(np.eye(3)))[:, k], axis=0)
        / np.ptp(np.stack(before.boxes(np.eye(3)))[:, k], axis=0)
        for k in frames
    ]
    changed = [k for k, each in enumerate(ratio) if np.abs(each - 1).max() > 1e-6]
    assert changed == [1]


def box_size(tree: Tree, select: str, number: int) -> np.ndarray:
    from ipmlang.edit.buildings.measuring import Measured

    low, high = Measured(tree).box(selected(tree, select, number)[0])
    return np.asarray(high - low)


@pytest.mark.parametrize("factor", [0.5, 1.5, 3.0])
@pytest.mark.parametrize("name", ["wall", "round", "bricks", "court"])
def test_there_and_back_is_as_it_was(tmp_path: Path, name: str, factor: float) -> None:
    draft = draft_of(name, tmp_path)
    before = grown(draft)
    there = resized(draft, WHOLE[name], "x", factor, None)
    back = resized(there, WHOLE[name], "x", 1 / factor, None)
    after = grown(back)
    assert len(after.owner) == len(before.owner)
    for one, other in zip(before.boxes(np.eye(3)), after.boxes(np.eye(3)), strict=True):
        assert np.abs(one - other).max() <= tolerance(before)


def test_a_stretched_part_becomes_a_row_of_itself(tmp_path: Path) -> None:
    made = resized(draft_of("wall", tmp_path), "Castle", "x", 2.0, None)
    assert re.search(r"Window_row +--> split x { { ~1.2: Window_fitted }\* }", made.text)
    assert grown(made).terminals.labels.count("Pane") == 2 * 12


def test_comments_and_other_rules_stay(tmp_path: Path) -> None:
    draft = draft_of("wall", tmp_path)
    made = resized(draft, "Window", "x", 1.5, 3)
    assert made.text.startswith("// A wall with windows between two towers")
    kept = [line for line in draft.text.splitlines() if line.startswith("Window ")]
    assert kept[0].split("-->")[1] in made.text


def test_one_parameter_is_enough_where_it_is(tmp_path: Path) -> None:
    draft = draft_of("floors", tmp_path)
    made = resize(draft, "Facade", Wanted(x=21.0))
    assert made.text == draft.text.replace("box(15, 9, 0)", "box(21, 9, 0)")
    made = resize(draft, "Facade", Wanted(y=19.2))
    assert made.text == draft.text.replace("int   = 4 in", "int   = 6 in")


def test_an_edit_finishes_as_a_file(tmp_path: Path) -> None:
    made = resized(draft_of("round", tmp_path), "Keep", "x", 1.5, None)
    out = tmp_path / "out" / "wide.ipm"
    out.parent.mkdir()
    finished = edit.save(made, out)
    assert not finished.warnings
    assert finished.terminals == 12
    assert {path.name for path in finished.files} == {"wide.baked.parts.obj"}


def test_a_range_that_would_be_left_is_told() -> None:
    text = "ipm 1\nattr h : float = 4 in 2..5\nPost --> size(1, 1, h) cube Wood\nstart Post"
    made = resize(edit.read_text(text), "Wood", Wanted(z=4.5))
    assert "attr h : float = 4.5" in made.text
    assert not made.notes
    made = resize(edit.read_text(text), "Wood", Wanted(z=8.0))
    assert [each.message for each in made.notes] == [
        "`h` would have to be 8, out of its range: places and sizes were changed instead"
    ]
    assert "size(1, 1, 8) cube Wood" in made.text


def test_without_a_part_the_whole_is_resized() -> None:
    wall = edit.read_text("ipm 1\nWall --> split x { { ~2: Tile }* }\nstart Wall on box(6, 1, 3)\n")
    made = resize(wall, None, Wanted(x=10.0))
    assert made.text.splitlines()[-1] == "start Wall on box(10, 1, 3)"


def test_a_start_of_several_parts_is_no_whole() -> None:
    pair = edit.read_text("ipm 1\nA --> cube P\nB --> cube Q\nstart [A] B on box(2, 3, 4)\n")
    with pytest.raises(IpmError, match="no single part"):
        resize(pair, None, Wanted(x=3.0))


STAIR = """ipm 1
Tower -->
    [translate(-0.5, -0.5, 0) size(1, 1, scope.sz) cube Core]
    repeat(i < 12) {
        [translate(0, 0, i) rotate(0, 0, 30 * i) translate(1, -0.2, 0) size(1, 0.4, 1) cube Step]
    }
start Tower on box(4, 4, 12)
"""


@pytest.mark.parametrize("parameters", [True, False])
def test_a_whole_is_larger_when_all_of_it_is(parameters: bool) -> None:
    """The lot and the scope are taller at once; of what is drawn only the core would be."""
    draft = edit.read_text(STAIR)
    made = resize(draft, "Tower", Wanted(z=18.0), parameters=parameters)
    low, high = grown(made).boxes(np.eye(3))
    assert high[:, 2].max() == pytest.approx(18)
    assert sorted(low[1:, 2]) == pytest.approx([1.5 * k for k in range(12)])


def test_what_turns_about_an_axis_is_still_said_so() -> None:
    made = resize(edit.read_text(STAIR), "Tower", Wanted(z=18.0), parameters=False)
    assert "repeat(i < 12) {" in made.text
    assert "translate(0, 0, 1.5 * i) rotate(0, 0, 30 * i)" in made.text


def test_what_an_edit_derived_is_not_derived_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The proof of a resize counts for the file, but not for what another edit makes of it."""
    draft = draft_of("wall", tmp_path)
    made = resized(draft, "Window", "x", 1.5, 3)
    assert made.terminals == len(grown(edit.read_text(made.text, folder=draft.folder)).owner)
    derived: list[object] = []
    count = saving._count
    monkeypatch.setattr(
        saving, "_count", lambda checked: (derived.append(checked), count(checked))[1]
    )
    assert edit.save(made, tmp_path / "wide.ipm").terminals == made.terminals
    assert not derived
    other = dividing.remove(made, "Window", number=1)
    assert other.terminals is None
    assert edit.save(other, tmp_path / "less.ipm").terminals < made.terminals
    assert len(derived) == 1


def test_an_edit_goes_on_from_what_the_one_before_it_derived(tmp_path: Path) -> None:
    """The same tree for the same draft, another one when a file beside it changed."""
    draft = draft_of("bricks", tmp_path)
    tree = grown(draft)
    assert grown(draft).scene is tree.scene
    again = edit.read(draft.path)
    known = grown(again)
    assert known.scene is tree.scene and known.draft.grammar is again.grammar
    assert known.draft.terminals == len(tree.scene.instances)
    draft.path.write_text(draft.text.replace("Pile", "Heap"), encoding="utf-8")
    assert "Heap" in grown(edit.read(draft.path)).names
    assert grown(draft, seed=1).scene is not tree.scene
    model = draft.folder / "brick.obj"
    model.write_text(f"{model.read_text(encoding='utf-8')}# larger\n", encoding="utf-8")
    assert grown(draft).scene is not tree.scene


def test_attributes_are_tried_on_the_program_that_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One text is compiled, that of the result; trees of trials push out none of an edit's own."""
    draft = draft_of("floors", tmp_path)
    before = grown(draft)
    compiled: list[str] = []
    compile_loaded = growing.compile_loaded

    def noted(loaded: Loaded) -> object:
        compiled.append(loaded.main.source.text)
        return compile_loaded(loaded)

    monkeypatch.setattr(growing, "compile_loaded", noted)
    made = resize(draft, "Facade", Wanted(y=19.2))
    assert "int   = 6 in" in made.text
    lots = [text for text in compiled if "box(15, 9, 0)" not in text]
    assert compiled == [*lots, made.text], "trials of the lot, and no other"
    compiled.clear()
    assert grown(draft).scene is before.scene
    assert grown(made).names.count("Facade") == 1
    assert not compiled


def test_a_lot_that_holds_no_floor_any_more_does_not_say_the_size() -> None:
    """Made lower than its top is, a tower would lose its floors and keep the top as it was."""
    tower = edit.read_text("""ipm 1
Tower --> split z {
      ~8: split z { { ~1: cube Slab }* }
    | 6: repeat(i < 4) { [translate(i, 0, 0) size(1, 4, 6) cube Pane] }
    }
start Tower on box(4, 4, 14)
""")
    after = grown(resize(tower, "Tower", Wanted(z=0.3, factors=True)))
    low, high = after.boxes(np.eye(3))
    assert {"Slab", "Pane"} <= {label.split("_")[0] for label in after.terminals.labels}
    assert float(high.max(axis=0)[2] - low.min(axis=0)[2]) == pytest.approx(4.2)


TERRACE = """ipm 1
attr bays   : int = 6 in 1..
attr floors : int = 4 in 1..

House --> split x { { ~3: Bay }* }
Bay   --> split y { { ~2.8: Floor }* }
Floor --> box

start House on box(3 * bays, 2.8 * floors, 9)
"""


@pytest.mark.parametrize(("x", "bays", "factor"), [(40.0, 13, 40 / 39), (10.0, 3, 10 / 9)])
def test_a_size_between_two_counts_has_the_nearer_one_and_a_lot_that_fits(
    x: float, bays: int, factor: float
) -> None:
    """A terrace of thirteen bays, a little wider each, not three terraces in a row."""
    made = resize(edit.read_text(TERRACE), None, Wanted(x=x))
    assert f"attr bays   : int = {bays} in" in made.text
    said = re.search(r"box\(3 \* bays \* ([\d.]+),", made.text)
    assert said is not None and float(said[1]) == pytest.approx(factor, rel=1e-6)
    assert np.ptp(grown(made).boxes(np.eye(3))[1][:, 0]) == pytest.approx(x - x / bays)
    back = resize(made, None, Wanted(x=18.0))
    assert [each for each in back.text.split() if each] == TERRACE.split()


def test_along_two_axes_both_counts_change() -> None:
    made = resize(edit.read_text(TERRACE), None, Wanted(x=40.0, y=30.0))
    assert "int = 13 in" in made.text and "int = 11 in" in made.text


def test_a_size_out_of_all_proportion_is_not_counted_up_to() -> None:
    """Millions of bays would be derived to find out that there is no memory for them."""
    made = resize(edit.read_text(TERRACE), None, Wanted(x=1e7))
    assert "attr bays   : int = 6 in" in made.text
    with pytest.raises(IpmError, match=r"nothing can be made 1e\+300 large"):
        Wanted(x=1e300)
