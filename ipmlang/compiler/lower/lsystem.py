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
from ipmlang.compiler.lower.expr import Binding, Code, Environment, Load, Named, Operand, Row
from ipmlang.compiler.lower.names import Unit
from ipmlang.compiler.lower.operands import form_for, operands
from ipmlang.compiler.lower.runs import Pattern, again, is_again, pattern_of
from ipmlang.compiler.lower.split import Splitting, selector
from ipmlang.compiler.lower.symbols import Bound, Choosing, Put
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.places import AT, PLACED, SHAPE, row_of, way_to_place


class Namer(Protocol):
    """Numbers what bodies name."""

    def symbol(self, unit: Unit, name: str, arity: int, bound: Bound = ()) -> int | None:
        """The number of a symbol with as many arguments, some of which are `bound` to symbols;
        None where no executor runs it yet.
        """

    def takes(self, unit: Unit, name: str, arity: int) -> frozenset[int]:
        """Which of the arguments of a symbol are symbols."""

    def mark(self, name: str, close: bool) -> int | None:
        """The symbol of the opening or closing brace of an operation, None as above."""

    def table(
        self, unit: Unit, name: str, shape: str | None = None
    ) -> tuple[int, tuple[str, ...], int] | None:
        """Number, columns and row count of a table, or of its rows that place a symbol."""

    def runs(self, unit: Unit, name: str) -> tuple[Named, ...]:
        """The symbols that the rows of a table place, if the rows of each stand together."""

    def choices(self, unit: Unit, name: str) -> tuple[tuple[Named, ...], int]:
        """The symbols that the rows of a table place, and a table of which of them each does."""

    def steps_table(self, steps: tuple[float, ...]) -> int:
        """The number of a table of the lengths of moves."""

    def refuse(self, code: Code, span: ast.Span, what: str) -> None:
        """Note that something is not executable yet."""

    def operation(self, unit: Unit, name: str) -> Operation | None:
        """The record of what a name does to a scope, None where it means something else."""

    @property
    def indices(self) -> tuple[int, int] | None:
        """The attributes that hold `split.index` and `split.count`, None if nothing reads them."""


