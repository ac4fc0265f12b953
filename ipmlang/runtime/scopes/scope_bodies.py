"""Python source for scopes: what operations make of them, slabs, pieces, and parts that are joined.

In go instructions and the writer of a body, out come calls of the run, and the state that each part
of a shape begins with. In a repeat every copy has a scope of its own: nothing of it reaches the
next. Nothing is computed here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ipmlang.compiler import ir
from ipmlang.runtime.algebra import Operand
from ipmlang.runtime.code import source
from ipmlang.runtime.fields import FRAME, SCOPE, TRIM
from ipmlang.runtime.primitives import UnscannableError
from ipmlang.runtime.queries.marks import SEEN
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.laying import FIELD as UV

if TYPE_CHECKING:
    from ipmlang.runtime.bodies import Writer
    from ipmlang.runtime.motion import State
    from ipmlang.runtime.naming import Scope

SHAPING = frozenset({"resize", "solid", "center", "report", "lay", "snap"})
MOVED = ("x", "y", "z")
TURNING = frozenset(
    {"rotate", "rotateScope", "mirrorScope", "alignScopeToAxes", "alignScopeToGeometry"}
)

KEEPING = frozenset({"mirrorScope", "tag", "reverseNormals"})  # they leave all measures alone


def changed_by(name: str) -> tuple[str, ...]:
    """The fields that an operation on a shape's geometry may change."""
    turned = ("w", "i", "j", "k", "scale") if name in TURNING else ()
    return (*MOVED, *SCOPE, *turned)


def asked(writer: Writer, name: str, state: State) -> Operand:
    """A field of the state that a body reads as a number."""
    if writer.quiet and name in FRAME:  # what copies before this one did is not known yet
        raise UnscannableError
    writer.known((name,))
    return state.get(name, -1.0)


def shaped(
    writer: Writer, each: ir.Instruction, args: list[Operand], scope: Scope, state: State
) -> State:
    """What an operation makes of the scope and its geometry. In a repeat every copy has its
    own: nothing of it reaches the next.
    """
    if each.op == "resize":
        sizes = (writer.source.let(f"run.extent({source(arg)})") for arg in args)
        writer.unknown -= {"sx", "sy", "sz"}
        own = {**state, **dict(zip(("sx", "sy", "sz"), sizes, strict=True))}
        if writer.quiet:
            return own
        parts = f"{source(own['sz'])}, {source(state['geo'])}, {scope.count}"
        return {**own, "geo": writer.source.let(f"run.risen({parts})")}
    if writer.quiet:
        if each.op == "solid" and each.const not in KEEPING:
            writer.unknown.update(SCOPE)
        return state
    if each.op == "report":
        what = f"{scope.count}, {writer.values(args)}, {scope.shown}"
        writer.source.lines.append(f"run.report({what})")
        return state
    if each.op == "snap":
        what = f"{scope.count}, {writer.values(args)}, {_seen(writer, state)}, {scope.shown}"
        writer.source.lines.append(f"run.snap({what})")
        return state
    if each.op == "lay":
        return laid(writer, each, args, scope, state)
    names = [name for name in state if name in FRAME or name in (*SCOPE, TRIM)]
    base = {name: _began(writer, name, state) for name in names}
    what = "center" if each.op == "center" else str(each.const)
    parts = f"'{what}', {scope.count}, {writer.values(args)}, {writer.mapping(state, names)}"
    more = f"{writer.mapping(base, names)}" if each.op == "center" else scope.shown
    call = "center" if each.op == "center" else "solid"
    found = writer.held(f"run.{call}({parts}, {more})")
    changed = MOVED if each.op == "center" else changed_by(what)
    own = {name: writer.source.let(f"{found}['{name}']") for name in changed if name in state}
    return {**state, **own}


def _began(writer: Writer, name: str, state: State) -> Operand:
    """A field of the scope that the body began with, a row for each copy."""
    value = writer.base.get(name, state[name])
    for owner in writer.owners:
        value = writer.taken(value, owner)
    return value


def laid(
    writer: Writer, each: ir.Instruction, args: list[Operand], scope: Scope, state: State
) -> State:
    """From here on textures lie as the operation says."""
    names = [name for name in state if name in FRAME]
    what = f"{each.const!r}, {scope.count}, {writer.values(args)}, {source(state[UV])}"
    return {
        **state,
        UV: writer.held(f"run.lay({what}, {writer.mapping(state, names)}, {scope.shown})"),
    }


