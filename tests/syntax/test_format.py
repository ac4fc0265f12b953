"""Goldens of the formatter: `tests/fmt/NAME.in.ipm` becomes `tests/fmt/NAME.ipm`."""

from __future__ import annotations

from pathlib import Path

import pytest

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_expression, format_grammar
from tests.syntax.test_round_trip import check_round_trip, tree

FOLDER = Path(__file__).resolve().parent.parent / "fmt"
INPUTS = sorted(FOLDER.glob("*.in.ipm"))


@pytest.mark.parametrize("path", INPUTS, ids=lambda path: path.name.removesuffix(".in.ipm"))
def test_golden(path: Path, update: bool) -> None:
    text = path.read_text(encoding="utf-8")
    check_round_trip(text)
    formatted = format_grammar(tree(text))
    golden = path.with_name(path.name.replace(".in.ipm", ".ipm"))
    if update:
        golden.write_text(formatted, encoding="utf-8")
    assert formatted == golden.read_text(encoding="utf-8")
    assert max(len(line.split("//")[0].rstrip()) for line in formatted.splitlines()) <= 100


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (ast.Number(2.0), "2"),
        (ast.Number(0.1), "0.1"),
        (ast.Number(0.1, "0.10"), "0.10"),
        (ast.Number(0.2, "0.10"), "0.2"),
        (ast.Number(1e300), "1e300"),
        (ast.Number(1e-7), "1e-7"),
        (ast.Number(2_000_000.0), "2000000"),
        (ast.Text('a"b\\\n'), '"a\\"b\\\\\\n"'),
    ],
)
def test_spelling(expression: ast.Expr, text: str) -> None:
    assert format_expression(expression) == text


def test_a_number_without_a_spelling_is_refused() -> None:
    with pytest.raises(ValueError, match="no spelling"):
        format_expression(ast.Number(float("nan")))
