"""Parts of buildings split, cut, joined, removed, added, scaled, pasted, mixed and transferred."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ipmlang import IpmError, edit
from ipmlang.edit.arithmetic import literal
from ipmlang.edit.buildings import dividing, pasting
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.pasting import Copying
from ipmlang.edit.buildings.resizing import Wanted, resize
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.draft import Draft

FILES = Path(__file__).parent / "buildings"
TEXT = """\
ipm 1
House --> [size(9, 0.4, 3) cube Wall] [translate(1, 0, 0) Front] [translate(4, -2, 0) Porch]
Front --> repeat(i < 3) { [translate(2.5 * i, -0.1, 1) Window] }
Window --> [size(1.2, 0.1, 1.5) cube Frame] [translate(0.1, 0.1, 0.1) size(1, 0.1, 1.3) cube Pane]
Porch --> [size(1.5, 2, 0.2) cube Step] [rotate(0, 0, 90) translate(0, -0.2, 0.2) Door]
Door --> size(1, 0.2, 2) cube Leaf
start House
"""


@pytest.fixture
def house() -> Draft:
    return edit.read_text(TEXT)


def boxes(tree: Tree, label: str) -> list[list[float]]:
    """The boxes of terminals of a label, low and high, in the order of the derivation."""
    low, high = tree.boxes(np.eye(3))
    rows = [k for k, own in enumerate(tree.terminals.labels) if own == label]
    return [[*np.round(low[k], 6).tolist(), *np.round(high[k], 6).tolist()] for k in rows]


def covers(tree: Tree, label: str) -> NDArray[np.float64]:
    found = np.array(boxes(tree, label))
    return np.concatenate([found[:, :3].min(axis=0), found[:, 3:].max(axis=0)])


def test_a_part_is_split_into_copies_in_its_room(house: Draft) -> None:
    made = grown(dividing.split(house, "Window", 0, 2, number=2))
    assert made.terminals.labels.count("Frame") == 4
    assert covers(made, "Frame") == pytest.approx(covers(grown(house), "Frame"))
    widths = sorted(round(b[3] - b[0], 6) for b in boxes(made, "Frame"))
    assert widths == [0.6, 0.6, 1.2, 1.2]


def test_a_part_is_cut_by_planes(house: Draft) -> None:
    made = grown(dividing.cut(house, "Wall", 0, [2.0, 5.0]))
    assert boxes(made, "Wall") == [
        [0, 0, 0, 2, 0.4, 3], [2, 0, 0, 5, 0.4, 3], [5, 0, 0, 9, 0.4, 3]
    ]  # fmt: skip


def test_joined_parts_are_a_rule_and_stay_where_they_are(house: Draft) -> None:
    made = dividing.join(house, "Window", [1, 2, 3], name="Range")
    assert "Range  --> repeat(i < 3) { [translate(2.5 * i, 0, 0) Window] }" in made.text
    for label in ("Frame", "Pane"):
        assert boxes(grown(made), label) == boxes(grown(house), label)


def test_a_part_is_removed_and_added(house: Draft) -> None:
    without = dividing.remove(house, "Window", number=2)
    assert [box[0] for box in boxes(grown(without), "Frame")] == [1.0, 6.0]
    back = dividing.add(without, "Window", "Front", np.array([2.5, -0.1, 1.0]))
    assert sorted(boxes(grown(back), "Frame")) == sorted(boxes(grown(house), "Frame"))


def test_an_added_part_takes_a_size(house: Draft) -> None:
    made = dividing.add(house, "Window", "House", np.zeros(3), np.array([2.4, 0.2, 3.0]))
    assert boxes(grown(made), "Frame")[-1] == [0, 0, 0, 2.4, 0.1, 3.0]


def test_a_scale_is_kept_through_later_edits(house: Draft) -> None:
    made = dividing.scale(house, "Pane", np.array([0.5, 1.0, 1.0]))
    assert boxes(grown(made), "Pane")[0] == [1.35, 0.0, 1.1, 1.85, 0.1, 2.4]
    wide = resize(made, "House", Wanted(x=1.5, factors=True))
    frame, pane = (boxes(grown(wide), label)[0] for label in ("Frame", "Pane"))
    assert (pane[3] - pane[0]) / (frame[3] - frame[0]) == pytest.approx(0.5 / 1.2)


def test_a_pasted_part_is_turned_and_fitted(house: Draft) -> None:
    before = grown(house)
    made = grown(pasting.paste(house, "Window", "Door"))
    assert "Leaf" not in made.terminals.labels
    frames, panes = boxes(made, "Frame"), boxes(made, "Pane")
    both = np.array([frames[-1], panes[-1]])
    assert [*both[:, :3].min(axis=0), *both[:, 3:].max(axis=0)] == boxes(before, "Leaf")[0]
    assert frames[-1][3] - frames[-1][0] == pytest.approx(0.1)


def test_a_pasted_part_fills_with_copies(house: Draft) -> None:
    made = pasting.paste(house, "Window", "Wall", Copying(fill=True))
    tree = grown(made)
    assert tree.terminals.labels.count("Frame") == 3 + 8 * 2 * 2
    assert "Wall" not in tree.terminals.labels


def test_an_inserted_part_keeps_what_stood_there(house: Draft) -> None:
    made = grown(pasting.paste(house, "Front", "Wall", Copying(insert=True)))
    assert made.terminals.labels.count("Wall") == 3
    assert covers(made, "Wall")[[0, 3]].tolist() == pytest.approx([0.0, 9.0], abs=1e-6)


def test_a_part_that_holds_the_source_is_refused(house: Draft) -> None:
    with pytest.raises(IpmError, match="itself"):
        pasting.paste(house, "Window", "Front")


def test_random_floors_differ_by_seed(house: Draft) -> None:
    made = pasting.mixed(house, ["Window", "Door"], name="Opening")
    assert "Opening : 50%" in made.text
    found = {tuple(grown(made, seed=seed).terminals.labels) for seed in range(8)}
    assert len(found) > 2


def test_a_rule_of_another_building_comes_along(tmp_path: Path) -> None:
    path = tmp_path / "plain.ipm"
    path.write_text(TEXT, encoding="utf-8")
    draft, other = edit.read(path), edit.read(FILES / "court.ipm")
    made = pasting.transfer(draft, other, "Bay", "Window")
    assert 'import "court"' in made.text
    out = tmp_path / "new" / "styled.ipm"
    out.parent.mkdir()
    finished = edit.save(made, out)
    assert {file.name for file in finished.files} == {"court.ipm"}
    tree = grown(edit.read(out))
    assert tree.terminals.labels.count("Ledge") == 3
    assert "Frame" in tree.terminals.labels


def test_what_no_scope_can_say_is_baked(tmp_path: Path) -> None:
    draft = edit.read_text(
        "ipm 1\nHall --> [size(4, 4, 0) quad Attic] [translate(4, 0, 0) size(2, 4, 2) cube Wing]\n"
        "Attic --> extrude(2) comp { top: roofGable(40) Roof | side: Wall | bottom: nil }\n"
        "start Hall"
    )
    made = resize(draft, "Wing", Wanted(z=3.0), parameters=False)
    assert boxes(grown(made), "Roof") == boxes(grown(draft), "Roof")
    cut = dividing.remove(draft, "Wall", number=1)
    assert len(grown(cut).terminals.labels) == len(grown(draft).terminals.labels) - 1
    out = tmp_path / "cut.ipm"
    assert {path.name for path in edit.save(cut, out).files} == {"cut.baked.parts.obj"}


def test_nobody_waits_for_a_hundred_thousand_copies(house: Draft) -> None:
    with pytest.raises(IpmError, match="at most 1,000"):
        dividing.split(house, "Window", 0, 100_000)


def test_what_is_joined_has_the_owner_of_its_first_part() -> None:
    text = "A --> [size(4, 1, 3) cube union { B | C }] translate(5, 0, 0) size(1, 1, 1) cube D\n"
    text += "B --> Wall\nC --> translate(1, 0, 0) Wall\nstart A\n"
    draft = edit.read_text("ipm 1\n" + text)
    tree = grown(draft)
    assert tree.terminals.labels == ("Wall", "D")
    assert [tree.names[row] for row in tree.owner.tolist()] == ["B", "A"]
    made = resize(draft, "D", Wanted(x=2.0))
    assert "size(2, 1, 1) cube D" in made.text


def test_what_a_turtle_draws_fits_no_box() -> None:
    draft = edit.read_text("ipm 1\nA --> F(1) &(30) B F(2)\nB --> F(3)\nstart A\n")
    with pytest.raises(IpmError, match=r"turtle|extent|building"):
        dividing.split(draft, "B", 0, 3)
    branch = edit.read_text("ipm 1\nA --> [&(30) F(2)] [^(30) B]\nB --> F(3)\nstart A\n")
    with pytest.raises(IpmError, match="drawn by a turtle"):
        dividing.split(branch, "F", 0, 3)


def test_a_number_that_grows_too_large_is_told() -> None:
    with pytest.raises(IpmError, match="too large"):
        literal(-2 * 1.79e308)


def test_a_rule_that_is_told_its_symbols_is_called_with_them() -> None:
    street = edit.read_text("""\
