"""Python source for a production's body: one function for batches, one for single shapes.

In go a production and the state's fields, out comes a function that computes values, carries the
state through the body and hands every child and every drawing to the run that calls it. Symbols
without productions are written out in place. Repeats become one batch of copies, whose frames are
found by a scan. Nothing is derived here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace

from ipmlang.compiler import ir
from ipmlang.runtime import runs
from ipmlang.runtime.algebra import Operand, Source
from ipmlang.runtime.code import INFIX, SOUND, Names, doubtful, expression, source
from ipmlang.runtime.content import Numbered
from ipmlang.runtime.copied_bodies import chosen_symbols, walked
from ipmlang.runtime.fields import FRAME, IDENTITY, LAG, UNSET
from ipmlang.runtime.fields import SCOPE as SCOPE_FIELDS
from ipmlang.runtime.grouping import FIELD
from ipmlang.runtime.motion import Motion, State
from ipmlang.runtime.naming import OWN, Scope, Setting, is_named_length
from ipmlang.runtime.primitives import UnscannableError
from ipmlang.runtime.queries import questions
from ipmlang.runtime.queries.marks import FIELD as MARK
from ipmlang.runtime.queries.marks import PHASE
from ipmlang.runtime.runs import Runs
from ipmlang.runtime.scene import SCOPE, SEGMENT
from ipmlang.runtime.scopes import scope_bodies


class Writer:
    """One function under construction. `quiet`: only the state matters, nothing is made."""

    def __init__(
        self,
        setting: Setting,
        single: bool,
        numbered: Numbered,
        tail: ir.Instruction | None = None,
    ) -> None:
        self._setting = setting
        self.numbered = numbered
        self.program = setting.program
        self._single = single
        self._tail = tail
        self.quiet = False
        self.source = Source()
        self.motion = Motion(setting.program, self.source)
        self.slots: list[str] = []
        self.ended: State | None = None
        self.base: State = {}
        self.owners: list[str] = []  # of the copies around, since the base was noted
        self._moving: dict[int, bool] = {}
        self.code: dict[int, ir.Instruction] = {}  # what wrote each register so far
        self._sound: set[int] = set()  # registers of the body whose numbers are finite
        self.unknown: set[str] = set()  # of a quiet walk: what an operation on geometry made of it

    # ------------------------------------------------------------------------ elements

    def body(self, elements: Sequence[ir.Instruction], scope: Scope, state: State) -> State:
        """Write the elements of a body; the state after them."""
        saved: list[State] = []
        passed = -1
        needed = self._needed(elements) if self.quiet else None
        self.base = self.base or state
        for number, each in enumerate(elements):
            if number <= passed and each.op not in ir.VALUE_OPS:
                continue
            if each.out >= 0:
                self.code[each.out] = each
            if each.op == "open":
                saved.append(dict(state))
                if MARK in state and not self.quiet:
                    state = questions.began(self, questions.inside(elements, number), scope, state)
                if self.quiet:  # what a bracket restores need not be walked
                    passed = self._bracket_end(elements, number)
            elif each.op == "close":
                state = saved.pop()
            elif isinstance(each, Runs):
                runs.written(self, each, scope, state)
            elif each.op == "repeat" and (
                last := chosen_symbols(self, elements, number, scope, state)
            ):
                passed = last
            elif each.op == "repeat":
                state = self._repeat(each, scope, state)
            elif each.op in scope_bodies.PARTING:
                scope_bodies.PARTING[each.op](self, each, scope, state)
            elif each is self._tail:
                self.ended = dict(state)
            elif each.op == "module":
                state = self._module(each, scope, state)
            elif each.out not in scope.registers and (needed is None or each.out in needed):
                if each.op in SOUND:
                    self._sound.add(each.out)
                scope.registers[each.out] = self._value(each, scope, scope.registers, state)
        return state

    def _bracket_end(self, elements: Sequence[ir.Instruction], begin: int) -> int:
        """The last element to pass over in a bracket: none where it holds the tail of a chain."""
        depth = 0
        for number in range(begin, len(elements)):
            each = elements[number]
            if each is self._tail:
                return begin
            depth += (each.op == "open") - (each.op == "close")
            if depth == 0:
                return number - 1
        return begin

    def _needed(self, elements: Sequence[ir.Instruction]) -> set[int]:
        """The registers that decide where a walk through elements leads."""
        moving = []
        passed = -1
        for number, each in enumerate(elements):
            if number > passed and not self._makes(each):
                moving.append(each)
            if each.op == "open" and number > passed:
                passed = self._bracket_end(elements, number)
        return questions.needed(elements, moving)

    def _makes(self, each: ir.Instruction) -> bool:
        """Whether an element makes shapes, or parts of the scope, and leaves the state alone."""
        if each.op in scope_bodies.PARTING or each is self._tail:
            return True
        return each.op == "module" and self._expands(each)

    def _expands(self, each: ir.Instruction) -> bool:
        assert isinstance(each.const, int)
        symbol = self.program.symbols[each.const]
        return bool(symbol.productions or symbol.interpretation)

    def act(
        self,
        meaning: Sequence[ir.Instruction],
        scope: Scope,
        args: tuple[Operand, ...],
        symbol: int,
        site: int,
        state: State,
    ) -> State:
        """Write what a module of a symbol without productions does."""
        inner = replace(scope, params=args, registers={})
        doubt = doubtful(meaning)
        for each in meaning:
            if each.op in ir.VALUE_OPS:
                inner.registers[each.out] = self._value(each, inner, inner.registers, state)
                continue
            given = [inner.registers[arg] for arg in each.args]
            if each.op == "pen" and not doubt.isdisjoint(each.args):  # else what is drawn tells
                self.check(each, self.program.symbols[symbol].name, inner, doubt)
            if each.op in ("segment", "emit"):
                self._draw(each, scope, given, symbol, site, state)
            if each.op == "pen" and _field(each) == FIELD:
                state = self._grouped(each, given, inner, state)
            elif each.op in scope_bodies.SHAPING:
                state = scope_bodies.shaped(self, each, given, scope, state)
            else:
                state = self._state(each, given, scope, state)
            state = questions.known(self, each, given, scope, site, state)
        return state

    def _module(self, each: ir.Instruction, scope: Scope, state: State) -> State:
        assert isinstance(each.const, int)
        if self.quiet and self._expands(each):
            return state
        symbol = self.program.symbols[each.const]
        args = tuple(scope.registers[register] for register in each.args)
        if not self._expands(each):
            self.check(each, symbol.name, scope)
            return self.act(symbol.meaning or (), scope, args, each.const, each.site, state)
        if not self.quiet:
            self._make(each.const, scope, args, each.site, state)
        return state

    def check(
        self, each: ir.Instruction, name: str, scope: Scope, among: Set[int] | None = None
    ) -> None:
        """What an operation is given must be finite, or some of it; that of children is checked
        with them.
        """
        if self.quiet:
            return
        for register in each.args:
            value = scope.registers[register]
            known = isinstance(value, float) and math.isfinite(value)
            if known or (register in self._sound if among is None else register not in among):
                continue
            if self._single:
                self.source.lines.append(f"if not isfinite({source(value)}):")
                self.source.lines.append(f"    run.finite({source(value)}, {name!r})")
            else:
                where = f"{scope.count}, {scope.shown}, {scope.around}"
                self.source.lines.append(f"run.finite({source(value)}, {name!r}, {where})")

    def _value(
        self, each: ir.Instruction, scope: Scope, registers: Mapping[int, Operand], state: State
    ) -> Operand:
        if each.op == "const":
            return float(str(each.const))
        if each.op == "state":
            return scope_bodies.asked(self, str(each.const), state)
        if each.op == "measure" and " " in str(each.const):
            return scope_bodies.unwrapped(self, str(each.const), scope, state)
        if each.op == "measure":
            self.known(SCOPE_FIELDS)
            parts = ", ".join(source(state[name]) for name in SCOPE_FIELDS)
            return self.source.let(f"run.measure('{each.const}', {parts})")
        if each.op == "count":
            return scope.many[int(str(each.const))]
        if each.op == "self":
            return self.source.let(f"arange({scope.count})")
        names = Names(
            lambda i: scope.params[i],  # type: ignore[arg-type,return-value]
            lambda i: self._setting.attrs[i],
            lambda i: dict(scope.copies)[i],
            f"{scope.k0}, {scope.k1}",
            scope.numbers,
            self.numbered.table,
        )
        args = [registers[arg] for arg in each.args]
        if each.op == "query":
            return questions.answered(self, each, args, scope, state)
        if each.op == "call" and each.const in INFIX:
            return self._arithmetic(str(each.const), args[0], args[1])
        found = expression(each, args, names)
        return self.source.let(found) if isinstance(found, str) and each.op != "param" else found

    def _arithmetic(self, name: str, a: Operand, b: Operand) -> Operand:
        if isinstance(a, float) and isinstance(b, float):
            return {"add": a + b, "sub": a - b, "mul": a * b}[name]
        return self.source.let(f"{source(a)} {INFIX[name]} {source(b)}")

    # --------------------------------------------------------------------------- state

    def _state(
        self, each: ir.Instruction, args: list[Operand], scope: Scope, state: State
    ) -> State:
        match each.op:
            case "move":
                return self.motion.moved(state, args[0], args[1], args[2])
            case "segment":
                return self.motion.moved(state, args[0], 0.0, 0.0)
            case "rotate":
                return self.motion.rotated(state, str(each.const), args[0])
            case "orient":
                return self.motion.oriented(state, args)
            case "scale":
                factor = args[0]
                if not isinstance(factor, float) or factor <= 0:
                    around = "" if self._single else f", {scope.around}"
                    self.source.lines.append(f"run.factor({source(factor)}{around})")
                return {**state, "scale": self.source.multiply(state["scale"], factor)}
            case "mirror":
                return {**state, "scale": self.source.minus(state["scale"])}
            case "level":
                return self.motion.levelled(state, self.quiet)
            case "pen":
                return self._penned(each, args, state)
            case "phase":
                before = source(state[PHASE])
                return {**state, PHASE: self.held(f"run.later({source(args[0])}, {before})")}
            case "layer":
                return {**state, "layer": self.source.add(state["layer"], args[0])}
            case _:
                return state

    def _penned(self, each: ir.Instruction, args: list[Operand], state: State) -> State:
        field = _field(each)
        changed = {**state, field: self._pen_value(each, args)}
        if field == "color":  # a colour is for both
            changed.update({name: -1.0 for name in ("fill", "stroke") if name in state})
        return changed

    def _pen_value(self, each: ir.Instruction, args: list[Operand]) -> Operand:
        assert isinstance(each.const, tuple)
        if args:
            return args[0]
        return float(self.program.strings.index(str(each.const[1])))

    def _grouped(
        self, each: ir.Instruction, args: list[Operand], scope: Scope, state: State
    ) -> State:
        """A group begins in the frame that the state has."""
        if self.quiet:  # a scan cannot make groups in groups
            raise UnscannableError
        names = [name for name in state if name in FRAME or name == "layer"]
        parts = [source(self._pen_value(each, args)), source(state[FIELD])]
        parts.append(self.mapping(state, names))
        count = [] if self._single else [scope.count]
        return {**state, FIELD: self.held(f"run.group({', '.join([*count, *parts])})")}

    # ---------------------------------------------------------------- what is handed over

    def values(self, operands: Iterable[Operand]) -> str:
        """The source of a tuple of operands."""
        return "(" + "".join(f"{source(each)}, " for each in operands) + ")"

    def _draw(
        self,
        each: ir.Instruction,
        scope: Scope,
        args: list[Operand],
        symbol: int,
        site: int,
        state: State,
    ) -> None:
        if self.quiet:
            return
        own = self.numbered.symbol(symbol)
        asset, size = SEGMENT, [args[0], 0.0, 0.0] if each.op == "segment" else [0.0, 0.0, 0.0]
        shown = scope.shown
        if each.op == "emit":
            assert isinstance(each.const, int)
            asset = each.const if each.const >= 0 else SCOPE
            size = args if len(args) == 3 else size
        if asset == SCOPE and "geo" in state:
            size = [state[name] for name in ("sx", "sy", "sz")]
            what = f"{own}, {source(state['geo'])}, {scope.count}, {shown}"
            shown = self.held(f"run.drawable({what})")
        parts = (self.values(size), self.values(state.values()))
        drawn = self.numbered.asset(asset)
        if self._single:
            key = "k0, k1" if site == OWN else f"*child(k0, k1, {site})"
            what = f"(rule, {own}, {drawn}, *{parts[0]}, *{parts[1]}, {key})"
            self.slots.append(self.held(f"~run.draw({what})"))
        else:
            where = f"{scope.k0}, {scope.k1}, {site}, {scope.tuple}"
            what = f"{scope.count}, rule, {own}, {drawn}, {parts[0]}, {parts[1]}, {where}"
            self.slots.append(self.held(f"run.draw({what}, {shown}, {scope.around})"))

    def _make(
        self, symbol: int, scope: Scope, args: tuple[Operand, ...], site: int, state: State
    ) -> None:
        columns = f"{self.values(args)}, {self.values(state.values())}"
        own = self.numbered.symbol(symbol)
        if self._single:
            made = f"run.make({own}, child(k0, k1, {site}), rule, {columns})"
        else:
            where = f"{scope.k0}, {scope.k1}, {site}, {scope.tuple}"
            made = f"run.make({scope.count}, {own}, rule, {columns}, {where}, {scope.shown})"
        self.slots.append(self.held(made))

    def held(self, call: str) -> str:
        name = self.source.name()
        self.source.lines.append(f"{name} = {call}")
        return name

    # ------------------------------------------------------------------------- repeats

    def chain(self, elements: Sequence[ir.Instruction], scope: Scope, state: State) -> None:
        """Write a body whose tail makes the next row of a chain: scan first, then draw."""
        start: State = {name: IDENTITY.get(name, 0.0) for name in state}
        start.update(
            {name: UNSET for name in state if name not in (*FRAME, *SCOPE_FIELDS, "layer")}
        )
        start.update({name: state[name] for name in SCOPE_FIELDS if name in state})
        self.quiet = True
        self.body(elements, scope, dict(start))
        self.quiet = False
        assert self.ended is not None
        own, after = state, state
        if self.ended != start:
            own, after = walked(self, state, self.ended, start, state, "counts", "owner")
        if LAG in state:
            own = {**own, LAG: self.source.let(f"{source(state[LAG])} + arange({scope.count})")}
        self.body(elements, scope, dict(own))
        self.ended = after

    def _repeat(self, each: ir.Instruction, scope: Scope, state: State) -> State:
        write = self.source
        limit = source(scope.registers[each.args[0]])
        where = f"{scope.count}, {scope.shown}, {scope.around}"
        counts = write.let(f"run.counts({limit}, {where})")
        found = self.held(f"run.copies({counts})")
        owner, index = write.let(f"{found}[0]"), write.let(f"{found}[1]")
        assert isinstance(each.const, int)
        inner = self.gathered(each, each.const, scope, owner, index)
        own = {name: self.taken(value, owner) for name, value in state.items()}
        start: State = {name: IDENTITY.get(name, 0.0) for name in state}
        start.update({name: own[name] for name in (*SCOPE_FIELDS, MARK) if name in own})
        pens = [name for name in state if name not in (*FRAME, *SCOPE_FIELDS, MARK)]
        start.update({name: UNSET for name in pens if name != "layer"})
        quiet, self.quiet = self.quiet, True
        unknown, self.unknown = self.unknown, set(self.unknown)
        step = self.body(each.body, inner, dict(start)) if self._moves(each) else start
        step.update((name, start[name]) for name in SCOPE_FIELDS if name in start)
        self.quiet, self.unknown = quiet, unknown
        after = state
        if step != start:
            own, after = walked(self, state, step, start, own, counts, owner)
        if not quiet:
            outer, self.slots = self.slots, []
            self.owners.append(owner)
            self.body(each.body, inner, questions.began(self, each.body, inner, own))
            self.owners.pop()
            slots, self.slots = self.held(self.values(self.slots)), outer
            self.slots.append(f"Copies({counts}, {owner}, {slots})")
        return after

    def _moves(self, repeat: ir.Instruction) -> bool:
        """Whether a copy may leave another state than it found: only then is it walked for it."""
        found = self._moving.get(id(repeat))
        if found is None:
            found = any(
                self._moves(each) if each.op == "repeat"
                else not (each.op in ir.VALUE_OPS or self._makes(each))
                for each in repeat.body
            )  # fmt: skip
            self._moving[id(repeat)] = found
        return found

    def mapping(self, state: State, names: Sequence[str]) -> str:
        """The source of some fields of a state."""
        return "{" + ", ".join(f"'{name}': {source(state[name])}" for name in names) + "}"

    def gathered(
        self, each: ir.Instruction, number: int, scope: Scope, owner: str, index: str
    ) -> Scope:
        """The names of the batch of copies; `each` is a repeat, or one part of pieces."""
        used = questions.read_inside(each.body)
        copies = tuple(
            (around, self.source.let(f"{name}[{owner}]")) for around, name in scope.copies
        )
        shown = None
        for register in each.args[1:]:
            hole = self.taken(scope.registers[register], owner)
            if not self.quiet:
                around = replace(scope, owners=(owner, *scope.owners)).around
                where = f"len({owner}), None, {around}"
                self.source.lines.append(f"run.finite({source(hole)}, 'except', {where})")
            clear = self.source.let(f"({source(hole)} != {index})")
            shown = clear if shown is None else self.source.let(f"{shown} & {clear}")
        rows = None if shown is None else self.source.let(f"flatnonzero({shown})")
        if scope.shown is not None:
            outer = f"{scope.shown}, {scope.count}, {owner}"
            rows = self.source.let(f"run.inner({outer}, {shown})")
        return Scope(
            self.source.let(f"len({owner})"),
            self.source.let(f"{scope.k0}[{owner}]"),
            self.source.let(f"{scope.k1}[{owner}]"),
            tuple(self.taken(value, owner) for value in scope.params),
            {
                register: self.taken(value, owner)
                for register, value in scope.registers.items()
                if register in used
            },
            (*copies, (number, index)),
            rows,
            {around: self.source.let(f"{name}[{owner}]") for around, name in scope.many.items()},
            (owner, *scope.owners),
        )

    def taken(self, value: Operand, owner: str) -> Operand:
        if isinstance(value, float) or is_named_length(value):  # one number for all
            return value
        return self.source.let(f"take({value}, {owner})")

    def known(self, names: Iterable[str]) -> None:
        """A walk that makes nothing cannot tell what an operation has made of the geometry."""
        if self.quiet and not self.unknown.isdisjoint(names):
            raise UnscannableError

    def within(self, body: Sequence[ir.Instruction], scope: Scope, state: State) -> None:
        """A body of its own; `center` in it asks for the scope that it began with."""
        before, self.base = self.base, state
        owners, self.owners = self.owners, []
        self.body(body, scope, questions.began(self, body, scope, state))
        self.base, self.owners = before, owners


def _field(each: ir.Instruction) -> str:
    """What a pen instruction sets."""
    assert isinstance(each.const, tuple)
    return str(each.const[0])