def slab(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """The part of the scope between two planes."""
    if writer.quiet:
        return
    assert isinstance(each.const, int)
    low, size = (source(scope.registers[arg]) for arg in each.args)
    scopes = ", ".join(source(state[name]) for name in SCOPE)
    what = f"{each.const}, {scope.count}, {low}, {size}, {scopes}, {scope.shown}"
    found = writer.held(f"run.slab({what})")
    shown, begin, extent, geometry = (writer.source.let(f"{found}[{k}]") for k in range(4))
    axis = min(each.const, 2) if each.const < 3 else 0
    move: list[Operand] = [0.0, 0.0, 0.0]
    move[axis] = begin
    own = writer.motion.moved(state, move[0], move[1], move[2])
    own = {**own, ("sx", "sy", "sz")[axis]: extent, "geo": geometry}
    writer.within(each.body, replace(scope, registers=dict(scope.registers), shown=shown), own)


def unwrapped(writer: Writer, what: str, scope: Scope, state: State) -> Operand:
    """How a texture coordinate runs over the scope."""
    if writer.quiet:  # what copies before this one did is not known yet
        raise UnscannableError
    own = writer.mapping(state, [name for name in state if name in (*FRAME, *SCOPE, UV)])
    return writer.source.let(f"run.unwrapped({what!r}, {scope.count}, {own}, {scope.shown})")


def slab_along(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """The same across an axis that differs from shape to shape."""
    if writer.quiet:
        return
    low, size, axis = (source(scope.registers[arg]) for arg in each.args)
    own = writer.mapping(state, [name for name in state if name in (*FRAME, *SCOPE, UV)])
    what = f"{each.const!r}, {axis}, {scope.count}, {low}, {size}, {own}, {scope.shown}"
    found = writer.held(f"run.slab_along({what})")
    shown, part = (writer.source.let(f"{found}[{k}]") for k in range(2))
    changed = {name: writer.source.let(f"{part}['{name}']") for name in (*MOVED, *SCOPE)}
    inner = replace(scope, registers=dict(scope.registers), shown=shown)
    writer.within(each.body, inner, {**state, **changed})


def pieces(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """The parts that an operation makes, a batch of copies for each selector."""
    if writer.quiet:
        return
    assert isinstance(each.const, tuple)
    name, number, site = each.const
    assert isinstance(number, int)
    writer.check(each, str(name), scope)
    args = [scope.registers[arg] for arg in each.args]
    names = [name for name in state if name in FRAME or name in (*SCOPE, TRIM)]
    selectors = tuple(part.const for part in each.body if part.op == "part")
    keys = f"({scope.k0}, {scope.k1}, {site}, {scope.tuple})"
    what = f"{name!r}, {selectors!r}, {scope.count}, {writer.values(args)}"
    call = f"run.pieces({what}, {writer.mapping(state, names)}, {keys}, {scope.shown})"
    _parts(writer, each, number, writer.held(call), names, scope, state)


def piece(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """One piece of a split whose cuts may move: it is noted."""
    if writer.quiet:
        return
    shape, low, size = (source(scope.registers[arg]) for arg in each.args)
    what = f"{each.const!r}, {scope.count}, {shape}, {low}, {size}, {scope.shown}"
    writer.source.lines.append(f"run.piece({what})")


def snapped(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """The pieces that were noted, once their cuts have moved."""
    if writer.quiet:
        return
    assert isinstance(each.const, tuple)
    axis, number, _ = each.const
    assert isinstance(number, int)
    writer.check(each, "split", scope)
    args = [scope.registers[arg] for arg in each.args]
    names = (*MOVED, *SCOPE)
    many = sum(part.op == "part" for part in each.body)
    what = f"{axis}, {number}, {many}, {scope.count}, {writer.values(args)}"
    call = f"run.snapped({what}, {_seen(writer, state)}, {scope.shown})"
    _parts(writer, each, number, writer.held(call), names, scope, state)


def _seen(writer: Writer, state: State) -> str:
    """The scope of a shape, and what it stands in."""
    return writer.mapping(state, [name for name in SEEN if name in state])


def _parts(
    writer: Writer,
    each: ir.Instruction,
    number: int,
    found: str,
    names: Sequence[str],
    scope: Scope,
    state: State,
) -> None:
    """The bodies of parts, each for a batch of copies; `names` are the fields that they change."""
    parts = [part for part in each.body if part.op == "part"]
    for place, part in enumerate(parts):
        mine = writer.source.let(f"{found}[{place}]")
        owner, index = writer.source.let(f"{mine}.owner"), writer.source.let(f"{mine}.index")
        inner = writer.gathered(part, number, replace(scope, shown=None), owner, index)
        inner = replace(inner, many={**inner.many, number: writer.source.let(f"{mine}.many")})
        own = {
            name: writer.source.let(f"{mine}.state['{name}']")
            if name in names
            else writer.taken(value, owner)
            for name, value in state.items()
        }
        outer, writer.slots = writer.slots, []
        writer.within(part.body, inner, own)
        slots, writer.slots = writer.values(writer.slots), outer
        writer.slots.append(f"Copies({mine}.counts, {owner}, {slots})")


def join(writer: Writer, each: ir.Instruction, scope: Scope, state: State) -> None:
    """Parts whose solids become one: each has a number, and draws under it."""
    if writer.quiet:
        return
    parts = [part for part in each.body if part.op == "part"]
    names = [name for name in state if name in FRAME]
    what = f"{each.const!r}, {len(parts)}, {scope.count}, {source(state[JOIN])}"
    found = writer.held(f"run.join({what}, {writer.mapping(state, names)})")
    for place, part in enumerate(parts):
        number = writer.source.let(f"{found} + {place}.0")
        inner = replace(scope, registers=dict(scope.registers))
        writer.within(part.body, inner, {**state, JOIN: number})


PARTING: Mapping[str, Callable[[Writer, ir.Instruction, Scope, State], None]] = {
    "slab": slab, "slab_along": slab_along, "pieces": pieces, "piece": piece, "snapped": snapped,
    "join": join,
}  # fmt: skip
