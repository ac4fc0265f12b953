"""Python source for copies: the states between them, and symbols that the rows of a table choose.

In go the writer of a body and instructions, out come calls of the run: a scan for what each copy
finds, one step for a choice among symbols. Nothing is derived here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ipmlang.compiler import ir
from ipmlang.runtime.code import source
from ipmlang.runtime.fields import FRAME
from ipmlang.runtime.symbol_rows import assets_of, named

if TYPE_CHECKING:
    from ipmlang.runtime.bodies import Writer
    from ipmlang.runtime.motion import State
    from ipmlang.runtime.naming import Scope


def walked(
    writer: Writer, state: State, step: State, start: State, own: State, counts: str, owner: str
) -> tuple[State, State]:
    """The state that each copy finds, and the one after the last copy."""
    write = writer.source
    count = f"len({owner})"
    after = dict(state)
    own = dict(own)
    frame = [name for name in state if name in FRAME]
    if any(step[name] != start[name] for name in frame):
        parts = f"{writer.mapping(state, frame)}, {writer.mapping(step, frame)}"
        found = writer.held(f"run.walk({counts}, {count}, {parts})")
        for name in frame:
            own[name] = write.let(f"{found}[0]['{name}']")
            after[name] = write.let(f"{found}[1]['{name}']")
    for name in state:
        if name not in FRAME and step[name] != start[name]:
            kind = "total" if name == "layer" else "last"
            parts = f"{source(state[name])}, {source(step[name])}"
            found = writer.held(f"run.{kind}({counts}, {count}, {parts})")
            own[name], after[name] = write.let(f"{found}[0]"), write.let(f"{found}[1]")
    return own, after


def chosen_symbols(
    writer: Writer,
    elements: Sequence[ir.Instruction],
    number: int,
    scope: Scope,
    state: State,
) -> int:
    """Write the choice of a symbol that a repeat begins, as one step; the last element that it
    takes, 0 where there is none. In a program with scopes its parts may ask for what is drawn.
    """
    program = writer.program
    found = None if program.scoped else named(elements, number, writer.code)
    assets = None if found is None else assets_of(program, found.leaves)
    if found is None or assets is None:
        return 0
    if not writer.quiet:
        called = writer.numbered
        leaves = [
            f"({called.symbol(leaf.symbol)}, {leaf.site}, {leaf.depth}, {called.asset(asset)})"
            for leaf, asset in zip(found.leaves, assets, strict=True)
        ]
        said = source(scope.registers[found.register])
        words = f"({scope.k0}, {scope.k1}, {scope.tuple})"
        what = f"{said}, ({', '.join(leaves)},), {writer.values(state.values())}, {words}"
        where = f"{scope.shown}, {scope.around}"
        call = writer.held(f"place_named(run, rule, {scope.count}, {what}, {where})")
        writer.slots.append(f"*{call}")
    return found.last
