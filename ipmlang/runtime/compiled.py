"""The functions of a bound program: bodies, meanings, choices and chains, written when first used.

In go the setting of a run, out come functions by production or symbol. Nothing here derives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias, cast

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime import keys
from ipmlang.runtime.algebra import Source
from ipmlang.runtime.bodies import (
    OWN,
    Scope,
    Setting,
    State,
    Writer,
)
from ipmlang.runtime.choose import OVER, told
from ipmlang.runtime.code import Names, compile_values, expression, needed, source
from ipmlang.runtime.primitives import UnscannableError, function, names_for

Body: TypeAlias = Callable[..., tuple[object, ...]]
Choose: TypeAlias = Callable[[tuple[float, ...], int, int], int]


@dataclass(frozen=True, slots=True)
class Chain:
    """A production whose tail makes its own symbol again.

    `loop` walks from (params, k0, k1) while the production is taken, `limit` steps at most: columns
    of the parameters, both words of the keys, and what the last one becomes. `body` draws all rows
    at once and returns their slots and the state after the last.
    """

    production: int
    loop: Callable[..., tuple[list[list[float]], list[int], list[int], tuple[float, ...], int, int]]
    body: Callable[..., tuple[tuple[object, ...], tuple[object, ...]]]


class Compiled:
    """All functions of one program with one set of attribute values."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._program = setting.program
        self._spaces = {single: names_for(single) for single in (False, True)}
        self._bodies: dict[tuple[int, bool], Body] = {}
        self._meanings: dict[tuple[int, bool], Body] = {}
        self._chains: dict[int, Chain | None] = {}
        self._choices: dict[tuple[int, ...], Choose] = {}
        self._singles: dict[int, bool] = {}

    def production(self, number: int) -> ir.Production:
        """A production; -1 is the axiom."""
        return self._program.axiom if number < 0 else self._program.productions[number]

    def is_single(self, number: int) -> bool:
        """Whether a body can run for one shape in plain numbers: it has no repeats."""
        if number not in self._singles:
            body = self.production(number).body
            self._singles[number] = all(each.op != "repeat" for each in body)
        return self._singles[number]

    def body(self, number: int, single: bool = False) -> Body:
        """body(run, rule, count, k0, k1, *params, *state) -> slots of a batch, or without `count`
        the items of one shape.
        """
        found = self._bodies.get((number, single))
        if found is None:
            production = self.production(number)
            writer = Writer(self._setting, single)
            writer.body(production.body, _scope(production.parameters), self._state())
            found = self._function(writer, production.parameters, single)
            self._bodies[number, single] = found
        return found

    def meaning(self, number: int, single: bool = False) -> Body:
        """The same for what is left of a symbol."""
        found = self._meanings.get((number, single))
        if found is None:
            symbol = self._program.symbols[number]
            writer = Writer(self._setting, single)
            scope = _scope(symbol.arity)
            meaning = symbol.meaning or ()
            writer.act(meaning, scope, scope.params, number, OWN, self._state())
            found = self._function(writer, symbol.arity, single)
            self._meanings[number, single] = found
        return found

    def choose(self, numbers: tuple[int, ...]) -> Choose:
        """choose(params, k0, k1) -> the production that one shape takes, -1 for none."""
        if numbers not in self._choices:
            self._choices[numbers] = self._choice(numbers)
        return self._choices[numbers]

    def chain(self, symbol: int) -> Chain | None:
        """The chain that a symbol's first production is, if it is one."""
        if symbol not in self._chains:
            self._chains[symbol] = self._chain(symbol)
        return self._chains[symbol]

    def _state(self) -> State:
        return {name: f"s_{name}" for name in self._setting.fields}

    def _arguments(self, parameters: int) -> list[str]:
        return [
            *(f"p{number}" for number in range(parameters)),
            *(f"s_{name}" for name in self._setting.fields),
        ]

    def _function(self, writer: Writer, parameters: int, single: bool) -> Body:
        head = ["run", "rule", *([] if single else ["n"]), "k0", "k1"]
        result = "(" + "".join(f"{slot}, " for slot in writer.slots) + ")"
        arguments = [*head, *self._arguments(parameters)]
        made = function(writer.source.lines, arguments, result, self._space(single))
        return cast("Body", made)

    def _space(self, single: bool) -> dict[str, object]:
        return {**self._spaces[single], "tables": self._tables()}

    def _tables(self) -> object:
        import numpy as np

        return [
            np.array(table.rows, np.float64).reshape(len(table.rows), len(table.columns)).T
            for table in self._program.tables
        ]

    # ------------------------------------------------------------------------- choices

    def _choice(self, numbers: tuple[int, ...]) -> Choose:
        productions = [(number, self.production(number)) for number in numbers]
        first = productions[0][1]
        if first.chance is None and first.guard is None:
            return lambda params, k0, k1: numbers[0]
        guards = [self._single(each.guard) for _, each in productions]
        chances = [
            None if each.chance is None else self._single((each.chance[1], each.chance[2]))
            for _, each in productions
        ]
        kinds = [None if each.chance is None else each.chance[0] for _, each in productions]

        def choose(params: tuple[float, ...], k0: int, k1: int) -> int:
            taken, total, drawn = -1, 0.0, -1.0
            shares: dict[int, float] | None = None
            for place, (number, _) in enumerate(productions):
                guard = guards[place]
                if guard is not None and not guard(params, k0, k1):
                    continue
                chance = chances[place]
                if chance is None:
                    taken = number if taken < 0 else taken
                    break
                if kinds[place] == "percent":
                    share = self._amount(number, chance(params, k0, k1)) / 100
                else:
                    shares = shares or self._shares(productions, guards, chances, params, k0, k1)
                    share = shares[number]
                if drawn < 0:
                    drawn = keys.choice_single(k0, k1)
                total += share
                if taken < 0 and drawn < total:
                    taken = number
            if total > OVER:
                name = told(self._program, first)
                raise fail("percent-over", f"the percentages of {name} add up to {total * 100:g}")
            return taken

        return choose

    def _shares(
        self,
        productions: list[tuple[int, ir.Production]],
        guards: list[Callable[..., float] | None],
        chances: list[Callable[..., float] | None],
        params: tuple[float, ...],
        k0: int,
        k1: int,
    ) -> dict[int, float]:
        """The share of each weighted production whose guard holds."""
        weights = {}
        for (number, production), guard, chance in zip(productions, guards, chances, strict=True):
            weighted = production.chance is not None and production.chance[0] == "weight"
            if weighted and chance and (guard is None or guard(params, k0, k1)):
                weights[number] = self._amount(number, chance(params, k0, k1))
        total = sum(weights.values())
        return {number: weight / total if total else 0.0 for number, weight in weights.items()}

    def _amount(self, number: int, amount: float) -> float:
        if not amount >= 0:
            name = told(self._program, self.production(number))
            raise fail("negative-chance", f"{name}: a chance is {amount:g}, but must be 0 or more")
        return amount

    def _single(
        self, code: tuple[tuple[ir.Instruction, ...], int] | None
    ) -> Callable[..., float] | None:
        if code is None:
            return None
        _, single = compile_values(code[0], (code[1],))
        attrs, tables = self._setting.attrs, self._tables()
        return lambda params, k0, k1: single(params, k0, k1, {}, attrs, tables)[0]  # type: ignore[arg-type]

    # -------------------------------------------------------------------------- chains

    def _chain(self, symbol: int) -> Chain | None:
        numbers = self._program.symbols[symbol].productions
        if self._program.steps is not None or not numbers:
            return None
        production = self.production(numbers[0])
        tail = _tail(production, symbol)
        if tail is None or production.chance is not None or production.guard is None:
            return None
        writer = Writer(self._setting, single=False, tail=tail)
        scope = _scope(production.parameters)
        try:
            writer.chain(production.body, scope, self._state())
        except UnscannableError:
            return None
        assert writer.ended is not None
        head = ["run", "rule", "n", "counts", "owner", "k0", "k1"]
        slots = "".join(f"{slot}, " for slot in writer.slots)
        ended = "".join(f"{source(writer.ended[name])}, " for name in self._setting.fields)
        body = function(
            writer.source.lines,
            [*head, *self._arguments(production.parameters)],
            f"({slots}), ({ended})",
            self._space(False),
        )
        return Chain(numbers[0], self._loop(production, tail), cast("Body", body))  # type: ignore[arg-type]

    def _loop(self, production: ir.Production, tail: ir.Instruction) -> Callable[..., object]:
        """The source of a chain's loop: guard, parameters and key, all in place."""
        assert production.guard is not None
        count = production.parameters
        guard, taken = self._inline(production.guard[0], (production.guard[1],))
        values, following = self._inline(production.body, tail.args)
        params = [f"p{number}" for number in range(count)]
        site = (tail.site * 1664525 + 1013904223) & keys.MASK
        lines = [
            *(f"q{number} = []" for number in range(count)),
            "a0, a1 = [], []",
            *(f"note{number} = q{number}.append" for number in range(count)),
            "note_k0, note_k1 = a0.append, a1.append",
            "for _ in range(limit):",
            *(f"    {line}" for line in guard),
            f"    if not {source(taken[0])}:",
            "        break",
            *(f"    note{number}(p{number})" for number in range(count)),
            "    note_k0(k0)",
            "    note_k1(k1)",
            *(f"    {line}" for line in values),
            *(
                [f"    {', '.join(params)}, = {', '.join(map(source, following))},"]
                if count
                else []
            ),
            *(f"    {line}" for line in _next_key(site)),
        ]
        columns = "".join(f"q{number}, " for number in range(count))
        result = f"[{columns}], a0, a1, ({''.join(name + ', ' for name in params)}), k0, k1"
        made = function(lines, ["limit", "k0", "k1", *params], result, self._space(True))
        return made

    def _inline(
        self, instructions: tuple[ir.Instruction, ...], outputs: tuple[int, ...]
    ) -> tuple[list[str], list[str | float]]:
        write = Source()
        write.name = lambda: f"t{len(write.lines)}_{outputs[0] if outputs else 0}"  # type: ignore[method-assign]
        names = Names(lambda i: f"p{i}", lambda i: self._setting.attrs[i], lambda i: "", "k0, k1")
        wanted = needed(instructions, outputs)
        values: dict[int, str | float] = {}
        for each in instructions:
            if each.out in wanted:
                args = [values[arg] for arg in each.args]
                found = _quick(each, args) or expression(each, args, names)
                values[each.out] = write.let(found) if isinstance(found, str) else found
        return write.lines, [values[register] for register in outputs]


