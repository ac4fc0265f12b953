"""Turtles in a program with scopes: which symbols are derived as strings of their own.

In go symbols and productions, out come flags, and what no string can hold because it stands among
operations on scopes. Shapes with scopes expand one by one; what carries on behind a rule, looks at
its neighbours, is cut, bent, filled or one path needs the whole string around it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ipmlang.compiler import ir
from ipmlang.compiler.lower.analysis import Analysis

OUTLINES = frozenset({"polygon_open", "polygon_close", "path_open", "path_close", "vertex"})
# what a turtle of a string can do, and the fields of its pen
TURTLE = frozenset({
    "move", "rotate", "orient", "scale", "mirror", "level", "segment", "emit", "layer", "cut",
}) | OUTLINES  # fmt: skip
PENS = frozenset({"width", "color", "fill", "stroke", "css", "material", "texture"})
VALUES = ir.VALUE_OPS - ir.SCOPE_OPS
BODIES = frozenset({"module", "open", "close", "repeat"})
PLAIN = VALUES | BODIES


@dataclass(frozen=True, slots=True)
class Misplaced:
    """What stands in a rule with scopes and needs a string: where, and what is wrong with it."""

    production: ir.Production
    place: ir.Instruction | None
    what: str


class Strings:
    """Which symbols are strings of their own; `bent`: there is a tropism."""

    def __init__(
        self,
        symbols: Sequence[ir.Symbol],
        productions: Sequence[ir.Production],
        found: Analysis,
        bent: bool,
    ) -> None:
        self._symbols = symbols
        self._productions = productions
        self._found = found
        self._bent = bent
        self._what: dict[int, str | None] = {}  # what modules of symbols need a string for
        self._trouble: dict[int, Misplaced | None] = {}
        self._some_need = any(self._needs_string(number) for number in range(len(symbols)))
        self._code = {id(each): _code(each) for each in productions}
        own = [self._own(symbol) for symbol in symbols]
        children = [
            {number for rule in every for number in _called(self._code[id(rule)])} for every in own
        ]
        plain = [self._is_plain(*pair) for pair in zip(symbols, own, strict=True)]
        mixed = _closed([not each for each in plain], children)
        needs = _closed([any(map(self._needs, every)) for every in own], children)
        pairs = zip(needs, mixed, own, strict=True)
        self.apart = [bool(every) and need and not other for need, other, every in pairs]

    def misplaced(self, axiom: ir.Production) -> Misplaced | None:
        """The first thing that needs a string where there is none."""
        for each in (axiom, *self._productions):
            if each.symbol < 0 or not self.apart[each.symbol]:
                wrong = self._wrong(each)
                if wrong is not None:
                    return wrong
        return None

    def _own(self, symbol: ir.Symbol) -> list[ir.Production]:
        numbers = symbol.productions + symbol.interpretation
        return [self._productions[number] for number in numbers]

    def _is_plain(self, symbol: ir.Symbol, own: Sequence[ir.Production]) -> bool:
        """Whether a turtle alone can do what a symbol says itself."""
        meaning = symbol.meaning or ()
        return (
            not (symbol.held and meaning)
            and all(map(_is_turtles, meaning))
            and all(each.op in PLAIN for rule in own for each in self._code[id(rule)])
        )

    def _needs(self, production: ir.Production) -> bool:
        return self._wrong(production) is not None

    def _wrong(self, production: ir.Production) -> Misplaced | None:
        """What in a production needs a string around it, looked for once."""
        if id(production) not in self._trouble:
            self._trouble[id(production)] = self._found_wrong(production)
        return self._trouble[id(production)]

    def _found_wrong(self, production: ir.Production) -> Misplaced | None:
        if production.left or production.right:
            return Misplaced(production, None, "a context")
        code = self._code.get(id(production)) or _all(production.body)
        for each in code if self._some_need else ():
            what = self._needed(_number(each)) if each.op == "module" else None
            if each.op == "repeat" and self._levels(each.body):
                what = "a `repeat` that levels the turtle"  # which no scan over copies can do
            if what is not None:
                return Misplaced(production, each, what)
        child = self._found.threads(production.body)
        return None if child is None else Misplaced(production, child, "")

    def _needs_string(self, number: int) -> bool:
        """Whether a module of a symbol needs a string around it, or may in a repeat."""
        meaning = self._symbols[number].meaning or ()
        return self._needed(number) is not None or any(each.op == "level" for each in meaning)

    def _levels(self, body: Sequence[ir.Instruction]) -> bool:
        """Whether a copy hands a levelled turtle on to the next."""
        depth = 0
        for each in body:
            depth += (each.op == "open") - (each.op == "close")
            if depth == 0 and each.op == "module":
                meaning = self._symbols[_number(each)].meaning or ()
                if any(step.op == "level" for step in meaning):
                    return True
        return False

    def _needed(self, number: int) -> str | None:
        """What a module of a symbol needs a string for, in the words of the message."""
        if number not in self._what:
            self._what[number] = self._need_of(self._symbols[number])
        return self._what[number]

    def _need_of(self, symbol: ir.Symbol) -> str | None:
        """The same for its symbol."""
        ops = {each.op for each in symbol.meaning or ()}
        if ops & {"path_open", "path_close"}:
            return "a path of the turtle"
        if ops & OUTLINES:
            return "a polygon of the turtle"
        if "cut" in ops:
            return "`cut`"
        if self._bent and "segment" in ops:
            return "a segment that a tropism bends"
        if any(each.left or each.right for each in self._own(symbol)):
            return f"`{symbol.name}`, whose rules look at what stands beside it,"
        return None


def _closed(flags: Sequence[bool], children: Sequence[set[int]]) -> list[bool]:
    """Flags that hold for all from which they can be reached."""
    parents: list[list[int]] = [[] for _ in flags]
    for number, below in enumerate(children):
        for each in below:
            parents[each].append(number)
    found = list(flags)
    waiting = [number for number, flag in enumerate(flags) if flag]
    while waiting:
        for each in parents[waiting.pop()]:
            if not found[each]:
                found[each] = True
                waiting.append(each)
    return found


def _is_turtles(each: ir.Instruction) -> bool:
    if each.op == "pen":
        return isinstance(each.const, tuple) and each.const[0] in PENS
    return each.op in VALUES or each.op in TURTLE


def _code(production: ir.Production) -> list[ir.Instruction]:
    """All instructions of a production, its conditions first."""
    guard = () if production.guard is None else production.guard[0]
    chance = () if production.chance is None else production.chance[1]
    return _all((*guard, *chance, *production.body))


def _all(code: Sequence[ir.Instruction]) -> list[ir.Instruction]:
    found = []
    for each in code:
        found.append(each)
        if each.body:
            found += _all(each.body)
    return found


def _called(code: Sequence[ir.Instruction]) -> Iterator[int]:
    """The symbols of modules; conditions have none."""
    return (_number(each) for each in code if each.op == "module")


def _number(each: ir.Instruction) -> int:
    assert isinstance(each.const, int)
    return each.const
