"""The functions of a bound program: bodies, meanings, choices and chains, written when first used.

In go the setting of a run, out come functions by production or symbol. Nothing here derives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias, cast

from ipmlang.compiler import ir
from ipmlang.runtime import keys
from ipmlang.runtime.bodies import Writer
from ipmlang.runtime.chains import Chain, Drawing, tail_of, walk_of
from ipmlang.runtime.choose import OVER, no_truth, out_of_range, over
from ipmlang.runtime.code import compile_values, source
from ipmlang.runtime.content import KEPT, Content, Numbered
from ipmlang.runtime.motion import State, mirrors
from ipmlang.runtime.naming import OWN, Scope, Setting, length_name
from ipmlang.runtime.primitives import UnscannableError, bound, compiled, function, names_for
from ipmlang.runtime.queries.marks import FIELD as MARK
from ipmlang.runtime.runs import with_runs

Body: TypeAlias = Callable[..., tuple[object, ...]]
Choose: TypeAlias = Callable[[tuple[float, ...], int, int], int]


class Compiled:
    """All functions of one program with one set of attribute values."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._program = setting.program
        self._mirrors = mirrors(setting.program)
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
            numbered, count = Numbered(self._setting), production.parameters
            apart = self._program.scoped and not single
            elements = production.body
            if not single and MARK not in self._setting.fields:  # where nobody asks for them
                elements = with_runs(self._program, elements)
            content = numbered.content(elements, apart)

            def write(writer: Writer) -> None:
                body = numbered.named(elements, count) if apart else elements
                writer.body(body, _scope(count, len(numbered.lengths)), self._state())

            found = self._made(numbered, content, write, count, single)
            self._bodies[number, single] = found
        return found

    def meaning(self, number: int, single: bool = False) -> Body:
        """The same for what is left of a symbol."""
        found = self._meanings.get((number, single))
        if found is None:
            symbol = self._program.symbols[number]
            numbered, scope = Numbered(self._setting), _scope(symbol.arity)

            def write(writer: Writer) -> None:
                meaning = symbol.meaning or ()
                writer.act(meaning, scope, scope.params, number, OWN, self._state())

            numbered.symbol(number)
            content = ("meaning", symbol.name, numbered.content(symbol.meaning or ()))
            found = self._made(numbered, content, write, symbol.arity, single)
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

    def _made(
        self,
        numbered: Numbered,
        content: Content,
        write: Callable[[Writer], None],
        parameters: int,
        single: bool,
    ) -> Body:
        """A function for what a body says; written only if no program before said the same."""
        program = self._setting.program
        around = (single, parameters, self._setting.fields, self._mirrors, program.scoped)
        content = (around, content)
        code = KEPT.get(content)
        if code is None:
            writer = Writer(self._setting, single, numbered)
            write(writer)
            code = compiled(*self._text(writer, parameters, single))
            KEPT.keep(content, numbered.size, code)
        return cast("Body", bound(code, *self._around(single), numbered.space()))

    def _text(
        self, writer: Writer, parameters: int, single: bool
    ) -> tuple[list[str], list[str], str]:
        """The lines, arguments and result of what was written."""
        head = ["run", "rule", *([] if single else ["n"]), "k0", "k1"]
        result = "(" + "".join(f"{slot}, " for slot in writer.slots) + ")"
        return writer.source.lines, [*head, *self._arguments(parameters)], result

    def _around(self, single: bool) -> tuple[Mapping[str, object], ...]:
        return self._spaces[single], {"data": self._setting.data}

    def _space(self, single: bool) -> dict[str, object]:
        """The names that all functions of a run may use."""
        spaces = self._around(single)
        return {**spaces[0], **spaces[1]}

    # ------------------------------------------------------------------------- choices

    def _choice(self, numbers: tuple[int, ...]) -> Choose:
        productions = [(number, self.production(number)) for number in numbers]
        first = productions[0][1]
        if first.chance is None and first.guard is None:
            return lambda params, k0, k1: numbers[0]
        guards = [self._guard(each) for _, each in productions]
        chances = [
            None if each.chance is None else self._single((each.chance[1], each.chance[2]))
            for _, each in productions
        ]
        kinds = [None if each.chance is None else each.chance[0] for _, each in productions]

        def choose(params: tuple[float, ...], k0: int, k1: int) -> int:
            taken, total, drawn = -1, 0.0, -1.0
            shares: dict[int, float] | None = None
            for place, (number, _) in enumerate(productions):
                guard, chance = guards[place], chances[place]
                if kinds[place] == "weight":
                    if shares is None:
                        shares = self._shares(productions, guards, chances, params, k0, k1)
                    if number not in shares:
                        continue
                    share = shares[number]
                elif guard is not None and not guard(params, k0, k1):
                    continue
                elif chance is None:
                    taken = number if taken < 0 else taken
                    break
                else:
                    share = self._amount(number, chance(params, k0, k1)) / 100
                if drawn < 0:
                    drawn = keys.choice_single(k0, k1)
                total += share
                if taken < 0 and drawn < total:
                    taken = number
            if total > OVER:
                raise over(_module(self._program.symbols[first.symbol], params), total)
            return taken

        return choose

    def _shares(
        self,
        productions: list[tuple[int, ir.Production]],
        guards: list[Callable[..., bool] | None],
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
        if not 0 <= amount < math.inf:
            raise out_of_range(self._program, self.production(number), amount)
        return amount

    def _guard(self, production: ir.Production) -> Callable[..., bool] | None:
        if production.guard is None:
            return None
        _, single = compile_values(production.guard[0], (production.guard[1],))
        attrs, data = self._setting.attrs, self._setting.data

        def guard(params: tuple[float, ...], k0: int, k1: int) -> bool:
            truth = single(params, k0, k1, {}, attrs, data)[0]
            if truth != truth:
                raise no_truth(self._program, production)
            return truth != 0

        return guard

    def _single(
        self, code: tuple[tuple[ir.Instruction, ...], int] | None
    ) -> Callable[..., float] | None:
        if code is None:
            return None
        _, single = compile_values(code[0], (code[1],))
        attrs, data = self._setting.attrs, self._setting.data
        return lambda params, k0, k1: single(params, k0, k1, {}, attrs, data)[0]

    def _chain(self, symbol: int) -> Chain | None:
        numbers = self._program.symbols[symbol].productions
        if self._program.steps is not None or not numbers:
            return None
        production = self.production(numbers[0])
        tail = tail_of(production, symbol)
        if tail is None:
            return None
        numbered = Numbered(self._setting)
        writer = Writer(self._setting, single=False, numbered=numbered, tail=tail)
        try:
            writer.chain(production.body, _scope(production.parameters), self._state())
        except UnscannableError:
            return None
        assert writer.ended is not None
        head = ["run", "rule", "n", "counts", "owner", "k0", "k1"]
        slots = "".join(f"{slot}, " for slot in writer.slots)
        ended = "".join(f"{source(writer.ended[name])}, " for name in self._setting.fields)
        arguments = [*head, *self._arguments(production.parameters)]
        space = {**self._space(False), **numbered.space()}
        body = function(writer.source.lines, arguments, f"({slots}), ({ended})", space)
        setting = self._setting
        walk = walk_of(production, tail, setting.attrs, setting.data, self._space(True))
        return Chain(numbers[0], walk, cast("Drawing", body))


def _module(symbol: ir.Symbol, params: tuple[float, ...]) -> str:
    """One shape as its grammar would write it."""
    written = ", ".join(f"{value:g}" for value in params[: symbol.arity - symbol.carried])
    return f"{symbol.name}({written})" if written else symbol.name


def _scope(parameters: int, lengths: int = 0) -> Scope:
    names = (f"p{number}" for number in range(parameters))
    own = map(length_name, range(lengths))
    return Scope("n", "k0", "k1", (*names, *own), {})
