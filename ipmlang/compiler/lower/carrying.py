"""Attributes that a `set` changes: carried down the derivation as parameters that nobody wrote.

In go symbols and productions as they were lowered, and which modules stand behind a `set` of which
attribute; out come the same with one more parameter, at the end, for each changed attribute that a
symbol or anything that it may become reads. Executors know parameters and nothing else: a value is
seen by all descendants of the body that set it and by no one beside them. Where nothing is set,
nothing changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from ipmlang.compiler import ir

# of one production: the site of a module -> attribute -> the register that holds its new value
Changes: TypeAlias = Mapping[int, Mapping[int, int]]
Code: TypeAlias = tuple[ir.Instruction, ...]


@dataclass(frozen=True, slots=True)
class Carried:
    """The symbols and productions of a program that carries what is set; `varied`: the attributes
    that are parameters of the axiom.
    """

    symbols: tuple[ir.Symbol, ...]
    productions: tuple[ir.Production, ...]
    axiom: ir.Production
    varied: tuple[int, ...] = ()


def carried(
    symbols: Sequence[ir.Symbol],
    productions: Sequence[ir.Production],
    axiom: ir.Production,
    changes: Sequence[Changes],
    varied: Sequence[int] = (),
) -> Carried:
    r"""The program with its changed attributes as parameters; the last of `changes` is the axiom's.

    `varied` are attributes that each first shape has a value of its own for, as if a `set` stood in
    front of the axiom: those that it needs are its parameters.

    >>> from ipmlang.compiler import compile_text
    >>> text = "ipm 1\nattr d = 1\nA --> F(d)\nB --> F(2)\nstart A [set d = 3 A] B\n"
    >>> [(each.name, each.arity, each.carried) for each in compile_text(text)[1].symbols]
    [('A', 1, 1), ('B', 0, 0), ('F', 1, 0)]
    """
    settable = {attr for own in changes for behind in own.values() for attr in behind}
    settable |= set(varied)
    if not settable:
        return Carried(tuple(symbols), tuple(productions), axiom)
    needs = _needs(symbols, productions, changes, settable)
    told = tuple(sorted(_of_axiom(axiom, needs, changes[-1]) & set(varied)))
    made = tuple(
        _production(production, needs, own, _own(symbols, production, needs))
        for production, own in zip(productions, changes, strict=False)
    )
    return Carried(
        tuple(_symbol(*pair) for pair in zip(symbols, needs, strict=True)),
        made,
        _production(axiom, needs, changes[-1], (0, told)),
        told,
    )


Needs: TypeAlias = Sequence[Sequence[int]]  # by symbol, the attributes that it carries, ascending


def _needs(
    symbols: Sequence[ir.Symbol],
    productions: Sequence[ir.Production],
    changes: Sequence[Changes],
    settable: set[int],
) -> Needs:
    """What each symbol must be told: what it reads, and what its children must be told by it."""
    needs = [set(_reads(symbol.meaning or ())) & settable for symbol in symbols]
    for production in productions:
        needs[production.symbol] |= set(_reads(_code(production))) & settable
    edges = [
        (production.symbol, _number(each), own.get(each.site, {}).keys())
        for production, own in zip(productions, changes, strict=False)
        for each in _all(production.body)
        if each.op == "module"
    ]
    growing = True
    while growing:
        growing = False
        for parent, child, known in edges:
            missing = needs[child] - known - needs[parent]
            if missing:
                needs[parent] |= missing
                growing = True
    return [sorted(each) for each in needs]


def _of_axiom(axiom: ir.Production, needs: Needs, changes: Changes) -> set[int]:
    """What the axiom must be told."""
    found = set(_reads(axiom.body))
    for each in _all(axiom.body):
        if each.op == "module":
            found |= set(needs[_number(each)]) - changes.get(each.site, {}).keys()
    return found


def _own(
    symbols: Sequence[ir.Symbol], production: ir.Production, needs: Needs
) -> tuple[int, Sequence[int]]:
    """How many parameters the symbol of a production has, and what it carries."""
    return symbols[production.symbol].arity, needs[production.symbol]


def _symbol(symbol: ir.Symbol, needs: Sequence[int]) -> ir.Symbol:
    if not needs:
        return symbol
    places = {attr: symbol.arity + number for number, attr in enumerate(needs)}
    meaning = None if symbol.meaning is None else _read_from(symbol.meaning, places)
    return replace(symbol, arity=symbol.arity + len(needs), carried=len(needs), meaning=meaning)


def _production(
    production: ir.Production,
    needs: Needs,
    changes: Changes,
    carries: tuple[int, Sequence[int]],
) -> ir.Production:
    """A production whose modules are told what they need; it reads its own from its parameters."""
    arity, own = carries
    first = sum(map(_captured, production.left)) + arity
    places = {attr: first + number for number, attr in enumerate(own)}
    told = _Told(production.registers, needs, changes)
    body = told.body(_shifted(production.body, first, len(own)))
    return replace(
        production,
        body=_read_from((*told.loads(), *body), places),
        registers=production.registers + len(told.registers),
        parameters=production.parameters + len(own),
        guard=_condition(production.guard, first, places),
        chance=_chance(production.chance, first, places),
    )


class _Told:
    """The modules of one body with one more argument for each attribute that their symbols carry.

    `registers`: attributes as the body found them, loaded once in front of it.
    """

    def __init__(self, first: int, needs: Needs, changes: Changes) -> None:
        self._first = first
        self._needs = needs
        self._changes = changes
        self.registers: dict[int, int] = {}

    def body(self, code: Code) -> Code:
        return tuple(self._one(each) for each in code)

    def loads(self) -> Code:
        return tuple(ir.Instruction("attr", out, const=a) for a, out in self.registers.items())

    def _one(self, each: ir.Instruction) -> ir.Instruction:
        if each.body:
            return replace(each, body=self.body(each.body))
        if each.op != "module":
            return each
        known = self._changes.get(each.site, {})
        more = [known.get(attr, self._before(attr, known)) for attr in self._needs[_number(each)]]
        return replace(each, args=(*each.args, *more)) if more else each

    def _before(self, attr: int, known: Mapping[int, int]) -> int:
        if attr in known:
            return known[attr]
        return self.registers.setdefault(attr, self._first + len(self.registers))


def _condition(
    code: tuple[Code, int] | None, first: int, places: Mapping[int, int]
) -> tuple[Code, int] | None:
    if code is None:
        return None
    return _read_from(_shifted(code[0], first, len(places)), places), code[1]


def _chance(chance: ir.Chance | None, first: int, places: Mapping[int, int]) -> ir.Chance | None:
    if chance is None:
        return None
    kind, code, register = chance
    return kind, _read_from(_shifted(code, first, len(places)), places), register


def _shifted(code: Code, first: int, count: int) -> Code:
    """Parameters of the right context stand behind those that are carried."""
    if not count:
        return code
    return tuple(
        replace(
            each,
            const=_number(each) + count if each.op == "param" and _number(each) >= first
            else each.const,
            body=_shifted(each.body, first, count),
        )
        for each in code
    )  # fmt: skip


def _read_from(code: Code, places: Mapping[int, int]) -> Code:
    """Code that reads attributes from the parameters that carry them."""
    if not places:
        return code
    return tuple(
        replace(each, op="param", const=places[_number(each)])
        if each.op == "attr" and _number(each) in places
        else replace(each, body=_read_from(each.body, places))
        for each in code
    )


def _captured(pattern: ir.Pattern) -> int:
    """How many parameters a module of a context brings, or a branch of them."""
    return sum(map(_captured, pattern.branch)) if pattern.branch else pattern.arity


def _reads(code: Iterable[ir.Instruction]) -> Iterator[int]:
    return (_number(each) for each in _all(code) if each.op == "attr")


def _code(production: ir.Production) -> Code:
    """All code of a production: guard, chance and body."""
    guard = () if production.guard is None else production.guard[0]
    chance = () if production.chance is None else production.chance[1]
    return (*guard, *chance, *production.body)


def _all(code: Iterable[ir.Instruction]) -> Iterator[ir.Instruction]:
    for each in code:
        yield each
        yield from _all(each.body)


def _number(each: ir.Instruction) -> int:
    assert isinstance(each.const, int)
    return each.const
