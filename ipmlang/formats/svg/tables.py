"""Tables of a parts file: rows of named columns inside the metadata of an SVG.

`table_xml` writes one, `read_table` reads it back: cells parted by blanks, a row a line, strings as
JSON, the rest numbers. What the columns mean is the caller's.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias
from xml.sax.saxutils import escape, quoteattr

from ipmlang.formats import FormatError
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.xml import Node, read_document

NAMESPACE = "https://ipmlang.org/ns"
_TABLE = f"{{{NAMESPACE}}}table"
_CELL = re.compile(r'"(?:[^"\\]++|\\.)*"|[^\s"]++|"')

Cell: TypeAlias = float | str


class Table(NamedTuple):
    """Rows of cells, each as long as `columns`, the names of the columns."""

    columns: tuple[str, ...]
    rows: list[tuple[Cell, ...]]


def table_xml(name: str, columns: Sequence[str], rows: Iterable[Sequence[Cell]]) -> str:
    """A `<table>` for the `<metadata>` of a parts file; numbers are written so that they read back
    as the same float.

    >>> print(table_xml("T", ["x", "c"], [(0.5, "a b"), (2.0, "c")]))
    <table xmlns="https://ipmlang.org/ns" id="T" columns="x c">
    0.5 "a b"
    2 "c"
    </table>
    """
    lines = "".join(" ".join(_cell(value) for value in row) + "\n" for row in rows)
    names = quoteattr(" ".join(columns))
    head = f'<table xmlns="{NAMESPACE}" id={quoteattr(name)} columns={names}>'
    return f"{head}\n{escape(lines)}</table>"


def _cell(value: Cell) -> str:
    if isinstance(value, str):
        return json.dumps(value)
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def read_table(path: Path | str, name: str) -> Table:
    """The table with this id: numbers as floats, what is quoted as text.

    Raises `FormatError`, with the line, if the file cannot be read, has no such table, or a row has
    more or fewer cells than there are columns or a cell that is neither number nor text.
    """
    document = read_document(path, Limits(), Notes())
    node = next(
        (one for one in document.nodes if one.tag == _TABLE and one.get("id") == name), None
    )
    if node is None:
        raise FormatError(f"{path} has no table `{name}`")
    columns = tuple((node.get("columns") or "").split())
    return Table(columns, _rows(node, len(columns), name))


def _rows(node: Node, width: int, name: str) -> list[tuple[Cell, ...]]:
    rows: list[tuple[Cell, ...]] = []
    for offset, line in enumerate(node.text.split("\n")):
        words = _CELL.findall(line) if '"' in line else line.split()
        if not words:
            continue
        place = None if node.line is None else node.line + offset
        if len(words) != width:
            raise FormatError(f"table `{name}`: a row has {len(words)} cells, not {width}", place)
        try:
            rows.append(tuple(map(_read_cell, words)))
        except ValueError:
            message = f"table `{name}`: a cell is neither a number nor a quoted text"
            raise FormatError(message, place) from None
    return rows


def _read_cell(word: str) -> Cell:
    return str(json.loads(word)) if word[0] == '"' else float(word)
