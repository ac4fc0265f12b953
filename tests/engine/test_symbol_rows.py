"""Rows that name their symbols, done at once: the same rows as symbol by symbol, keys included.
And runs of them, whose symbols stand together: one step for all, lowered after one pattern.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import compile_file, ir
from ipmlang.compiler.lower import lsystem
from ipmlang.runtime import compiled, copied_bodies, derive
from ipmlang.runtime.content import Kept
from ipmlang.runtime.lineage import Lineage
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.runs import Runs, with_runs
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.symbol_rows import modules_in

PARTS = "".join(f'<rect id="{name}" width="{n + 1}" height="1"/>' for n, name in enumerate("abcde"))
HEAD = """ipm 1
asset a, b, c, d, e in "x.parts.svg"
table P(shape, x) =
    a, 1
    Ruled, 2.5
    b, 3
    a, 4
    c, 5
    Other, 6
    d, 7
    Ruled, 8
    e, 9.5
Ruled --> [F(rand(1, 2)) [f(rand(0, 9)) b]]
Other --> [a] [f(1) F]
"""
DRAWN = {
    "rows": "start repeat(r in P) { [f(r.x) r.shape] }",
    "moved": 'start repeat(r in P) { [+(r.x) f(3) color("#ff0000") r.shape] f(1) }',
    "holes": "start repeat(i < 9) except (2, 4) with r in P { [f(r.x) r.shape] }",
    "nested": "S --> repeat(j < 3) { [+(120 * j) *(1 + j) repeat(r in P) { [f(r.x) r.shape] }] }\n"
    "start S",
    "two": "start repeat(r in P) { [f(r.x) r.shape] [f(-r.x) r.shape] }",
}
PLACES = """table Q(shape, x, y, rx, rz) =
    a, 1, 2, 180, 30
    a, 2, 2, 0, 30
    Ruled, 2.5, 0, 90, 0
    Scoped, 3, 1, 0, 45
    b, 4, 1, 0, 60
table R(shape, x, y, rx, rz) =
    Scoped, 3, 1, 0, 45
    c, 9, 0, 0, 0
table T(shape, x, scale) =
    Ruled, 1, 0.5
    d, 3, 2
    d, 4, 2
Scoped : 50% --> size(1, 2, 3) cube Box [translate(0.1, 0, 1) b]
Scoped : else --> [mirror a] c
"""
RUNS = {  # how many repeats are one
    "two tables": ("start repeat(at Q) { at.shape } repeat(at R) { at.shape }", [6]),
    "among others": ("start [translate(0, 0, 0) a] repeat(at Q) { at.shape } Scoped repeat(at R) {"
                     " mirror at.shape } repeat(at R) { at.shape }", [4, 2, 2]),
    "of many": ("Lot --> repeat(at Q) { at.shape } b\nstart repeat(i < 3) { [translate(i, 0, 1)"
                " rotate(0, 0, 20 * i) Lot] } repeat(at T) { at.shape }", [2]),
    "in the plane": ("start F(1) [repeat(at T) { at.shape }] repeat(at T) { at.shape }", [2, 2]),
}  # fmt: skip
COLUMNS = (
    "position",
    "rotation",
    "scale",
    "size",
    "asset",
    "label",
    "rule",
    "key",
    "layer",
    "style",
)


@pytest.fixture(autouse=True)
def _nothing_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bodies are written anew each time: these tests change how."""
    monkeypatch.setattr(compiled, "KEPT", Kept(0))


def made(folder: Path, text: str) -> ir.Program:
    """The program of a text."""
    svg = f'<svg xmlns="http://www.w3.org/2000/svg">{PARTS}</svg>'
    (folder / "x.parts.svg").write_text(svg, encoding="utf-8")
    path = folder / "x.ipm"
    path.write_text(HEAD + text + "\n", encoding="utf-8")
    return compile_file(path)[1]


def assert_same(found: Scene, wanted: Scene) -> None:
    """Bit by bit, in the same order."""
    for name in COLUMNS:
        one, other = (getattr(each.instances, name) for each in (found, wanted))
        assert np.array_equal(one, other), name
    assert (found.shapes, found.generations) == (wanted.shapes, wanted.generations)


@pytest.mark.parametrize("text", DRAWN.values(), ids=DRAWN)
def test_the_same_as_symbol_by_symbol(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    program = made(tmp_path, text)
    found = derive(program, seed=3)
    calls: list[int] = []

    def none(*given: object) -> None:
        calls.append(len(given))

    monkeypatch.setattr(copied_bodies, "named", none)
    assert_same(found, derive(program, seed=3))
    assert calls, "nothing asked whether rows name their symbols"


def traced(program: ir.Program) -> Lineage:
    """Who drew what."""
    kept: list[Lineage] = []
    derive_frontier(program, (), 3, program.limits, kept.append)
    return kept[0]


def test_who_drew_what_is_told_as_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = made(tmp_path, DRAWN["nested"])
    found = traced(program)
    monkeypatch.setattr(copied_bodies, "named", lambda *_: None)
    wanted = traced(program)
    assert np.array_equal(found.drawn_at, wanted.drawn_at)
    # Shapes are numbered symbol by symbol, in whatever order these are reached.
    assert sorted(found.key.tolist()) == sorted(wanted.key.tolist())
    assert np.array_equal(found.key[found.drawer], wanted.key[wanted.drawer])


@pytest.mark.parametrize("name", RUNS)
def test_runs_are_as_symbol_by_symbol(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    text, sizes = RUNS[name]
    program = made(tmp_path, PLACES + text)
    joined = with_runs(program, program.axiom.body)
    assert [len(each.runs) for each in joined if isinstance(each, Runs)] == sizes
    found, told = derive(program, seed=3), traced(program)
    monkeypatch.setattr(compiled, "with_runs", lambda _, body: tuple(body))
    assert_same(found, derive(program, seed=3))
    wanted = traced(program)
    for column in ("key", "parent", "site", "production", "drawer", "drawn_at"):
        assert np.array_equal(getattr(told, column), getattr(wanted, column)), column
    assert all(np.array_equal(each, wanted.state[field]) for field, each in told.state.items())


@pytest.mark.parametrize("name", RUNS)
def test_runs_are_lowered_as_each_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    found = made(tmp_path, PLACES + RUNS[name][0])
    monkeypatch.setattr(lsystem, "is_again", lambda *_: False)
    assert found == made(tmp_path, PLACES + RUNS[name][0])


def test_a_choice_counts_as_one_module(tmp_path: Path) -> None:
    assert modules_in(made(tmp_path, DRAWN["rows"]).axiom.body) == 2
    assert modules_in(made(tmp_path, DRAWN["two"]).axiom.body) == 4
