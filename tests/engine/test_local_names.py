"""`with name = value`: computed once, where it stands, and read by what follows in its body."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from ipmlang.runtime import frontier, single
from ipmlang.runtime.bind import bind
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled
from tests.engine.random_grammars import Naming
from tests.engine.random_splits import Named
from tests.engine.test_frontier import assert_same, by_frontier, oracle
from tests.engine.test_scope_oracle import compare


def lengths(text: str, seed: int = 0) -> list[float]:
    """The lengths of what is drawn, which strings and batches draw alike."""
    program, attrs = bind(compiled("ipm 1\n" + text), None, seed)
    assert verify(program) == []
    string = derive_string(program, attrs, seed, program.limits).instances
    batched = by_frontier(program, attrs, seed).instances
    assert batched.size.tolist() == string.size.tolist()
    assert batched.key.tolist() == string.key.tolist()
    found: list[float] = string.size[:, 0].tolist()
    return found


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("A --> with w = 2 F(w) with v = w + 1 F(v) F(w)\nstart A\n", [2, 3, 2]),
        ("A(n) --> with w = n * 2 repeat(i < w - 2) { F(w + i) }\nstart A(2)\n", [4, 5]),
        ("A --> [with w = 2 F(w)] [with w = 3 F(w)]\nstart A\n", [2, 3]),
        ("A --> repeat(i < 3) { with w = i * i F(w + 1) }\nstart A\n", [1, 2, 5]),
        ("A --> with w = 5 [B(w)] B(w + 1)\nB(w) --> F(w)\nstart A\n", [5, 6]),
        ("attr d = 1\nA --> with w = d + 1 set d = w * 10 F(w) B\nB --> F(d)\nstart A\n", [2, 20]),
        ("fn twice(x) = 2 * x\nA --> with w = twice(3) F(twice(w))\nstart A\n", [12]),
        ("start with w = 4 F(w) [F(w)] with v = w + 1 F(v)\n", [4, 4, 5]),
        ("A --> with (w = 3) -(17) F(w)\nstart A\n", [3]),
        ("table T(x) = (2), (3)\nA --> repeat(r in T) { with w = r.x + 1 F(w) F(w) }\nstart A\n",
         [3, 3, 4, 4]),
    ],
)  # fmt: skip
def test_what_a_name_stands_for(text: str, wanted: list[float]) -> None:
    assert lengths(text) == wanted


def test_one_draw_is_read_twice() -> None:
    first, second, third = lengths("A --> with w = rand() F(w) F(w) F(rand())\nstart A\n")
    assert first == second != third


def test_each_copy_draws_its_own() -> None:
    found = lengths("A --> repeat(i < 4) { with w = rand() F(w) F(w) }\nstart A\n")
    assert found[::2] == found[1::2]
    assert len(set(found)) == 4


def test_a_draw_is_that_of_its_place() -> None:
    """What a name stands for is what stood there without one, for this rule and for all others."""
    named = lengths("A --> with w = rand() F(w) B\nB --> F(rand())\nstart A\n", 5)
    plain = lengths("A --> F(rand()) B\nB --> F(rand())\nstart A\n", 5)
    assert named == plain


def test_a_value_is_that_of_the_scope_where_it_stands() -> None:
    grammar = ipmlang.parse(
        "ipm 1\nA --> with wide = scope.sx with gap = rand(0.5, 1)\n"
        "    split x { gap: L | ~1: size(wide / 10, scope.sy, scope.sz) M | gap: R }\n"
        "start A on box(10, 2, 3)\n"
    )
    sizes = grammar.run(seed=4).instances.size[:, 0]
    assert sizes[1] == 1.0
    assert sizes[0] == sizes[2]
    assert 0.5 < sizes[0] < 1


@pytest.mark.parametrize("seed", range(120))
def test_in_scopes_names_are_those_of_the_oracle(seed: int) -> None:
    compare(Named(seed).text(), seed)


@pytest.mark.parametrize("seed", range(48))
def test_turtles_agree(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    program, attrs = bind(compiled(Naming(seed).text()), None, seed)
    narrow = [24, 0, 1 << 30][seed % 3]
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", max(narrow, 96))
    rows = oracle(program, attrs, seed)
    assert_same(by_frontier(program, attrs, seed), rows)
    assert_same(derive_string(program, attrs, seed, program.limits), rows)


def test_strings_that_thread_read_names() -> None:
    text = (
        "ipm 1\nA(n) : n > 0 --> with w = rand(1, 2) F(w) A(n - 1) F(w)\nA(n) : else --> nil\n"
        "start A(3)\n"
    )
    program, attrs = bind(compiled(text), None, 1)
    assert program.threaded
    found = derive_string(program, attrs, 1, program.limits).instances.size[:, 0]
    np.testing.assert_array_equal(found, found[::-1])
    assert len(set(found)) == 3
