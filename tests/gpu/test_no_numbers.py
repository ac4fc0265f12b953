"""NaN is an error with its production on both executors, wherever it arises: in guards and nested
conditions, in strings whose modules thread or look at their neighbours, in splits, in chances, pens
and holes; and none where what is asked does not hang on it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.compiler import compile_text
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.runtime import derive
from ipmlang.runtime.scene import Scene
from tests.agreement import Outcome, assert_agree, outcome
from tests.errors.test_errors import MESSAGE, SOURCE
from tests.errors.test_run_errors import GOLDENS, message

pytestmark = pytest.mark.usefixtures("card")

ELSE = "\nA(x) : else --> F(2)\nstart A(-1)"
GUARDS = {
    "below": f"A(x) : sqrt(x) < 1 --> F{ELSE}",
    "at most": f"A(x) : 0 <= sqrt(x) --> F{ELSE}",
    "equal": f"A(x) : sqrt(x) == sqrt(x) --> F{ELSE}",
    "not equal": f"A(x) : sqrt(x) != 1 --> F{ELSE}",
    "not": f"A(x) : not (sqrt(x) > 0) --> F{ELSE}",
    "and": f"A(x) : x < 0 and sqrt(x) > 0 --> F{ELSE}",
    "or": f"A(x) : sqrt(x) > 0 or x > 0 --> F{ELSE}",
    "not and": f"A(x) : not (x < 0 and log(x) > 0) --> F{ELSE}",
    "if": f"A(x) : if sqrt(x) > 0 then true else true --> F{ELSE}",
    "chosen": f"A(x) : (if x < 0 then mod(x, 0) else x) > 0 --> F{ELSE}",
    "less": f"A(x) : min(1, sqrt(x)) > 0 --> F{ELSE}",
    "among those taken": f"A(x) : 50% --> F\nA(x) : asin(2 * x) > 0 --> F{ELSE}",
    "a constant": "const c = 0 / 0\nA(x) : c > x --> F\nA(x) : else --> F\nstart A(1)",
    "an attribute": "attr c : float = 3\nA(x) : 0 * (x / (c - 3)) > 1 --> F\nstart A(1)",
    "one of many": "A(x) : sqrt(x - 3) > 1 --> F\nA(x) : else --> F(2)\n"
    "start repeat(i < 700) { [f(i) A(mod(i, 50) + 2.5)] }",
    "a long chain": "A(x) : sqrt(x - 40) >= 0 --> F(1) A(x - 1)\nA(x) : else --> F\nstart A(600)",
    "a chain that draws": "A(x) : x > 0 and not (sqrt(x - 40) < rand() - 1) --> F(1) A(x - 1)\n"
    "A(x) : else --> F\nstart A(600)",
    "interpret": "A(x) --> B(x)\ninterpret B(x) : sqrt(x) > 1 --> F\nstart A(-1) steps 1",
    "a string": "A(x) : sqrt(x) > 0 --> +(3)\nA(x) : else --> -(3)\nB(x) --> A(x) F A(x - 2)\n"
    "start B(1) F",
    "a long string": "A(x) : sqrt(x - 2) > 0 --> +(3) A(x - 1) F\nA(x) : else --> -(3)\n"
    "start repeat(i < 300) { A(i / 40) F }",
    "a left neighbour": "A(x) < B(y) : sqrt(x - y) > 0 --> F\nstart A(1) B(2) steps 2",
    "a right neighbour": "B(y) > A(x) : mod(x, y) == 0 --> F\nstart B(0) A(2) steps 2",
    "a scope": "A : sqrt(scope.sx - 9) > 1 --> Fill\nA : else --> Wall\nstart A on box(3, 3, 3)",
    "a part": "A --> split x { { ~1: B(split.index / (split.count - 4)) }* }\n"
    "B(u) : asin(u - 1) < 9 --> Fill\nB(u) : else --> Wall\nstart A on box(3, 3, 3)",
    "a set attribute": "attr a = 1\nB : sqrt(a) > 0 --> Fill\nB : else --> Wall\n"
    "A --> split x { ~1: B | ~1: set (a = 0 - 4) B }\nstart A on box(3, 3, 3)",
    "a context": 'context m = "mask.png" over (-9, -9, 18, 18)\n'
    "A(x) : fetch(m, sqrt(x), 1) > 0 --> F\nA(x) : else --> F\nstart A(-1)",
}
OTHERS = {
    "a condition": "A(x) --> F(if sqrt(x) > 0 then 1 else 2)\nstart A(-1)",
    "a known condition": "A(x) --> F(if 0 / 0 > 0 then 1 else 2)\nstart A(-1)",
    "a truth value": "A(x) --> B(sqrt(x) > 0)\nB(g) : g --> F\nB(g) : else --> F\nstart A(-1)",
    "a percentage": f"A(x) : sqrt(x)% --> F{ELSE}",
    "a weight": "A(x) : weight 1 --> F\nA(x) : weight sqrt(x) --> F(2)\nstart A(-1)",
    "a width": "A(x) --> !(sqrt(x)) F\nstart A(-1)",
    "an infinite width": "A(x) --> !(1 / x) F\nstart A(0)",
    "a layer": "A(x) --> layer(sqrt(x)) F\nstart A(-1)",
    "a colour": 'A(x) --> color(if sqrt(x) > 0 then "red" else "blue") F\nstart A(-1)',
    "a material": 'A(x) --> material(if x / x > 0 then "a" else "b") Fill\n'
    "start A(0) on box(1, 1, 1)",
    "a hole": "A(x) --> repeat(i < 3) except (sqrt(x)) { [f(i) F] }\nstart A(-1)",
    "a hole in a string": (
        "A(x) --> repeat(i < 3) except (sqrt(x)) { B F }\nB --> +(3)\nstart A(-1)"
    ),
    "a move that nobody sees": "A(x) --> [f(sqrt(x))] F\nstart A(-1)",
    "a pen in a string": "A(x) --> B [!(sqrt(x))] F\nB --> +(3)\nstart A(-1) F",
    "an argument in a hole of a string": (
        "A(x) --> repeat(i < 3) except (1) { B !(1 / (i - 1)) F }\nB --> +(3)\nstart A(-1)"
    ),
    "a turtle's step": "attr a = -1\nturtle step sqrt(a)\nA --> F\nstart A",
    "a turtle's step that is drawn": ("turtle step sqrt(rand() - 0.5)\nA --> F F F\nstart A A A"),
    "a turtle's width": "attr a = -1\nturtle width sqrt(a)\nA --> [! F]\nstart A",
    "a turtle's width in a string": (
        "attr a = -1\nturtle width sqrt(a)\nA --> ! B F\nB --> +(3)\nstart A F"
    ),
    "a turtle's angle that nobody sees": (
        "attr a = -1\nturtle angle sqrt(a)\nA --> B F(1) [+]\nB --> +(3)\nstart A F(1)"
    ),
    "a turtle's step in a string": (
        "attr a = -1\nturtle step sqrt(a)\nA --> B F\nB --> +(3)\nstart A F(1)"
    ),
    "an overhang": "A(x) --> roofHip(30, overhang: sqrt(x))\nstart A(-1) on box(3, 3, 0)",
}
NONE = {
    "false and": "A(x) : x > 0 and sqrt(x) > 0 --> F\nA(x) : else --> F(2)\n"
    "start repeat(i < 400) { [A(i - 3)] }",
    "and false": "A(x) : sqrt(x) > 0 and x > 0 --> F\nA(x) : else --> F(2)\nstart A(-1)",
    "true or": "A(x) : x < 0 or sqrt(x) < 2 --> F\nA(x) : else --> F(2)\nstart A(-1) A(9)",
    "or true": "A(x) : sqrt(x) < 2 or x < 0 --> F\nA(x) : else --> F(2)\nstart A(-1) A(9)",
    "if": "A(x) --> F(if x > 0 then sqrt(x) else 2)\nstart A(-1) A(9)",
    "no one asks": "A(x) : x < 0 --> F\nA(x) : sqrt(x) > 1 --> F(2)\nA(x) : else --> F(3)\n"
    "start A(-1) A(9) A(1)",
    "weights behind": "A(x) : x < 0 --> F\nA(x) : weight sqrt(x) --> F(2)\n"
    "A(x) : weight 1 --> F(3)\nstart A(-1) A(9)",
    "a part that is not there": "A(x) --> split x { 20: Fill | x - x: !(sqrt(x)) B }\nB --> Fill\n"
    "start A(-1) on box(3, 3, 3)",
    "an argument of no copies": "A(x) --> repeat(i < x) { [+(0 / 0) F] } F\nstart A(0)",
    "an argument of no copies in a string": (
        "A(x) --> repeat(i < x) { B(0 / 0) +(0 / 0) F } F\nB(x) --> +(x)\nstart A(0)"
    ),
    "an argument in a hole": "A --> repeat(i < 3) except (1) { [!(1 / (i - 1)) F] }\nstart A",
    "any power of 0": "A(x) : pow(sqrt(x), 0) == 1 --> F\nA(x) : else --> F(2)\nstart A(-1)",
}
FOLDER = Path(__file__).resolve().parents[1] / "random_grammars"


def both(text: str) -> tuple[Outcome, Outcome]:
    """What numpy makes of a grammar, and what the card does."""
    program = compile_text(f"ipm 1\n{text}\n", folder=FOLDER)[1]
    wanted = outcome(lambda: derive(program, seed=2))
    return wanted, outcome(lambda: derive(program, seed=2, backend="gpu"))


@pytest.mark.parametrize("name", GUARDS)
def test_a_guard_that_is_not_a_number(name: str) -> None:
    wanted, found = both(GUARDS[name])
    assert isinstance(wanted, Diagnostic)
    assert wanted.code == "not-a-number"
    assert ": its guard is neither true nor false" in wanted.message
    assert wanted.trail is not None and wanted.trail.startswith("start")
    assert found == wanted


@pytest.mark.parametrize("name", OTHERS)
def test_something_else_that_is_not_a_number(name: str) -> None:
    wanted, found = both(OTHERS[name])
    assert isinstance(wanted, Diagnostic) and wanted.code == "not-a-number"
    assert wanted.trail is not None and wanted.trail.startswith("start")
    assert found == wanted


@pytest.mark.parametrize("name", NONE)
def test_what_does_not_hang_on_it(name: str) -> None:
    wanted, found = both(NONE[name])
    assert isinstance(found, Scene) and found.backend == "gpu"
    assert_agree(wanted, found)


@pytest.mark.parametrize("path", GOLDENS, ids=lambda path: path.stem)
def test_the_card_tells_the_same(path: Path) -> None:
    source, _, expected = path.read_text(encoding="utf-8").removeprefix(SOURCE).partition(MESSAGE)
    assert message(source, "gpu") == expected
