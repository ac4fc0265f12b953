"""The paper's branching rules r3 and r4 found from placed copies in any order, and run again."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.inverse.lsystem.frames import Frames, compose, frames, identity, join
from ipmlang.inverse.lsystem.symmetry import dihedral, of_line
from ipmlang.inverse.recursion import (
    branching_rules,
    branching_start,
    find_branching,
    find_tips,
    tip_place,
)
from ipmlang.inverse.recursion.twigs import Twig, grow

Numbers = tuple[float, float, float, float]
SAME: Numbers = (0, 0, 0, 0)


def twig(first: Numbers, slope: Numbers = SAME, hand: int = 1, less: int = 1) -> Twig:
    return Twig(np.array(first, float), np.array(slope, float), hand, less)


FIGURE_1 = [twig((-17, 64, 0.8, -3)), twig((7, 181, 0.6, 23))]
STRUCTURES = {
    "figure 1": (FIGURE_1, 3),
    "deeper": (FIGURE_1, 8),
    "three branches": ([*FIGURE_1, twig((50, 60, 0.75, 0))], 5),
    "unequal": ([twig((-27, 64, 0.8, -3)), twig((37, 60, 0.8, 23), less=2)], 8),
    "changing": (
        [twig((-17, 64, 0.8, -3), (4, 0, 0, -1)), twig((27, 81, 0.7, 23), (-3, 0, 0, 2))],
        5,
    ),
    "mirrored": ([twig((-20, 64, 0.7, -10)), twig((25, 60, 0.7, 15), hand=-1)], 6),
    "four ways": ([twig((90.0 * k, 60 + k, 0.45, 0)) for k in range(4)], 4),
}


def structure(name: str, seed: int) -> Frames:
    """All nodes in an order of chance."""
    twigs, depth = STRUCTURES[name]
    grown = grow(frames(np.array([10 + 20j]), 90.0), twigs, depth, 100000)
    assert grown is not None
    return grown.frames[np.random.default_rng(seed).permutation(len(grown.frames))]


def run(found: object, node: str) -> tuple[str, np.ndarray]:
    """The grammar's text and the places of what it draws."""
    drawn = ast.Bracket((ast.Module(node, (ast.Argument(ast.Number(10.0)),)),))
    rules = branching_rules(found, "R", (drawn,))
    start = ast.Start(branching_start(found, "R"))
    text = format_grammar(ast.Grammar((ast.Version(1), *rules, start)))
    rows = ipmlang.parse(text).run().instances
    return text, rows.position[:, 0] + 1j * rows.position[:, 1]


@pytest.mark.parametrize("name", STRUCTURES)
def test_structure_is_found_in_any_order(name: str) -> None:
    placed = structure(name, 5)
    found = find_branching(placed, identity(1), radius=10, tolerance=1e-4)
    assert found is not None
    assert len(found.twigs) == len(STRUCTURES[name][0])
    assert found.depth == STRUCTURES[name][1]
    _, places = run(found, "F")
    assert np.abs(places - placed.position[found.order]).max() < 1e-6


@pytest.mark.parametrize("name", STRUCTURES)
def test_structure_is_found_as_it_is_painted(name: str) -> None:
    twigs, depth = STRUCTURES[name]
    grown = grow(frames(np.array([10 + 20j]), 90.0), twigs, depth, 100000)
    assert grown is not None
    placed = grown.frames[grown.preorder()]
    before = frames(np.arange(3) * (37 + 11j) - 900, np.arange(3) * 13.0, 0.9)
    found = find_branching(
        join([before, placed]), identity(1), radius=10, tolerance=1e-4, painted=True
    )
    assert found is not None
    assert len(found.twigs) == len(twigs)
    assert found.order.tolist() == list(range(3, 3 + len(placed)))


def test_other_orders_are_not_as_it_is_painted() -> None:
    placed = structure("deeper", 5)
    assert find_branching(placed, identity(1), radius=10, tolerance=1e-4, painted=True) is None


def test_figure_1_reads_as_in_the_paper() -> None:
    found = find_branching(structure("figure 1", 1), identity(1), radius=10, tolerance=1e-4)
    text, _ = run(found, "F")
    assert "[-(17) f(64) *(0.8) -(3) R(m - 1)]" in text
    assert "[+(7) f(181) *(0.6) +(23) R(m - 1)]" in text
    assert "start at(10, 20, 90) R(3)" in text


