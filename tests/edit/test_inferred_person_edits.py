"""Twenty edits that a person would make to what was read from models, over more than ten of them:
each changes three tokens or fewer of the text, what was wished for happens, the rest holds.

Models are those of tests/inverse/buildings without names, shuffled and turned, the README's, and
real ones where they are there. An edit says where in the text by a pattern that must fit once.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from edit.holding import let_go, own_axes, token_changes
from inverse.buildings.answers import FOLDER, names
from inverse.disguise import TURN, disguised, model_of

from ipmlang import edit
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.soundness import came_apart
from ipmlang.edit.buildings.tree import Tree
from ipmlang.edit.buildings.units import tolerance
from ipmlang.inverse import infer

ROOT = Path(__file__).parents[2]
REAL = ROOT / "../shared/data/mesh"
MOST_TOKENS = 3
NEAR = 1e-3  # of a size that is asked for: numbers of a text are as exact as its first size needs


@dataclass(frozen=True)
class Edit:
    """What a person wishes of a model, and the changes that give it: patterns with one group each,
    and what comes in its place. more: terminals that are drawn more than before; grows: units by
    which the whole gets longer along its own axes, None where that is not the wish; sparser: what
    stood side by side is to stand apart.
    """

    wish: str
    model: str
    changes: tuple[tuple[str, str], ...]
    more: int
    grows: tuple[float, float, float] | None = None
    sparser: bool = False


def attribute(name: str, value: int) -> tuple[str, str]:
    """An attribute set."""
    return rf"attr {name}\s*: int\s*= (\d+)", str(value)


def times(before: int, after: int) -> tuple[str, str]:
    """How often something repeats."""
    return rf"repeat\(i < ({before})\)", str(after)


def turn(before: int, after: str) -> tuple[str, str]:
    """The angle between the members of a ring."""
    return rf"rotate\([^()]*\b({before}) \* i\)", after


SEVENTH = "51.428571"
EDITS = (
    Edit("one more floor", "hotel.obj", (attribute("floors", 5),), 24, (0, 0, 3)),
    Edit("twice the width", "hotel.obj", (attribute("bays", 12),), 126, (18, 0, 0)),
    Edit("no sills", "hotel.obj", ((r"Pane( Sill)", ""),), -24),
    Edit("one more floor", "17_house_with_floors", (attribute("floors", 5),), 7, (0, 0, 3.25)),
    Edit("twice the width", "17_house_with_floors", (attribute("bays", 6),), 27, (9, 0, 0)),
    Edit("one more floor", "03_grid_of_windows", (attribute("floors", 6),), 7, (0, 0, 3)),
    Edit("twice the width", "03_grid_of_windows", ((r"box\((16\.8)", "33.6"),), 35, (16.8, 0, 0)),
    Edit("two more floors", "05_window_of_parts", (attribute("floors", 6),), 36, (0, 0, 6.4)),
    Edit("a longer wall", "08_crenellated_wall", (attribute("bays", 9),), 12, (9, 0, 0)),
    Edit("a seven-fold top", "09_round_tower", (times(12, 7), turn(30, SEVENTH)), -5, sparser=True),
    Edit("a higher spiral stair", "11_spiral_stair", (attribute("treads", 30),), 12, (0, 0, 1.44)),
    Edit("four more steps", "12_straight_stair", (times(14, 18),), 12, (0, 1.2, 0.68)),
    Edit("longer wings", "14_rotated_wings", (attribute("bays", 6),), 9, (7.2, 3.6, 0)),
    Edit("one more storey", "18_two_buildings", (times(5, 6),), 4, (0, 0, 3.25)),
    Edit("one more floor", "21_nested_four_deep", (attribute("floors", 7),), 67, (0, 0, 3.5)),
    Edit("a longer balcony", "21_nested_four_deep", (attribute("bays", 4),), 132, (2.8, 0, 0)),
    Edit("a longer bridge", "25_truss_bridge", (attribute("rows", 9),), 24, (0, 12, 0)),
    Edit("two more houses", "28_terrace", (attribute("bays", 7),), 40, (19.2, 0, 0)),
    Edit("a seven-fold tower", "castle.obj", (times(6, 7), turn(60, SEVENTH)), 2),
    Edit("other windows", "building_H.obj",
         ((r"(\w+), 1.676446, 0.557424, 1.743639", "BlockGroup_3"),), 0),
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where what is read is kept for all edits of a model."""
    return tmp_path_factory.mktemp("inferred")


def read(model: str, folder: Path) -> Path:
    """The grammar of a model, read once."""
    made = folder / f"{model.removesuffix('.obj')}.ipm"
    if not made.exists():
        infer(seen(model, folder), up="z" if model in names() else "auto").save(made)
    return made


def seen(model: str, folder: Path) -> Path:
    """The file of a model: a building of an author as triangles and nothing else."""
    if model in names():
        path = folder / f"{model}.obj"
        triangles = disguised(*model_of(FOLDER / f"{model}.ipm"), names().index(model), TURN, False)
        path.write_text(triangles, encoding="utf-8")
        return path
    path = ROOT / "examples" / model if model == "hotel.obj" else REAL / model
    if not path.exists():
        pytest.skip(f"{path} is not here")
    return path


def changed(text: str, wanted: Edit) -> str:
    for pattern, after in wanted.changes:
        found = list(re.finditer(pattern, text))
        assert len(found) == 1, f"{pattern!r} fits {len(found)} times in\n{text}"
        begin, end = found[0].span(1)
        text = text[:begin] + after + text[end:]
    return text


def fault(before: Tree, after: Tree, wanted: Edit) -> str | None:
    """What is wrong with the building after an edit, nothing if it holds."""
    if (after.terminals.high - after.terminals.low < 0).any():
        return "a part has a negative size"
    more = len(after.owner) - len(before.owner)
    if more != wanted.more:
        return f"{more} terminals more"
    grown_by = extent(after, before) - extent(before, before)
    if wanted.grows and np.abs(grown_by - wanted.grows).max() > NEAR:
        return f"longer by {grown_by.tolist()}"
    loose = came_apart(before, after, tolerance(before)) | let_go(before, after)
    if wanted.sparser:
        loose = {each for each in loose if len(set(each.split())) > 1}
    return f"came apart: {', '.join(sorted(loose))}" if loose else None


def extent(tree: Tree, seen_from: Tree) -> np.ndarray:
    low, high = tree.boxes(own_axes(seen_from))
    return np.asarray(high.max(axis=0) - low.min(axis=0))


def test_twenty_edits_of_ten_models() -> None:
    assert len(EDITS) == 20
    assert len({each.model for each in EDITS}) >= 10


@pytest.mark.parametrize("wanted", EDITS, ids=lambda each: f"{each.model}: {each.wish}")
def test_what_is_read_is_edited_by_three_tokens(wanted: Edit, folder: Path) -> None:
    path = read(wanted.model, folder)
    text = path.read_text(encoding="utf-8")
    new = changed(text, wanted)
    assert 0 < token_changes(text, new) <= MOST_TOKENS
    made = path.with_name(f"edited_{path.name}")
    made.write_text(new, encoding="utf-8")
    found = fault(grown(edit.read(path)), grown(edit.read(made)), wanted)
    assert found is None, f"{found}\n{text}"
