"""The frontier as a back end: which programs it runs, and their scenes.

In go a program with attribute values, out comes a scene, or None where modules thread, bend or fill
polygons across rules: those are derived as strings, with the same keys. So are long texts that are
mostly read once, such as a drawing whose elements all stand in the axiom: writing and compiling
Python costs more than it saves there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import drawings
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.fields import fields
from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.primitives import UnscannableError
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.strings import steps_of
from ipmlang.runtime.values import Bound

LONG = 500  # modules in all bodies; compiling one takes about 0.2 ms, a string 10 us
TEXTUAL = frozenset({"polygon_open", "polygon_close", "vertex", "cut", "uniform"})


def derive_frontier(
    program: ir.Program, attrs: Sequence[float], seed: int, limits: ir.Limits
) -> Scene | None:
    """Derive a program whose modules expand independently; None where they do not.

    Raises IpmError where a limit is reached, no production applies, or a number is not finite.
    """
    if not is_independent(program) or _modules(program) > LONG:
        return None
    bound = Bound(program, attrs, FUNCTIONS)
    initial = fields(program)
    frontier = Frontier(bound, initial, limits, steps_of(bound, seed))
    with np.errstate(all="ignore"):  # what is not finite is an error, not a warning
        try:
            frontier.run(seed)
        except UnscannableError:
            return None
        places = frontier.order.places(frontier.shapes, frontier.drawings)
        frontier.order.records.clear()
        rows = drawings.rows(program, frontier.chunks, places, initial, frontier.grouping)
    return scene(
        program,
        rows,
        seed=seed,
        generations=frontier.generations,
        shapes=frontier.shapes + frontier.drawings,
    )


def is_independent(program: ir.Program) -> bool:
    """Whether nothing needs the string: no thread, no context, no tropism, no polygon."""
    return not program.threaded and program.tropism is None and not (TEXTUAL & set(_ops(program)))


def _modules(program: ir.Program) -> int:
    """How many modules stand in all bodies."""
    return sum(_count(each.body) for each in (*program.productions, program.axiom))


def _count(body: Sequence[ir.Instruction]) -> int:
    return sum(1 if each.op == "module" else _count(each.body) for each in body)


def _ops(program: ir.Program) -> Iterator[str]:
    for symbol in program.symbols:
        yield from (each.op for each in symbol.meaning or ())
