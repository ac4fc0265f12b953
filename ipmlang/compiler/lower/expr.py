"""Expressions to straight-line value instructions.

In goes an expression and what its names stand for, out comes an operand: a known number, or a
register of the code that was appended. Constants fold, functions are inlined, random call sites are
numbered in the order of the code. Makes no modules and knows no operation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias, assert_never

from ipmlang.compiler import ast, ir
from ipmlang.compiler.diagnostics import IpmError
from ipmlang.compiler.lower.names import Place, Unit
from ipmlang.compiler.ops import CONSTANTS, FUNCTIONS, OPERATORS, PREFIXES, QUERIES
from ipmlang.compiler.quick import quick

QUERY_SITE = 0x38000000  # queries are numbered apart: a new one leaves all draws as they were


@quick
@dataclass(frozen=True, slots=True)
class Known:
    """A number that is known when lowering; a text is its number among Program.strings."""

    value: float


@quick
@dataclass(frozen=True, slots=True)
class Register:
    """A number that code computes."""

    number: int


@quick
@dataclass(frozen=True, slots=True)
class Load:
    """What code loads where it is first read: a parameter or a copy's number."""

    op: Literal["param", "index"]
    number: int


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table: the table's number, its columns, and which row; what the table is called
    where the row is read.
    """

    table: int
    columns: tuple[str, ...]
    index: Load
    name: str = ""


@dataclass(frozen=True, slots=True)
class Named:
    """A symbol that a rule was given: a name, and the unit in which it is one."""

    unit: Unit
    name: str


Operand: TypeAlias = Known | Register
Binding: TypeAlias = Operand | Load | Row | Named
Environment: TypeAlias = Mapping[str, Binding]
_Key: TypeAlias = tuple[ir.Opcode, object]


@dataclass(slots=True, eq=False)
class Pool:
    """What the whole program shares: interned texts, the numbers of attributes and of assets, and
    the contexts with the last channel of each that is asked for.
    """

    strings: dict[str, int] = field(default_factory=dict)
    attrs: dict[str, int] = field(default_factory=dict)
    assets: dict[ir.AssetFile, int] = field(default_factory=dict)
    contexts: dict[tuple[int, int], tuple[Place, int]] = field(default_factory=dict)
    paths: dict[tuple[str, str], Path] = field(default_factory=dict)  # of files, by who names them

    def text(self, value: str) -> Known:
        """A text as its number."""
        return Known(float(self.strings.setdefault(value, len(self.strings))))

    def asset(self, unit: Unit, name: str, item: ast.Asset) -> int:
        """The number of an asset."""
        file, _, node = item.reference.partition("#")
        if item.by_name:
            node = name.rpartition(".")[2]
        key = (unit.source.path, file)
        path = self.paths.get(key)
        if path is None:
            path = self.paths[key] = (unit.folder / file).absolute()
        made = ir.AssetFile(name, path, node or None, tuple([each.value for each in item.stretch]))
        return self.assets.setdefault(made, len(self.assets))

    def context(self, place: Place, channel: int) -> int:
        """The number of a context."""
        key = (id(place.unit), place.item)
        self.contexts[key] = (place, max(channel, self.contexts.get(key, (place, 0))[1]))
        return list(self.contexts).index(key)


@dataclass(slots=True, eq=False)
class Counter:
    """The next register and the next site of one production, and how many queries it has.
    `changes`: for the site of a module behind a `set`, the registers of the attributes' new values.
    """

    register: int = 0
    site: int = 0
    queries: int = 0
    changes: dict[int, dict[int, int]] = field(default_factory=dict)


class Code:
    """Code under construction, in one block of a production: its body, or that of a repeat.

    `unit` and `item` are where names are looked up and errors are reported. A block within another
    reads its registers; constants, parameters and attributes are loaded once a block. `changed`:
    the attributes that a `set` has changed for what is written next; `shaped`: there is a shape
    that queries are about.
    """

    def __init__(
        self,
        pool: Pool,
        unit: Unit,
        item: int,
        counter: Counter | None = None,
        outer: Code | None = None,
    ) -> None:
        self.pool = pool
        self.unit = unit
        self.item = item
        self.shaped: bool = outer.shaped if outer is not None else _is_body(unit, item)
        self.counter = counter or Counter()
        self.instructions: list[ir.Instruction] = []
        self.changed: dict[int, Operand] = {} if outer is None else dict(outer.changed)
        self._outer = outer
        self._loaded: dict[_Key, int] = {}
        self._inlining: list[str] = []

    def block(self) -> Code:
        """The code of a repeat within this one."""
        return Code(self.pool, self.unit, self.item, self.counter, self)

    def site(self) -> int:
        """The next number for a random draw or a child."""
        self.counter.site += 1
        return self.counter.site - 1

    def error(self, span: ast.Span, code: str, message: str, hint: str | None = None) -> IpmError:
        """An error at a place of the item that is lowered."""
        return self.unit.error(self.item, span, code, message, hint)

    def module(
        self, symbol: int, args: Sequence[Operand] = (), span: ast.Span = ast.NOWHERE
    ) -> None:
        """A child, or a command to the turtle."""
        registers = tuple(self.register(arg) for arg in args)
        place = (span.start, span.end)
        made = ir.Instruction("module", -1, registers, symbol, self.site(), span=place)
        if self.changed:
            behind = {attr: self.register(value) for attr, value in self.changed.items()}
            self.counter.changes[made.site] = behind
        self.instructions.append(made)

    def act(self, op: ir.Opcode, args: Sequence[Operand] = (), const: ir.Const = None) -> None:
        """An instruction without a result: a bracket, or one of a meaning."""
        registers = tuple(self.register(arg) for arg in args)
        self.instructions.append(ir.Instruction(op, -1, registers, const))

    def repeat(self, number: int, args: Sequence[Operand], body: Code, span: ast.Span) -> None:
        """Copies of a block: how many, and which of them draw nothing."""
        registers = tuple(self.register(arg) for arg in args)
        place = (span.start, span.end)
        instructions = tuple(body.instructions)
        made = ir.Instruction("repeat", -1, registers, number, -1, instructions, place)
        self.instructions.append(made)

    def structure(
        self, op: ir.Opcode, args: Sequence[Operand], const: ir.Const, body: Code, span: ast.Span
    ) -> None:
        """A block that is done for a part of the shape, or for each of its parts."""
        registers = tuple(self.register(arg) for arg in args)
        place = (span.start, span.end)
        self.instructions.append(
            ir.Instruction(op, -1, registers, const, -1, tuple(body.instructions), place)
        )

    def state(self, field: str) -> Operand:
        """An extent or the place of the scope, as it is here."""
        return self._append("state", const=field)

    def measure(self, what: str) -> Operand:
        """A measure of the shape's geometry, as it is here."""
        return self._append("measure", const=what)

    def own(self) -> Operand:
        """A number that tells the shapes of a batch apart."""
        return self._append("self")

    def query(self, name: str, args: Sequence[Operand]) -> Operand:
        """What other shapes say, as it is asked here."""
        self.counter.queries += 1
        registers = tuple(self.register(arg) for arg in args)
        return self._append("query", registers, name, QUERY_SITE + self.counter.queries)

    def fetch(self, context: int, channel: int, x: Operand, y: Operand) -> Operand:
        """What a context is somewhere on the ground."""
        return self._append("fetch", (self.register(x), self.register(y)), (context, channel))

    def number(self, value: float) -> Operand:
        """A known number."""
        return Known(float(value))

    def known(self, expr: ast.Expr, names: Environment) -> float | None:
        """The number of an expression that needs no code."""
        operand = self.block().value(expr, names)
        return operand.value if isinstance(operand, Known) else None

    def register(self, operand: Operand) -> int:
        """The register that holds an operand."""
        if isinstance(operand, Register):
            return operand.number
        return self.load("const", operand.value).number

    def load(self, op: ir.Opcode, const: float | int) -> Register:
        """A constant, parameter, attribute or copy number, read once."""
        found = self._find((op, const))
        if found is None:
            found = self._append(op, const=const).number
            self._loaded[op, const] = found
        return Register(found)

    def knows(self, value: ir.Const) -> bool:
        """Whether a constant has been loaded here or around."""
        return self._find(("const", value)) is not None

    def call(self, name: str, args: Sequence[Operand]) -> Operand:
        """A pure function of operands, folded where all of them are known."""
        function = FUNCTIONS[name]
        if function.random:
            drawn: Operand = self._append("uniform", site=self.site())
            args = (drawn, *args)
        known = [arg.value for arg in args if isinstance(arg, Known)]
        if len(known) == len(args):
            return Known(function.single(*known))
        return self._append("call", tuple(self.register(arg) for arg in args), name)

    def row(self, row: Row, column: str) -> Operand:
        """A cell of a table."""
        where = (row.table, row.columns.index(column))
        index = self.load(row.index.op, row.index.number)
        return self._append("row", (index.number,), where)

    def value(self, expr: ast.Expr, names: Environment) -> Operand:
        """The operand of an expression; `names` are its parameters and copy numbers."""
        match expr:
            case ast.Number():
                return Known(float(expr.value))
            case ast.Truth():
                return Known(float(expr.value))
            case ast.Text():
                return self.pool.text(expr.value)
            case ast.Name():
                return self._name(expr, names)
            case ast.Call():
                return self._call(expr, names)
            case ast.Unary():
                return self.call(PREFIXES[expr.op], (self.value(expr.value, names),))
            case ast.Binary():
                both = (self.value(expr.left, names), self.value(expr.right, names))
                return self.call(OPERATORS[expr.op], both)
            case ast.If():
                return self._choice(expr, names)
            case ast.Tuple():
                raise self.error(expr.span, "not-executable", "a vector is no number here")
            case _:
                assert_never(expr)

    def _append(
        self,
        op: ir.Opcode,
        args: tuple[int, ...] = (),
        const: ir.Const = None,
        site: int = -1,
    ) -> Register:
        out = self.counter.register
        self.counter.register += 1
        self.instructions.append(ir.Instruction(op, out, args, const, site))
        return Register(out)

    def _find(self, key: _Key) -> int | None:
        if key in self._loaded:
            return self._loaded[key]
        return None if self._outer is None else self._outer._find(key)

    def _choice(self, expr: ast.If, names: Environment) -> Operand:
        condition = self.value(expr.condition, names)
        if isinstance(condition, Known) and math.isnan(condition.value):
            return condition
        if isinstance(condition, Known):
            return self.value(expr.value if condition.value else expr.other, names)
        value = self.value(expr.value, names)
        return self.call("select", (condition, value, self.value(expr.other, names)))

    def _name(self, expr: ast.Name, names: Environment) -> Operand:
        bound = names.get(expr.id)
        if isinstance(bound, Known | Register):
            return bound
        if isinstance(bound, Load):
            return self.load(bound.op, bound.number)
        if isinstance(bound, Named):
            raise self.error(expr.span, "wrong-type", f"`{expr.id}` is a symbol, and has no value")
        first, _, column = expr.id.rpartition(".")
        row = names.get(first)
        if isinstance(row, Row) and column in row.columns:
            return self.row(row, column)
        place = self.unit.find(expr.id)
        if place is not None:
            match place.unit.grammar.items[place.item]:
                case ast.Const() as item:
                    return self._inlined(expr, place.unit, place.item, item.value, {})
                case ast.Attr() as item:
                    number = self.pool.attrs.get(place.unit.attribute(item.name))
                    if number is not None:
                        return self.changed.get(number) or self.load("attr", number)
                case ast.Asset() as item:
                    name = expr.id.rpartition(".")[2]
                    return Known(float(self.pool.asset(place.unit, name, item)))
                case ast.Field():
                    message = f"`{expr.id}` alone has no value that this version can compute"
                    hint = f"where the shape stands it is fetch({expr.id})"
                    raise self.error(expr.span, "not-executable", message, hint)
                case _:
                    pass
        if expr.id in QUERIES and QUERIES[expr.id].ready:
            self._check_shape(expr.span, expr.id)
            return self._asked(expr.id)
        if expr.id in CONSTANTS:
            return Known(CONSTANTS[expr.id][0])
        raise self.error(
            expr.span, "not-executable", f"`{expr.id}` has no value that this version can compute"
        )

    def _asked(self, name: str) -> Operand:
        """What a name asks about the shape."""
        if name in self.pool.attrs:  # which piece of its split: carried down like what is set
            number = self.pool.attrs[name]
            return self.changed.get(number) or self.load("attr", number)
        of, _, what = name.partition(".")
        return self.measure(what) if of == "geometry" else self.state(what)

    def _call(self, expr: ast.Call, names: Environment) -> Operand:
        query = QUERIES.get(expr.name) if self.unit.find(expr.name) is None else None
        if query is not None and query.params and query.params[0].type == "context":
            return _fetched(self, expr, names)
        args = [self.value(each.value, names) for each in self._ordered(expr)]
        place = self.unit.find(expr.name)
        if place is not None:
            item = place.unit.grammar.items[place.item]
            if isinstance(item, ast.Function):
                own = dict(zip((each.name for each in item.parameters), args, strict=True))
                return self._inlined(expr, place.unit, place.item, item.value, own)
        if expr.name in QUERIES and QUERIES[expr.name].ready:
            self._check_shape(expr.span, expr.name)
            return self.query(expr.name, args)
        if expr.name not in FUNCTIONS:
            message = f"the function `{expr.name}` is not executable yet"
            raise self.error(expr.span, "not-executable", message)
        return self.call(expr.name, args)

    def _check_shape(self, span: ast.Span, name: str) -> None:
        if not self.shaped:
            raise self.error(
                span,
                "no-shape",
                f"`{name}` asks about a shape, and where this is computed there is none yet",
                hint="ask in a rule",
            )

    def _ordered(self, expr: ast.Call) -> list[ast.Argument]:
        """Arguments in the order of the function's parameters."""
        record = FUNCTIONS.get(expr.name)
        if record is None or all(each.name is None for each in expr.args):
            return list(expr.args)
        order = [each.name for each in record.params]
        plain = [each for each in expr.args if each.name is None]
        named = [each for each in expr.args if each.name is not None]
        return [*plain, *sorted(named, key=lambda each: order.index(str(each.name)))]

    def _inlined(
        self,
        expr: ast.Name | ast.Call,
        unit: Unit,
        item: int,
        value: ast.Expr,
        names: Environment,
    ) -> Operand:
        """The value of a constant or function, in the unit that defines it."""
        name = expr.id if isinstance(expr, ast.Name) else expr.name
        key = f"{unit.source.path}:{item}"
        if key in self._inlining:
            raise self.error(expr.span, "endless-definition", f"`{name}` is defined by itself")
        self._inlining.append(key)
        here = (self.unit, self.item)
        self.unit, self.item = unit, item
        try:
            return self.value(value, names)
        finally:
            self.unit, self.item = here
            self._inlining.pop()


