"""Symbols as arguments: a rule that takes some gives what the rules written out for each give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ipmlang.compiler import compile_text
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.ir import Program
from ipmlang.compiler.load import load_text
from ipmlang.compiler.verify import verify
from ipmlang.rule_table import rule_rows
from ipmlang.runtime import derive
from ipmlang.runtime.scene import Scene
from tests.random_grammars import FOLDER

LEAVES = """
    asset leaf, star in "pieces.parts.svg"
    Leaf --> F(1) [+ F(0.5)] f
    Bud --> -(20) F(2)
"""
ROW = """
    Row(s, n) : n > 0 --> [s] f(3) Row(s, n - 1)
    Row(s, n) : else --> s s F
"""


def program(text: str) -> Program:
    lines = [line.strip() for line in text.strip().splitlines()]
    made = compile_text("\n".join(["ipm 1", *lines, ""]), folder=FOLDER)[1]
    assert verify(made) == []
    return made


def scene(text: str, seed: int = 3) -> Scene:
    found = derive(program(text), seed=seed)
    assert isinstance(found, Scene)
    return found


PAIRS = {
    "placed": (
        LEAVES + "Two(s) --> [s] + s F\nstart Two(Leaf) Two(star) Two(Tip)",
        LEAVES + "A --> [Leaf] + Leaf F\nB --> [star] + star F\nC --> [Tip] + Tip F\nstart A B C",
    ),
    "handed on, with numbers, to itself": (
        LEAVES + ROW + "start Row(Leaf, 4) [Row(Bud, 2)]",
        LEAVES + "A(n) : n > 0 --> [Leaf] f(3) A(n - 1)\nA(n) : else --> Leaf Leaf F\n"
        "B(n) : n > 0 --> [Bud] f(3) B(n - 1)\nB(n) : else --> Bud Bud F\n"
        "start A(4) [B(2)]",
    ),
    "handed on to another, which places it": (
        LEAVES + ROW + "Fork(n, t) --> [+ Row(t, n)] [- Row(t, n + 1)]\nstart Fork(2, Leaf)",
        LEAVES + ROW + "Fork(n) --> [+ Row(Leaf, n)] [- Row(Leaf, n + 1)]\nstart Fork(2)",
    ),
    "swapped from call to call": (
        LEAVES + "A(s, t, n) : n > 0 --> [s] f A(t, s, n - 1)\nA(s, t, n) : else --> t\n"
        "start A(Leaf, Bud, 3)",
        LEAVES + "A(n) : n > 0 --> [Leaf] f B(n - 1)\nA(n) : else --> Bud\n"
        "B(n) : n > 0 --> [Bud] f A(n - 1)\nB(n) : else --> Leaf\nstart A(3)",
    ),
    "drawn with alternatives": (
        LEAVES + "S(s) : 40% --> [s] F\nS(s) : else --> + s\nstart repeat(i < 20) { S(Leaf) f(9) }",
        LEAVES + "S : 40% --> [Leaf] F\nS : else --> + Leaf\nstart repeat(i < 20) { S f(9) }",
    ),
    "in rules of what is left": (
        LEAVES + "A(s, n) --> A(s, n + 1)\ninterpret A(s, n) --> F(n) [s]\n"
        "start A(Bud, 1) A(Leaf, 2) steps 3",
        LEAVES + "A(n) --> A(n + 1)\nB(n) --> B(n + 1)\ninterpret A(n) --> F(n) [Bud]\n"
        "interpret B(n) --> F(n) [Leaf]\nstart A(1) B(2) steps 3",
    ),
    "in a neighbourhood": (
        LEAVES + "A(x) < B(s, y) > A(z) --> F(x + z) s\nB(s, y) --> nil\nA(x) --> A(x)\n"
        "start A(1) B(Leaf, 5) A(2) B(Bud, 1) steps 2",
        LEAVES + "A(x) < B(y) > A(z) --> F(x + z) Leaf\nC(y) --> nil\nA(x) --> A(x)\n"
        "start A(1) B(5) A(2) C(1) steps 2",
    ),
    "under what is set": (
        LEAVES + "attr w = 1\nStem --> F(w)\nTwice(s) --> set w = 2 * w s s\n"
        "start Stem Twice(Stem) Twice(Leaf)",
        LEAVES + "attr w = 1\nStem --> F(w)\nA --> set w = 2 * w Stem Stem\n"
        "B --> set w = 2 * w Leaf Leaf\nstart Stem A B",
    ),
    "of a shape": (
        "asset block = \"pieces.obj\"\nWall(s, w) --> split x { { ~w: s }* }\n"
        "Door --> size(scope.sx / 2, scope.sy, 1) Panel\n"
        "start split y { 1: Wall(Door, 2) | 1: Wall(block, 3) | 1: Wall(Pane, 1) } on box(9, 3, 0)",
        "asset block = \"pieces.obj\"\nA(w) --> split x { { ~w: Door }* }\n"
        "B(w) --> split x { { ~w: block }* }\nC(w) --> split x { { ~w: Pane }* }\n"
        "Door --> size(scope.sx / 2, scope.sy, 1) Panel\n"
        "start split y { 1: A(2) | 1: B(3) | 1: C(1) } on box(9, 3, 0)",
    ),
    "that bears an operation's name as a parameter": (
        LEAVES + "A(comp) --> [comp] F\nstart A(Leaf)",
        LEAVES + "A --> [Leaf] F\nstart A",
    ),
    "of a table's rows": (
        LEAVES + "table T(x, shape) = (1, Leaf), (3, Leaf), (5, Bud)\nTwo(s) --> [s] + s\n"
        "start repeat(at T) { Two(at.shape) }",
        LEAVES + "table T(x, shape) = (1, A), (3, A), (5, B)\nA --> [Leaf] + Leaf\n"
        "B --> [Bud] + Bud\nstart repeat(at T) { at.shape }",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("with_symbols", "written_out"), PAIRS.values(), ids=PAIRS)
def test_a_rule_that_takes_symbols_is_its_rules_written_out(
    with_symbols: str, written_out: str
) -> None:
    """The same rows with the same keys: what is drawn hangs on no symbol's being an argument."""
    one, other = scene(with_symbols), scene(written_out)
    assert len(one.instances) > 1
    for column in ("position", "rotation", "scale", "size", "key"):
        wanted = getattr(other.instances, column)
        np.testing.assert_array_equal(getattr(one.instances, column), wanted, err_msg=column)


