"""Values of instructions for a batch of shapes: numbers that are the same for all stay numbers.

In go straight-line value instructions and a batch (parameters, keys, copy numbers), out come
registers: a float, or an array with one number a shape. Loops run over instructions, never over
shapes. Makes no children and knows no turtle.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.compiler.ops.record import Function
from ipmlang.runtime import keys
from ipmlang.runtime.code import Data, as_number, cell_of
from ipmlang.runtime.fields import SCOPE
from ipmlang.runtime.keys import Words
from ipmlang.runtime.sampling import fetch, load_contexts
from ipmlang.runtime.scan import Real, Whole

Value: TypeAlias = "float | Real"
Flags: TypeAlias = NDArray[np.bool_]


class Bound:
    """A program with values for its attributes, and what its code reads: tables as columns, and
    contexts, which are loaded unless `data` has them already.
    """

    def __init__(
        self,
        program: ir.Program,
        attrs: Sequence[float],
        functions: Mapping[str, Function],
        data: Data | None = None,
    ) -> None:
        self.program = program
        self.attrs = tuple(float(value) for value in attrs)
        self.functions = functions
        self.data = data or Data(
            [
                list(
                    np.array(table.rows, np.float64).reshape(len(table.rows), len(table.columns)).T
                )
                for table in program.tables
            ],
            load_contexts(program),
        )


class Measures(Protocol):
    """Who measures geometry. `first_pass`: answers about other shapes are yet to come."""

    first_pass: bool

    def measure(self, what: str, sx: Value, sy: Value, sz: Value, geometry: Value) -> Value:
        """The area, the volume or the number of sides of geometries."""

    def ask(
        self,
        name: str,
        count: int,
        args: Sequence[Value],
        state: Mapping[str, Value],
        shown: Whole | None,
    ) -> Value:
        """The answers to a query about other shapes."""


@dataclass(frozen=True, slots=True, eq=False)
class Scope:
    """The states of a batch's shapes, by field, for guards that ask about scopes."""

    state: Mapping[str, Value]
    measures: Measures

    def measured(self, what: str) -> Value:
        """A measure of the shapes' geometries."""
        return self.measures.measure(what, *(self.state[name] for name in SCOPE))

    def take(self, rows: Whole) -> Scope:
        """The states of some rows."""
        state = {name: spread(value, rows) for name, value in self.state.items()}
        return Scope(state, self.measures)


