"""Symbols as arguments: a rule that takes some is lowered once for each that it is given.

In go units, out comes which parameters of a symbol's rules are symbols, and for an argument every
symbol that it may be with the condition under which it is. So a program knows no symbols as values:
`Card(Heart, 5)` is a symbol of its own with one number, and executors see nothing new.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.lower.expr import Code, Environment, Known, Named, Operand, Row
from ipmlang.compiler.lower.names import Unit
from ipmlang.compiler.ops import OPERATIONS, OPERATORS
from ipmlang.compiler.passing import Passing, passing, symbols_taken
from ipmlang.compiler.places import SHAPE, row_of

Key: TypeAlias = tuple[int, str, int]  # a unit, a name in it, how many arguments
Bound: TypeAlias = tuple[Named | None, ...]  # of each argument the symbol, None: it is a value
Put: TypeAlias = Callable[[Code, Named], None]  # what is to be written for a symbol


class Takers:
    """Which rules of some units take symbols."""

    def __init__(self, units: Iterable[Unit]) -> None:
        self._found = symbols_taken(use for unit in units for use in _uses(unit))

    def of(self, unit: Unit, name: str, arity: int) -> frozenset[int]:
        """Which of the arguments of a symbol, as a unit calls it, are symbols."""
        if not arity or not self._found:
            return frozenset()
        return self._found.get(_key(unit, name, arity), frozenset())


def _uses(unit: Unit) -> Iterator[tuple[Key, Passing, Callable[[str, int], Key]]]:
    """The rules that a unit knows and that have parameters, with what they do with them."""
    for named in (unit.rules, unit.interpretations):
        for name, places in named.items():
            for place in places:
                rule = place.unit.grammar.items[place.item]
                if isinstance(rule, ast.Rule) and rule.head.parameters:
                    own = (id(unit), plain(name), len(rule.head.parameters))
                    yield own, passing(rule), partial(_key, place.unit)


def _key(unit: Unit, name: str, arity: int) -> Key:
    """A symbol as the unit knows it that a name leads to."""
    owner, own = unit.within(name)
    return id(owner), plain(own), arity


def plain(name: str) -> str:
    """The first of the names that an operation has; any other name as it is."""
    record = OPERATIONS.get(name)
    return name if record is None else record.name


class Choosing:
    """Writes code for each symbol that an argument may be; `number` numbers its repeats, `rows`
    gives the symbols that the rows of a table place, and a table of which of them each does.
    """

    def __init__(
        self,
        number: Callable[[], int],
        rows: Callable[[Unit, str], tuple[tuple[Named, ...], int]],
    ) -> None:
        self._number = number
        self._rows = rows

    def put(
        self, code: Code, expr: ast.Expr, names: Environment, span: ast.Span, write: Put
    ) -> None:
        """Write what is to be written for the symbol that an expression is."""
        if isinstance(expr, ast.If):
            self._either(code, expr, names, span, write)
            return
        if not isinstance(expr, ast.Name):
            raise code.error(expr.span, "wrong-type", "this must be a symbol")
        bound, row = names.get(expr.id), names.get(row_of(expr.id))
        if isinstance(bound, Named):
            write(code, bound)
        elif isinstance(row, Row):
            self.row(code, row, span, write)
        else:
            write(code, Named(code.unit, expr.id))

    def row(self, code: Code, row: Row, span: ast.Span, write: Put) -> None:
        """The symbol of a row's column `shape`."""
        shapes, table = self._rows(code.unit, row.name)
        if shapes:
            self._one_of(code, shapes, (Row(table, (SHAPE,), row.index), 0), span, write)

    def _either(
        self, code: Code, expr: ast.If, names: Environment, span: ast.Span, write: Put
    ) -> None:
        """The outcome of a choice: each is written once or not at all."""
        condition = code.value(expr.condition, names)
        if isinstance(condition, Known):
            self.put(code, expr.value if condition.value else expr.other, names, span, write)
            return
        for often, outcome in (
            (condition, expr.value),
            (code.call("not", (condition,)), expr.other),
        ):
            inner = code.block()
            self.put(inner, outcome, names, span, write)
            code.repeat(self._number(), (often,), inner, span)

    def _one_of(
        self,
        code: Code,
        shapes: Sequence[Named],
        choice: tuple[Row, int],
        span: ast.Span,
        write: Put,
    ) -> None:
        """The symbol whose number a row says, `choice[1]` for the first: by halves, each of which
        is drawn once or not at all, so that many rows of many symbols take few questions.
        """
        if len(shapes) == 1:
            write(code, shapes[0])
            return
        row, first = choice
        middle = len(shapes) // 2
        said, limit = code.row(row, SHAPE), code.number(first + middle)
        for sign, half, start in (("<", shapes[:middle], 0), (">=", shapes[middle:], middle)):
            inner = code.block()
            self._one_of(inner, half, (row, first + start), span, write)
            often: Operand = code.call(OPERATORS[sign], (said, limit))
            code.repeat(self._number(), (often,), inner, span)
