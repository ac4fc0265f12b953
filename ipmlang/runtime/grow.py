"""A string of modules, rewritten step by step.

In goes a bound program, out comes the string after its last step: the modules of each symbol as
columns with their places among all modules and brackets. While no production looks at its
neighbours the string is never written: each step keeps the blocks of what it rewrote, and one pass
from the last step to the first and back finds every place. With contexts, or where `cut` may take
branches away, the places are found after every step. The turtle is not here.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime.ancestry import Grown, History, ModuleError, Rewritten, told_way, way_of
from ipmlang.runtime.branches import Branches
from ipmlang.runtime.choose import Match, ShapeError, told
from ipmlang.runtime.context import Neighbours
from ipmlang.runtime.rewrite import (
    CLOSE,
    OPEN,
    Block,
    Modules,
    Rest,
    Rewriter,
    lay,
    leaves,
    merged,
    modules,
)
from ipmlang.runtime.scan import Whole
from ipmlang.runtime.values import Batch, Bound


@dataclass(slots=True, eq=False)
class String:
    """`length` modules and brackets; `tables` by symbol number (OPEN and CLOSE for brackets)."""

    length: int
    tables: dict[int, Modules]
    steps: int = 0

    def places(self, symbol: int) -> Whole:
        """Where a symbol stands, in no order."""
        table = self.tables.get(symbol)
        return np.zeros(0, np.int64) if table is None else table.place


def derived(
    rewriter: Rewriter, seed: int, count: int | None, history: History | None = None
) -> String:
    """The string after `count` steps (None: when no module with productions is left), before
    `interpret` rules. Raises IpmError, or ModuleError where only a `history` knows the way.
    """
    try:
        start = rewriter.axiom(seed)
    except ShapeError as found:
        raise told_way(found.error, way_of(())) from found
    return grown_from(rewriter, start, count, history)


def grown_from(
    rewriter: Rewriter, start: Block, count: int | None, history: History | None = None
) -> String:
    """The same from the modules of a block of one row."""
    if _looks_around(rewriter.program):
        return _step_by_step(rewriter, start, count, history)
    return _at_once(rewriter, start, count, history)


def interpreted(rewriter: Rewriter, string: String, history: History | None = None) -> String:
    """The string with every `interpret` rule applied once. Raises as above."""
    program = rewriter.program
    numbers = {i: symbol.interpretation for i, symbol in enumerate(program.symbols)}
    if not any(numbers[symbol] for symbol in string.tables if symbol >= 0):
        return string
    return _cut(program, _stepped(rewriter, string, numbers, "leave", history), history)


def _rest(program: ir.Program) -> Rest:
    return "refuse" if program.steps is None else "again"


def _looks_around(program: ir.Program) -> bool:
    cuts = _meaning(program, "cut")
    return bool(cuts) or any(each.left or each.right for each in program.productions)


def _meaning(program: ir.Program, op: str) -> list[int]:
    """The symbols whose meaning has some instruction."""
    return [
        number
        for number, symbol in enumerate(program.symbols)
        if any(each.op == op for each in symbol.meaning or ())
    ]


def _at_once(
    rewriter: Rewriter, start: Block, count: int | None, history: History | None
) -> String:
    program = rewriter.program
    grown = Grown(program, start)
    done, kept = grown.done, grown.kept
    if rewriter.draws is not None:
        _rank(program, [(start, np.zeros(1, np.int64))], 1)
    frontier = _sorted_out(program, modules(start.items), kept)
    while frontier and (count is None or len(done) < count):
        stopped = _at_limit(rewriter, len(done), frontier)
        if stopped is not None:
            raise told_way(stopped, way_of(grown.labels(frontier[min(frontier)], 0)))
        step: list[Rewritten] = []
        made: list[Modules] = []
        ranked: list[tuple[Block, Whole]] = []
        for symbol in sorted(frontier):
            parts = frontier[symbol]
            table = merged(parts)
            batch = _batch(rewriter.bound, table)
            numbers = program.symbols[symbol].productions
            try:
                blocks = rewriter.step(batch, symbol, numbers, None, _rest(program), table.place)
            except ShapeError as found:
                way = way_of(grown.labels(parts, found.row))
                raise told_way(found.error, way) from found
            step.append(Rewritten(parts, batch.count, blocks))
            ranked += [(block, table.place[block.rows]) for block in blocks if len(table.place)]
            for block in blocks:
                made += modules(block.items)
        done.append(step)
        if rewriter.draws is not None:
            _rank(program, ranked, sum(each.count for each in step))
        frontier = _sorted_out(program, made, kept)
    for parts in frontier.values():
        kept += parts
    length = _find_places(start, done)
    if history is not None:
        history.grown = grown
    return _gathered(length, kept, len(done))


def _sorted_out(
    program: ir.Program, made: Iterable[Modules], kept: list[Modules]
) -> dict[int, list[Modules]]:
    """New modules by symbol where it has productions; the others go to `kept`."""
    frontier: dict[int, list[Modules]] = {}
    for part in made:
        if part.count == 0:
            continue
        if part.symbol >= 0 and program.symbols[part.symbol].productions:
            frontier.setdefault(part.symbol, []).append(part)
        else:
            kept.append(part)
    return frontier


def _rank(program: ir.Program, blocks: Iterable[tuple[Block, Whole]], count: int) -> None:
    """Number the modules that the next step rewrites, from left to right, in their `place`. Each
    block comes with the numbers below `count` of the modules that it stands for.
    """
    every = [each for block, _ in blocks for each in modules(block.items)]
    for each in every:
        each.leaves = int(each.symbol >= 0 and bool(program.symbols[each.symbol].productions))
    length = np.zeros(count, np.int64)
    for block, numbers in blocks:
        length[numbers] = leaves(block.items, len(numbers))
    starts = np.cumsum(length) - length
    for block, numbers in blocks:
        lay(block.items, starts[numbers])
    for each in every:
        each.leaves = 1


def _batch(bound: Bound, table: Modules) -> Batch:
    return Batch(bound, table.count, table.params, table.k0, table.k1, table.silent)


def _find_places(start: Block, done: list[list[Rewritten]]) -> int:
    """Count leaves from the last step to the first, then hand places down; the string's length."""
    for step in reversed(done):
        for each in step:
            count = np.empty(each.count, np.int64)
            for block in each.blocks:
                count[block.rows] = leaves(block.items, len(block.rows))
            begin = 0
            for part in each.parts:
                part.leaves = count[begin : begin + part.count]
                begin += part.count
    length = int(leaves(start.items, 1)[0])
    lay(start.items, np.zeros(1, np.int64))
    for step in done:
        for each in step:
            place = np.concatenate([part.place for part in each.parts])
            for block in each.blocks:
                lay(block.items, place[block.rows])
    return length


