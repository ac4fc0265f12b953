"""Python source for what a body asks about other shapes, and for what makes it known to them.

In go instructions and the writer of a body, out come calls of the run: for queries, for the labels
and reports that queries find, and for the parts of a body that ask. Nothing is answered here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ipmlang.compiler import ir
from ipmlang.runtime.algebra import Operand
from ipmlang.runtime.code import source
from ipmlang.runtime.primitives import UnscannableError
from ipmlang.runtime.queries.marks import ASKING, FIELD, LABELLED, REPORTING, SEEN, first_query

if TYPE_CHECKING:
    from ipmlang.runtime.bodies import Writer
    from ipmlang.runtime.motion import State
    from ipmlang.runtime.naming import Scope


def answered(
    writer: Writer, each: ir.Instruction, args: Sequence[Operand], scope: Scope, state: State
) -> Operand:
    """The answers to a query, where it is asked."""
    if writer.quiet:  # what copies before this one did is not known yet
        raise UnscannableError
    what = f"{each.const!r}, {scope.count}, {writer.values(args)}, {_seen(writer, state)}"
    return writer.source.let(f"run.ask({what}, {scope.shown})")


def began(writer: Writer, body: Sequence[ir.Instruction], scope: Scope, state: State) -> State:
    """A part of a shape begins, a copy or a bracket; one that asks is a shape of its own."""
    if FIELD not in state or writer.quiet:
        return state
    query = first_query(body)
    if query is None:
        return state
    return _noted(writer, ASKING, -1.0, 0.0, scope, query.site, state)


def inside(elements: Sequence[ir.Instruction], begin: int) -> Sequence[ir.Instruction]:
    """What stands in the bracket that opens at an element."""
    depth = 0
    for number in range(begin, len(elements)):
        depth += (elements[number].op == "open") - (elements[number].op == "close")
        if depth == 0:
            return elements[begin + 1 : number]
    return elements[begin + 1 :]


def known(
    writer: Writer,
    each: ir.Instruction,
    args: Sequence[Operand],
    scope: Scope,
    site: int,
    state: State,
) -> State:
    """A label or a report makes a shape known to queries. In a repeat every copy has its own:
    nothing of it reaches the next.
    """
    if FIELD not in state or writer.quiet:
        return state
    if each.op == "report":
        return _noted(writer, REPORTING, args[0], args[1], scope, site, state)
    if each.op == "pen" and isinstance(each.const, tuple) and each.const[0] == "label":
        return _noted(writer, LABELLED, state["label"], 0.0, scope, site, state)
    return state


def _noted(
    writer: Writer,
    kind: int,
    label: Operand,
    value: Operand,
    scope: Scope,
    site: int,
    state: State,
) -> State:
    keys = f"({scope.k0}, {scope.k1}, {site}, {scope.tuple})"
    what = f"{kind}, {scope.count}, {source(label)}, {source(value)}, {_seen(writer, state)}"
    return {**state, FIELD: writer.source.let(f"run.mark({what}, {keys}, {scope.shown})")}


def _seen(writer: Writer, state: State) -> str:
    return writer.mapping(state, [name for name in SEEN if name in state])


def needed(elements: Sequence[ir.Instruction], moving: Sequence[ir.Instruction]) -> set[int]:
    """The registers that the elements `moving` depend on."""
    found = _read(moving)
    for each in reversed(elements):
        if each.op in ir.VALUE_OPS and each.out in found:
            found.update(each.args)
    return found


def _read(body: Sequence[ir.Instruction]) -> set[int]:
    """What elements read, but for values: these count where they are needed."""
    found: set[int] = set()
    for each in body:
        if each.op not in ir.VALUE_OPS:
            found.update(each.args)
        found |= read_inside(each.body)
    return found


def read_inside(body: Sequence[ir.Instruction]) -> set[int]:
    """The registers that elements read, and what they hold reads."""
    found: set[int] = set()
    for each in body:
        found.update(each.args)
        found |= read_inside(each.body)
    return found