@pytest.mark.parametrize("name", ["figure 1", "deeper", "unequal", "three branches"])
def test_round_shapes_have_no_heading_to_see(name: str) -> None:
    placed = structure(name, 3)
    turned = frames(placed.position, 0.0, placed.scale)
    found = find_branching(turned, identity(1), free=True, radius=10, tolerance=1e-4)
    assert found is not None
    assert len(found.order) == len(placed)
    _, places = run(found, "F")
    assert np.abs(places - placed.position[found.order]).max() < 1e-6


def test_lines_may_point_either_way() -> None:
    placed = structure("deeper", 2)
    keeps = of_line(10.0, False).stabiliser
    found = find_branching(placed, keeps, radius=10, tolerance=1e-4)
    assert found is not None
    assert len(found.order) == len(placed)


def test_numbers_with_noise_come_out_round() -> None:
    placed = structure("deeper", 4)
    random = np.random.default_rng(0)
    noise = random.uniform(-0.005, 0.005, (2, len(placed)))
    moved = frames(placed.position + noise[0] + 1j * noise[1], placed.angle, placed.scale)
    found = find_branching(moved, identity(1), radius=10, tolerance=0.2)
    assert found is not None
    assert len(found.order) == len(placed)
    assert sorted(each.first[2] for each in found.twigs) == pytest.approx([0.6, 0.8], abs=1e-3)


def test_other_copies_are_left_alone() -> None:
    placed = structure("figure 1", 1)
    others = frames(np.arange(40) * (37 + 11j) - 900, np.arange(40) * 13.0, 0.9)
    both = Frames(
        *(
            np.concatenate([getattr(placed, name), getattr(others, name)])
            for name in ("x", "y", "angle", "scale", "handedness")
        )
    )
    found = find_branching(both, identity(1), radius=10, tolerance=1e-4)
    assert found is not None
    assert set(found.order.tolist()) == set(range(len(placed)))


@pytest.mark.parametrize("count", [3, 7, 500])
def test_chance_has_no_rule(count: int) -> None:
    random = np.random.default_rng(count)
    at = random.uniform(0, 1000, count) + 1j * random.uniform(0, 1000, count)
    placed = frames(at, random.uniform(0, 360, count), random.uniform(0.2, 1, count))
    assert find_branching(placed, identity(1), radius=10, tolerance=1e-3) is None


def test_a_grid_is_no_branching() -> None:
    x, y = np.meshgrid(np.arange(12), np.arange(12))
    placed = frames((x * 10 + 10j * y).ravel())
    keeps = dihedral(4, 0.0).stabiliser
    assert find_branching(placed, keeps, radius=5, tolerance=1e-3) is None


def test_ends_may_be_another_shape() -> None:
    twigs, depth = STRUCTURES["changing"]
    grown = grow(frames(np.array([10 + 20j]), 90.0), twigs, depth, 100000)
    assert grown is not None
    along, ends = grown.frames[grown.depth > 0], grown.frames[grown.depth == 0]
    leaf = compose(ends, frames(np.full(len(ends), 3 + 1j), 40.0, 0.5))[::-1]
    found = find_branching(along, identity(1), radius=10, tolerance=1e-4)
    assert found is not None
    tipped = find_tips(found, leaf, identity(1), radius=10, tolerance=1e-4)
    assert tipped is not None
    assert tipped.branching.depth == depth
    node = ast.Bracket((ast.Module("F", (ast.Argument(ast.Number(10.0)),)),))
    rules = branching_rules(tipped.branching, "R", (node,), (*tip_place(tipped), node))
    start = ast.Start(branching_start(tipped.branching, "R"))
    text = format_grammar(ast.Grammar((ast.Version(1), *rules, start)))
    rows = ipmlang.parse(text).run().instances
    places = rows.position[:, 0] + 1j * rows.position[:, 1]
    is_tip = tipped.is_tip.astype(bool)
    assert np.abs(places[is_tip] - leaf.position[tipped.tips]).max() < 1e-6
    assert np.abs(places[~is_tip] - along.position[found.order]).max() < 1e-6
    assert "R(m) : else  --> +(18.4" in text