@dataclass(slots=True, eq=False)
class Batch:
    """`count` shapes of one production: parameters, key words, and whether each draws nothing.

    In a repeat a row is one copy: `owner` is its row in `outer`, `copies` are its numbers in the
    repeats around it (repeat's number, numbers of the copies), outermost first. `scope`: what
    guards may ask about the shapes, None for turtles.
    """

    bound: Bound
    count: int
    params: tuple[Value, ...]
    k0: Words
    k1: Words
    silent: Flags | None = None
    outer: Batch | None = None
    owner: Whole | None = None
    copies: tuple[tuple[int, Words], ...] = ()
    registers: dict[int, Value] = field(default_factory=dict)
    scope: Scope | None = None

    def get(self, register: int) -> Value:
        """A register's value, brought in from the batch around a repeat when first read there."""
        value = self.registers.get(register)
        if value is None:
            assert self.outer is not None and self.owner is not None, f"register {register} unset"
            value = spread(self.outer.get(register), self.owner)
            self.registers[register] = value
        return value

    def column(self, register: int) -> Real:
        """A register's value as one number a shape."""
        return np.broadcast_to(np.asarray(self.get(register), np.float64), (self.count,))

    def numbers(self) -> tuple[Words, ...]:
        """The copies' numbers alone, as keys take them."""
        return tuple(index for _, index in self.copies)

    def evaluate(self, instructions: Iterable[ir.Instruction]) -> None:
        """Run value instructions."""
        for each in instructions:
            self.registers[each.out] = self._value(each)

    def _value(self, each: ir.Instruction) -> Value:
        match each.op:
            case "const":
                assert isinstance(each.const, int | float)
                return float(each.const)
            case "param":
                assert isinstance(each.const, int)
                return self.parameter(each.const)
            case "attr":
                assert isinstance(each.const, int)
                return self.bound.attrs[each.const]
            case "index":
                return as_number(dict(self.copies)[int(str(each.const))])
            case "row":
                return self._cell(each)
            case "fetch":
                return self._sample(each)
            case "call":
                function = self.bound.functions[str(each.const)]
                return function.batch(*(self.get(register) for register in each.args))
            case "uniform":
                return keys.uniform(self.k0, self.k1, each.site, *self.numbers())
            case "state":
                assert self.scope is not None
                return self.scope.state.get(str(each.const), -1.0)
            case "query":
                assert self.scope is not None
                args = [self.get(register) for register in each.args]
                asked = (str(each.const), self.count, args, self.scope.state, None)
                return self.scope.measures.ask(*asked)
            case "measure":
                assert self.scope is not None
                return self.scope.measured(str(each.const))
            case _:
                raise AssertionError(f"{each.op} is no value instruction")

    def parameter(self, number: int) -> Value:
        """A parameter's value; a copy in a repeat has those of its shape."""
        if self.outer is None or self.owner is None:
            return self.params[number]
        return spread(self.outer.parameter(number), self.owner)

    def _cell(self, each: ir.Instruction) -> Value:
        assert isinstance(each.const, tuple)
        number, column = each.const
        cells = self.bound.data.tables[int(str(number))][int(str(column))]
        return cell_of(cells, self.get(each.args[0]))

    def _sample(self, each: ir.Instruction) -> Value:
        assert isinstance(each.const, tuple)
        number, channel = (int(str(part)) for part in each.const)
        x, y = (self.get(register) for register in each.args)
        return fetch(self.bound.data.contexts[number], channel, x, y)

    def take(self, rows: Whole) -> Batch:
        """The shapes of some rows, with no registers yet."""
        return Batch(
            self.bound,
            len(rows),
            tuple(spread(value, rows) for value in self.params),
            self.k0[rows],
            self.k1[rows],
            None if self.silent is None else self.silent[rows],
            scope=None if self.scope is None else self.scope.take(rows),
        )

    def repeated(self, number: int, counts: Whole, holes: Sequence[int]) -> Batch:
        """One row a copy: row r of this batch gives counts[r] of them. The copies whose number is
        in one of the registers `holes` draw nothing.
        """
        owner = np.repeat(np.arange(self.count), counts)
        begins = np.cumsum(counts) - counts
        index = (np.arange(len(owner)) - begins[owner]).astype(np.uint32)
        silent = None if self.silent is None else self.silent[owner]
        for register in holes:
            hole = np.equal(spread(self.get(register), owner), index)
            silent = hole if silent is None else silent | hole
        copies = tuple((each, numbers[owner]) for each, numbers in self.copies)
        return Batch(
            self.bound,
            len(owner),
            (),
            self.k0[owner],
            self.k1[owner],
            silent,
            self,
            owner,
            (*copies, (number, index)),
        )


def spread(value: Value, rows: Whole) -> Value:
    """A value's numbers for chosen rows; one number for all stays one number."""
    return value[rows] if isinstance(value, np.ndarray) and value.ndim else value


def joined(values: Sequence[Value], counts: Sequence[int]) -> Value:
    """Values of several batches as one, kept a single number where all are the same number."""
    first = values[0]
    if len(values) == 1:
        return first
    if not any(isinstance(value, np.ndarray) for value in values):
        same = all(value == first for value in values)
        return first if same else np.repeat(np.array(values, np.float64), counts)
    parts = [np.broadcast_to(value, (count,)) for value, count in zip(values, counts, strict=True)]
    return np.concatenate(parts)
