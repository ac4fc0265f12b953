"""Real buildings, inferred and then edited: what touched in the model still touches."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang import edit, infer
from ipmlang.compiler import ast
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.edit.buildings import Wanted, dividing, pasting, resize
from ipmlang.edit.buildings.contacts import gaps, neighbours
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.soundness import came_apart
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import tolerance
from ipmlang.edit.draft import Draft

MODEL = "building_F_nobase"


@pytest.fixture(scope="module")
def building(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A house of 110 parts as a grammar."""
    model = Path(__file__).parents[2] / "../shared/data/mesh" / f"{MODEL}.obj"
    if not model.exists():
        pytest.skip(f"{MODEL}.obj is not here")
    out = tmp_path_factory.mktemp("inferred") / "house.ipm"
    infer(model).save(out)
    return out


def axiom(draft: Draft) -> str:
    """The rule that stands for the whole."""
    tree = grown(draft)
    return tree.names[tree.children[0][0]]


def check_touching(before: Tree, after: Tree) -> None:
    near = tolerance(before)
    assert not came_apart(before, after, near)
    assert len(after.owner) >= len(before.owner)
    if len(after.owner) == len(before.owner):
        pairs = neighbours(*before.boxes(np.eye(3)), near)
        new = after.boxes(np.eye(3))
        size = np.linalg.norm(new[1].max(axis=0) - new[0].min(axis=0))
        assert gaps(*new, pairs).max() <= 2 * max(near, 1e-6 * size)


@pytest.mark.parametrize("factor", [0.4, 1.5, 2.5])
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_real_house_is_resized(building: Path, axis: str, factor: float) -> None:
    draft = edit.read(building)
    wanted = Wanted(**{axis: factor}, factors=True)
    check_touching(grown(draft), grown(resize(draft, axiom(draft), wanted)))


@pytest.mark.parametrize("axis", ["x", "z"])
def test_there_and_back_is_the_model(building: Path, axis: str) -> None:
    draft = edit.read(building)
    whole = axiom(draft)
    there = resize(draft, whole, Wanted(**{axis: 1.6}, factors=True))
    back = grown(resize(there, whole, Wanted(**{axis: 1 / 1.6}, factors=True)))
    before = grown(draft)
    for one, other in zip(before.boxes(np.eye(3)), back.boxes(np.eye(3)), strict=True):
        assert np.abs(one - other).max() <= 0.5 * tolerance(before)


def test_a_larger_house_is_no_longer_a_text(building: Path) -> None:
    draft = edit.read(building)
    made = resize(draft, axiom(draft), Wanted(x=1.5, factors=True))
    assert count_text_tokens(made.text) < 1.2 * count_text_tokens(draft.text)
    rules = [item.head.name for item in made.grammar.items if isinstance(item, ast.Rule)]
    kept = [item.head.name for item in draft.grammar.items if isinstance(item, ast.Rule)]
    assert set(kept) <= set(rules), "a rule that only changed its numbers keeps its name"


def test_what_an_edit_does_not_reach_stays_to_the_last_bit(building: Path) -> None:
    """Faces of real models lie in one plane but for rounding: that must move nothing."""
    draft = edit.read(building)
    before = grown(draft)
    panel = before.terminals.labels.index("Panel")
    wanted = Wanted(x=1.1, factors=True)
    after = grown(resize(draft, "Panel", wanted, number=1, parameters=False))
    low, high = (np.abs(a - b).max(axis=1) for a, b in zip(
        before.boxes(np.eye(3)), after.boxes(np.eye(3)), strict=True))  # fmt: skip
    still = np.maximum(low, high) <= 1e-9
    assert not still[panel]
    assert still.mean() > 0.9


def test_parts_of_it_are_split_removed_and_pasted(building: Path, tmp_path: Path) -> None:
    draft = edit.read(building)
    tree = grown(draft)
    often = max(set(tree.terminals.labels), key=tree.terminals.labels.count)
    count = len(tree.owner)
    assert len(grown(dividing.split(draft, often, 2, 2, number=1)).owner) == count + 1
    assert len(grown(dividing.remove(draft, often, number=1)).owner) == count - 1
    other = next(label for label in tree.terminals.labels if label != often)
    made = pasting.paste(draft, often, other, number=1)
    assert len(grown(made).owner) == count
    assert edit.save(made, tmp_path / "pasted.ipm").terminals == count


@pytest.fixture(scope="module")
def hotel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A house with a hip roof as a grammar with floors and bays."""
    out = tmp_path_factory.mktemp("inferred") / "hotel.ipm"
    infer(Path(__file__).parents[2] / "examples/hotel.obj").save(out)
    return out


def test_a_house_made_wide_and_high_has_more_bays_and_floors(hotel: Path) -> None:
    """Each a little larger; and back again all is as it was."""
    draft = edit.read(hotel)
    made = resize(draft, None, Wanted(x=40.0, z=50.0))
    assert "bays   : int = 13 in" in made.text and "floors : int = 14 in" in made.text
    assert "Row" not in made.text
    check_touching(grown(draft), grown(made))
    size = grown(draft).size[0]
    back = resize(made, None, Wanted(x=float(size[0]), z=float(size[2])))
    assert back.text == draft.text


def test_no_house_stands_on_a_roof(hotel: Path) -> None:
    """A house whose floors no attribute counts is stretched, not stacked."""
    text = hotel.read_text(encoding="utf-8").replace("3 * floors", "12")
    path = hotel.with_name("fixed.ipm")
    path.write_text(text, encoding="utf-8")
    made = resize(edit.read(path), None, Wanted(z=50.0))
    assert "Row" not in made.text
