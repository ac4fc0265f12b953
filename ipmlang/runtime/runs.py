"""Repeats over rows of tables that stand side by side and differ in their symbol, done at once.

`repeat(at T) { at.shape }` is lowered to a repeat for each symbol whose rows stand together, each
with the same way to a row's place. In go such repeats; out comes one instruction for all of them,
so that a body computes the places of all rows together, and at run time what each of them draws or
makes, with the keys, the numbers and the order that the repeats would have given.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ipmlang.compiler import ir
from ipmlang.runtime import keys
from ipmlang.runtime.code import Column, Tables
from ipmlang.runtime.keys import Words
from ipmlang.runtime.naming import Scope, is_named_length
from ipmlang.runtime.order import Copies, Drawn, Made, Slot
from ipmlang.runtime.pending import Shapes, taken
from ipmlang.runtime.symbol_rows import NO_SIZE, RULED, asset_of

if TYPE_CHECKING:
    from ipmlang.runtime.bodies import Writer
    from ipmlang.runtime.frontier import Frontier
    from ipmlang.runtime.motion import State

Numbers = NDArray[np.int64]
MOVING = frozenset({"move", "rotate", "scale", "mirror"})


@dataclass(frozen=True, slots=True)
class Run:
    """One of the repeats: how many rows of which table, the symbol that they place and its site;
    asset: what the symbol draws as it stands, RULED where it has rules.
    """

    count: int
    table: int
    symbol: int
    site: int
    asset: int


@dataclass(frozen=True, slots=True)
class Runs(ir.Instruction):
    """Repeats in one: `const` is the number of the first, `body` what leads to a row's place;
    table: the number, below 0, that it has for all their rows one after the other.
    """

    runs: tuple[Run, ...] = ()
    table: int = -1


class Standing:
    """The rows of runs in one program: columns, and for a batch of n which row of it and of them
    each copy belongs to. Copies of one run stand together, those of one shape within it, too.
    reached: for each run how many shapes there would be with it, of those that a shape makes.
    """

    def __init__(self, runs: Sequence[Run], tables: Tables) -> None:
        self.runs = runs
        self.counts = [run.count for run in runs]
        ruled = np.cumsum([run.count * (run.asset == RULED) for run in runs]).tolist()
        self.reached = [a + b for a, b in zip([0, *ruled], self.counts, strict=False)]
        self.columns = tuple(
            np.concatenate(each) for each in zip(*(tables[run.table] for run in runs), strict=False)
        )

    def copies(self, count: int) -> tuple[Numbers, Words, Numbers]:
        """(n·m,) the row of the batch, the number of the copy in its repeat, the row of a table."""
        first = np.cumsum(self.counts) - self.counts
        if count == 1:
            place = np.arange(sum(self.counts))
            index = place - np.repeat(first, self.counts)
            return np.zeros(len(place), np.int64), index.astype(np.uint32), place
        own = [np.tile(np.arange(each), count) for each in self.counts]
        owner = np.concatenate([np.repeat(np.arange(count), each) for each in self.counts])
        place = np.concatenate([at + each for at, each in zip(first, own, strict=True)])
        return owner, np.concatenate(own).astype(np.uint32), place


def with_runs(program: ir.Program, body: Sequence[ir.Instruction]) -> tuple[ir.Instruction, ...]:
    """A body in which repeats side by side that differ in symbol and table alone are one."""
    if sum(each.op == "repeat" for each in body) < 2:
        return tuple(body)
    made: list[ir.Instruction] = []
    known: dict[int, float] = {}
    alike: list[ir.Instruction] = []
    runs: list[Run] = []
    tables = 0

    def end() -> None:
        nonlocal tables
        if len(alike) > 1:
            tables += 1
            made.append(_joined(alike[0], tuple(runs), -tables))
        else:
            made.extend(alike)
        alike.clear()
        runs.clear()

    for each in body:
        if each.op == "const":
            assert isinstance(each.const, float)
            known[each.out] = each.const
            made.append(each)
            continue
        run = _run(program, each, known) if each.op == "repeat" else None
        if alike and (run is None or not _is_alike(alike[0], each)):
            end()
        if run is not None and (alike or _leads_to_place(program, each, known.keys())):
            alike.append(each)
            runs.append(run)
        else:
            made.append(each)
    end()
    return tuple(made)


def _run(program: ir.Program, repeat: ir.Instruction, known: dict[int, float]) -> Run | None:
    """The run that a repeat may be by its ends: so many copies, of a symbol that ends them."""
    body = repeat.body
    if len(repeat.args) != 1 or len(body) < 4 or body[0].op != "open" or body[-1].op != "close":
        return None
    count, row, last = known.get(repeat.args[0]), body[2], body[-2]
    if count is None or count < 0 or not count.is_integer() or row.op != "row":
        return None
    if last.op != "module" or last.args:
        return None
    assert isinstance(last.const, int) and isinstance(row.const, tuple)
    asset = asset_of(program, last.const)
    table = row.const[0]
    assert isinstance(table, int)
    return None if asset is None else Run(int(count), table, last.const, last.site, asset)


def _leads_to_place(program: ir.Program, repeat: ir.Instruction, known: Iterable[int]) -> bool:
    """Whether all but the ends of a repeat reads cells of one table in its own row, and moves;
    known: the registers that hold constants around it.
    """
    own = set(known)
    for each in repeat.body[1:-2]:
        if not own.issuperset(each.args):
            return False
        match each.op:
            case "index" if each.const == repeat.const:
                pass
            case "row" if each.const[0] == repeat.body[2].const[0]:  # type: ignore[index]
                pass
            case "const":
                pass
            case "module":
                symbol = program.symbols[int(str(each.const))]
                if symbol.productions or symbol.interpretation or not _moves(symbol.meaning or ()):
                    return False
            case _:
                return False
        own.add(each.out)
    return True


def _moves(meaning: Sequence[ir.Instruction]) -> bool:
    return all(each.op in MOVING or each.op in ("param", "const") for each in meaning)


def _is_alike(first: ir.Instruction, other: ir.Instruction) -> bool:
    """Whether a repeat has the same way to its rows as the first one, which leads to a place."""
    if len(first.body) != len(other.body):
        return False
    begin = first.body[1].out  # what is in a register before that is the same for both
    by = other.body[1].out - begin
    table = other.body[2].const[0]  # type: ignore[index]
    for one, each in zip(first.body[1:-2], other.body[1:-2], strict=True):
        if one.op != each.op or (one.out >= 0 and each.out != one.out + by):
            return False
        if each.args != tuple([arg + by if arg >= begin else arg for arg in one.args]):
            return False
        if one.op == "index":
            same = each.const == other.const
        elif one.op == "row":
            same = each.const == (table, one.const[1])  # type: ignore[index]
        else:
            same = repr(each.const) == repr(one.const)
        if not same:
            return False
    return True


def _joined(first: ir.Instruction, runs: tuple[Run, ...], table: int) -> Runs:
    """One instruction for repeats that are like the first."""
    body = tuple(
        ir.Instruction("row", each.out, each.args, (table, each.const[1]))  # type: ignore[index]
        if each.op == "row"
        else each
        for each in first.body[1:-2]
    )
    return Runs("repeat", const=first.const, body=body, span=first.span, runs=runs, table=table)


def runs_name(table: int) -> str:
    """What source calls runs."""
    return f"runs{~table}"


# ------------------------------------------------------------------------ what bodies write


def written(writer: Writer, each: Runs, scope: Scope, state: State) -> None:
    """Write runs: what leads to all their rows, and one step that draws or makes what they place.
    They stand in no copy and no part, so all rows of the batch have them.
    """
    own, write = runs_name(each.table), writer.source
    found = writer.held(f"run.standing({own}, {scope.count})")
    owner, index, place = (write.let(f"{found}[{k}]") for k in range(3))
    assert isinstance(each.const, int)
    inner = Scope(
        write.let(f"len({owner})"),
        write.let(f"{scope.k0}[{owner}]"),
        write.let(f"{scope.k1}[{owner}]"),
        scope.params,
        {
            register: value
            for register, value in scope.registers.items()
            if isinstance(value, float) or is_named_length(value)
        },
        ((each.const, place),),
        None,
        {},
        (owner,),
    )
    taken = {name: writer.taken(value, owner) for name, value in state.items()}
    reached = writer.body(each.body, inner, taken)
    words = f"({inner.k0}, {inner.k1}, {index})"
    what = f"{own}, rule, {scope.count}, {owner}, {writer.values(reached.values())}, {words}"
    call = writer.held(f"place_runs(run, {what})")
    writer.slots.append(f"*{call}")


def place_runs(
    run: Frontier,
    standing: Standing,
    rule: int,
    count: int,
    owner: Numbers,
    state: tuple[Column, ...],
    words: tuple[Words, Words, Words],
) -> list[Slot]:
    """Draw or make what the rows of runs place, for a batch of `count` shapes; words: the keys of
    the shapes and the numbers of the copies (n,), owner the shape of each.
    """
    runs = standing.runs
    many = [each * count for each in standing.counts]
    ends = np.cumsum(many).tolist()
    begins = [0, *ends[:-1]]
    site = np.repeat(np.array([each.site for each in runs], np.uint32), many)
    k0, k1 = keys.child(words[0], words[1], site, words[2])
    drawn = _drawn(run, standing, rule, owner, state, (*words, site))
    slots: list[Slot] = []
    for each, begin, end in zip(runs, begins, ends, strict=True):
        own = slice(begin, end)
        slot: Slot
        if each.asset == RULED:
            slot = _made(run, each, rule, state, (k0[own], k1[own]), own)
        else:
            slot = Drawn(drawn, end - begin)
            drawn += end - begin
        slots.append(Copies(np.full(count, each.count), owner[own], (slot,)))
    return slots


def _made(
    run: Frontier,
    each: Run,
    rule: int,
    state: tuple[Column, ...],
    words: tuple[Words, Words],
    rows: slice,
) -> Made:
    """Make what a run places in some rows, with these keys."""
    from ipmlang.runtime.frontier import NOTHING, columns

    count = len(words[0])
    if run.is_barren(each.symbol):
        run.counted.make(count)
        return NOTHING
    own = tuple(taken(column, rows) for column in columns(state))
    plain = Shapes(count, np.zeros(0, np.int32), *words, int(rule), (), own)
    return run.born(each.symbol, each.site, plain, words)


def _drawn(
    run: Frontier,
    standing: Standing,
    rule: int,
    owner: Numbers,
    state: tuple[Column, ...],
    words: tuple[Words, Words, Words, Words],
) -> int:
    """Draw the assets among what runs place; the number of the first drawing."""
    many = [each * (len(owner) // sum(standing.counts)) for each in standing.counts]
    symbol, asset = (
        np.repeat(np.array(each, np.int32), many)
        for each in zip(*((each.symbol, each.asset) for each in standing.runs), strict=True)
    )
    rows = np.flatnonzero(asset != RULED)
    if not len(rows):
        return run.drawings
    k0, k1, index, site = words
    return run.draw(
        len(owner), rule, symbol, asset, NO_SIZE, state, k0, k1, site, (index,),
        None if len(rows) == len(owner) else rows, (owner,),
    ).start  # fmt: skip
