"""Run-time errors say how the shape came about, alike in both executors."""

from __future__ import annotations

import pytest

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.runtime import derive, frontier, single
from ipmlang.runtime.bind import bind
from ipmlang.runtime.numpy_backend import derive_frontier
from ipmlang.runtime.strings import derive_string
from tests.engine.grammars import compiled

GRAMMARS = {
    "copies": (
        "A --> repeat(i < 3) { [B(i)] }\nB(n) --> repeat(j < 4) { [f(j) C(n, j)] }\n"
        "C(n, j) : n + j < 5 --> F\nstart A\n",
        "start > A > B[2] > C[3]",
    ),
    "argument": (
        "A(n) : n > 0 --> [A(n - 1)] [B(n - 1)]\nA(n) : else --> nil\n"
        "B(n) --> [C(1 / n)]\nC(n) --> F(n)\nstart A(3)\n",
        "start > A > A > A > B",
    ),
    "percent": (
        "A(n) : n > 0 --> [A(n - 1)] [B(50 * n)]\nA(n) : else --> nil\n"
        "B(p) : p% --> F\nB(p) : else --> nil\nstart A(2) A(3)\n",
        "start > A > B",
    ),
    "chance": (
        "A --> repeat(i < 3) { [B(1 - i)] }\nB(p) : weight p --> F\nB(p) : weight 1 --> F\n"
        "start A\n",
        "start > A > B[2]",
    ),
    "in the start": ("A(n) : n > 9 --> F\nstart [A(10)] [A(2)]\n", "start > A"),
}


def failure(text: str, executor: str) -> Diagnostic:
    program, attrs = bind(compiled("ipm 1\n" + text), None, 0)
    derive = derive_frontier if executor == "frontier" else derive_string
    with pytest.raises(IpmError) as raised:
        derive(program, attrs, 0, program.limits)
    (diagnostic,) = raised.value.diagnostics
    return diagnostic


@pytest.mark.parametrize("name", GRAMMARS)
@pytest.mark.parametrize("narrow", [0, 1 << 30])
def test_both_executors_name_the_way(
    name: str, narrow: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frontier, "NARROW", narrow)
    monkeypatch.setattr(single, "WIDE", max(narrow, 96))
    text, way = GRAMMARS[name]
    string, batched = failure(text, "string"), failure(text, "frontier")
    assert batched.code == string.code
    assert string.trail == way
    if name != "argument":  # the frontier finds it when the shape that was made is derived
        assert batched.trail == way


@pytest.mark.parametrize(
    ("text", "way"),
    [
        # only strings
        ("A(n) : n > 0 --> F A(n - 1) F\nA(n) : else --> B F\nB : 1 > 2 --> F\nstart F A(2) F\n",
         "start > A > A > A > B"),
        ("A(n) : n > 0 --> repeat(i < 3) { F A(n - 1 - i) F }\nA(n) : n > -1.5 --> F\n"
         "start A(1) A(2)\n", "start > A > A[2]"),
        # contexts and cuts are derived step by step, and looked up afterwards
        ("B(n) < A(m) : m < 0 --> A(m)\nA(n) : n > 0 --> F B(n) A(n - 1)\nA(n) : else --> F(1)\n"
         "B(n) : n > 1 --> F\nstart A(2) F\n", "start > A > A > B"),
        ("A(n) : n > 0 --> [F cut F] B(n - 1) F\nB(n) --> F [A(n)] cut F\nA(n) : n < 0 --> F\n"
         "start F A(2) F\n", "start > A > B > A > B > A"),
        # interpretation
        ("A --> [X(2)] [X(0)]\ninterpret X(n) : n > 0 : (150 * n)% --> F\nstart A F\n",
         "start > A > X"),
        ("attr p = -1\nA < A --> A A\ninterpret A : p% --> F\nstart A A A steps 2\n",
         "start > A > A > A"),
        # of the turtle
        ("A(n) : n > 0 --> *(n - 1) F A(n - 1)\nA(n) : else --> nil\nstart A(3) F\n",
         "start > A > A > A > *"),
        ("A(n) : n > 0 --> repeat(i < 200) { *(10) } F A(n - 1)\nA(n) : else --> nil\n"
         "start A(3) F\n", "start > A > A > F"),
        ("A --> B cut\nB --> repeat(i < 2) { *(i - 1) F }\nstart A F\n", "start > A > B > *"),
    ],
)  # fmt: skip
def test_strings_name_the_way(text: str, way: str) -> None:
    assert failure(text, "string").trail == way


def test_limits_name_the_way() -> None:
    program = compiled("ipm 1\nA --> B F\nB --> [A] F\nstart [A] F\n")
    for limits in (ir.Limits(steps=30), ir.Limits(shapes=100)):
        with pytest.raises(IpmError) as raised:
            derive_string(program, (), 0, limits)
        trail = raised.value.diagnostics[0].trail
        assert trail is not None
        assert trail.startswith("start > A > B > A") and "> … >" in trail


def test_a_count_that_is_no_number_is_an_error_in_strings_too() -> None:
    found = failure("A(n) --> repeat(i < n / n) { F } F\nstart A(0) F\n", "string")
    assert (found.code, found.trail) == ("not-a-number", "start > A")
    assert "the count of a repeat is no finite number" in found.message


@pytest.mark.parametrize(
    "body",
    [
        "repeat(i < 3) { [!(sqrt(150.5 - k)) F] }",
        "repeat(i < 3) { repeat(j < 2) { [F(sqrt(150.5 - k))] } }",
        "repeat(i < 3) { repeat(j < 1 + sqrt(150.5 - k)) { [F] } }",
        "repeat(i < 3) { [*(150.5 - k) F] }",
        "repeat(i < 3) except (1, sqrt(150.5 - k)) { [F] }",
        "repeat(i < 3) except (0, 2) { [f(1e308 * sqrt(k - 150.5)) f(1e308 * k) F] }",
    ],
)
def test_the_way_leads_to_the_shape_whose_copies_fail(body: str) -> None:
    """A row of copies is not a row of the shapes that they are made of."""
    text = f"B(k) --> {body}\nstart repeat(k < 200) {{ [B(k)] }}\n"
    with pytest.raises(IpmError) as raised:
        derive(compiled("ipm 1\n" + text), seed=0)
    wanted = 0 if "k - 150" in body else 151
    assert raised.value.diagnostics[0].trail == f"start > B[{wanted}]"
