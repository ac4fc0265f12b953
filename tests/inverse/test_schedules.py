"""What stands here and there is rows of one table where that is shorter, in the same order."""

from __future__ import annotations

import numpy as np
import pytest

from ipmlang.compiler import ast, compile_text
from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.inverse.naming import Names
from ipmlang.inverse.schedules import with_schedules
from ipmlang.runtime import derive

THINGS = frozenset("ABC")
PLACES = [
    (7, 3, "A"),
    (2, 9, "B"),
    (4, 4, "A"),
    (8, 1, "C"),
    (5, 5, "B"),
    (1, 2, "A"),
    (9, 9, "C"),
    (3, 8, "B"),
]


def scheduled(body: str) -> tuple[str, list[ast.Table]]:
    grammar, problems = parse(Source("<text>", f"R --> {body}"))
    assert not problems
    rules = [item for item in grammar.items if isinstance(item, ast.Rule)]
    found = with_schedules(rules, THINGS, Names(), 1e-9)
    made, tables = found.rules, found.tables
    words = format_grammar(ast.Grammar(tuple(made))).split()
    return " ".join(words[2:]), tables


def test_many_things_here_and_there_are_a_table() -> None:
    body, (table,) = scheduled(" ".join(f"[at({x}, {y}) {thing}]" for x, y, thing in PLACES))
    assert body == "repeat(r in Places) { [at(r.x, r.y) r.shape] }"
    assert table.columns == ("shape", "x", "y")
    assert table.rows[1] == (ast.Name("B"), ast.Number(2.0), ast.Number(9.0))


def test_what_all_rows_have_is_said_once() -> None:
    placed = " ".join(f"[at({x}, 5, 30, {y}) mirror A]" for x, y, _ in PLACES)
    body, (table,) = scheduled(placed)
    assert body == "repeat(r in Places) { [at(r.x, 5, 30, r.scale) mirror A] }"
    assert table.columns == ("x", "scale")


@pytest.mark.parametrize(
    "placed",
    [
        "[at(1, 3) A] [at(0, 3) B] [at(5, 9) C]",  # few
        " ".join(f"[at({x}, {y}) Row({x})]" for x, y, _ in PLACES),  # a row says no argument
        "A B C A B C A B C A B C A B C A B C",  # all in one place: nothing to say
        "A [at(1, 0) B] [at(2, 0) A] [at(3, 0) B]",  # a walk is as short
    ],
)
def test_other_placements_stay(placed: str) -> None:
    assert scheduled(placed) == (placed, [])


def test_turned_mirrored_and_strange_ones_break_no_order() -> None:
    """The same things at the same places, one after the other."""
    placed = " ".join(f"[at({x}, {y}, {10 * x}) {thing}]" for x, y, thing in 2 * PLACES)
    plain = f"{placed} [- mirror B] [at(3, 1) f A] {placed} [+(20) *(3) C] A"
    body, tables = scheduled(plain)
    assert len(tables) == 2 and "[- mirror B] [at(3, 1) f A] repeat" in body
    rules = "A --> F(1)\nB --> F(2)\nC --> F(3)\nstart R\n"
    items = format_grammar(ast.Grammar(tuple(tables)))
    short = derive(compile_text(f"ipm 1\n{items}R --> {body}\n{rules}")[1]).instances
    long = derive(compile_text(f"ipm 1\nR --> {plain}\n{rules}")[1]).instances
    for column in ("position", "rotation", "scale", "size"):
        np.testing.assert_allclose(getattr(short, column), getattr(long, column), atol=1e-12)


def test_unlike_things_in_even_steps_are_a_loop_and_their_names() -> None:
    """Along a line, and along lines; what stands before and behind them stays where it is."""
    row = " ".join(f"[at({10 + 25 * k}, 14) {'ABC'[k * k % 3]}]" for k in range(12))
    body, (table,) = scheduled(f"[at(3, 2) C] {row} [at(7, 7) B]")
    loop = "[at(10, 14) repeat(i < 12) with r in Places { [at(25 * i, 0) r.shape] }]"
    assert body == f"[at(3, 2) C] {loop} [at(7, 7) B]"
    assert table.columns == ("shape",)
    lines = " ".join(f"[at({5 * (k % 4)}, {-9 * (k // 4)}) {'ABC'[k * k % 3]}]" for k in range(12))
    body, _ = scheduled(lines)
    assert "[at(5 * mod(k, 4), -9 * floor(k / 4)) r.shape]" in body


def test_few_things_and_turned_ones_are_walked() -> None:
    few = " ".join(f"[at({10 + 25 * k}, 14) {'AB'[k % 2]}]" for k in range(7))
    turned = " ".join(f"[at({10 + 25 * k}, 14, {k + 1}) {'AB'[k % 2]}]" for k in range(9))
    assert "repeat(i" not in scheduled(few)[0] + scheduled(turned)[0]