def _gathered(length: int, kept: Iterable[Modules], steps: int) -> String:
    parts: dict[int, list[Modules]] = {}
    for each in kept:
        parts.setdefault(each.symbol, []).append(each)
    return String(length, {symbol: merged(parts[symbol]) for symbol in sorted(parts)}, steps)


def _step_by_step(
    rewriter: Rewriter, start: Block, count: int | None, history: History | None
) -> String:
    program = rewriter.program
    lay(start.items, np.zeros(1, np.int64))
    string = _gathered(int(leaves(start.items, 1)[0]), modules(start.items), 0)
    string = _cut(program, string, history)
    numbers = {i: symbol.productions for i, symbol in enumerate(program.symbols)}
    while count is None or string.steps < count:
        live = [symbol for symbol in string.tables if symbol >= 0 and numbers[symbol]]
        if not live:
            break
        stopped = _at_limit(rewriter, string.steps, live)
        if stopped is not None:
            raise _placed_error(stopped, string, min(live), 0, history)
        string = _stepped(rewriter, string, numbers, _rest(program), history)
        string = _cut(program, string, history)
    return string


def _placed_error(
    error: IpmError, string: String, symbol: int, row: int, history: History | None
) -> IpmError | ModuleError:
    """An error at a row of a symbol's modules, with the way there if that is known."""
    if history is None:
        return ModuleError(error, symbol, row)
    return told_way(error, history.way(symbol, int(string.tables[symbol].place[row])))


