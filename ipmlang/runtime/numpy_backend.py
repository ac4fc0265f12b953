"""The frontier as a back end: which programs it runs, and their scenes.

In go a program with attribute values, out comes a scene, or None where modules thread, bend or fill
polygons across rules: those are derived as strings, with the same keys. So are long texts that are
mostly read once, such as a drawing whose elements all stand in the axiom: writing and compiling
Python costs more than it saves there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import fail
from ipmlang.compiler.ops import FUNCTIONS
from ipmlang.runtime import drawings
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.fields import fields
from ipmlang.runtime.frontier import Frontier
from ipmlang.runtime.lineage import Lineage, Recorder
from ipmlang.runtime.primitives import UnscannableError
from ipmlang.runtime.replay import Recording, Replay
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.scopes.reports import unfit_notes
from ipmlang.runtime.strings import steps_of
from ipmlang.runtime.symbol_rows import modules_in
from ipmlang.runtime.values import Bound

LONG = 500  # modules in all bodies; compiling one takes about 0.2 ms, a string 10 us
TEXTUAL = frozenset({
    "polygon_open", "polygon_close", "path_open", "path_close", "vertex", "cut", "uniform",
})  # fmt: skip


def derive_frontier(
    program: ir.Program,
    attrs: Sequence[float],
    seed: int,
    limits: ir.Limits,
    tell: Callable[[Lineage], None] | None = None,
    draws: Replay | Recording | None = None,
) -> Scene | None:
    """Derive a program whose modules expand independently; None where they do not. `tell` gets the
    derivation tree, which is kept for it alone. `draws`: known choices of productions, or who notes
    them, in a program with scopes.

    Raises IpmError where a limit is reached, no production applies, or a number is not finite.
    """
    if not program.scoped and (
        not is_independent(program) or (_modules(program) > LONG and tell is None)
    ):
        return None
    return derived(program, attrs, seed, limits, tell, draws)


def derived(
    program: ir.Program,
    attrs: Sequence[float],
    seed: int,
    limits: ir.Limits,
    tell: Callable[[Lineage], None] | None = None,
    draws: Replay | Recording | None = None,
    begin: Callable[..., Frontier] = Frontier,
) -> Scene | None:
    """The same by the frontier that `begin` makes, whatever the program."""
    bound = Bound(program, attrs, FUNCTIONS)
    initial = fields(program)
    recorder = None if tell is None else Recorder()
    frontier = begin(bound, initial, limits, steps_of(bound, seed), None, recorder, draws)
    with np.errstate(all="ignore"):  # what is not finite is an error, not a warning
        try:
            frontier.run(seed)
            if frontier.first_pass:
                answers = frontier.occluders()
                recorder = None if tell is None else Recorder()
                if draws is not None:
                    draws.restart()
                frontier = begin(
                    bound, initial, limits, steps_of(bound, seed), answers, recorder, draws
                )
                frontier.run(seed)
            if draws is not None:
                draws.finish()
        except UnscannableError:
            if program.scoped:
                raise fail(
                    "not-executable",
                    "a `repeat` levels the turtle, or asks where it is, or asks how large it is "
                    "once its geometry is another one, and moves on from there",
                    hint="put brackets around what moves, or compute the place from the copy's "
                    "number",
                ) from None
            return None
        places = frontier.order.places(frontier.shapes, frontier.drawings)
        lineage = None
        if recorder is not None:
            lineage = recorder.lineage(frontier.order, frontier.fields, frontier.shapes, places)
        frontier.order.records.clear()
        rows = drawings.rows(
            program,
            frontier.chunks,
            places,
            initial,
            frontier.grouping,
            frontier.laying,
            frontier.joining,
            frontier.pool,
        )
    if tell is not None and lineage is not None:
        tell(lineage if rows.drawn is None else lineage.of_drawn(rows.drawn))
    made = scene(
        program,
        rows,
        frontier.polygons,
        seed=seed,
        generations=frontier.generations,
        shapes=frontier.shapes + frontier.counted.strung + frontier.drawings,
    )
    made.solids = frontier.pool.solids()
    made.reports = frontier.reports.sums()
    made.notes += frontier.notes + frontier.snap_notes()
    made.notes += unfit_notes(program, frontier.reports)
    return made


def is_independent(program: ir.Program) -> bool:
    """Whether nothing needs the string: no thread, no context, no tropism, no polygon or path."""
    return not program.threaded and program.tropism is None and not (TEXTUAL & set(_ops(program)))


def _modules(program: ir.Program) -> int:
    """How many modules stand in all bodies."""
    return sum(modules_in(each.body) for each in (*program.productions, program.axiom))


def _ops(program: ir.Program) -> Iterator[str]:
    for symbol in program.symbols:
        yield from (each.op for each in symbol.meaning or ())
