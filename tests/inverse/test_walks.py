"""What stands in a line is written as a walk along it where that is shorter, and only there."""

from __future__ import annotations

import pytest

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Source
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.parse import parse
from ipmlang.inverse.joined_tables import join_tables
from ipmlang.inverse.walks import with_walks

THINGS = {"A", "B", "C"}


def rule_of(text: str) -> ast.Rule:
    grammar, problems = parse(Source("<text>", text))
    assert not problems
    (rule,) = (item for item in grammar.items if isinstance(item, ast.Rule))
    return rule


def walked(body: str) -> str:
    made = with_walks(rule_of(f"R --> {body}"), THINGS)
    return format_grammar(ast.Grammar((made,))).strip().removeprefix("R --> ")


@pytest.mark.parametrize(
    ("placed", "wanted"),
    [
        ("[at(1.1, 3) A] [at(3.3, 3) B]", "[at(1.1, 3) A f(2.2) B]"),
        ("[at(1, 3) A] [at(1, 3) B] [at(4, 3) C]", "[at(1, 3) A B f(3) C]"),
        ("A [at(2, 0) B] [at(5, 0) C]", "[A f(2) B f(3) C]"),
    ],
)
def test_things_ahead_of_each_other_are_a_walk(placed: str, wanted: str) -> None:
    assert walked(placed) == wanted


@pytest.mark.parametrize(
    "placed",
    [
        "A B [at(5, 0) C]",  # a walk would be no shorter
        "[at(1, 3) A] [at(0, 3) B]",  # back
        "[at(1, 3) A] [at(2, 4) B]",  # on another line
        "[at(1, 3, 90) A] [at(2, 3) B]",  # turned
        "[at(1, 3) Row] [at(2, 3) B]",  # leaves the turtle elsewhere
    ],
)
def test_other_placements_stay(placed: str) -> None:
    assert walked(placed) == placed


def number(value: float) -> ast.Number:
    return ast.Number(value)


def table(name: str, *columns: tuple[str, list[float]]) -> ast.Table:
    rows = zip(*(map(number, cells) for _, cells in columns), strict=True)
    return ast.Table(name, None, tuple(column for column, _ in columns), tuple(rows))


def test_tables_with_a_column_in_common_are_one() -> None:
    heights = [64.0, 28.0, 91.0]
    one = table("One", ("x", [1.0, 5.0, 2.0]), ("y", heights))
    two = table("Two", ("x", [7.0, 3.0, 8.0]), ("y", [each - 20 for each in heights]))
    other = table("Other", ("x", [7.5, 3.0, 8.0]), ("y", [1.0, 2.0, 4.0]))
    rule = rule_of(
        "R --> repeat(r in One) { [at(r.x, r.y) A] } repeat(r in Two) { [at(r.x, r.y) B] } "
        "repeat(r in Other) { [at(r.x, r.y) C] }"
    )
    (made,), tables = join_tables([rule], [one, two, other])
    assert [(each.name, each.columns) for each in tables] == [
        ("One", ("x", "y", "x_2")),
        ("Other", ("x", "y")),
    ]
    assert made == rule_of(
        "R --> repeat(r in One) { [at(r.x, r.y) A] } repeat(r in One) { [at(r.x_2, r.y - 20) B] } "
        "repeat(r in Other) { [at(r.x, r.y) C] }"
    )


def test_residuals_of_a_rule_are_left_alone() -> None:
    same = [1.0, 2.0, 4.0]
    one, two = (table(name, ("x", same), ("y", same)) for name in ("One", "Two"))
    rule = rule_of(
        "R --> repeat(i < 3) with r in One { [at(r.x, r.y) A] } "
        "repeat(r in Two) { [at(r.x, r.y) B] }"
    )
    (made,), tables = join_tables([rule], [one, two])
    assert made == rule
    assert tables == [one, two]
