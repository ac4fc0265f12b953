"""What a lowered program is: which symbols move the turtle, whether it threads, whether it is flat.

In go symbols and productions, out come flags. A body is read backwards: the state is live where
something that follows in the same bracket reads it. A child that moves where the state is live
threads; one that is last in its bracket, or at the end of a body that is itself used so, does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ipmlang.compiler import ir

READS = frozenset({
    "segment", "emit", "vertex", "polygon_open", "polygon_close", "path_open", "path_close", "cut",
})  # fmt: skip
MOTIONS = frozenset({"move", "rotate", "orient", "scale", "mirror", "level", "segment"})
MOVES = MOTIONS | {"pen", "layer"}


class Analysis:
    """The fixed points over the symbols of a program. In one with scopes the pen ends with the body
    of its rule, as scopes do. `threading`: the child that was found last to thread.
    """

    def __init__(
        self,
        symbols: Sequence[ir.Symbol],
        productions: Sequence[ir.Production],
        stepped: bool,
        scoped: bool = False,
    ) -> None:
        self.threading: ir.Instruction | None = None
        self._motions = MOTIONS if scoped else MOVES
        self._symbols = symbols
        self._productions = productions
        self._bodies = [self._own_bodies(symbol, stepped) for symbol in symbols]
        self._moves = [False] * len(symbols)
        changed = True
        while changed:
            changed = False
            for number, bodies in enumerate(self._bodies):
                if not self._moves[number] and any(self._displaces(each) for each in bodies):
                    self._moves[number] = changed = True

    def symbols(self) -> tuple[ir.Symbol, ...]:
        """The symbols with `moves` set."""
        pairs = zip(self._symbols, self._moves, strict=True)
        return tuple(replace(symbol, moves=True) if moves else symbol for symbol, moves in pairs)

    def threaded(self, axiom: ir.Production) -> bool:
        """Whether anything that threads, looks around or cuts is there."""
        productions = (*self._productions, axiom)
        return (
            any(each.left or each.right for each in productions)
            or any(each.op == "cut" for symbol in self._symbols for each in symbol.meaning or ())
            or any(self._read(each.body, live=False)[0] for each in productions)
        )

    def threads(self, body: Sequence[ir.Instruction]) -> ir.Instruction | None:
        """A child of a body that moves the turtle for what stands behind it, if there is one."""
        return self.threading if self._read(body, live=False)[0] else None

    def _own_bodies(self, symbol: ir.Symbol, stepped: bool) -> list[tuple[ir.Instruction, ...]]:
        """All that a module of a symbol may become, its meaning included where that may be left."""
        numbers = symbol.productions + symbol.interpretation
        bodies = [self._productions[number].body for number in numbers]
        if symbol.meaning is not None and (stepped or not symbol.productions):
            bodies.append(symbol.meaning)
        return bodies

    def _displaces(self, body: Sequence[ir.Instruction]) -> bool:
        depth = 0
        for each in body:
            depth += (each.op == "open") - (each.op == "close")
            if depth == 0 and self._moves_one(each):
                return True
        return False

    def _moves_one(self, each: ir.Instruction) -> bool:
        if each.op == "module":
            return self._moves[_number(each)] and not self._symbols[_number(each)].held
        return each.op in self._motions or (each.op == "repeat" and self._displaces(each.body))

    def _read(self, body: Sequence[ir.Instruction], live: bool) -> tuple[bool, bool]:
        """Whether a body threads when the state is live, or not, at its end; whether it is live at
        its start.
        """
        threads = False
        after: list[bool] = []
        for each in reversed(body):
            if each.op == "close":
                after.append(live)
                live = False
            elif each.op == "open":
                live = after.pop() or live
            elif each.op == "module":
                if self._expands(each) and self._moves[_number(each)] and live:
                    threads, self.threading = True, each
                live |= self._looks(each)
            elif each.op == "repeat":
                inner, start = self._read(each.body, live)
                if start and not live:  # a copy is followed by another one
                    inner, start = self._read(each.body, live=True)
                threads |= inner
                live |= start
            elif each.op in ("slab", "slab_along", "pieces", "snapped", "part", "join"):
                threads |= self._read(each.body, live=False)[0]
                live = True
        return threads, live

    def _expands(self, each: ir.Instruction) -> bool:
        symbol = self._symbols[_number(each)]
        return bool(symbol.productions or symbol.interpretation)

    def _looks(self, each: ir.Instruction) -> bool:
        """Whether a module reads the state: it draws, or becomes something that may."""
        meaning = self._symbols[_number(each)].meaning or ()
        return self._expands(each) or any(step.op in READS for step in meaning)


def scoped(symbols: Sequence[ir.Symbol], productions: Sequence[ir.Production]) -> bool:
    """Whether anything asks for a scope or works on one."""
    codes = [symbol.meaning or () for symbol in symbols]
    for each in productions:
        codes.append(each.body)
        codes.append(() if each.guard is None else each.guard[0])
        codes.append(() if each.chance is None else each.chance[1])
    return any(_uses_scope(code) for code in codes)


def _uses_scope(code: Sequence[ir.Instruction]) -> bool:
    return any(each.op in ir.SCOPE_OPS or _uses_scope(each.body) for each in code)


def flat(symbols: Sequence[ir.Symbol], tropism: tuple[float, float, float, float] | None) -> bool:
    """Whether nothing leaves z = 0: no meaning tilts, lifts or bends out of it."""
    lifted = any(_lifts(symbol) for symbol in symbols)
    return not lifted and (tropism is None or tropism[2] == 0)


def _lifts(symbol: ir.Symbol) -> bool:
    constants = {each.out: each.const for each in symbol.meaning or () if each.op == "const"}
    for each in symbol.meaning or ():
        if each.op == "orient" or (each.op == "rotate" and each.const != "z"):
            return True
        if each.op == "move" and constants.get(each.args[2]) != 0.0:
            return True
    return False


def _number(each: ir.Instruction) -> int:
    assert isinstance(each.const, int)
    return each.const
