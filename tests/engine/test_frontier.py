"""The batched frontier against the naive derivation: keys and topology exactly, frames closely.

Each grammar is one idea; every one is derived by the oracle, by the frontier (batches, single
shapes and chains as they come) and as a string, and all three must agree.
"""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler import ir
from ipmlang.runtime import compiled, frontier, pending, single
from ipmlang.runtime.bind import bind
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.strings import derive_string, steps_of
from ipmlang.runtime.values import Bound
from tests.engine.random_grammars import Grammar
from tests.oracles import Naive, Row, quaternion_matrix

GRAMMARS = {
    "fence": """
        P(m) : m > 0 --> [F(1)] f(13) P(m - 1)
        P(m) : else --> [F(2)]
        start P(24)""",
    "leaf": """
        R(m)  : m > 0 --> [F(3)] [-(17) f(64) *(0.8) -(3) R(m - 1)] [+(7) f(181) *(0.6) R(m - 1)]
        R(m)  : else  --> [F(1)]
        start R(7)""",
    "copies": """
        start repeat(i < 5) { [+(i * 10) F(1 + i)] f(2) +(3) *(1.1) !(i) } F(2) color("#f00") F""",
    "nested copies with holes": """
        A(n) --> repeat(i < n) except (2, 3) { repeat(j < i) { [+(rand(0, 90)) B(j)] f(1) -(2)
            layer(1) } mirror f(3) } F
        B(x) : 50% --> F(x) C(x)
        B(x) : else --> C(x + 1)
        C(x) : x > 2 --> nil
        C(x) : else --> F(rand(1, 2))
        start [A(5)] +(90) A(7)""",
    "rows": """
        table T(x, y, angle) = (1, 2, 30), (3, 4, 60), (5, 6, 90)
        start repeat(r in T) { [at(r.x, r.y, r.angle) F(r.x)] }
            repeat(i < 4) except (1, 3) steps (1, 2, 3) { [F(i) [+(i) F(2)]] }""",
    "steps in space": """
        A(l, w) : 50% --> !(w) F(l) [&(45 + rand(-9, 9)) A(l * 0.7, w * 0.7)] /(137.5) A(l * 0.9, w)
        A(l, w) : else --> !(w) F(l) [&(30) A(l * 0.8, w * 0.7)] /(90)
            [^(40) mirror $ A(l * 0.7, w)] /(137.5) A(l * 0.9, w * 0.7)
        start A(1, 10) steps 7""",
    "copies in space": """
        A(n) : n > 0 --> repeat(i < 4) { F(1) /(30) [&(40) mirror F(2) A(n - 1)]
            at(0.1, 0.2, 0.1, 0.9, 0.1, 0, 0.2, 0.9) } F(1)
        A(n) : else --> F(1)
        start A(2)""",
    "chain in space": """
        P(m) : m > 0 --> F(1) +(3) [-(90) F(2) Q(m)] &(1) *(0.999) color("#0f0") P(m - 1)
        P(m) : else --> F(9)
        Q(m) : m > 50 --> F(3)
        Q(m) : else --> nil
        start P(120)""",
    "chain with draws": """
        turtle angle 25
        P(m, s) : m < 60 --> F(s) +(s * 2) [-(90) F(rand(0, 1)) layer(2) F(1)] mirror layer(1) !(m)
            P(m + 0.5, s * 0.99)
        P(m, s) : else --> F(9)
        start P(0, 3)""",
    "interpretation": """
        A(n) : n > 0 --> [X(n)] [+(30) A(n - 1)] [-(30) A(n - 1)]
        A(n) : else --> X(2)
        interpret X(n) : 40% --> F(n) color("#123") F(3)
        interpret X(n) : else --> F(1)
        start A(4)""",
    "what no production takes stays": """
        A(n) : 70% --> F(n) [+(30) A(n + 1)] [-(30) B] A(n)
        B --> F(2)
        interpret A(n) --> F(100)
        start A(1) steps 6""",
    "pens in nested copies": """
        A(n) --> repeat(i < n) { repeat(j < i) except (1) { color("teal") F(j) !(j) } F layer(1) }
            css("a:b") F
        start [A(4)] [color("red") A(3)] F""",
    "weights": """
        A(n) : n > 0 : weight 2 --> F(1) [+(20) A(n - 1)] A(n - 1)
        A(n) : n > 0 : weight n --> F(2) [-(20) A(n - 1)] A(n - 2)
        A(n) : else --> css("a:b") F fill("#111") F
        start A(7)""",
}  # fmt: skip


def bound(text: str, seed: int) -> tuple[ir.Program, tuple[float, ...]]:
    grammar = ipmlang.parse("ipm 1\n" + "\n".join(_dedented(text)))
    return bind(grammar.program, None, seed)


def _dedented(text: str) -> list[str]:
    return [line[8:] for line in text.split("\n")]


def oracle(program: ir.Program, attrs: tuple[float, ...], seed: int) -> list[Row]:
    from ipmlang.compiler.ops import FUNCTIONS

    return Naive(program, attrs, steps_of(Bound(program, attrs, FUNCTIONS), seed)).run(seed)


def by_frontier(program: ir.Program, attrs: tuple[float, ...], seed: int) -> Scene:
    scene = derive_frontier(program, attrs, seed, program.limits)
    assert scene is not None, "the frontier left this program to strings"
    return scene


def assert_counted_alike(batched: Scene, string: Scene) -> None:
    """Both executors say the same about how much was derived."""
    assert batched.shapes == string.shapes
    assert batched.generations == string.generations


