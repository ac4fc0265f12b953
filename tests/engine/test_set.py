"""`set name = value`: who sees it, in batches, shape by shape, in chains and in strings."""

from __future__ import annotations

import numpy as np
import pytest

import ipmlang
from ipmlang.compiler.verify import verify
from ipmlang.runtime import frontier, single
from ipmlang.runtime.bind import bind
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.strings import derive_modules, derive_string
from tests.engine.grammars import compiled
from tests.engine.random_grammars import Setting, Written


def lengths(text: str) -> list[float]:
    """The lengths of what both executors draw, which must be the same."""
    program = compiled("ipm 1\nattr d = 1\n" + text)
    assert verify(program) == []
    program, attrs = bind(program, None, 0)
    string = derive_string(program, attrs, 0, program.limits).instances
    scene = derive_frontier(program, attrs, 0, program.limits)
    if scene is not None:
        assert scene.instances.size.tolist() == string.size.tolist()
        assert scene.instances.key.tolist() == string.key.tolist()
    found: list[float] = string.size[:, 0].tolist()
    return found


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("A --> F(d) set d = 2 F(d)\nstart A F(d)\n", [1, 2, 1]),
        ("A --> B set d = 2 B\nB --> C\nC --> F(d)\nstart A B\n", [1, 2, 1]),
        ("A --> [set d = 2 B] B\nB --> F(d)\nstart A\n", [2, 1]),
        ("A --> polygon { set d = 2 f F } B\nB --> F(d)\nstart A\n", [0, 1]),
        ("A --> repeat(i < 3) { set d = d + i B } B\nB --> F(d)\nstart A\n", [1, 2, 3, 1]),
        ("A --> repeat(i < 2) except (0) { set d = 5 B }\nB --> F(d)\nstart [A] F\n", [5, 1]),
        ("A --> set d = 2 set d = d * 3 B\nB --> F(d)\nstart A\n", [6]),
        ("A --> set d = 3 B set d = 4 B\nB --> repeat(i < d) { F }\nstart A\n", [1] * 7),
        ("start set d = 4 F(d) [set d = 5 F(d)] F(d)\n", [4, 5, 4]),
        ("const twice = 2 * d\nfn more(x) = x + d\nA --> set d = 5 F(twice) F(more(1))\n"
         "start A F(twice)\n", [10, 6, 2]),
        ("attr e = d * 10\nA --> set d = 2 F(e) F(d)\nstart A\n", [10, 2]),
        ("turtle step d\nA --> set d = 7 B F\nB --> F\nstart F A F\n", [1, 7, 7, 1]),
        ("A(n) : n > 0 --> F(d) set d = d * 2 A(n - 1)\nA(n) : else --> nil\nstart A(4)\n",
         [1, 2, 4, 8]),
        ("A --> set d = 5 B\nB : d > 3 --> F(1)\nB : else --> F(2)\nstart B A\n", [2, 1]),
        ("A --> set d = 100 B\nB : d% --> F(1)\nB : else --> F(2)\nattr z = 0\n"
         "start A [set d = 0 B]\n", [1, 2]),
        ("A --> set d = 5 B\nB --> F(d)\ninterpret C --> F(d)\nstart B A C [set d = 6 C]\n",
         [1, 5, 1, 6]),
        ("F --> F(d + 1)\nF(n) --> F(n)\nstart F [set d = 5 F] steps 2\n", [2, 6]),
    ],
)  # fmt: skip
def test_who_sees_the_value(text: str, wanted: list[float]) -> None:
    assert lengths(text) == wanted


def test_what_follows_a_threading_rule_keeps_the_value() -> None:
    text = "A(n) : n > 0 --> set d = d + 1 F(d) A(n - 1) F(d)\nA(n) : else --> F(d)\n"
    assert lengths(text + "start A(2) F(d)\n") == [2, 3, 3, 3, 2, 1]


def test_contexts_do_not_see_what_is_carried() -> None:
    program = compiled(
        "ipm 1\nattr d = 1\nA(x) --> set d = 9 A(x + d)\n"
        "A(x) < B(y) > C(z) --> B(x + y + z + d)\nC(z) --> C(z)\n"
        "* < D > *(x) --> D\n"
        "start A(1) [set d = 100 B(2) C(7)] B(3) C(5) D A(0) steps 1\n"
    )
    program, attrs = bind(program, None, 0)
    assert verify(program) == []
    found = derive_modules(program, attrs, 0, program.limits)
    assert found == [
        ("A", (10.0,)), ("[", ()), ("B", (110.0,)), ("C", (7.0,)), ("]", ()), ("B", (10.0,)),
        ("C", (5.0,)), ("D", ()), ("A", (9.0,)),
    ]  # fmt: skip


def test_a_text_and_a_colour() -> None:
    grammar = ipmlang.parse(
        'ipm 1\nattr paint = "red"\nA --> color(paint) F\nstart [A] [set paint = "#00f" A]\n'
    )
    assert [hex(each) for each in grammar.run().instances.color] == ["0xff0000ff", "0xffff"]


def test_nothing_is_carried_that_nobody_reads() -> None:
    found = compiled(
        "ipm 1\nattr d = 1\nattr e = 2\nA --> set d = 2 B C\nB --> F(d)\nC --> F(e)\nstart A C\n"
    )
    carried = {symbol.name: (symbol.arity, symbol.carried) for symbol in found.symbols}
    assert carried == {"A": (0, 0), "B": (1, 1), "C": (0, 0), "F": (1, 0)}


def test_messages_show_what_was_written() -> None:
    grammar = ipmlang.parse(
        "ipm 1\nattr d = 1\nA(x) : x > d --> F\nstart [A(2)] [set d = 5 A(3)]\n"
    )
    with pytest.raises(ipmlang.IpmError, match=r"no production of A\(3\) applies"):
        grammar.run()


@pytest.mark.parametrize("seed", range(60))
def test_set_is_a_parameter_that_nobody_wrote(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = [24, 0, 1 << 30][seed % 3]
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", max(narrow, 96))
    program, attrs = bind(compiled(Written(seed).text()), None, seed)
    wanted = derive_string(program, attrs, seed, program.limits)
    program, attrs = bind(compiled(Setting(seed).text()), None, seed)
    batched = derive_frontier(program, attrs, seed, program.limits)
    assert batched is not None
    assert_alike(batched, wanted)
    assert_alike(derive_string(program, attrs, seed, program.limits), wanted)


def assert_alike(scene: Scene, wanted: Scene) -> None:
    found, other = scene.instances, wanted.instances
    assert found.key.tolist() == other.key.tolist()
    np.testing.assert_allclose(found.position, other.position, atol=1e-7, rtol=1e-9)
    np.testing.assert_allclose(found.size, other.size, rtol=1e-9)
    np.testing.assert_allclose(found.layer, other.layer)
