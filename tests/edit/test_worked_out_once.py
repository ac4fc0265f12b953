"""What edits work out once and use again: an edit says the same whether or not another came before
it, and quick ways give what slow ones do.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from ipmlang import edit
from ipmlang.compiler import ast
from ipmlang.compiler.nodes import nodes
from ipmlang.edit.buildings import Wanted, contacts, growing, paste, resize
from ipmlang.edit.buildings.growing import grown
from ipmlang.edit.buildings.measuring import Measured, measured
from ipmlang.edit.draft import Draft
from ipmlang.edit.places import places, places_in
from ipmlang.edit.symbols import Asked, needed_names, taken_names, used_names
from ipmlang.formats.mesh_types import Mesh, moved, stretched
from ipmlang.inverse.frames import Frames, about, compose, corners, inverse, linear, moved_to

FILES = Path(__file__).parent / "buildings"
NAMES = ("wall", "round", "court", "bricks", "floors")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return Path(shutil.copytree(FILES, tmp_path / "files"))


def larger(draft: Draft, part: str, factor: float) -> str:
    wanted = Wanted(z=factor, factors=True)
    return resize(draft, part, wanted, number=1, parameters=False).text


def test_an_edit_says_the_same_whatever_was_edited_before(folder: Path) -> None:
    """Also where the tree is still known, and what its parts are."""
    wall = edit.read(folder / "wall.ipm")
    first = larger(wall, "Window", 1.3)
    other = larger(wall, "Window", 0.8)
    paste(wall, "Window", "Window", number=1)
    assert other != first
    assert larger(wall, "Window", 1.3) == first
    larger(edit.read(folder / "court.ipm"), "Bay", 1.2)
    assert larger(edit.read(folder / "wall.ipm"), "Window", 1.3) == first
    growing._last_trees().clear()
    assert larger(edit.read(folder / "wall.ipm"), "Window", 1.3) == first


def test_what_is_known_of_parts_is_of_the_tree_that_is_asked_for(folder: Path) -> None:
    wall, court = (grown(edit.read(folder / f"{name}.ipm")) for name in ("wall", "court"))
    assert measured(wall).tree is wall
    assert measured(court).tree is court
    assert measured(wall) is measured(wall)
    for _ in range(len(wall) + len(wall.owners) + 200):
        known = measured(wall)
        known.maps(wall.frames[:1])
    assert len(known._maps) < len(wall) + len(wall.owners) + 150


@pytest.mark.parametrize("name", NAMES)
def test_parts_are_measured_in_any_frame(folder: Path, name: str) -> None:
    """Batches of maps and remembered places against one frame after the other."""
    own = grown(edit.read(folder / f"{name}.ipm"))
    known = Measured(own)
    one = own.terminals
    for row in range(len(own)):
        base = known.frame(("shape", row))
        for unit in known.parts(row):
            rows = known.rows(unit)
            back = inverse(base)
            points = corners(one.frames[np.array(rows)], one.low[rows], one.high[rows])
            local = points.reshape(-1, 3) @ linear(back)[0].T + back.position[0]
            low, high = known.box_in(unit, base)
            np.testing.assert_allclose(low, local.min(axis=0), atol=1e-9)
            np.testing.assert_allclose(high, local.max(axis=0), atol=1e-9)
            turn = linear(compose(back, known.frame(unit)))[0]
            turn /= np.linalg.norm(turn, axis=0)
            np.testing.assert_allclose(known.turned(unit, base), np.abs(turn), atol=1e-9)


def test_few_boxes_have_the_neighbours_that_many_would_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    random = np.random.default_rng(7)
    for count in (0, 1, 2, 40, 150):
        low = random.uniform(0, 2, (count, 3)).round(1)
        high = low + random.uniform(0, 1, (count, 3)).round(1)
        few = contacts.neighbours(low, high, 1e-6)
        with monkeypatch.context() as patch:
            patch.setattr(contacts, "FEW", 1)
            many = contacts.neighbours(low, high, 1e-6)
        assert few.shape == many.shape
        assert (few == many).all()
        assert count < 40 or len(few) > count / 2


@pytest.mark.parametrize("name", NAMES)
def test_places_of_a_rule_are_those_among_all(folder: Path, name: str) -> None:
    grammar = edit.read(folder / f"{name}.ipm").grammar
    rules = {item.head.name for item in grammar.items if isinstance(item, ast.Rule)} | {"start"}
    every = places(grammar)
    for rule in rules:
        assert places_in(grammar, rule) == [each for each in every if each[0].rule == rule]


@pytest.mark.parametrize("name", NAMES)
def test_names_that_are_remembered_are_those_that_are_asked_for(folder: Path, name: str) -> None:
    grammar = edit.read(folder / f"{name}.ipm").grammar
    asked = Asked()
    bodies = [item.body for item in grammar.items if isinstance(item, ast.Rule)]
    assert bodies
    for _ in range(2):
        for each in (*bodies, *grammar.items, grammar):
            assert asked.names(each) == used_names(each)
            slow = [node.name for node in nodes(each) if isinstance(node, ast.Module)]
            assert set(slow) <= used_names(each)
    later, known = Asked(asked), len(asked._known)
    assert later.names((ast.Module("new"), *bodies)) == {"new"} | used_names(tuple(bodies))
    assert len(asked._known) == known
    assert needed_names(grammar, asked) == needed_names(grammar)
    assert taken_names(grammar, asked) == taken_names(grammar)


def test_a_mesh_that_is_stretched_is_what_a_matrix_makes_of_it() -> None:
    random = np.random.default_rng(7)
    corners, normals = np.arange(60), random.normal(size=(60, 3))
    none = np.full(20, -1)
    mesh = Mesh(random.normal(size=(60, 3)), corners, 3 * np.arange(21), none, none, (), (),
                None, normals)  # fmt: skip
    mesh.vertices[:5] = -0.0
    for factors in ((1.5, 0.3, 1.0052), (1.0, 1.0, 2.0), tuple(random.uniform(0.1, 9, 3))):
        matrix = np.concatenate([np.diag(factors), np.zeros((3, 1))], axis=1)
        own, slow = stretched(mesh, factors), moved(mesh, matrix)
        assert own.vertices.tobytes() == slow.vertices.tobytes()
        assert own.normals is not None and slow.normals is not None
        assert own.normals.tobytes() == slow.normals.tobytes()


@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_what_is_only_moved_is_placed_as_what_hardly_turns(hand: float) -> None:
    rotation = about(np.array([0.6, 0.0, 0.8]), np.array([30.0, 180.0, 271.0]))
    outer = Frames(np.arange(9.0).reshape(3, 3), rotation, np.full(3, hand), np.full(3, 1.5))
    moves = Frames(*(each[np.zeros(3, int)] for each in _columns(moved_to(np.array([1.0, 2, 3])))))
    hardly = about(np.array([0.0, 1.0, 0.0]), np.full(3, 1e-9))
    turned = Frames(moves.position, hardly, moves.hand, moves.scale)
    both = (_columns(compose(outer, each)) for each in (moves, turned))
    for own, other in zip(*both, strict=True):
        np.testing.assert_allclose(own, other, atol=1e-10)


def _columns(frames: Frames) -> tuple[np.ndarray, ...]:
    return frames.position, frames.rotation, frames.hand, frames.scale