def _is_body(unit: Unit, item: int) -> bool:
    """Whether code of an item belongs to a rule or a start."""
    return item >= 0 and isinstance(unit.grammar.items[item], ast.Rule | ast.Start)


def _fetched(code: Code, call: ast.Call, names: Environment) -> Operand:
    """A context's number at x and y, or where the shape's scope has its origin."""
    if not code.shaped:
        raise code.error(
            call.span,
            "no-shape",
            f"`{call.name}` asks while shapes are made, and this is computed before there are any",
            hint="ask in a rule",
        )
    context, *rest = (each.value for each in call.args)
    assert isinstance(context, ast.Name)  # the checker has seen to it
    place = code.unit.find(context.id)
    assert place is not None
    channel = _channel(code, rest[2], names) if len(rest) > 2 else 0
    number = code.pool.context(place, channel)
    if not rest:
        return code.fetch(number, channel, code.state("x"), code.state("y"))
    x, y = (code.value(each, names) for each in rest[:2])
    return code.fetch(number, channel, x, y)


def _channel(code: Code, expr: ast.Expr, names: Environment) -> int:
    known = code.known(expr, names)
    if known is None:
        raise code.error(
            expr.span, "not-constant", "a channel must be known before a derivation starts"
        )
    if not 0 <= known < 4 or known % 1:
        raise code.error(
            expr.span, "out-of-range", f"a channel is 0, 1, 2 or 3, and this is {known:g}"
        )
    return int(known)
