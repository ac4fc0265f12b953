"""What a derivation that cannot go on says, and that it stops in bounded time and memory."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import pytest

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.runtime.strings import derive_modules, derive_string
from tests.engine.grammars import compiled

RUNAWAYS = {
    "doubling": "A --> F A + A\nstart A",
    "curve": "F --> F - F + F\nstart F steps 1000",
    "repeat": "A(n) --> repeat(i < n) { F B } F\nB --> F +\nstart A(1e12)",
    "nested": "A --> repeat(i < 1e6) { repeat(j < 1e6) { F } }\nstart A steps 1",
    "context": "B < A --> F\nA --> F A + A\nstart A",
}


@pytest.mark.parametrize("name", RUNAWAYS)
def test_growth_without_end_stops(name: str) -> None:
    code = compiled(RUNAWAYS[name] + "\n")
    limits = ir.Limits(shapes=200_000)
    began = time.process_time()
    tracemalloc.start()
    with pytest.raises(IpmError) as raised:
        derive_string(code, (), 0, limits)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == "limit-shapes"
    grew = {"curve": "F (<text>:1)", "context": "A (<text>:2)"}.get(name, "A (<text>:1)")
    assert f"rule {grew} would" in diagnostic.message
    assert peak < 200_000 * 200
    assert time.process_time() - began < 20


def test_memory_is_asked_for_before_it_is_taken() -> None:
    code = compiled("F --> F F\nstart F steps 30\n")
    tracemalloc.start()
    with pytest.raises(IpmError, match="limit-memory") as raised:
        derive_string(code, (), 0, ir.Limits(memory=10_000_000))
    assert tracemalloc.get_traced_memory()[1] < 10_000_000
    tracemalloc.stop()
    assert "rule F (<text>:1)" in str(raised.value)
    with pytest.raises(IpmError, match="limit-memory"):
        derive_string(
            compiled("start repeat(i < 100000) { F }\n"), (), 0, ir.Limits(memory=9_000_000)
        )


def test_steps_and_depth_have_limits() -> None:
    code = compiled("A --> A\nstart A\n")
    with pytest.raises(IpmError, match=r"limit-steps.*rule A \(<text>:1\) still applies"):
        derive_string(code, (), 0, ir.Limits(steps=50))
    with pytest.raises(IpmError, match="limit-depth"):
        derive_string(code, (), 0, ir.Limits(depth=20))


@pytest.mark.parametrize(
    ("grammar", "code", "says"),
    [
        ("A(x) : x > 1 --> F\nstart A(0.5) A(2)", "no-production", "A(0.5)"),
        (
            "A(x) : x% --> F\nA(x) : 50% --> f\nstart A(60)",
            "over-100-percent",
            "A(60) add up to 110",
        ),
        (
            "A(x) : 0 - x% --> F\nstart A(5) steps 1",
            "out-of-range",
            "rule A (<text>:1): its percentage is -5",
        ),
        (
            "A(x) : weight x --> F\nstart A(-1) steps 1",
            "out-of-range",
            "rule A (<text>:1): its weight is -1",
        ),
        ("A(x) --> B(1 / x)\nB(x) --> F(x)\nstart A(0)", "not-a-number", "argument of B"),
        ("A(x) --> *(x) F\nstart A(0)", "out-of-range", "rule A (<text>:1): `*` needs"),
        ("A --> F\nstart repeat(i < 400) { *(10) } A", "not-a-number", "rule A (<text>:1) draws"),
        ("attr n = 1.5\nstart F steps n", "bad-steps", "1.5"),
    ],
)
def test_run_time_errors_name_what_is_wrong(grammar: str, code: str, says: str) -> None:
    program = compiled(grammar + "\n")
    attrs = [1.5] * len(program.attrs)
    with pytest.raises(IpmError) as raised:
        derive_string(program, attrs, 0, ir.Limits())
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == code
    assert says in diagnostic.message


def test_a_module_without_production_stays_under_steps() -> None:
    code = compiled("A(x) : x > 1 --> A(x - 1)\nstart A(2.5) steps 5\n")
    assert derive_modules(code, (), 0, ir.Limits()) == [("A", (0.5,))]


def test_what_stays_draws_anew_in_each_step() -> None:
    code = compiled("A : 30% --> B\nstart repeat(i < 4000) { A } steps 3\n")
    names = [name for name, _ in derive_modules(code, (), 1, ir.Limits())]
    assert names.count("A") / 4000 == pytest.approx(0.7**3, abs=0.04)


def test_weights_are_shares_of_what_may_be_taken() -> None:
    grammar = """
A(x) : x > 0 : weight 3 --> F
A(x) : weight x + 1 --> f
start repeat(i < 4000) { A(1) } repeat(i < 500) { A(0) } steps 1
"""
    names = [name for name, _ in derive_modules(compiled(grammar), (), 1, ir.Limits())]
    assert names[:4000].count("F") / 4000 == pytest.approx(0.6, abs=0.04)
    assert set(names[4000:]) == {"f"}


TREE = """
A(l) : 85% --> F(l) [+(rand(9, 40)) A(l * 0.8)] B A(l * 0.9)
A(l) : else --> F(l) [-(rand(9, 40)) A(l * 0.8)]
B --> {}
start A(1) steps 9
"""


def test_editing_one_rule_leaves_the_draws_of_others() -> None:
    drawn = [
        derive_string(compiled(TREE.format(body)), (), 5, ir.Limits()).instances
        for body in ("nil", "[+(rand(0, 90)) F(0.1)] [F(0.2)]")
    ]
    kept = [each.key[each.size[:, 0] > 0.21] for each in drawn]
    assert len(kept[0]) > 20
    assert kept[0].tolist() == kept[1].tolist()
    assert len(drawn[1]) > len(drawn[0])


PRINT = """
import hashlib, sys
from ipmlang.compiler import ir
from ipmlang.runtime.strings import derive_string
sys.path.insert(0, sys.argv[1])
from tests.engine.grammars import compiled
found = derive_string(compiled(sys.argv[2]), (), 7, ir.Limits()).instances
parts = (getattr(found, name).tobytes() for name in found.__slots__)
print(hashlib.sha256(b"".join(parts)).hexdigest())
"""


def test_two_processes_give_the_same_bytes() -> None:
    root = str(Path(__file__).parents[2])
    command = [sys.executable, "-c", PRINT, root, TREE.format("f(0.1)")]
    found = {subprocess.check_output(command, env={"PYTHONHASHSEED": each}) for each in "123"}
    assert len(found) == 1
    assert len(found.pop().strip()) == len(hashlib.sha256().hexdigest())
