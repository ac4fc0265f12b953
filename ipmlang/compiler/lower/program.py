"""A whole program: from its start, every symbol, rule, asset and table that it reaches.

In go units with their names found, out comes a program. What no executor runs yet is collected and
reported at once, each with its place, when it can be reached; what cannot be is not lowered.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

from ipmlang.compiler import ast, ir
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.compiler.lower import analysis, settings
from ipmlang.compiler.lower.carrying import Changes, carried
from ipmlang.compiler.lower.contexts import context_files
from ipmlang.compiler.lower.expr import Code, Named, Pool
from ipmlang.compiler.lower.meaning import Meanings, steps_of
from ipmlang.compiler.lower.names import Place, Unit
from ipmlang.compiler.lower.productions import axiom, production
from ipmlang.compiler.lower.strings import Misplaced, Strings
from ipmlang.compiler.lower.symbols import Bound, Takers
from ipmlang.compiler.lower.tables import Tables
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.places import SHAPE, in_runs, shapes_of

SCOPE_FAMILIES = ("scope", "solid", "split")
MOST_KINDS = 10_000  # of one rule: a rule that swaps many symbols could stand for any number
# the unit that defines it (0: none does), name, arity, which of its arguments are which symbols
Key = tuple[int, str, int, Bound]


class Lowering:
    """Numbers for all that is named, given when it is first reached."""

    def __init__(self, main: Unit, units: tuple[Unit, ...]) -> None:
        self._main = main
        self._units = units
        self._pool = Pool()
        self._tables = Tables(self._pool)
        self._attrs = settings.attributes(self._pool, units)
        self._indices = settings.indices(self._pool, units)
        self._turtle = settings.turtle(main)
        self._meanings = Meanings(self._pool, main, self._turtle)
        self._numbers: dict[Key, int] = {}
        self._found: dict[Key, int | None] = {}
        self._operations: dict[tuple[int, str], Operation | None] = {}
        self._takers = Takers(units)
        self._kinds: Counter[tuple[int, str, int]] = Counter()
        self._symbols: list[ir.Symbol] = []
        self._waiting: deque[tuple[int, Unit, str, int, Bound]] = deque()
        self._productions: list[ir.Production] = []
        self._changes: list[Changes] = []
        self._refused: dict[str, list[Diagnostic]] = {}

    def program(self) -> ir.Program:
        """The program, or an error that names all that is not executable yet."""
        number, start = self._start()
        elements = (*settings.prelude(self._turtle), *start.axiom)
        first, behind = axiom(self._pool, self, self._main, number, elements)
        while self._waiting:
            self._lower_rules(*self._waiting.popleft())
        steps = None
        if start.steps is not None:
            code = Code(self._pool, self._main, number)
            code.shaped = False
            register = code.register(code.value(start.steps, {}))
            steps = (tuple(code.instructions), register)
        ignored = self._ignored()
        self._refuse_options(number, start)
        self._raise_refused()
        ground = settings.ground(self._pool, self._main, number, start.place)
        scoped = ground is not None or analysis.scoped(self._symbols, (*self._productions, first))
        fixed = settings.fixed(self._pool, self._main, scoped=scoped)
        tropism = fixed.tropism
        if scoped:
            self._symbols = [_terminal(each) for each in self._symbols]
        drawn = settings.varied(self._attrs) if scoped else ()
        made = carried(self._symbols, self._productions, first, (*self._changes, behind), drawn)
        first = made.axiom
        stepped = start.steps is not None
        found = analysis.Analysis(made.symbols, made.productions, stepped, scoped)
        symbols = found.symbols()
        if scoped:
            strings = Strings(symbols, made.productions, found, tropism is not None)
            self._refuse_misplaced(strings.misplaced(first), number)
            pairs = zip(symbols, strings.apart, strict=True)
            symbols = tuple(
                replace(symbol, apart=True) if apart else symbol for symbol, apart in pairs
            )
        canvas, size, decimals = settings.canvas(self._pool, self._main)
        flat = not scoped and analysis.flat(made.symbols, tropism)
        residual = self._residual(flat)
        return ir.Program(
            symbols,
            made.productions,
            first,
            (*self._attrs, *settings.hidden(self._indices)),
            tuple(self._tables.data),
            tuple(self._pool.assets),
            tuple(self._pool.strings),
            steps,
            not scoped and found.threaded(first),
            flat,
            settings.is_abop(self._turtle),
            tropism,
            ignored,
            fixed.limits,
            canvas,
            size,
            decimals,
            self._up(),
            settings.pen_width(self._pool, self._main, self._turtle),
            start.choices,
            residual,
            fixed.late,
            self._main.source.path,
            scoped,
            ground,
            made.varied,
            context_files(self._pool),
        )

    # ------------------------------------------------------------------ what bodies ask

    def symbol(self, unit: Unit, name: str, arity: int, bound: Bound = ()) -> int | None:
        """The number of a symbol with as many arguments, some of which are `bound` to symbols;
        None where no executor runs it yet.
        """
        written = (id(unit), name, arity, bound)
        if written not in self._found:
            self._found[written] = self._find(unit, name, arity, bound)
        return self._found[written]

    def takes(self, unit: Unit, name: str, arity: int) -> frozenset[int]:
        """Which of the arguments of a symbol are symbols."""
        return self._takers.of(unit, name, arity)

    def _find(self, unit: Unit, name: str, arity: int, bound: Bound) -> int | None:
        """The number of a symbol that is named for the first time in a file."""
        record = OPERATIONS.get(name)
        owner, own = unit.within(name)
        spellings = _spellings(own, record)
        rules = any(each in owner.rules or each in owner.interpretations for each in spellings)
        place = owner.find(own)
        item = None if place is None else place.unit.grammar.items[place.item]
        asset = item if isinstance(item, ast.Asset) else None
        steps = None if record is None or asset is not None else steps_of(record, arity)
        if record is not None and steps is None and not rules and asset is None:
            return None
        shown = record.name if record is not None and asset is None else own
        key = (id(owner) if rules or asset is not None else 0, shown, arity, bound)
        if key not in self._numbers:
            held = record is not None and asset is None and record.family in SCOPE_FAMILIES
            left = arity - sum(each is not None for each in bound)
            told = tuple(None if each is None else each.name for each in bound)
            given = told if any(told) else ()
            meaning: tuple[ir.Instruction, ...] | None = None
            registers = 0
            if asset is not None and place is not None:
                drawn = self._pool.asset(place.unit, own, asset)
                meaning = (ir.Instruction("emit", const=drawn),)
            elif record is not None and steps is not None and not any(bound):
                meaning, registers = self._meanings.of(record, arity, steps)
            number = self._add(key, ir.Symbol(
                shown, left, (), (), meaning, registers, held=held and not rules, given=given
            ))  # fmt: skip
            if rules:
                self._check_kinds(owner, own, arity, bound)
                self._waiting.append((number, owner, own, arity, bound))
        return self._numbers[key]

    def _check_kinds(self, unit: Unit, name: str, arity: int, bound: Bound) -> None:
        """A rule that swaps the symbols that it is given may stand for very many rules."""
        if not any(bound):
            return
        key = (id(unit), name, arity)
        self._kinds[key] += 1
        if self._kinds[key] > MOST_KINDS:
            place = [*unit.rules.get(name, ()), *unit.interpretations.get(name, ())][0]
            span = place.unit.grammar.items[place.item].span
            message = f"`{name}` is given symbols in more than {MOST_KINDS:,} ways"
            hint = "give it fewer symbols at once, or do not swap them from call to call"
            raise place.unit.error(place.item, span, "too-many-symbols", message, hint)

    def mark(self, name: str, close: bool) -> int | None:
        """The symbol of the opening or closing brace of an operation."""
        record = OPERATIONS.get(name)
        steps = None if record is None else steps_of(record, 0)
        middle = [number for number, step in enumerate(steps or ()) if step.op == "body"]
        if record is None or steps is None or not middle:
            return None
        key: Key = (0, "}" if close else "{", -1 - list(OPERATIONS).index(name), ())
        if key not in self._numbers:
            half = steps[middle[0] + 1 :] if close else steps[: middle[0]]
            self._add(key, ir.Symbol(key[1], 0, (), (), *self._meanings.of(record, 0, half)))
        return self._numbers[key]

    def runs(self, unit: Unit, name: str) -> tuple[Named, ...]:
        """The symbols that the rows of a table place, if the rows of each stand together."""
        found = _table(unit, name)
        return _shapes(found) if found is not None and in_runs(found[1]) else ()

    def choices(self, unit: Unit, name: str) -> tuple[tuple[Named, ...], int]:
        """The symbols that the rows of a table place, and a table of which of them each does."""
        found = _table(unit, name)
        return ((), 0) if found is None else (_shapes(found), self._tables.choices(found[0]))

    def table(
        self, unit: Unit, name: str, shape: str | None = None
    ) -> tuple[int, tuple[str, ...], int] | None:
        """Number, columns and row count of a table, or of its rows that place a symbol."""
        place = unit.find(name)
        if place is None or not isinstance(place.unit.grammar.items[place.item], ast.Table):
            return None
        tables = self._tables
        number = tables.number(place) if shape is None else tables.only(place, shape)
        return number, self._tables.data[number].columns, len(self._tables.data[number].rows)

    def steps_table(self, steps: tuple[float, ...]) -> int:
        """The number of a table of the lengths of moves."""
        return self._tables.steps(steps)

    def operation(self, unit: Unit, name: str) -> Operation | None:
        """The record of what a name does to a scope, None where it means something else."""
        key = (id(unit), name)
        if key not in self._operations:
            self._operations[key] = self._operation(unit, name)
        return self._operations[key]

    def _operation(self, unit: Unit, name: str) -> Operation | None:
        record = OPERATIONS.get(name)
        if record is None or record.family not in SCOPE_FAMILIES:
            return None
        owner, own = unit.within(name)
        spellings = _spellings(own, record)
        ruled = any(each in owner.rules or each in owner.interpretations for each in spellings)
        return None if ruled or owner.find(own) is not None else record

    @property
    def indices(self) -> tuple[int, int] | None:
        """The attributes that hold `split.index` and `split.count`, None if nothing reads them."""
        return self._indices

    def refuse(self, code: Code, span: ast.Span, what: str) -> None:
        """Note that an operation is not executable yet."""
        self._note(code.unit, code.item, span, what, f"operation `{what}` is not executable yet")

    # ------------------------------------------------------------------------- parts

    def _add(self, key: Key, symbol: ir.Symbol) -> int:
        self._numbers[key] = len(self._symbols)
        self._symbols.append(symbol)
        return self._numbers[key]

    def _lower_rules(self, number: int, unit: Unit, name: str, arity: int, bound: Bound) -> None:
        spellings = _spellings(name, OPERATIONS.get(name))
        made = []
        for named in (unit.rules, unit.interpretations):
            places = [place for each in spellings for place in named.get(each, ())]
            made.append(self._alternatives(number, places, arity, bound))
        self._symbols[number] = replace(
            self._symbols[number], productions=made[0], interpretation=made[1]
        )

    def _alternatives(
        self, number: int, places: Sequence[Place], arity: int, bound: Bound
    ) -> tuple[int, ...]:
        numbers = []
        for place in sorted(places, key=lambda each: each.item):
            rule = place.unit.grammar.items[place.item]
            assert isinstance(rule, ast.Rule)
            if len(rule.head.parameters) == arity:
                made, behind = production(self._pool, self, place, number, rule, bound)
                numbers.append(len(self._productions))
                self._productions.append(made)
                self._changes.append(behind)
        return tuple(numbers)

    def _start(self) -> tuple[int, ast.Start]:
        found = list(self._main.items(ast.Start))
        if not found:
            raise fail(
                "no-start", f"{self._main.source.path} has no `start`: nothing says where to begin"
            )
        return found[-1]

    def _ignored(self) -> frozenset[int]:
        names = {
            spelling
            for _, item in self._main.items(ast.Ignore)
            for name in item.names
            for spelling in _spellings(name, OPERATIONS.get(name))
        }
        return frozenset(i for i, symbol in enumerate(self._symbols) if symbol.name in names)

    def _residual(self, flat: bool) -> ir.Residual | None:
        for number, item in self._main.items(ast.Residual):
            place = self._main.find(item.table)
            assert place is not None  # the checker has seen to it
            table = self._tables.number(place)
            mistyped = self._tables.mistyped(table, ir.RESIDUAL_TEXTS)
            if mistyped is not None:
                kinds = "texts" if mistyped in ir.RESIDUAL_TEXTS else "numbers"
                message = f"the column `{mistyped}` of a residual holds {kinds} alone"
                raise self._main.error(number, item.span, "wrong-type", message)
            if flat and "z" in self._tables.data[table].columns:
                message = "a residual in `z` needs a program in space, and nothing leaves the plane"
                raise self._main.error(number, item.span, "not-in-space", message)
            return ir.Residual(table)
        return None

    def _up(self) -> Literal["y-up", "z-up"]:
        items = [item for _, item in self._main.items(ast.Axes)]
        return items[-1].up if items else "z-up"

    def _refuse_options(self, number: int, start: ast.Start) -> None:
        options = {
            "on": None if start.place is None or start.place.kind != "surface" else start.place,
            "seeds": start.seeds, "direction": start.direction,
            "with": start.sites or None, "avoiding": start.avoiding, "retries": start.retries,
        }  # fmt: skip
        for word, value in options.items():
            if value is not None:
                message = f"`start … {word}` is not executable yet"
                self._note(self._main, number, start.span, f"start {word}", message)

    def _note(self, unit: Unit, item: int, span: ast.Span, what: str, message: str) -> None:
        self._refused.setdefault(what, []).append(
            unit.diagnostic(item, span, "not-executable", message)
        )

    def _refuse_misplaced(self, wrong: Misplaced | None, start: int) -> None:
        """Shapes with scopes expand one by one: what needs a string cannot stand among them."""
        if wrong is None:
            return
        production, place = wrong.production, wrong.place
        unit = next(
            (each for each in self._units if each.source.path == production.path), self._main
        )
        item = start if production.symbol < 0 else production.item
        span = unit.grammar.items[item].span if place is None else ast.Span(*place.span)
        message = f"{wrong.what} cannot stand in a rule that scopes come through"
        hint = "make a rule of its own of it, without operations on scopes: that is a string"
        if not wrong.what and place is not None:
            assert isinstance(place.const, int)
            name = self._symbols[place.const].name
            message = f"`{name}` moves the turtle for what stands behind it, and this rule is no "
            message += "string: scopes come through it"
            hint = f"put brackets around it, [ {name} ], or make a rule of its own of this part, "
            hint += "without operations on scopes"
        raise unit.error(item, span, "misplaced", message, hint)

    def _raise_refused(self) -> None:
        """One error an operation, at its first use; the others are counted."""
        if not self._refused:
            return
        errors = []
        for uses in self._refused.values():
            more = len(uses) - 1
            hint = f"and in {more:,} more place{'s' if more > 1 else ''}" if more else None
            errors.append(replace(uses[0], hint=hint))
        raise IpmError(errors)


def _table(unit: Unit, name: str) -> tuple[Place, ast.Table] | None:
    """A table with a column of symbols, and where it is written."""
    place = unit.find(name)
    item = None if place is None else place.unit.grammar.items[place.item]
    if place is None or not isinstance(item, ast.Table) or SHAPE not in item.columns:
        return None
    return place, item


def _shapes(found: tuple[Place, ast.Table]) -> tuple[Named, ...]:
    """The symbols that the rows of a table place, as the file of the table knows them."""
    place, table = found
    return tuple(Named(place.unit, name) for name in shapes_of(table))


def _terminal(symbol: ir.Symbol) -> ir.Symbol:
    """A symbol that nothing gives a meaning draws its own scope or geometry."""
    if symbol.meaning is not None or symbol.productions:
        return symbol
    return replace(symbol, meaning=(ir.Instruction("emit", const=-1),))


def _spellings(name: str, record: Operation | None) -> tuple[str, ...]:
    return (name,) if record is None else (record.name, *record.synonyms)
