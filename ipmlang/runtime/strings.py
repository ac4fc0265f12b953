"""Derivation as a string: for turtles that thread, for contexts, and for exactly `steps` steps.

In goes a program with the values of its attributes and a seed; out comes the scene, or for
inspection the string itself. The string is grown (`grow`), read as acts (`interpret`), walked
(`turtle`) and drawn (`draw`); nothing of that is done here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import keys
from ipmlang.runtime.ancestry import History, ModuleError, told_way
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.draw import drawn
from ipmlang.runtime.grow import derived, interpreted
from ipmlang.runtime.interpret import stream
from ipmlang.runtime.replay import Recording, Replay
from ipmlang.runtime.rewrite import CLOSE, OPEN, Budget, Rewriter
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.turtle import Turtle
from ipmlang.runtime.values import Batch, Bound

BRACKETS = {OPEN: ir.Symbol("[", 0), CLOSE: ir.Symbol("]", 0)}


def derive_string(
    program: ir.Program,
    attrs: Sequence[float],
    seed: int,
    limits: ir.Limits,
    draws: Replay | Recording | None = None,
) -> Scene:
    """Derive a program as a string and draw it. `attrs`: the values of Program.attrs, in order;
    `draws`: known choices of productions, or who notes them.

    Raises IpmError where a limit is reached, no production applies, a number is not finite, or the
    known choices are not those of this program.
    """
    try:
        return _scene(begun(program, attrs, limits, draws), seed)
    except ModuleError as found:
        raise _retraced(begun(program, attrs, limits, draws), seed, found) from found


def _scene(rewriter: Rewriter, seed: int) -> Scene:
    program = rewriter.program
    with np.errstate(all="ignore"):  # what is not finite is an error, not a warning
        string = derived(rewriter, seed, steps_of(rewriter.bound, seed))
        final = interpreted(rewriter, string)
        if rewriter.draws is not None:
            rewriter.draws.finish()
        rewriter.budget.walk(final.length)
        acts = stream(rewriter.bound, final)
        rows, polygons = drawn(program, acts, Turtle(program, acts))
    made = rewriter.budget.ruled + len(rows.scale)
    return scene(program, rows, polygons, seed=seed, generations=string.steps, shapes=made)


def _retraced(rewriter: Rewriter, seed: int, found: ModuleError) -> IpmError:
    """An error with the way to its module: derived again, as nobody keeps a way that no one asks
    for.
    """
    if rewriter.draws is not None:
        rewriter.draws.restart()
    history = History(rewriter.program)
    with np.errstate(all="ignore"):
        string = derived(rewriter, seed, steps_of(rewriter.bound, seed), history)
        final = interpreted(rewriter, string, history)
    place = int(final.tables[found.symbol].place[found.row])
    return told_way(found.error, history.way(found.symbol, place))


def derive_modules(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> list[tuple[str, tuple[float, ...]]]:
    """The string after the last step, before `interpret` rules: names with arguments, brackets as
    `[` and `]`.
    """
    rewriter = begun(program, attrs, limits)
    try:
        with np.errstate(all="ignore"):
            string = derived(rewriter, seed, steps_of(rewriter.bound, seed))
    except ModuleError as stopped:
        raise _retraced(begun(program, attrs, limits), seed, stopped) from stopped
    found: list[tuple[str, tuple[float, ...]]] = [("", ())] * string.length
    for symbol, table in string.tables.items():
        own = BRACKETS.get(symbol) or program.symbols[symbol]
        name, written = own.name, table.params[: own.arity - own.carried]
        columns = [np.broadcast_to(value, (table.count,)).tolist() for value in written]
        rows = list(zip(*columns, strict=True)) or [()] * table.count
        for place, row in zip(table.place.tolist(), rows, strict=True):
            found[place] = (name, row)
    return found


def begun(
    program: ir.Program,
    attrs: Sequence[float],
    limits: ir.Limits,
    draws: Replay | Recording | None = None,
) -> Rewriter:
    """A program with its attributes' values, and nothing made yet."""
    return Rewriter(Bound(program, attrs, FUNCTIONS), Budget(limits), draws)


def steps_of(bound: Bound, seed: int) -> int | None:
    """How many steps the program wants, None for as many as it takes."""
    if bound.program.steps is None:
        return None
    instructions, register = bound.program.steps
    k0, k1 = (np.array([word], np.uint32) for word in keys.root(seed))
    batch = Batch(bound, 1, (), k0, k1)
    batch.evaluate(instructions)
    count = float(batch.column(register)[0])
    if not 0 <= count < 2**31 or count != round(count):
        raise fail("bad-steps", f"`steps` must be a whole number from 0 on, and is {count:g}")
    return int(count)
