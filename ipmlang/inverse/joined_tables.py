"""Tables that share columns, joined: one row for each thing of which several marks are drawn.

Takes the rules and tables as they are printed; where tables of equally many rows have a column in
common, give or take a constant (the dots of two series at the same heights), gives one table with
that column once, and loops that add the constant. What is drawn stays the same. Nothing here looks
at a drawing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from ipmlang.compiler import ast
from ipmlang.inverse.lsystem.frames import Floats
from ipmlang.inverse.numbers import shortest

SAME = 1e-9  # of the largest cell: what two columns, a constant apart, may differ by
DECIMALS = 9

Column: TypeAlias = "tuple[str, float]"  # where a column is found now, and what is added to it


@dataclass(slots=True, eq=False)
class _Joint:
    """A table that others are joined to: its cells, and those that are numbers, by column; found:
    where each column of each table that was joined stands now.
    """

    name: str
    rows: int
    cells: dict[str, tuple[ast.Expr, ...]] = field(default_factory=dict)
    values: dict[str, Floats] = field(default_factory=dict)
    found: dict[tuple[str, str], Column] = field(default_factory=dict)

    def shared(self, table: ast.Table) -> dict[str, Column]:
        """Which columns of a table are here already, up to a constant."""
        own = {name: self._find(value) for name, value in _numbers(table).items()}
        return {name: column for name, column in own.items() if column is not None}

    def _find(self, value: Floats) -> Column | None:
        for name, known in self.values.items():
            apart = value - known
            middle = shortest(float(np.median(apart)), 10.0**-DECIMALS / 2)
            size = max(float(np.abs(value).max()), float(np.abs(known).max()))
            if np.ptp(known) > 0 and (np.abs(apart - middle) <= SAME * size).all():
                return name, middle
        return None

    def take(self, table: ast.Table) -> None:
        """Join a table to this one."""
        there, numbers = self.shared(table), _numbers(table)
        for place, column in enumerate(table.columns):
            if column not in there:
                own = self._free(column)
                there[column] = own, 0.0
                self.cells[own] = tuple(row[place] for row in table.rows)
                if column in numbers:
                    self.values[own] = numbers[column]
            self.found[table.name, column] = there[column]

    def _free(self, wish: str) -> str:
        names = (wish, *(f"{wish}_{k}" for k in range(2, len(self.cells) + 3)))
        return next(name for name in names if name not in self.cells)

    def table(self) -> ast.Table:
        """The table of all that were joined."""
        rows = tuple(zip(*self.cells.values(), strict=True))
        return ast.Table(self.name, None, tuple(self.cells), rows)


def _numbers(table: ast.Table) -> dict[str, Floats]:
    """The columns that hold numbers only."""
    columns = dict(zip(table.columns, zip(*table.rows, strict=True), strict=True))
    known: dict[str, Floats] = {}
    for name, cells in columns.items():
        values = [cell.value for cell in cells if isinstance(cell, ast.Number)]
        if len(values) == len(cells):
            known[name] = np.array(values)
    return known


def join_tables(
    rules: Sequence[ast.Rule], tables: Sequence[ast.Table]
) -> tuple[list[ast.Rule], list[ast.Table]]:
    """The same rules and tables, those that share a column as one.

    Only tables whose rows one kind of loop places are looked at, not the residuals of rules.
    """
    placing = _placing(rules)
    joints: list[_Joint] = []
    for table in (each for each in tables if each.name in placing):
        fits = [(len(each.shared(table)), each) for each in joints if each.rows == len(table.rows)]
        often, joint = max(fits, key=lambda each: each[0], default=(0, None))
        if joint is None or not often:
            joint = _Joint(table.name, len(table.rows))
            joints.append(joint)
        joint.take(table)
    of = {name: joint for joint in joints for name, _ in joint.found}
    joined = {each.name: each for each in joints if len({name for name, _ in each.found}) > 1}
    of = {name: joint for name, joint in of.items() if joint.name in joined}
    left = [
        joined[each.name].table() if each.name in joined else each
        for each in tables
        if each.name not in of or each.name in joined
    ]
    return [replace(rule, body=_elements(rule.body, of)) for rule in rules], left


def _placing(rules: Sequence[ast.Rule]) -> set[str]:
    """The tables that a loop goes over and nothing else reads."""
    loops = [each for rule in rules for each in _loops(rule.body)]
    heads = {each.head.table for each in loops if isinstance(each.head, ast.Rows)}
    return heads - {each.rows.table for each in loops if each.rows is not None}


def _loops(body: tuple[ast.Element, ...]) -> Iterator[ast.Repeat]:
    for element in body:
        if isinstance(element, ast.Repeat):
            yield element
        if isinstance(element, ast.Repeat | ast.Bracket):
            yield from _loops(element.body)


# ------------------------------------------------------------------------ the loops


def _elements(body: tuple[ast.Element, ...], of: dict[str, _Joint]) -> tuple[ast.Element, ...]:
    return tuple(_element(each, of) for each in body)


def _element(element: ast.Element, of: dict[str, _Joint]) -> ast.Element:
    if isinstance(element, ast.Bracket):
        return replace(element, body=_elements(element.body, of))
    if not isinstance(element, ast.Repeat):
        return element
    head = element.head
    if not isinstance(head, ast.Rows) or head.table not in of:
        return replace(element, body=_elements(element.body, of))
    joint = of[head.table]
    columns = {
        f"{head.variable}.{column}": (f"{head.variable}.{own}", more)
        for (table, column), (own, more) in joint.found.items()
        if table == head.table
    }
    body = tuple(_reading(each, columns) for each in element.body)
    return replace(element, head=replace(head, table=joint.name), body=body)


def _reading(element: ast.Element, columns: dict[str, Column]) -> ast.Element:
    """An element of a loop over a table, with the names of its columns as they are now."""
    if isinstance(element, ast.Bracket):
        return replace(element, body=tuple(_reading(each, columns) for each in element.body))
    if isinstance(element, ast.Module):
        args = tuple(replace(each, value=_value(each.value, columns)) for each in element.args)
        return replace(element, args=args)
    return element


def _value(value: ast.Expr, columns: dict[str, Column]) -> ast.Expr:
    if not isinstance(value, ast.Name) or value.id not in columns:
        return value
    name, more = columns[value.id]
    if not more:
        return ast.Name(name)
    return ast.Binary("+" if more > 0 else "-", ast.Name(name), ast.Number(abs(more)))