class Body:
    """Writes one production's body; repeats are numbered as they come."""

    def __init__(self, namer: Namer) -> None:
        self._namer = namer
        self._repeats = 0
        self._choosing = Choosing(self._number, namer.choices)

    def write(self, code: Code, elements: Sequence[ast.Element], names: Environment) -> None:
        """Append the elements to the code; what they `set` ends with them."""
        before = dict(code.changed)
        for number, element in enumerate(elements):
            match element:
                case ast.Module() if self._spreads(code, element, names):
                    self._spread(code, element, elements[number + 1 :], names)
                    break
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
                    splitting = Splitting(self.write, self._number, self._namer.indices)
                    splitting.split(code, element, names)
                case ast.Each():
                    self._namer.refuse(code, element.span, element.target.name)
                    self._reach(code, [part.body for part in element.parts], names)
                case ast.Assign():
                    code.changed[self._attribute(code, element)] = code.value(element.value, names)
                case ast.Local(name, value):
                    names = {**names, name: code.value(value, names)}
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
        return code.pool.attrs[place.unit.attribute(item.name)]

    def _number(self) -> int:
        """The number of a new repeat."""
        self._repeats += 1
        return self._repeats - 1

    def _module(self, code: Code, module: ast.Module, names: Environment) -> None:
        given = isinstance(names.get(module.name), Named)
        if not module.args and (given or isinstance(names.get(row_of(module.name)), Row)):
            symbol = ast.Name(module.name, module.span)
            self._choosing.put(code, symbol, names, module.span, self._put(module))
            return
        taken = self._namer.takes(code.unit, module.name, len(module.args))
        if taken:
            self._given(code, module, sorted(taken), (None,) * len(module.args), names)
            return
        record = self._namer.operation(code.unit, module.name)
        scoped = record is not None and bool(record.meaning)
        arity = len(form_for(record, module.args)) if record and scoped else len(module.args)
        number = self._namer.symbol(code.unit, module.name, arity)
        if number is None:
            self._namer.refuse(code, module.span, module.name)
            return
        if record is not None and scoped:
            args = operands(code, record, module.args, names)
        else:
            written = (each.value for each in self._ordered(module))
            args = [_value(code, module.name, each, names) for each in written]
        code.module(number, args, module.span)

    def _put(self, module: ast.Module) -> Put:
        """What writes a symbol that a parameter, or a row of a table, stands for."""

        def write(code: Code, symbol: Named) -> None:
            number = self._namer.symbol(symbol.unit, symbol.name, 0)
            if number is None:
                self._namer.refuse(code, module.span, symbol.name)
            else:
                code.module(number, (), module.span)

        return write

    def _given(
        self,
        code: Code,
        module: ast.Module,
        taken: Sequence[int],
        bound: Bound,
        names: Environment,
    ) -> None:
        """A symbol some of whose arguments are symbols: `taken` of these are still to be found."""
        if taken:
            place = taken[0]

            def write(inner: Code, symbol: Named) -> None:
                known = (*bound[:place], symbol, *bound[place + 1 :])
                self._given(inner, module, taken[1:], known, names)

            self._choosing.put(code, module.args[place].value, names, module.span, write)
            return
        number = self._namer.symbol(code.unit, module.name, len(module.args), bound)
        assert number is not None  # it has rules
        values = [
            code.value(each.value, names)
            for each, symbol in zip(module.args, bound, strict=True)
            if symbol is None
        ]
        code.module(number, values, module.span)

    # -------------------------------------------------------------- parts of a shape

    def _spreads(self, code: Code, module: ast.Module, names: Environment) -> bool:
        record = self._namer.operation(code.unit, module.name)
        hidden = not module.args and isinstance(names.get(module.name), Named)
        return record is not None and record.spreads and bool(record.meaning) and not hidden

    def _spread(
        self,
        code: Code,
        module: ast.Module,
        rest: Sequence[ast.Element],
        names: Environment,
    ) -> None:
        """An operation that makes parts, for each of which the rest of the bracket is done."""
        part = ast.Part(None, tuple(rest), span=module.span)
        self._pieces(code, module.name, module.args, (part,), module.span, names)

    def _pieces(
        self,
        code: Code,
        name: str,
        args: Sequence[ast.Argument],
        parts: Sequence[ast.Part],
        span: ast.Span,
        names: Environment,
    ) -> None:
        """An operation that takes the shape apart: the pieces of each part are copies of it."""
        record = self._namer.operation(code.unit, name)
        assert record is not None
        values = operands(code, record, args, names)
        number = self._number()
        outer = code.block()
        for part in parts:
            inner = outer.block()
            if self._namer.indices is not None:
                index, count = self._namer.indices
                inner.changed[index] = inner.load("index", number)
                inner.changed[count] = inner.load("count", number)
            self.write(inner, part.body, names)
            outer.structure("part", (), selector(part.label), inner, part.span)
        const = (record.name, number, code.site())
        code.structure("pieces", values, const, outer, span)

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
        record = self._namer.operation(code.unit, block.name)
        if record is not None and record.meaning and record.meaning[0][0].op == "join":
            self._join(code, record.name, block, names)
            return
        if record is not None and record.family == "solid" and record.meaning:
            self._pieces(code, block.name, block.args, block.parts, block.span, names)
            return
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

    def _join(self, code: Code, kind: str, block: ast.Block, names: Environment) -> None:
        """An operation that makes one solid of what its parts draw."""
        outer = code.block()
        for part in block.parts:
            inner = outer.block()
            self.write(inner, part.body, names)
            outer.structure("part", (), None, inner, part.span)
        code.structure("join", (), kind, outer, block.span)

    def _reach(
        self, code: Code, bodies: Sequence[Sequence[ast.Element]], names: Environment
    ) -> None:
        """Look into the parts of what is not executable, so that all such operations are named."""
        for body in bodies:
            with suppress(IpmError):  # there is an error already, at the operation around it
                self.write(code.block(), body, names)

    def _repeat(self, code: Code, repeat: ast.Repeat, names: Environment) -> None:
        """Copies; where rows of one symbol stand together, those of each symbol by themselves."""
        head = repeat.head
        shapes: tuple[Named | None, ...] = ()
        if isinstance(head, ast.Rows) and head.places:
            shapes = self._namer.runs(code.unit, head.table)
        pattern: Pattern | None = None
        for shape in shapes or (None,):
            if pattern is None or shape is None or not self._again(code, repeat, pattern, shape):
                self._copies(code, repeat, names, shape)
                pattern = None if shape is None else pattern_of(code, repeat)

    def _again(self, code: Code, repeat: ast.Repeat, pattern: Pattern, shape: Named) -> bool:
        """Copies of the rows that place a symbol, if they are like those that were written."""
        if not is_again(code, pattern) or not isinstance(repeat.head, ast.Rows):
            return False
        found = self._namer.table(code.unit, repeat.head.table, shape.name)
        symbol = self._namer.symbol(shape.unit, shape.name, 0)
        if found is None or symbol is None:
            return False
        table, _, count = found
        again(code, pattern, self._number(), table, count, symbol)
        return True

    def _copies(
        self, code: Code, repeat: ast.Repeat, names: Environment, shape: Named | None
    ) -> None:
        """Copies, of a table's rows those that place a symbol."""
        number = self._number()
        copy = Load("index", number)
        own: dict[str, Binding] = dict(names)
        if isinstance(repeat.head, ast.Count):
            limit = code.value(repeat.head.limit, names)
            own[repeat.head.variable] = copy
        else:
            limit = self._rows(code, repeat.head, copy, own, shape)
        if repeat.rows is not None:
            self._rows(code, repeat.rows, copy, own)
        args = [limit, *(code.value(each, names) for each in repeat.holes)]
        inner = code.block()
        self.write(inner, self._standing(code, repeat, own), own)
        if repeat.steps:
            self._step(inner, repeat, copy)
        code.repeat(number, args, inner, repeat.span)

    def _rows(
        self,
        code: Code,
        rows: ast.Rows,
        copy: Load,
        names: dict[str, Binding],
        shape: Named | None = None,
    ) -> Operand:
        """Bind a row's variable, and the symbol of the row where it is known; how many rows."""
        found = self._namer.table(code.unit, rows.table, None if shape is None else shape.name)
        if found is None:
            raise code.error(rows.span, "unknown-table", f"there is no table `{rows.table}`")
        table, columns, count = found
        names[rows.variable] = Row(table, columns, copy, rows.table)
        names.pop(f"{rows.variable}.{SHAPE}", None)
        if shape is not None:
            names[PLACED] = shape
        return code.number(count)

    def _standing(
        self, code: Code, repeat: ast.Repeat, names: Environment
    ) -> tuple[ast.Element, ...]:
        """The body of a repeat; under `at T` in brackets, behind the way to the row's place."""
        row = names.get(AT)
        if not isinstance(repeat.head, ast.Rows) or not repeat.head.places:
            return repeat.body
        assert isinstance(row, Row)
        steps = way_to_place(row.columns, repeat.head.span)
        for step in steps:
            if step.name in code.unit.rules or step.name in code.unit.interpretations:
                message = f"`repeat(at …)` needs `{step.name}`, which is a rule's name here"
                raise code.error(repeat.head.span, "name-taken", message)
        return (ast.Bracket((*steps, *repeat.body), repeat.span),)

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


def _value(code: Code, name: str, given: ast.Expr, names: Environment) -> Operand:
    """An argument; a file that an imported grammar names lies beside that grammar."""
    record = OPERATIONS.get(name)
    forms = () if record is None or not code.unit.prefix else record.forms
    is_file = any(param.suffixes for form in forms for param in form)
    if is_file and isinstance(given, ast.Text) and given.value:
        return code.pool.text(str(code.unit.folder.absolute() / given.value))
    return code.value(given, names)