def _stepped(
    rewriter: Rewriter,
    string: String,
    numbers: dict[int, tuple[int, ...]],
    rest: Rest,
    history: History | None,
) -> String:
    """The string with every module rewritten that `numbers` has productions for."""
    program = rewriter.program
    used = (program.productions[number] for own in numbers.values() for number in own)
    around = any(each.left or each.right for each in used)
    neighbours = Neighbours(program, string.length, string.tables) if around else None
    length = np.ones(string.length, np.int64)
    rewritten: list[tuple[Modules, list[Block]]] = []
    static: list[Modules] = []
    for symbol, table in string.tables.items():
        if symbol < 0 or not numbers[symbol]:
            static.append(table)
            continue
        match: Match | None = neighbours.of(table) if neighbours is not None else None
        batch = _batch(rewriter.bound, table)
        try:
            blocks = rewriter.step(batch, symbol, numbers[symbol], match, rest, table.place)
        except ShapeError as found:
            raise _placed_error(found.error, string, symbol, found.row, history) from found
        for block in blocks:
            length[table.place[block.rows]] = leaves(block.items, len(block.rows))
        rewritten.append((table, blocks))
    ends = np.cumsum(length)
    starts = ends - length
    if history is not None:
        tables = [(table.symbol, table.place) for table, _ in rewritten]
        history.steps.append((np.repeat(np.arange(len(length)), length), tables))
    kept = list(static)
    for table in static:
        table.place = starts[table.place]
    for table, blocks in rewritten:
        for block in blocks:
            lay(block.items, starts[table.place[block.rows]])
            kept += modules(block.items)
    total = int(ends[-1]) if len(ends) else 0
    return _gathered(total, (each for each in kept if each.count), string.steps + 1)


def _cut(program: ir.Program, string: String, history: History | None) -> String:
    """The string without each `cut` and what follows it in its branch."""
    first = _placed(program, string, "cut")
    if not len(first):
        return string
    branches = Branches(string.length, string.places(OPEN), string.places(CLOSE))
    end = branches.ends()[branches.branch()[branches.place[first + 1]]]
    change = np.bincount(first, minlength=string.length + 1)
    change = change - np.bincount(end, minlength=string.length + 1)
    left = np.cumsum(change[:-1]) == 0
    begins, closes = _braces(program, string)
    left[closes] = left[begins]  # what stays open of a polygon or path must close
    place = np.cumsum(left) - 1
    if history is not None:
        history.steps.append((np.flatnonzero(left), []))
    tables = {}
    for symbol, table in string.tables.items():
        rows = np.flatnonzero(left[table.place])
        if len(rows):
            tables[symbol] = _some(table, rows)
            tables[symbol].place = place[tables[symbol].place]
    return String(int(left.sum()), tables, string.steps)


def _placed(program: ir.Program, string: String, *ops: str) -> Whole:
    """Where the symbols stand whose meaning has one of some instructions."""
    symbols = [number for op in ops for number in _meaning(program, op)]
    return np.concatenate([string.places(OPEN)[:0], *map(string.places, symbols)])


def _braces(program: ir.Program, string: String) -> tuple[Whole, Whole]:
    """Where each polygon or path opens and where it closes, pair by pair."""
    opens = np.sort(_placed(program, string, "polygon_open", "path_open"))
    closes = np.sort(_placed(program, string, "polygon_close", "path_close"))
    places = np.concatenate((opens, closes))
    order = np.argsort(places)
    opening = order < len(opens)
    nest = np.cumsum(np.where(opening, 1, -1)) + ~opening
    pairs = places[order][np.argsort(nest, kind="stable")]
    return pairs[::2], pairs[1::2]


def _some(table: Modules, rows: Whole) -> Modules:
    params = tuple(v[rows] if isinstance(v, np.ndarray) and v.ndim else v for v in table.params)
    keyed = len(table.k0) > 0
    return Modules(
        table.symbol,
        len(rows),
        params,
        table.k0[rows] if keyed else table.k0,
        table.k1[rows] if keyed else table.k1,
        table.rule[rows] if isinstance(table.rule, np.ndarray) and table.rule.ndim else table.rule,
        None if table.silent is None else table.silent[rows],
        place=table.place[rows],
    )


def _at_limit(rewriter: Rewriter, done: int, frontier: Iterable[int]) -> IpmError | None:
    """The error of one more step where there may be none."""
    limits = rewriter.budget.limits
    bound, kind = min((limits.steps, "steps"), (limits.depth, "depth"))
    if done < bound:
        return None
    program = rewriter.program
    number = program.symbols[min(frontier)].productions[0]
    return fail(
        f"limit-{kind}",
        f"the derivation stopped at its limit of {bound:,} for {kind}: "
        f"{told(program, program.productions[number])} still applies",
        hint="a guard or `steps` ends the growth; `limit steps` raises the limit",
    )