def _quick(each: ir.Instruction, args: list[str | float]) -> str | None:
    """A comparison that is decided without a call unless its sides are close."""
    name = str(each.const)
    if each.op != "call" or name not in ("lt", "gt") or not any(isinstance(a, str) for a in args):
        return None
    low, high = [source(arg) for arg in (args if name == "lt" else args[::-1])]
    if "0.0" in (low, high):
        return f"({low} < {high})"  # nothing but 0 itself is close to 0
    return f"({high} - {low} > 1e-9 * (abs({low}) + abs({high})) or f_lt({low}, {high}))"


def _next_key(site: int) -> list[str]:
    """pcg3d of (k0, k1, site), whose third word is known."""
    return [
        "k1 = k1 * 1664525 + 1013904223",
        f"k0 = (k0 * 1664525 + 1013904223 + k1 * {site}) & 4294967295",
        f"k1 = (k1 + {site} * k0) & 4294967295",
        f"k2 = ({site} + k0 * k1) & 4294967295",
        "k0 ^= k0 >> 16",
        "k1 ^= k1 >> 16",
        "k2 ^= k2 >> 16",
        "k0 = (k0 + k1 * k2) & 4294967295",
        "k1 = (k1 + k2 * k0) & 4294967295",
    ]


def _scope(parameters: int) -> Scope:
    return Scope("n", "k0", "k1", tuple(f"p{number}" for number in range(parameters)), {})


def _tail(production: ir.Production, symbol: int) -> ir.Instruction | None:
    """The last module of a body, where it makes the body's own symbol again."""
    for each in reversed(production.body):
        if each.op == "module":
            return each if each.const == symbol and each.site >= 0 else None
        if each.op == "repeat":
            return None
    return None