ipm 1
table houses(shape, x, y) =
    Slate, 0, 1
    Brick, 10, 4
    Brick, 25, 2
    Slate, 40, 3
Street --> repeat(at houses) { House(at.shape, 3) }
House(roof, tall) --> [size(5, 5, tall) cube Wall] [translate(0, 0, tall) roof]
Slate --> size(5, 5, 1) cube Tiles
Brick --> size(5, 5, 1) cube Bricks
start Street
""")
    made = resize(street, "House", Wanted(x=1.5, factors=True), number=1)
    assert "House(Brick, 3)" in made.text
    assert boxes(grown(made), "Bricks") == boxes(grown(street), "Bricks")
    assert [box[3] - box[0] for box in boxes(grown(made), "Tiles")] == [7.5, 5]


def test_random_parts_keep_the_assets_that_only_they_draw(tmp_path: Path) -> None:
    """Every door is one of both now, so nothing else asks for the asset of a door."""
    for name in ("door", "pane"):
        text = f"o {name}\nv 0 0 0\nv 1 0 0\nv 1 0 2\nf 1 2 3\n"
        (tmp_path / f"{name}.obj").write_text(text, encoding="utf-8")
    text = (
        'ipm 1\nasset door in "door.obj"\nasset pane in "pane.obj"\n'
        "House --> size(4, 4, 3) cube Wall\n"
        "Front --> House [translate(1, 0, 0) door] [translate(3, 0, 0) pane]\nstart Front\n"
    )
    made = pasting.mixed(edit.read_text(text, folder=tmp_path), ["door", "pane"])
    assert len(grown(made).owner) == 3
    drawn = {tuple(sorted(grown(made, seed=seed).drawn_assets)) for seed in range(8)}
    assert len(drawn) > 1
