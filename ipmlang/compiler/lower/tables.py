"""Tables to numbers: rows written in the file, or read from the file beside it that it names.

In go `table` items, out come columns of numbers in which a text is its number among the program's
strings. Only a table that the program reaches is read.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Known, Pool
from ipmlang.compiler.lower.names import Place
from ipmlang.compiler.places import SHAPE, by_shape, choices, without_shapes

Cell = float | str


class Tables:
    """The tables of a program by the order in which it reaches them."""

    def __init__(self, pool: Pool) -> None:
        self._pool = pool
        self._numbers: dict[tuple[int, int], int] = {}
        self._placed: dict[tuple[int, int, str], int] = {}
        self._parted: dict[tuple[int, int], dict[str, ast.Table]] = {}
        self.data: list[ir.TableData] = []

    def number(self, place: Place) -> int:
        """The number of a table, made when first asked for."""
        key = (id(place.unit), place.item)
        if key not in self._numbers:
            item = place.unit.grammar.items[place.item]
            assert isinstance(item, ast.Table)
            self._numbers[key] = self._add(self._table(place, item))
        return self._numbers[key]

    def only(self, place: Place, shape: str) -> int:
        """The number of the rows of a table that place a symbol."""
        key = (id(place.unit), place.item, shape)
        if key not in self._placed:
            parted = self._parted.get(key[:2])
            if parted is None:
                item = place.unit.grammar.items[place.item]
                assert isinstance(item, ast.Table)
                parted = self._parted[key[:2]] = by_shape(item)
            self._placed[key] = self._add(self._table(place, parted[shape]))
        return self._placed[key]

    def choices(self, place: Place) -> int:
        """The number of a table of which symbol each row of a table places."""
        key = (id(place.unit), place.item, "")
        if key not in self._placed:
            item = place.unit.grammar.items[place.item]
            assert isinstance(item, ast.Table)
            chosen = choices(item)
            rows = self._inline(place, chosen)
            numbers = tuple(tuple(self._number(cell) for cell in row) for row in rows)
            self._placed[key] = self._add(
                ir.TableData(item.name, chosen.columns, frozenset(), numbers)
            )
        return self._placed[key]

    def steps(self, lengths: tuple[float, ...]) -> int:
        """A table of the moves between the copies of a repeat."""
        data = ir.TableData("", ("step",), frozenset(), tuple((each,) for each in lengths))
        return self.data.index(data) if data in self.data else self._add(data)

    def mistyped(self, number: int, texts: Sequence[str]) -> str | None:
        """The first column that should hold `texts` and does not, or the other way about."""
        table = self.data[number]
        wrong = [
            name
            for name in table.columns
            if table.rows and (name in texts) != (name in table.text_columns)
        ]
        return wrong[0] if wrong else None

    def _add(self, data: ir.TableData) -> int:
        self.data.append(data)
        return len(self.data) - 1

    def _table(self, place: Place, item: ast.Table) -> ir.TableData:
        item = item if SHAPE not in item.columns else without_shapes(item)
        if item.reference is not None:
            columns, rows = _read(place, item, item.reference)
        else:
            columns, rows = item.columns, self._inline(place, item)
        text = [
            name
            for column, name in enumerate(columns)
            if any(isinstance(row[column], str) for row in rows)
        ]
        numbers = tuple(tuple(self._number(cell) for cell in row) for row in rows)
        return ir.TableData(item.name, tuple(columns), frozenset(text), numbers)

    def _number(self, cell: Cell) -> float:
        return self._pool.text(cell).value if isinstance(cell, str) else float(cell)

    def _inline(self, place: Place, item: ast.Table) -> Sequence[Sequence[Cell]]:
        code = Code(self._pool, place.unit, place.item)
        return [[self._cell(code, cell) for cell in row] for row in item.rows]

    def _cell(self, code: Code, cell: ast.Expr) -> Cell:
        if isinstance(cell, ast.Text):
            return cell.value
        if isinstance(cell, ast.Number):
            return cell.value
        operand = code.value(cell, {})
        if isinstance(operand, Known):
            return operand.value
        raise code.error(cell.span, "not-constant", "a cell of a table must be a known number")


def _read(
    place: Place, item: ast.Table, reference: str
) -> tuple[Sequence[str], Sequence[Sequence[Cell]]]:
    from ipmlang.formats import FormatError

    name, _, node = reference.partition("#")
    path = place.unit.folder / name
    if path.suffix.lower() != ".svg":
        raise place.unit.error(
            place.item, item.span, "not-executable", f"tables in {path.suffix} are not read yet"
        )
    from ipmlang.formats.svg import read_table

    try:
        table = read_table(path, node)
    except FormatError as error:
        raise place.unit.error(
            place.item, item.span, "bad-table", f"{reference}: {error.message}", error.hint
        ) from error
    return table.columns, table.rows
