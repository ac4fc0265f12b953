"""Successors to code: modules, brackets, repeats and polygons become children of a production.

In go the elements of a body, out come instructions appended to its code. An operation that no
executor runs yet is noted with its place and left out; whoever asked raises what was noted.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.lower.expr import Binding, Code, Environment, Load, Operand, Row
from ipmlang.compiler.lower.names import Unit
from ipmlang.compiler.ops import OPERATIONS


class Namer(Protocol):
    """Numbers what bodies name."""

    def symbol(self, unit: Unit, name: str, arity: int) -> int | None:
        """The number of a symbol, None where no executor runs it yet."""

    def mark(self, name: str, close: bool) -> int | None:
        """The symbol of the opening or closing brace of an operation, None as above."""

    def table(self, unit: Unit, name: str) -> tuple[int, tuple[str, ...], int] | None:
        """Number, columns and row count of a table."""

    def steps_table(self, steps: tuple[float, ...]) -> int:
        """The number of a table of the lengths of moves."""

    def refuse(self, code: Code, span: ast.Span, what: str) -> None:
        """Note that something is not executable yet."""


class Body:
    """Writes one production's body; repeats are numbered as they come."""

    def __init__(self, namer: Namer) -> None:
        self._namer = namer
        self._repeats = 0

    def write(self, code: Code, elements: Sequence[ast.Element], names: Environment) -> None:
        """Append the elements to the code; what they `set` ends with them."""
        before = dict(code.changed)
        for element in elements:
            match element:
                case ast.Module():
                    self._module(code, element, names)
                case ast.Bracket():
                    code.act("open")
                    self.write(code, element.body, names)
                    code.act("close")
                case ast.Repeat():
                    self._repeat(code, element, names)
                case ast.Block():
                    self._block(code, element, names)
                case ast.Split():
                    self._namer.refuse(code, element.span, "split")
                    self._reach(code, _split_bodies(element.parts), names)
                case ast.Each():
                    self._namer.refuse(code, element.span, element.target.name)
                    self._reach(code, [part.body for part in element.parts], names)
                case ast.Assign():
                    code.changed[self._attribute(code, element)] = code.value(element.value, names)
                case _:
                    assert_never(element)
        code.changed = before

    def _attribute(self, code: Code, element: ast.Assign) -> int:
        """The number of the attribute that a `set` changes."""
        place = code.unit.find(element.name)
        item = None if place is None else place.unit.grammar.items[place.item]
        if place is None or not isinstance(item, ast.Attr):
            message = f"no attribute is called `{element.name}`"
            raise code.error(element.span, "not-an-attribute", message)
        return code.pool.attrs[place.unit.prefix + item.name]

    def _module(self, code: Code, module: ast.Module, names: Environment) -> None:
        symbol = self._namer.symbol(code.unit, module.name, len(module.args))
        if symbol is None:
            self._namer.refuse(code, module.span, module.name)
            return
        args = [code.value(each.value, names) for each in self._ordered(module)]
        code.module(symbol, args, module.span)

    def _ordered(self, module: ast.Module) -> list[ast.Argument]:
        """Arguments in the order of the operation's parameters."""
        record = OPERATIONS.get(module.name)
        if record is None or all(each.name is None for each in module.args):
            return list(module.args)
        for form in record.forms:
            order = [each.name for each in form]
            if len(form) >= len(module.args) and all(
                each.name is None or each.name in order for each in module.args
            ):
                plain = [each for each in module.args if each.name is None]
                named = [each for each in module.args if each.name is not None]
                return [*plain, *sorted(named, key=lambda each: order.index(str(each.name)))]
        return list(module.args)

    def _block(self, code: Code, block: ast.Block, names: Environment) -> None:
        opens = self._namer.mark(block.name, close=False)
        closes = self._namer.mark(block.name, close=True)
        if opens is None or closes is None:
            self._namer.refuse(code, block.span, block.name)
            self._reach(code, [part.body for part in block.parts], names)
            return
        code.module(opens, (), block.span)
        for part in block.parts:
            self.write(code, part.body, names)
        code.module(closes, (), block.span)

    def _reach(
        self, code: Code, bodies: Sequence[Sequence[ast.Element]], names: Environment
    ) -> None:
        """Look into the parts of what is not executable, so that all such operations are named."""
        for body in bodies:
            with suppress(IpmError):  # there is an error already, at the operation around it
                self.write(code.block(), body, names)

    def _repeat(self, code: Code, repeat: ast.Repeat, names: Environment) -> None:
        number = self._repeats
        self._repeats += 1
        copy = Load("index", number)
        own: dict[str, Binding] = dict(names)
        if isinstance(repeat.head, ast.Count):
            limit = code.value(repeat.head.limit, names)
            own[repeat.head.variable] = copy
        else:
            limit = self._rows(code, repeat.head, copy, own)
        if repeat.rows is not None:
            self._rows(code, repeat.rows, copy, own)
        args = [limit, *(code.value(each, names) for each in repeat.holes)]
        inner = code.block()
        self.write(inner, repeat.body, own)
        if repeat.steps:
            self._step(inner, repeat, copy)
        code.repeat(number, args, inner, repeat.span)

    def _rows(self, code: Code, rows: ast.Rows, copy: Load, names: dict[str, Binding]) -> Operand:
        """Bind a row's variable; the number of rows."""
        found = self._namer.table(code.unit, rows.table)
        if found is None:
            raise code.error(rows.span, "unknown-table", f"there is no table `{rows.table}`")
        table, columns, count = found
        names[rows.variable] = Row(table, columns, copy)
        return code.number(count)

    def _step(self, code: Code, repeat: ast.Repeat, copy: Load) -> None:
        """The move from this copy to the next; after the last one, none."""
        lengths = []
        for each in repeat.steps:
            length = code.known(each, {})
            if length is None:
                message = "the lengths of `steps` must be known numbers"
                raise code.error(repeat.span, "not-constant", message)
            lengths.append(length)
        table = self._namer.steps_table((*lengths, 0.0))
        move = self._namer.symbol(code.unit, "f", 1)
        assert move is not None
        code.module(move, (code.row(Row(table, ("step",), copy), "step"),), repeat.span)


def _split_bodies(parts: Sequence[ast.SplitPart | ast.SplitGroup]) -> list[Sequence[ast.Element]]:
    """The bodies of all parts of a split, those of its groups too."""
    bodies: list[Sequence[ast.Element]] = []
    for part in parts:
        bodies += [part.body] if isinstance(part, ast.SplitPart) else _split_bodies(part.parts)
    return bodies
