"""Schemes printed as grammars: what the engine makes of the text is what the scheme means.

Random schemes of every kind of item are printed, checked, derived by the engine, and every terminal
compared with `expand`, which is the definition. Wordings that a person reads are told one by one.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import ipmlang
from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.formats.mesh_types import Mesh, triangle_mesh
from ipmlang.formats.obj_parts import obj_parts
from ipmlang.inverse.frames import Floats, Frames, canonical, identity, matrices, moved_to
from ipmlang.inverse.split.comparison import compare_models
from ipmlang.inverse.split.expansion import expand
from ipmlang.inverse.split.placing import Precision
from ipmlang.inverse.split.printing.grammar import print_scheme
from ipmlang.inverse.split.scheme import (
    Array,
    Cell,
    Direction,
    Item,
    Place,
    Ring,
    Rule,
    Scheme,
    Split,
    Symbol,
    Terminal,
)
from ipmlang.runtime.export.placing import frame_matrices

ONE = np.ones(3)
FINE = Precision(1e-9)
TERMINALS: tuple[Symbol, ...] = (Terminal("brick", ONE, 0), Terminal("stone", 2 * ONE, 1))


def _text(scheme: Scheme, precision: Precision = FINE, one_by_one: bool = False) -> str:
    printed = print_scheme(scheme, "House", precision, one_by_one)
    names = tuple(
        name
        for name, symbol in zip(printed.names, scheme.symbols, strict=True)
        if isinstance(symbol, Terminal)
    )
    asset = ast.Asset(names, "house.parts.obj", True)
    return format_grammar(ast.Grammar((ast.Version(1), asset, *printed.items)))


def _drawn(text: str, folder: Path) -> dict[str, Floats]:
    """The matrices (n, 3, 4) of each terminal that the engine draws, and no warning."""
    corner = triangle_mesh(np.eye(3), np.array([[0, 1, 2]]))
    (folder / "house.parts.obj").write_text(obj_parts({"brick": corner, "stone": corner}, 6))
    (folder / "house.ipm").write_text(text, encoding="utf-8")
    grammar = ipmlang.load(folder / "house.ipm")
    assert not grammar.warnings, text
    scene = grammar.run()
    every = frame_matrices(scene.instances, np.arange(len(scene.instances)))
    labels = np.array([scene.labels[each] for each in scene.instances.label])
    return {name: every[labels == name] for name in ("brick", "stone")}


def _agrees(scheme: Scheme, folder: Path, text: str, within: float) -> None:
    found = _drawn(text, folder)
    parts, frames = expand(scheme)
    for number, name in enumerate(("brick", "stone")):
        wanted = matrices(frames[parts == number]).reshape(-1, 12)
        drawn = found[name].reshape(-1, 12)
        assert len(drawn) == len(wanted), text
        if len(wanted):
            distance, index = map(np.asarray, cKDTree(drawn).query(wanted))
            assert distance.max() <= within and len(np.unique(index)) == len(wanted), text


def _frames(random: np.random.Generator, count: int) -> Frames:
    turn = random.normal(size=(count, 4))
    whole = random.integers(-1, 2, (count, 4)).astype(np.float64)
    whole[:, 0] += ~whole.any(axis=1)
    turn = np.where(random.random((count, 1)) < 0.7, whole, turn)
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    return Frames(
        random.integers(-9, 10, (count, 3)) / 2.0,
        canonical(turn),
        np.where(random.random(count) < 0.3, -1.0, 1.0),
        np.where(random.random(count) < 0.2, 1.5, 1.0),
    )


def _array(random: np.random.Generator, symbol: int) -> Array:
    directions = []
    for _ in range(int(random.integers(1, 4))):
        count = int(random.integers(2, 5))
        uneven = tuple(random.integers(1, 5, count - 1) / 2.0) if random.random() < 0.3 else ()
        directions.append(Direction(count, random.integers(-2, 3, 3) * 1.0 + 0.25, uneven))
    counts = [each.count for each in directions]
    holes = {tuple(int(random.integers(0, n)) for n in counts) for _ in range(2)}
    kept = frozenset(holes) if random.random() < 0.5 else frozenset()
    return Array(symbol, _frames(random, 1), tuple(directions), kept)


def _ring(random: np.random.Generator, symbol: int) -> Ring:
    axis = np.eye(3)[random.integers(0, 3)] * random.choice([-1.0, 1.0])
    if random.random() < 0.3:
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
    count = int(random.integers(2, 8))
    return Ring(
        symbol,
        _frames(random, 1),
        count,
        random.integers(-3, 4, 3) / 2.0,
        axis,
        float(random.choice([360 / count, -30.0, 22.5])),
        float(random.choice([0.0, 0.5])),
        float(random.choice([1.0, 1.1])),
        frozenset({1}) if random.random() < 0.3 else frozenset(),
    )


def _item(random: np.random.Generator, symbols: int) -> Item:
    symbol = int(random.integers(0, symbols))
    match int(random.integers(0, 3)):
        case 0:
            return Place(symbol, _frames(random, int(random.integers(1, 12))))
        case 1:
            return _array(random, symbol)
        case _:
            return _ring(random, symbol)


@pytest.mark.parametrize("seed", range(12))
def test_the_engine_draws_what_a_scheme_means(seed: int, tmp_path: Path) -> None:
    """Whatever is placed by hand, in rows, grids with holes, uneven rows, rings and spirals."""
    random = np.random.default_rng(seed)
    symbols: list[Symbol] = list(TERMINALS)
    for _ in range(3):
        items = tuple(_item(random, len(symbols)) for _ in range(int(random.integers(1, 4))))
        symbols.append(Rule("", 5 * ONE, items))
    scheme = Scheme(tuple(symbols), _frames(random, 1))
    if len(expand(scheme)[0]) > 20_000:
        pytest.skip("too many terminals for a quick test")
    _agrees(scheme, tmp_path, _text(scheme), 1e-6)
    _agrees(scheme, tmp_path, _text(scheme, one_by_one=True), 1e-6)


def _split(axis: int, *cells: Cell) -> Split:
    return Split(axis, cells)


def test_splits_stand_in_scopes_of_their_size(tmp_path: Path) -> None:
    """In cells, placed freely, turned, and beside other items."""
    floor = Rule("Floor", np.array([7.0, 1, 3]), (
        _split(0, Cell(1, None), Cell(2, 0, 2, True), Cell(2, 1, 1, True)),))  # fmt: skip
    house = Rule("House", np.array([7.0, 1, 9.5]), (
        _split(2, Cell(3, 2, 3), Cell(0.5, None)), Place(2, _frames(np.random.default_rng(1), 3)),
    ))  # fmt: skip
    scheme = Scheme((*TERMINALS, floor, house), moved_to(np.array([[1.0, 2, 3]])))
    text = _text(scheme)
    _agrees(scheme, tmp_path, text, 1e-6)
    assert "{ ~2: brick }*" in text and "size(" in text


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_circles_are_said_by_sines_whichever_way_they_go(axis: int, tmp_path: Path) -> None:
    random = np.random.default_rng(axis)
    ways = (
        (0.0, 3.0, -1.5, 40.0, 1.0, ()),
        (0.0, 6.0, -1.0, -17.5, 1.0, (2,)),
        (0.0, 0.0, 4.0, 33.0, -1.0, (0,)),
    )
    items = tuple(
        Array(0, _frames(random, 1), (Direction(9, np.roll(arm, axis), (), angle, axes),),
              frozenset((hole,) for hole in holes))
        for *arm, angle, sign, holes in ways
        for axes in [np.eye(3)[axis] * sign]
    )  # fmt: skip
    scheme = Scheme((*TERMINALS, Rule("", 9 * ONE, items)), identity())
    _agrees(scheme, tmp_path, _text(scheme), 1e-6)


def _axiom(*items: Item) -> Scheme:
    return Scheme((*TERMINALS, Rule("", 9 * ONE, items)), identity())


def test_rows_and_rings_are_said_as_people_say_them() -> None:
    """Nothing that is nothing, signs where they belong."""
    row = Array(0, moved_to(np.array([[1.0, 0, 0]])), (Direction(5, np.array([2.4, 0, 0])),))
    assert "repeat(i < 5) { [translate(1 + 2.4 * i, 0, 0) brick] }" in _text(_axiom(row))
    back = Array(0, identity(), (Direction(3, np.array([-2.0, 0, 0])),))
    assert "[translate(-2 * i, 0, 0) brick]" in _text(_axiom(back))
    ring = Ring(0, moved_to(np.array([[2.0, 0, 0]])), 12, np.zeros(3), np.array([0.0, 0, 1]), 30.0)
    wanted = "repeat(i < 12) { [rotate(0, 0, 30 * i) translate(2, 0, 0) brick] }"
    assert wanted in _text(_axiom(ring))


def test_many_by_hand_are_a_table_and_few_are_not() -> None:
    """Whichever has fewer tokens; constant columns are no columns."""
    places = np.array([[k * k, 0.5, 0.25 * k] for k in range(9)])
    text = _text(_axiom(Place(0, moved_to(places))))
    assert "table bricks(x, z) =" in text and "{ translate(0, 0.5, 0) brick }" in text
    few = _text(_axiom(Place(0, moved_to(places[:2]))))
    assert "table" not in few and "[translate(1, 0.5, 0.25) brick]" in few


def test_numbers_are_as_short_as_they_may_be() -> None:
    """Noise below what is allowed is not printed, and what is nearly a right angle is one."""
    noisy = Frames(
        np.array([[0.3000000004, 0, 0]]),
        canonical(np.array([[np.cos(np.pi / 4 + 1e-11), 0, 0, np.sin(np.pi / 4 + 1e-11)]])),
        np.ones(1),
        np.ones(1),
    )
    assert "[translate(0.3, 0, 0) rotate(0, 0, 90) brick]" in _text(_axiom(Place(0, noisy)))


def _square(first: int = 0, material: int = -1) -> Mesh:
    ring = (np.arange(4) + first) % 4
    return Mesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        ring,
        np.array([0, 4]),
        np.array([material]),
        np.zeros(1, np.int64),
        groups=((),),
    )


def test_a_proof_can_fail() -> None:
    """What is lost, new, doubled, moved or of another material is told; where a face begins and
    which way it winds does not matter.
    """
    from dataclasses import replace

    from ipmlang.formats.mesh_types import Material, merged, reversed_faces

    one = _square()
    assert compare_models(one, reversed_faces(_square(2)), 1e-6).none
    twice = compare_models(one, merged([one, one]), 1e-6)
    assert (twice.lost, twice.new) == (0, 2)  # as triangles, where counts differ
    lost = compare_models(merged([one, replace(one, vertices=one.vertices + 5)]), one, 1e-6)
    assert (lost.lost, lost.new) == (2, 0)
    near = compare_models(one, replace(one, vertices=one.vertices + 3e-7), 1e-6)
    assert near.none and near.error == pytest.approx(3e-7 * 3**0.5)
    assert not compare_models(one, replace(one, vertices=one.vertices + 2e-6), 1e-6).none
    red = replace(_square(material=0), materials=(Material("red"),))
    assert not compare_models(one, red, 1e-6).none


@pytest.mark.parametrize(
    ("name", "stones", "told"), [("", 1, False), ("Bay", 1, True), ("", 4, True)]
)
def test_short_rules_that_are_used_once_are_said_in_their_cell(
    tmp_path: Path, name: str, stones: int, told: bool
) -> None:
    """But for those that have a name, and for long ones."""
    spots = np.array([[0.0, 0.5 * k, 1.0 + k] for k in range(stones)])
    bay = Rule(name, np.array([3.0, 4, 9]), (
        Place(0, identity()), Place(1, moved_to(spots)),
    ))  # fmt: skip
    house = Rule("", np.array([15.0, 4, 9]), (_split(0, Cell(3, 2, 5, True)),))
    scheme = Scheme((*TERMINALS, bay, house), identity())
    text = _text(scheme)
    _agrees(scheme, tmp_path, text, 1e-6)
    assert text.count("-->") == 1 + told
    if not told:
        assert "{ ~3: brick [translate(0, 0, 1) stone] }*" in text
        assert "times that" not in text or "times that stone repeats" in text


def test_rows_of_rows_of_one_thing_are_one_rule(tmp_path: Path) -> None:
    bay = Rule("Bay", np.array([3.0, 8, 1]), (_split(1, Cell(2, 0, 4, True)),))
    floor = Rule("Floor", np.array([15.0, 8, 1]), (_split(0, Cell(3, 2, 5, True)),))
    house = Rule("", np.array([15.0, 8, 6]), (_split(2, Cell(1, 3, 6, True)),))
    scheme = Scheme((*TERMINALS, bay, floor, house), identity())
    text = _text(scheme)
    _agrees(scheme, tmp_path, text, 1e-6)
    assert "split z { { ~1: split x { { ~3: split y { { ~2: brick }* } }* } }* }" in text
