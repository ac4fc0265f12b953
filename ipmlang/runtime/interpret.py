"""What the modules of a string do: the meanings of its symbols, batched, as one stream of acts.

In goes a string, out comes a stream: for each instruction of each symbol's meaning the positions at
which it acts and its arguments. Modules without a meaning have no place in a stream. Nothing here
moves the turtle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.runtime.ancestry import ModuleError
from ipmlang.runtime.choose import told
from ipmlang.runtime.code import doubtful
from ipmlang.runtime.grow import String
from ipmlang.runtime.rewrite import CLOSE, OPEN, Modules
from ipmlang.runtime.scan import Whole
from ipmlang.runtime.values import Batch, Bound, Value


@dataclass(slots=True, eq=False)
class Act:
    """One instruction of a symbol's meaning, for all its modules.

    `at` (n,) places in the stream, `args` a number each or one a module, `rows` the module's row in
    `modules` where that is not the row itself. What is `hidden` only moves.
    """

    op: ir.Opcode
    const: object
    at: Whole
    args: tuple[Value, ...]
    modules: Modules
    rows: Whole | None = None
    hidden: bool = False


@dataclass(slots=True, eq=False)
class Stream:
    """`length` places in the order of the string; brackets at `opens` and `closes`."""

    length: int
    opens: Whole
    closes: Whole
    acts: list[Act]

    def of(self, *ops: str) -> list[Act]:
        """The acts of some kinds."""
        return [act for act in self.acts if act.op in ops]

    def visible(self, op: str) -> list[Act]:
        """The acts of a kind that do not only move."""
        return [act for act in self.of(op) if not act.hidden]

    def drop(self, *ops: str) -> None:
        """Forget the acts of some kinds: whoever follows them has done so."""
        self.acts = [act for act in self.acts if act.op not in ops]


def stream(bound: Bound, string: String) -> Stream:
    """The acts of a string in the order of its modules. Takes the string's tables away as it goes:
    a turtle needs the room.
    """
    symbols = bound.program.symbols
    width = np.zeros(string.length + 1, np.int64)
    meanings = {}
    for number, table in string.tables.items():
        if number < 0:
            width[table.place] = 1
            continue
        meanings[number] = acting = _acting(symbols[number])
        if acting:
            width[table.place] = len(acting)
    first = np.cumsum(width) - width
    acts: list[Act] = []
    for number, acting in meanings.items():
        table = string.tables.pop(number)
        if acting:
            acts += _acts(bound, symbols[number], table, first)
    return Stream(int(first[-1]), first[string.places(OPEN)], first[string.places(CLOSE)], acts)


def _acting(symbol: ir.Symbol) -> list[ir.Instruction]:
    return [each for each in symbol.meaning or () if _acts_on_turtle(each)]


def _acts_on_turtle(each: ir.Instruction) -> bool:
    return each.op not in ir.VALUE_OPS and each.op != "cut"


def _acts(bound: Bound, symbol: ir.Symbol, table: Modules, first: Whole) -> list[Act]:
    batch = Batch(bound, table.count, table.params, table.k0, table.k1)
    at = first[table.place]
    made = replace(table, params=(), place=at[:0])
    acts: list[Act] = []
    doubt = doubtful(symbol.meaning or ())  # what modules are given was looked at
    for each in symbol.meaning or ():
        if not _acts_on_turtle(each):
            if each.op != "cut":
                batch.evaluate((each,))
            continue
        args = tuple(batch.get(register) for register in each.args)
        for register, arg in zip(each.args, args, strict=True):
            if register in doubt and table.count:
                _check(bound.program, symbol, table, arg)
        act = Act(each.op, each.const, at, args, made)
        acts += [act] if table.silent is None else _quiet(act)
        at = at + 1
    return acts


def _check(program: ir.Program, symbol: ir.Symbol, table: Modules, arg: Value) -> None:
    """Stop at a setting, such as the turtle's step, that is no number where it is used."""
    finite = np.broadcast_to(np.isfinite(arg), (table.count,))
    if finite.all():
        return
    row = int(np.argmin(finite))
    number = int(np.broadcast_to(table.rule, (table.count,))[row])
    rule = program.axiom if number < 0 else program.productions[number]
    message = f"{told(program, rule)}: an argument of {symbol.name} is not a finite number"
    raise ModuleError(fail("not-a-number", message), table.symbol, row)


def _quiet(act: Act) -> list[Act]:
    """An act of modules some of which draw nothing: those only move."""
    silent = act.modules.silent
    if silent is None or act.op not in ("segment", "emit", "polygon_close", "path_close"):
        return [act]
    hidden = chosen(act, np.flatnonzero(silent))
    hidden.hidden = True
    return [chosen(act, np.flatnonzero(~silent)), hidden]


def chosen(act: Act, rows: Whole) -> Act:
    """An act of some of its modules."""
    args = tuple(v[rows] if isinstance(v, np.ndarray) and v.ndim else v for v in act.args)
    own = rows if act.rows is None else act.rows[rows]
    return replace(act, at=act.at[rows], args=args, rows=own)