def assert_same(scene: Scene, rows: list[Row]) -> None:
    found = scene.instances
    axiom = len(scene.rules) - 1
    assert [int(key) for key in found.key] == [row.key for row in rows]
    assert found.label.tolist() == [row.symbol for row in rows]
    assert found.rule.tolist() == [axiom if row.rule < 0 else row.rule for row in rows]
    assert found.asset.tolist() == [row.asset for row in rows]
    np.testing.assert_allclose(found.size, [row.size for row in rows], atol=1e-9)
    places = [row.turtle.position for row in rows]
    np.testing.assert_allclose(found.position, places, atol=1e-7, rtol=1e-9)
    np.testing.assert_allclose(
        found.scale, [row.turtle.scale * row.turtle.hand for row in rows], rtol=1e-9
    )
    np.testing.assert_allclose(found.layer, [row.turtle.layer for row in rows])
    widths = [row.turtle.pen.get("width", np.nan) for row in rows]
    np.testing.assert_allclose(found.width, widths, rtol=1e-6)
    for rotation, row in zip(found.rotation, rows, strict=True):
        np.testing.assert_allclose(quaternion_matrix(*rotation), row.turtle.rotation, atol=1e-8)


@pytest.mark.parametrize("name", GRAMMARS)
@pytest.mark.parametrize("seed", [0, 7])
def test_frontier_agrees_with_the_naive_derivation(name: str, seed: int) -> None:
    program, attrs = bound(GRAMMARS[name], seed)
    rows = oracle(program, attrs, seed)
    assert len(rows) > 3
    assert_same(by_frontier(program, attrs, seed), rows)


@pytest.mark.parametrize("name", GRAMMARS)
def test_strings_agree_with_the_naive_derivation(name: str) -> None:
    program, attrs = bound(GRAMMARS[name], 3)
    scene = derive_string(program, attrs, 3, program.limits)
    assert_same(scene, oracle(program, attrs, 3))
    assert_counted_alike(by_frontier(program, attrs, 3), scene)


@pytest.mark.parametrize("name", GRAMMARS)
@pytest.mark.parametrize(("narrow", "wide"), [(0, 0), (1 << 30, 1 << 30)])
def test_batches_and_single_shapes_agree(
    name: str, narrow: int, wide: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    program, attrs = bound(GRAMMARS[name], 5)
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", wide)
    monkeypatch.setattr(compiled.Compiled, "chain", lambda self, symbol: None)
    assert_same(by_frontier(program, attrs, 5), oracle(program, attrs, 5))


@pytest.mark.parametrize("name", ["leaf", "steps in space", "weights"])
def test_small_chunks_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    program, attrs = bound(GRAMMARS[name], 5)
    monkeypatch.setattr(frontier, "NARROW", 0)
    monkeypatch.setattr(pending, "CHUNK", 5)
    assert_same(by_frontier(program, attrs, 5), oracle(program, attrs, 5))


@pytest.mark.parametrize("seed", range(48))
def test_random_grammars_agree(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    grammar = ipmlang.parse(Grammar(seed).text())
    program, attrs = bind(grammar.program, None, seed)
    narrow, wide, chunk = [(24, 96, 16384), (0, 0, 16384), (1 << 30, 1 << 30, 16384), (0, 0, 7)][
        seed % 4
    ]
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", wide)
    monkeypatch.setattr(pending, "CHUNK", chunk)
    rows = oracle(program, attrs, seed)
    batched = by_frontier(program, attrs, seed)
    string = derive_string(program, attrs, seed, program.limits)
    assert_same(batched, rows)
    assert_same(string, rows)
    assert_counted_alike(batched, string)


def test_a_long_tail_runs_as_a_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    program, attrs = bound(GRAMMARS["chain in space"], 1)
    applied: list[int] = []
    plain = frontier.Frontier.apply
    monkeypatch.setattr(
        frontier.Frontier,
        "apply",
        lambda self, number, shapes: (applied.append(shapes.count), plain(self, number, shapes))[1],
    )
    scene = by_frontier(program, attrs, 1)
    assert scene.generations > 100
    assert len(applied) < 20


def test_editing_one_production_leaves_other_draws_alone() -> None:
    text = """
        A(n) : n > 0 --> [B(n)] [+(30) A(n - 1)] A(n - 1)
        A(n) : else --> nil
        B(n) --> F(rand())
        start A(6)"""
    scenes = [
        by_frontier(*bound(each, 2), 2)
        for each in (text, text.replace("A(n) : else --> nil", "A(n) : else --> f(rand()) C"))
    ]
    first, second = (scene.instances for scene in scenes)
    assert first.size[:, 0].tolist() == second.size[:, 0].tolist()
    assert first.key.tolist() == second.key.tolist()


def test_the_books_axes_are_the_same_in_both_executors() -> None:
    """`$` levels against the world's up, whichever way the turtle's own up points at the start."""
    grammar = ipmlang.parse(
        "ipm 1\nturtle frame abop\n"
        "A(n) : n > 0 --> F(1) [&(40) /(30) $ F(1) B(n - 1)] +(20) ^(10) A(n - 1)\n"
        "A(n) : else --> nil\n"
        "B(n) : n > 0 --> [+(25) $ F(2)] -(9) F(1) B(n - 1)\n"
        "B(n) : else --> nil\nstart A(3)\n"
    )
    program = grammar.program
    batched = derive_frontier(program, (), 0, program.limits)
    assert batched is not None
    found, wanted = batched.instances, derive_string(program, (), 0, program.limits).instances
    assert np.abs(found.position - wanted.position).max() < 1e-12
    assert np.abs(found.rotation - wanted.rotation).max() < 1e-12
