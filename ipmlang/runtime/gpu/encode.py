"""A program as bytecode: what each symbol becomes, in words that one shader runs.

In goes a program with the fields of its state, out come code, numbers, and for every symbol that
the CPU must derive the reason. Nothing is compiled here, so that an edit costs what it changes.
Symbols without productions are written out in place, as the frontier does; copies that leave the
state alone become blocks of their own, which as many threads run.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime.gpu.elements import OWN, Elements
from ipmlang.runtime.gpu.isa import LONG, NONE, ON_CPU, WORDS, Op
from ipmlang.runtime.gpu.registers import Names, Room
from ipmlang.runtime.gpu.sampling import Sample
from ipmlang.runtime.gpu.unsupported import UnsupportedError
from ipmlang.runtime.gpu.words import Calls, Faces, Words
from ipmlang.runtime.numpy_backend import is_independent
from ipmlang.runtime.queries.marks import asked

MEANING = -2  # what is written where no production is
WHOLE = frozenset({"phase"})  # what one rule does concerns all shapes


@dataclass(frozen=True, slots=True)
class Reason:
    """Why the CPU derives a production: what of it the GPU has no body for. `production` is -1 for
    the axiom, MEANING for an operation by itself, and None where it is the whole program.
    """

    production: int | None
    what: str
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """A program as words: `symbols` and `blocks` are where in the code their entries begin, `faces`
    the parts whose faces are listed when the geometries are known, `samples` what is fetched,
    `parameters` how many numbers beside its state a record has, `capable` the symbols that run
    here, `extruded` where the data has the number of the box that `extrude` makes, or -1; `axiom`
    is where its code begins, None: it is the CPU's, and `registers` how many a body needs;
    `resumable`: bodies may be broken off.
    """

    code: NDArray[np.uint32]
    data: NDArray[np.float64]
    symbols: int
    blocks: int
    faces: tuple[Faces, ...]
    samples: tuple[Sample, ...]
    parameters: int
    capable: frozenset[int]
    extruded: int
    axiom: int | None
    registers: int
    resumable: bool
    reasons: tuple[Reason, ...]


class _Kept:
    """The last programs that were encoded in this process, with what was asked."""

    programs: ClassVar[deque[tuple[ir.Program, tuple[object, ...], Encoded]]] = deque(maxlen=8)


def kept(
    program: ir.Program, fields: Sequence[str], attrs: int, texels: Sequence[int], calls: Calls
) -> Encoded:
    """The same as `encode`, once for all runs of a program, whatever the values of its attributes;
    nobody may write to it.
    """
    asked_for = (tuple(fields), attrs, tuple(texels), calls)
    for own, key, found in tuple(_Kept.programs):
        if key == asked_for and _is_same(own, program):
            return found
    made = encode(program, fields, attrs, texels, calls)
    _Kept.programs.append((program, asked_for, made))
    return made


def _is_same(one: ir.Program, other: ir.Program) -> bool:
    """Whether two programs are one with other values for its attributes."""
    parts = ("symbols", "productions", "axiom", "tables")
    same = all(getattr(one, part) is getattr(other, part) for part in parts)
    return same and (one.strings, one.tropism) == (other.strings, other.tropism)


def calls_of(program: ir.Program) -> Calls:
    """What becomes of children: calls that change the turtle where modules thread."""
    return "none" if program.scoped or is_independent(program) else "threads"


def encode(
    program: ir.Program, fields: Sequence[str], attrs: int, texels: Sequence[int] = (),
    calls: Calls = "none",
) -> Encoded:  # fmt: skip
    """The bytecode of a program whose state has these fields and that has so many attributes.
    `texels`: how many each of its contexts has, where that is known; `calls`: what becomes of
    children.
    """
    words = Words(program, tuple(fields), attrs, texels, calls)
    whole = refused(program)
    reasons = list(whole)
    entries: list[int] = []
    capable = set()
    for number, symbol in enumerate(program.symbols):
        found = None if whole else _symbol(words, number, reasons)
        if found is not None:
            capable.add(number)
        own = (symbol.productions, symbol.interpretation, symbol.meaning)
        codes = found or tuple(0 if each else NONE for each in own)
        entries += [*codes, 0 if found else ON_CPU, symbol.arity]
    axiom = None if whole else _axiom(words, reasons)
    code, symbols, blocks, faces, samples = words.finished(entries)
    parameters = max([words.widest, *(symbol.arity for symbol in program.symbols)])
    if words.resumable:
        parameters = max(parameters, words.registers)
    return Encoded(
        np.array(code, np.uint32), np.array(words.data, np.float64),
        symbols, blocks, faces, samples, parameters,
        frozenset(capable), words.extrusion, axiom, words.registers, words.resumable,
        tuple(dict.fromkeys(reasons)),
    )  # fmt: skip


def refused(program: ir.Program) -> tuple[Reason, ...]:
    """Why no rule of a program can run on the GPU; nothing where some may."""
    reasons = []
    if asked(program) is not None:
        reasons.append(Reason(None, "query", "its rules ask about other shapes"))
    if program.tropism is not None:
        reasons.append(Reason(None, "tropism", "branches bend by where they head"))
    if any(each.op in WHOLE for symbol in program.symbols for each in symbol.meaning or ()):
        reasons.append(Reason(None, "phase", "shapes wait for phases"))
    return tuple(reasons)


def _axiom(words: Words, reasons: list[Reason]) -> int | None:
    """The code of the start; None, and a reason, where the CPU derives it."""
    mark = words.mark()
    try:
        return _body(words, -1, words.program.axiom)
    except UnsupportedError as found:
        words.back(mark)
        reasons.append(Reason(-1, found.what, found.why))
        return None


def _symbol(words: Words, number: int, reasons: list[Reason]) -> tuple[int, int, int] | None:
    """The code of a symbol: of its productions, its interpretations and its meaning; None, and a
    reason, where the CPU derives it.
    """
    symbol = words.program.symbols[number]
    mark = words.mark()
    try:
        if symbol.apart:
            words.production = symbol.productions[0]
            raise UnsupportedError(symbol.name, "it is derived as a string of its own")
        productions, interpretations = (
            _choice(words, number, each) if each else NONE
            for each in (symbol.productions, symbol.interpretation)
        )
        return productions, interpretations, _meaning(words, symbol, number)
    except UnsupportedError as found:
        words.back(mark)
        reasons.append(Reason(words.production, found.what, found.why))
        return None


def _meaning(words: Words, symbol: ir.Symbol, number: int) -> int:
    if not symbol.meaning:
        return NONE
    words.production = MEANING
    start = words.here
    room = Room(words.fields, symbol.arity)
    Elements(words, room).acts(symbol.meaning, number, OWN, Names(room.own()))
    words.put(Op.END)
    return start


def _choice(words: Words, symbol: int, productions: Sequence[int]) -> int:
    """The code that chooses among productions as they are written, and theirs."""
    alternatives = [(each, words.program.productions[each]) for each in productions]
    for number, production in alternatives:
        if production.left or production.right:
            words.production = number
            raise UnsupportedError("context", "its neighbours in the string decide")
    bodies = [(_body(words, *each), each[0]) for each in alternatives]
    first = alternatives[0][1]
    if first.guard is None and first.chance is None:
        return bodies[0][0]
    start = words.here
    weights: int | None = None
    taking: list[int] = []
    for place, (number, production) in enumerate(alternatives):
        if _weighted(production) and weights is None:
            weights = _total(words, alternatives)
        words.production = number
        elements = Elements(words, Room(words.fields, production.parameters, reserved=1))
        skip = _guarded(words, elements, production)
        if production.chance is None:
            taking.append(words.put(Op.TAKE, z=place))
        else:
            words.put(Op.SHARE, a=_share(words, elements, production, weights), z=place)
        if skip is not None:
            words.patch(skip, 2)
    for at in taking:
        words.patch(at, 3)
    words.choose(symbol, bodies)
    return start


def _guarded(words: Words, elements: Elements, production: ir.Production) -> int | None:
    """Code that skips what follows where a guard does not hold; the instruction to patch."""
    if production.guard is None:
        return None
    held = elements.values(*production.guard)
    return words.put(Op.ZERO, a=held)


def _weighted(production: ir.Production) -> bool:
    return production.chance is not None and production.chance[0] == "weight"


def _total(words: Words, alternatives: Sequence[tuple[int, ir.Production]]) -> int:
    """Code that adds up the weights of what may be taken; the register that has the sum."""
    weighted = [(number, each) for number, each in alternatives if _weighted(each)]
    total = len(words.fields) + weighted[0][1].parameters
    words.put(Op.LOAD, out=total, z=words.constant(0.0))
    for number, production in weighted:
        words.production = number
        room = Room(words.fields, production.parameters, reserved=1)
        elements = Elements(words, room)
        skip = _guarded(words, elements, production)
        assert production.chance is not None
        weight = elements.values(production.chance[1], production.chance[2])
        words.put(Op.CHECK, a=weight, n=2)
        elements.called("add", total, (total, weight))
        if skip is not None:
            words.patch(skip, 2)
    return total


def _share(words: Words, elements: Elements, production: ir.Production, total: int | None) -> int:
    """Code for the chance of a production; its register."""
    assert production.chance is not None
    kind, code, out = production.chance
    amount = elements.values(code, out)
    made = elements.room.new()
    if kind == "percent":
        hundred = elements.room.new()
        words.put(Op.LOAD, out=hundred, z=words.constant(100.0))
        elements.called("div", made, (amount, hundred))
        return made
    assert total is not None
    words.put(Op.COPY, out=made, a=amount)
    skip = words.put(Op.ZERO, a=total)
    elements.called("div", made, (amount, total))
    words.patch(skip, 2)
    return made


def _body(words: Words, number: int, production: ir.Production) -> int:
    """The code of a production's body."""
    words.production = number
    start = words.here
    words.put(Op.RULE, z=number)
    room = Room(words.fields, production.parameters)
    Elements(words, room).production(production.body)
    words.put(Op.END)
    if (words.here - start) // WORDS > LONG:
        words.resumable = True
    return start
