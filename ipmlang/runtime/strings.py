"""Derivation as a string: for turtles that thread, for contexts, and for exactly `steps` steps.

In goes a program with the values of its attributes and a seed; out comes the scene, or for
inspection the string itself. The string is grown (`grow`), read as acts (`interpret`), walked
(`turtle`) and drawn (`draw`); nothing of that is done here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import keys
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.draw import drawn
from ipmlang.runtime.grow import derived, interpreted
from ipmlang.runtime.interpret import stream
from ipmlang.runtime.rewrite import CLOSE, OPEN, Budget, Rewriter
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.turtle import Turtle
from ipmlang.runtime.values import Batch, Bound


def derive_string(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Scene:
    """Derive a program as a string and draw it. `attrs`: the values of Program.attrs, in order.

    Raises IpmError where a limit is reached, no production applies, or a number is not finite.
    """
    rewriter = begun(program, attrs, limits)
    with np.errstate(all="ignore"):  # what is not finite is an error, not a warning
        string = derived(rewriter, seed, steps_of(rewriter.bound, seed))
        final = interpreted(rewriter, string)
        rewriter.budget.walk(final.length)
        acts = stream(rewriter.bound, final)
        rows, polygons = drawn(program, acts, Turtle(program, acts))
    return scene(
        program, rows, polygons, seed=seed, generations=string.steps, shapes=rewriter.budget.shapes
    )


def derive_modules(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> list[tuple[str, tuple[float, ...]]]:
    """The string after the last step, before `interpret` rules: names with arguments, brackets as
    `[` and `]`.
    """
    rewriter = begun(program, attrs, limits)
    with np.errstate(all="ignore"):
        string = derived(rewriter, seed, steps_of(rewriter.bound, seed))
    found: list[tuple[str, tuple[float, ...]]] = [("", ())] * string.length
    for symbol, table in string.tables.items():
        name = {OPEN: "[", CLOSE: "]"}.get(symbol) or program.symbols[symbol].name
        columns = [np.broadcast_to(value, (table.count,)).tolist() for value in table.params]
        rows = list(zip(*columns, strict=True)) or [()] * table.count
        for place, row in zip(table.place.tolist(), rows, strict=True):
            found[place] = (name, row)
    return found


def begun(program: ir.Program, attrs: Sequence[float], limits: ir.Limits) -> Rewriter:
    """A program with its attributes' values, and nothing made yet."""
    return Rewriter(Bound(program, attrs, FUNCTIONS), Budget(limits))


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