def lengths(text: str, seed: int = 0) -> list[float]:
    found: list[float] = scene(text, seed).instances.size[:, 0].tolist()
    return found


CHOSEN = """
    One --> F(1)
    Two --> F(2)
    Three --> F(3)
    A(s, n) --> s F(n)
"""


def test_a_choice_is_made_where_the_symbol_is_given() -> None:
    row = "table T(d, shape) = (1, Two), (2, One), (3, Three), (4, Two)\n"
    assert lengths(CHOSEN + "start A(if 2 > 1 then One else Two, 7)") == [1, 7]
    chosen = "repeat(i < 4) { A(if i > 2 then One else if i > 1 then Two else Three, i + 5) }"
    assert lengths(CHOSEN + f"start {chosen}") == [3, 5, 3, 6, 2, 7, 1, 8]
    rows = "start repeat(r in T) { A(r.shape, r.d) }"
    assert lengths(CHOSEN + row + rows) == [2, 1, 1, 2, 3, 3, 2, 4]
    mixed = "start repeat(r in T) { A(if r.d > 2 then r.shape else One, r.d) }"
    assert lengths(CHOSEN + row + mixed) == [1, 1, 1, 2, 3, 3, 2, 4]


def test_what_chance_chose_stays_chosen() -> None:
    text = CHOSEN + "Twice(s) --> s s\nstart repeat(i < 40) { "
    found = lengths(text + "Twice(if rand() < 0.5 then One else Two) }", seed=5)
    pairs = np.asarray(found).reshape(-1, 2)
    assert len(found) == 80
    assert (pairs[:, 0] == pairs[:, 1]).all()
    assert {1.0, 2.0} == set(found)


def test_a_symbol_means_what_it_means_where_it_was_written(tmp_path: Path) -> None:
    (tmp_path / "lib.ipm").write_text(
        "ipm 1\nPart --> F(9)\nTwice(s) --> [s] [Part]\ntable T(x, shape) = 1, Part\nstart Part\n"
    )
    text = 'ipm 1\nimport "lib"\nPart --> F(4)\nstart lib.Twice(Part) lib.Twice(lib.Part) '
    made = compile_text(text + "repeat(at lib.T) { at.shape }\n", folder=tmp_path)[1]
    found = derive(made)
    assert isinstance(found, Scene)
    assert found.instances.size[:, 0].tolist() == [4, 9, 9, 9, 9]


def test_many_symbols_that_are_swapped_are_refused() -> None:
    names = "abcdefgh"
    turned = ", ".join(names[1:] + names[0])
    swapped = ", ".join("ba" + names[2:])
    given = ", ".join(f"P{name}" for name in names)
    text = f"R({', '.join(names)}, n) : n > 0 --> R({turned}, n - 1) R({swapped}, n - 1)\n"
    text += f"R({', '.join(names)}, n) : else --> {' '.join(names)}\nstart R({given}, 3)"
    with pytest.raises(IpmError) as error:
        program(text)
    assert error.value.diagnostics[0].code == "too-many-symbols"


def test_a_rule_is_one_rule_however_many_symbols_it_is_given() -> None:
    rows = rule_rows(program(LEAVES + ROW + "start Row(Leaf, 4) [Row(Bud, 2)] Row(star, 1)"))
    assert [row["rule"] for row in rows].count("Row") == 2  # its two alternatives


def test_it_is_written_as_it_is_read() -> None:
    text = "ipm 1\nA(s, n) --> [s] A(if n > 1 then s else Leaf, n - 1)\nstart A(Leaf, 3)\n"
    assert format_grammar(load_text(text).main.grammar) == text
