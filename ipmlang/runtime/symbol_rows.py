"""Rows of a table that name their symbols, done at once instead of symbol by symbol.

Lowering writes "the symbol that this row names" as repeats in repeats, each of which asks for one
half of the symbols and makes one copy or none. In go such repeats; out come the symbols with what
tells their keys, and at run time what all rows draw and make, with the keys and in the order that
the repeats would have given. What draws anything but an asset as it stands is left to the repeats.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime.code import Column
from ipmlang.runtime.keys import Words
from ipmlang.runtime.order import Slot

if TYPE_CHECKING:
    from ipmlang.runtime.copying import Around
    from ipmlang.runtime.frontier import Frontier

Code: TypeAlias = Mapping[int, ir.Instruction]
Cell: TypeAlias = tuple[ir.Const, int]  # table and column, and the register of the row's number
Numbers: TypeAlias = NDArray[np.int64]

NO_SIZE = (0.0, 0.0, 0.0)
RULED = -1  # instead of an asset: the symbol has rules


@dataclass(frozen=True, slots=True)
class Leaf:
    """One of the symbols: where its module stands, and in how many repeats of the choice."""

    symbol: int
    site: int
    depth: int


@dataclass(frozen=True, slots=True)
class Named:
    """The symbols in the order of their numbers, the register that says which a row names, and the
    last element that the choice takes.
    """

    leaves: tuple[Leaf, ...]
    register: int
    last: int


def named(elements: Sequence[ir.Instruction], number: int, code: Code) -> Named | None:
    """The choice that the repeat at `number` of a body begins, None where it is a plain repeat;
    code: what wrote the registers so far.
    """
    lower = elements[number]
    last = next(
        (at for at in range(number + 1, len(elements)) if elements[at].op not in ir.VALUE_OPS), None
    )
    if last is None or elements[last].op != "repeat" or _asked(lower, "lt", code) is None:
        return None
    known = dict(code)
    known.update((each.out, each) for each in elements[number:last] if each.out >= 0)
    leaves = _halves((lower, elements[last]), 0, 1, known)
    test = known[lower.args[0]]
    return None if leaves is None else Named(leaves, test.args[0], last)


def assets_of(program: ir.Program, leaves: Sequence[Leaf]) -> list[int] | None:
    """The asset that each symbol draws as it stands, RULED where it has rules; None where one of
    them does anything else.
    """
    found = [asset_of(program, leaf.symbol) for leaf in leaves]
    known = [each for each in found if each is not None]
    return known if len(known) == len(found) else None


def asset_of(program: ir.Program, number: int) -> int | None:
    """The asset that a symbol draws as it stands, RULED where it has rules; None where it does
    anything else.
    """
    symbol = program.symbols[number]
    if symbol.productions or symbol.interpretation:
        return RULED
    meaning = symbol.meaning or ()
    if len(meaning) != 1 or meaning[0].op != "emit" or meaning[0].args:
        return None
    asset = int(str(meaning[0].const))
    return asset if asset >= 0 else None


def modules_in(body: Sequence[ir.Instruction]) -> int:
    """How many modules stand in a body, the choice of one of many counted as one."""
    code = {each.out: each for each in body if each.out >= 0}
    count, passed = 0, -1
    for number, each in enumerate(body):
        if number <= passed:
            continue
        found = named(body, number, code) if each.op == "repeat" else None
        if found is not None:
            passed = found.last
        count += 1 if each.op == "module" or found is not None else modules_in(each.body)
    return count


def _halves(
    pair: Sequence[ir.Instruction], low: int, depth: int, code: MutableMapping[int, ir.Instruction]
) -> tuple[Leaf, ...] | None:
    """The symbols of two repeats: the first for numbers from `low` up to a limit, the second for
    those from there on.
    """
    tests = [_asked(each, name, code) for each, name in zip(pair, ("lt", "ge"), strict=True)]
    if tests[0] is None or tests[0] != tests[1]:
        return None
    cell, limit = tests[0]
    below = _inside(pair[0], cell, low, depth, code)
    if below is None or limit != low + len(below):
        return None
    above = _inside(pair[1], cell, low + len(below), depth, code)
    return None if above is None else below + above


def _inside(
    repeat: ir.Instruction,
    cell: Cell,
    low: int,
    depth: int,
    code: MutableMapping[int, ir.Instruction],
) -> tuple[Leaf, ...] | None:
    """The symbols of one repeat: that of its only module, or those of two more repeats."""
    code.update((each.out, each) for each in repeat.body if each.out >= 0)
    acts = [each for each in repeat.body if each.op not in ir.VALUE_OPS]
    if [each.op for each in acts] == ["repeat", "repeat"]:
        test = _asked(acts[0], "lt", code)
        inner = test is not None and test[0] == cell
        return _halves(acts, low, depth + 1, code) if inner else None
    if [each.op for each in acts] != ["module"] or acts[0].args:
        return None
    return (Leaf(int(str(acts[0].const)), acts[0].site, depth),)


def _asked(repeat: ir.Instruction, name: str, code: Code) -> tuple[Cell, float] | None:
    """The cell and the limit that a repeat's count compares."""
    test = code.get(repeat.args[0]) if len(repeat.args) == 1 else None
    if test is None or test.op != "call" or test.const != name:
        return None
    said, limit = (code.get(each) for each in test.args)
    if said is None or limit is None or said.op != "row" or limit.op != "const":
        return None
    return (said.const, said.args[0]), float(str(limit.const))


def place_named(
    run: Frontier,
    rule: int,
    count: int,
    said: Column,
    leaves: tuple[tuple[int, int, int, int], ...],
    state: tuple[Column, ...],
    words: tuple[Words, Words, tuple[Words, ...]],
    shown: Numbers | None,
    around: Around,
) -> list[Slot]:
    """Draw or make what each row of a batch names; said: its number among the leaves, of each of
    which symbol, site, depth and asset are given; words: keys, and the numbers of the copies.
    """
    which = np.broadcast_to(np.asarray(said), (count,)).astype(np.int64)
    table = np.array(leaves, np.int64).reshape(-1, 4)
    symbol, site, depth, asset = table[which].T
    rows = np.arange(count) if shown is None else shown
    drawn = rows[asset[rows] >= 0]
    slots: list[Slot] = []
    for deep in np.unique(depth[drawn]).tolist():
        own = drawn[depth[drawn] == deep]
        nested = (np.zeros(count, np.uint32),) * deep
        slots.append(
            run.draw(
                count, rule, symbol.astype(np.int32), asset.astype(np.int32), NO_SIZE, state,
                words[0], words[1], site.astype(np.uint32), (*words[2], *nested),
                None if len(own) == count else own, around,
            )
        )  # fmt: skip
    ruled = rows[asset[rows] < 0]
    for number in np.unique(which[ruled]).tolist():
        own = ruled[which[ruled] == number]
        symbol_number, at, deep, _ = leaves[number]
        copies = (*words[2], *((np.zeros(count, np.uint32),) * deep))
        slots.append(
            run.make(count, symbol_number, rule, (), state, words[0], words[1], at, copies, own)
        )
    return slots
