"""Tables of parts files: what is written comes back, and what is broken is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as some

from ipmlang.formats import FormatError
from ipmlang.formats.svg import read_svg, read_table, table_xml

SVG = '<svg xmlns="http://www.w3.org/2000/svg"><metadata>{}</metadata></svg>'
TEXTS = some.text(some.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]))
NUMBERS = some.floats(allow_nan=False, allow_infinity=False)


@given(some.lists(some.tuples(NUMBERS, TEXTS), max_size=5))
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, str]]
) -> None:
    """Numbers to the last bit, texts with quotes, angle brackets and blanks."""
    path = tmp_path_factory.getbasetemp() / "table.svg"
    path.write_text(SVG.format(table_xml("T", ["x", "label"], rows)), encoding="utf-8")
    table = read_table(path, "T")
    assert table.columns == ("x", "label")
    assert table.rows == rows


@pytest.mark.parametrize(
    ("body", "message"),
    [("1 2\n3", "1 cells, not 2"), ("1 x", "neither a number"), ('1 "a', "cells, not 2")],
)
def test_broken_rows(tmp_path: Path, body: str, message: str) -> None:
    """A row with a wrong number of cells, a bare word, a quote that is not closed."""
    path = tmp_path / "table.svg"
    table = f'<table xmlns="https://ipmlang.org/ns" id="T" columns="x y">{body}</table>'
    path.write_text(SVG.format(table), encoding="utf-8")
    with pytest.raises(FormatError, match=message):
        read_table(path, "T")


def test_no_such_table(tmp_path: Path) -> None:
    """Another table in the same file is not taken for it, and a table is not drawn."""
    path = tmp_path / "table.svg"
    path.write_text(SVG.format(table_xml("T", ["x"], [(1.0,)])), encoding="utf-8")
    with pytest.raises(FormatError, match="no table `S`"):
        read_table(path, "S")
    assert not read_svg(path).elements
