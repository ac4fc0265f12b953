"""The frame of a random grammar: declarations, symbols with parameters, and their alternatives.

A symbol is written after those that it calls, so that what a call costs (about how many shapes it
makes) is known when a body spends its budget: every derivation ends, and stays small. A symbol that
makes itself counts its first parameter `n` down. A symbol that takes another, `sym`, places it at
a known cost, or hands it on. What stands in bodies is for the families to say.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

from tests.random_grammars.values import COLORS, TAKEN, Function, Value, Values

PARAMETERS = (
    Value("p", 0.2, 4.0),
    Value("q", -2.0, 3.0),
    Value("s", 0.2, 4.0, exact=False),
    Value("t", kind="text"),
    Value("g", kind="truth"),
)


TAKEN_SYMBOL = Value("sym", kind="symbol")
GIVEN_COST = 6  # a symbol that is given to another makes at most so many shapes

RARE = (
    "center", "mirrorScope", "alignScope", "rotateScope", "about:", "tag(", "label(", "report(",
    "UV", "texture(", "cylinder", "cone", "sphere", "octant", "subdivide", "setback", "offset",
    "shapeL", "scatter", "comp(edges)", "roof", "taper", "effect", "polygon {", "$", "css(",
    "split",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Symbol:
    """What can be called: `cost` is about how many shapes it makes, `most` the largest `n` that may
    be given. `form` is the geometry that its rules expect, "" any.
    """

    name: str
    parameters: tuple[Value, ...] = ()
    cost: int = 1
    most: int = 0
    form: str = ""


@dataclass(slots=True)
class Again:
    """The symbol whose rules are being written, and how often its body may still call it."""

    symbol: Symbol
    left: int


@dataclass(slots=True)
class Place:
    """Where a body is being written: what can be read and called, what may still be spent, and
    what geometry stands there. The body is there `share` times.
    """

    names: tuple[Value, ...]
    budget: int
    again: Again | None = None
    form: str = ""
    depth: int = 0
    share: int = 1
    start: int = field(init=False)

    def __post_init__(self) -> None:
        self.start = self.budget

    def inner(self, share: int = 1, *names: Value, form: str | None = None) -> Place:
        """A place inside braces or brackets."""
        return Place(
            (*self.names, *names),
            self.budget // share,
            self.again if share == 1 else None,
            self.form if form is None else form,
            self.depth + 1,
            share,
        )

    def settle(self, inner: Place) -> None:
        """Pay for what an inner place has spent."""
        self.budget -= (inner.start - inner.budget) * inner.share


@dataclass(slots=True)
class Writer:
    """One grammar under construction."""

    draw: Random
    largest: int = 800
    lines: list[str] = field(default_factory=list)
    names: list[Value] = field(default_factory=list)
    tables: list[tuple[str, tuple[Value, ...], int]] = field(default_factory=list)
    symbols: list[Symbol] = field(default_factory=list)
    settable: list[str] = field(default_factory=list)
    risk: float = 0.0
    given: tuple[str, ...] = ()  # terminals that may be given to symbols; without any, none takes
    values: Values = field(init=False)
    dropped: tuple[str, ...] = field(init=False)
    aside: Random = field(init=False)  # for symbols as arguments: all else is drawn as without

    def __post_init__(self) -> None:
        self.values = Values(self.draw, self.risk)
        self.aside = Random(str(self.draw.getstate()[1][:3]))
        share = self.draw.choice((0.2, 0.7, 0.95))
        self.dropped = tuple(word for word in RARE if self.draw.random() < share)

    def choice(self, options: Sequence[str]) -> str | None:
        """One of these texts, without what this grammar goes without: some use few operations."""
        kept = [each for each in options if not any(word in each for word in self.dropped)]
        return self.draw.choice(kept) if kept else None

    # ------------------------------------------------------------------- declarations

    def declare(self) -> None:
        """Attributes, constants, functions and tables."""
        draw, values = self.draw, self.values
        for name in "ab"[: draw.randrange(3)]:
            drawn = values.number(0.3, 3.5, self.names, exact=True)
            self.lines.append(f"attr {name} : float = {drawn} in 0.1..5")
            self.names.append(Value(name, 0.1, 5))
            self.settable.append(name)
        if draw.random() < 0.3:
            self.lines.append(f"attr m : int = {values.whole(1, 4)} in 0..6")
            self.names.append(Value("m", 0, 6))
        if draw.random() < 0.2:
            self.lines.append(f"attr lit = {draw.choice(('true', 'false', 'rand() < 0.5'))}")
            self.names.append(Value("lit", kind="truth"))
        if draw.random() < 0.25:
            self.lines.append('attr hue : string = "#f00" in { "#f00", "teal", "#2a6f4e" }')
            self.names.append(Value("hue", kind="text"))
        if draw.random() < 0.4:
            self.lines.append(f"const c = {values.number(0.3, 3, (), fixed=True, exact=True)}")
            self.names.append(Value("c", 0.3, 3))
        for number in range(draw.choice((0, 0, 1, 2))):
            self._function(number)
        if draw.random() < 0.4:
            self._table()
        if draw.random() < 0.12:
            nearest = draw.choice(("", " nearest"))
            self.lines.append(f'context mask = "mask.png" over (-9, -9, 18, 18){nearest}')
            asked = f"fetch(mask, {draw.randint(-9, 9)}, 2.3, {draw.randint(0, 2)})"
            self.names.append(Value(asked, 0, 1, exact=False))

    def _function(self, number: int) -> None:
        exact = self.draw.random() < 0.6
        arity = self.draw.randint(1, 2)
        own = tuple(Value(name, *TAKEN) for name in ("p", "q")[:arity])
        known = [each for each in self.names if each.text != "m"]  # it would make whole numbers
        others, self.values.functions = self.values.functions, []  # a call fixes its types
        text = self.values.number(0, 6, (*own, *known), exact, fixed=True)
        self.values.functions = others
        parameters = ", ".join(each.text for each in own)
        name = f"fn{number}"
        self.lines.append(f"fn {name}({parameters}) = {text}")
        self.values.functions.append(Function(name, arity, Value("", 0, 6, exact)))

    def _table(self) -> None:
        draw = self.draw
        rows = []
        count = draw.randint(1, 5)
        for _ in range(count):
            u, v = (round(draw.uniform(-2, 3), 2) for _ in range(2))
            rows.append(f'({u}, {v}, {draw.choice((0, 90, 17.5))}, "{draw.choice(COLORS)}")')
        self.lines.append(f"table Rows(u, v, w, h) = {', '.join(rows)}")
        columns = (Value("r.u", -2, 3), Value("r.v", -2, 3), Value("r.w", 0, 90),
                   Value("r.h", kind="text"))  # fmt: skip
        self.tables.append(("Rows", columns, count))

    # ------------------------------------------------------------------------- symbols

    def symbol(self, name: str, budget: int, form: str = "", recursive: float = 0.35) -> Symbol:
        """Write all rules of a new symbol, which may cost about so much."""
        draw = self.draw
        own = tuple(each for each in PARAMETERS if draw.random() < 0.25)
        again = draw.random() < recursive
        most = draw.choice((2, 3, 4, 9)) if again else 0
        if again or draw.random() < 0.3:
            own = (Value("n", 0, max(most, 4)), *own)
        if self.given and self.aside.random() < 0.3:
            own = (*own, TAKEN_SYMBOL)
        calls = 1 if most > 4 else draw.choice((1, 2, 2, 3)) if again else 0
        calls = min(calls, 2) if most == 4 else calls
        inside = sum(calls**k for k in range(most + 1)) if again else 1
        known = Symbol(name, own, budget, most if again else 4, form)
        place = Place((*self.names, *own), budget // inside, form=form)
        cost = max(1, *self._rules(known, place, calls)) * inside
        made = Symbol(name, own, cost, known.most, form)
        self.symbols.append(made)
        return made

    def _rules(self, symbol: Symbol, place: Place, calls: int) -> list[int]:
        head = symbol.name
        if symbol.parameters:
            head += f"({', '.join(each.text for each in symbol.parameters)})"
        guards = self._guards(place, calls > 0)
        costs = []
        for number, guard in enumerate(guards):
            again = calls > 0 and number < len(guards) - 1
            own = Place(place.names, place.budget, form=place.form)
            own.again = Again(symbol, calls) if again else None
            body = self.body(own)
            if TAKEN_SYMBOL in symbol.parameters and number == len(guards) - 1:
                body += f" [{TAKEN_SYMBOL.text}]"  # a rule that places none takes none
                own.budget -= GIVEN_COST
            self.lines.append(f"{head}{guard} --> {body}".rstrip())
            costs.append(own.start - own.budget)
        return costs

    def _guards(self, place: Place, again: bool) -> tuple[str, ...]:
        """Guards of the alternatives of a symbol; the last one is not recursive."""
        draw, values = self.draw, self.values
        if self.risk and draw.random() < 0.5:
            risky = values.risky(place.names)
            return (f" : n > 0 and {risky}" if again else f" : {risky}", " : else")
        if again:
            weight = values.number(0.2, 4, place.names, exact=True)
            return draw.choice(
                (
                    (" : n > 0", " : else"),
                    (" : n > 0", " : else"),
                    (" : n > 0 : 60%", " : n > 0 : 30%", " : else"),
                    (" : n > 0 : weight 2", f" : n > 0 : weight {weight}", " : n <= 0"),
                    (" : n > 0 and rand() < 0.9", " : else"),
                )
            )
        guard = values.condition(place.names)
        percent = values.number(0, 60, place.names, exact=True)
        return draw.choice(
            (
                ("",),
                ("",),
                (f" : {guard}", " : else"),
                (" : 35%", f" : {guard} : 30%", " : else"),
                (f" : {guard} : ({percent})%", " : else"),
                (" : weight 2", f" : weight {values.number(0.1, 3, place.names, exact=True)}"),
                (f" : {guard} : weight 1", " : weight 0.5", " : weight 2.5"),
            )
        )

    @abstractmethod
    def body(self, place: Place) -> str:
        """Elements, for the family to say; what it spends goes off the budget of the place."""

    # --------------------------------------------------------------------------- calls

    def call(self, place: Place, among: Sequence[Symbol] | None = None) -> str | None:
        """A call of a symbol that fits the form and the budget, or of the symbol itself."""
        draw = self.draw
        placing = among is None and TAKEN_SYMBOL in place.names and place.budget >= GIVEN_COST
        if placing and self.aside.random() < 0.5:
            place.budget -= GIVEN_COST
            return TAKEN_SYMBOL.text
        known = self.symbols if among is None else among
        fitting = [
            each for each in known if each.cost <= place.budget and each.form in ("", place.form)
        ]
        again = place.again
        possible = again and again.left and again.symbol.form in ("", place.form)
        if again and possible and (not fitting or draw.random() < 0.6):
            again.left -= 1
            return self._given(again.symbol, place, f"n - {draw.choice((1, 1, 1, 2))}")
        if not fitting:
            return None
        chosen = draw.choice(fitting)
        place.budget -= chosen.cost
        return self._given(chosen, place)

    def _given(self, symbol: Symbol, place: Place, first: str = "") -> str:
        """A call with its arguments."""
        given = [self._argument(each, symbol, place, first) for each in symbol.parameters]
        return f"{symbol.name}({', '.join(given)})" if given else symbol.name

    def _argument(self, parameter: Value, symbol: Symbol, place: Place, first: str) -> str:
        values = self.values
        match parameter.kind:
            case "text":
                return values.text(place.names)
            case "truth":
                return values.condition(place.names, 1)
            case "symbol":
                return self._symbol_given(place)
            case _ if parameter.text == "n":
                return first or values.whole(0, symbol.most, place.names)
            case _:
                return values.number(
                    parameter.low, parameter.high, place.names, exact=parameter.exact
                )

    def _symbol_given(self, place: Place) -> str:
        """A terminal, a symbol without parameters, the one that was taken, or one of two."""
        small = (
            each.name
            for each in self.symbols
            if not each.parameters and not each.form and each.cost <= GIVEN_COST
        )
        taken = [TAKEN_SYMBOL.text] * 2 if TAKEN_SYMBOL in place.names else []
        known = [*self.given, *small, *taken]
        one, other = self.aside.choice(known), self.aside.choice(known)
        if self.aside.random() < 0.7:
            return one
        counted = [each.text for each in place.names if each.text == "n"]
        condition = self.aside.choice(("rand() < 0.4", *(f"{each} > 1" for each in counted)))
        return f"if {condition} then {one} else {other}"

    def several(self, place: Place, step: str) -> str | None:
        """Copies of a symbol, each a `step` further: as many as the budget allows."""
        fitting = [each for each in self.symbols if each.form in ("", place.form)]
        if not fitting:
            return None
        chosen = self.draw.choice(fitting)
        count = min(self.draw.choice((1, 3, 5, 12)), max(1, place.budget // chosen.cost))
        inner = place.inner(count, *([Value("k", 0, count)] if count > 1 else []))
        found = self._given(chosen, inner)
        place.budget -= chosen.cost * count
        return f"repeat(k < {count}) {{ {step} [{found}] }}" if count > 1 else f"[{found}]"

    # ------------------------------------------------------------- what all bodies share

    def named(self, place: Place) -> str:
        """A local name, which later elements of the body can read."""
        name = f"w{len(place.names)}"
        exact = self.draw.random() < 0.6
        value = self.values.number(0.2, 4, place.names, exact)
        place.names = (*place.names, Value(name, 0.2, 4, exact))
        return f"with ({name} = {value})"

    def setting(self, place: Place) -> str | None:
        """An attribute that is set for what follows."""
        if not self.settable:
            return None
        name = self.draw.choice(self.settable)
        return f"set ({name} = {self.values.number(0.1, 5, place.names, exact=True)})"

    def copies(self, place: Place) -> tuple[str, Place]:
        """The head of a `repeat` and the place of its body."""
        draw = self.draw
        most = draw.choice((2, 3, 4))
        if self.tables and draw.random() < 0.3:
            name, columns, count = draw.choice(self.tables)
            renamed = f"r{place.depth}"
            own = [
                Value(each.text.replace("r.", f"{renamed}."), each.low, each.high, True, each.kind)
                for each in columns
            ]
            return f"repeat({renamed} in {name})", place.inner(count + 1, *own)
        index = f"i{place.depth}"
        count = self.values.whole(draw.choice((0, 1, 2)), most, place.names)
        holes = draw.choice(("", "", "", " except (1)", f" except (0, {draw.randint(1, 2)})"))
        inner = place.inner(most, Value(index, 0, most))
        return f"repeat({index} < {count}){holes}", inner
