"""Tables of a parts file: rows of named columns inside the metadata of an SVG.

`table_xml` writes one, `read_table` reads it back: cells parted by blanks, a row a line, strings as
JSON. Cells stay text here; what they mean is the caller's.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from ipmlang.formats import FormatError
from ipmlang.formats.svg.limits import Limits, Notes
from ipmlang.formats.svg.xml import Node, read_document

NAMESPACE = "https://ipmlang.org/ns"
_TABLE = f"{{{NAMESPACE}}}table"
_CELL = re.compile(r'"(?:[^"\\]++|\\.)*+"|[^\s"]++')
_BLANK = re.compile(r"\s*+")


def table_xml(name: str, columns: Sequence[str], rows: Iterable[Sequence[str | float]]) -> str:
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


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return json.dumps(value)
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def read_table(path: Path | str, name: str) -> tuple[list[str], list[list[str]]]:
    """The columns and the rows of the table with this id; strings come without their quotes.

    Raises `FormatError` if the file cannot be read, has no such table, or a row has more or fewer
    cells than there are columns.
    """
    document = read_document(path, Limits(), Notes())
    node = next(
        (one for one in document.nodes if one.tag == _TABLE and one.get("id") == name), None
    )
    if node is None:
        raise FormatError(f"{path} has no table `{name}`")
    columns = (node.get("columns") or "").split()
    return columns, _rows(node, len(columns), name)


def _rows(node: Node, width: int, name: str) -> list[list[str]]:
    rows: list[list[str]] = []
    for offset, line in enumerate(node.text.split("\n")):
        cells = _cells(line)
        if cells is None or (cells and len(cells) != width):
            found = "a broken cell" if cells is None else f"{len(cells)} cells"
            place = None if node.line is None else node.line + offset
            raise FormatError(f"table `{name}`: a row has {found}, not {width} cells", place)
        if cells:
            rows.append(cells)
    return rows


def _cells(line: str) -> list[str] | None:
    """The cells of a row; None if one of them is broken."""
    words = _CELL.findall(line)
    if len("".join(words)) != len(_unquoted_blanks(line)):
        return None
    try:
        return [str(json.loads(word)) if word[0] == '"' else word for word in words]
    except ValueError:
        return None


def _unquoted_blanks(line: str) -> str:
    """The line without the blanks between its cells."""
    parts, end = [], 0
    for match in _CELL.finditer(line):
        parts += [_BLANK.sub("", line[end : match.start()]), match[0]]
        end = match.end()
    return "".join(parts) + _BLANK.sub("", line[end:])
