"""Python source for frames: how moves and turns change the state of a turtle or of a scope.

In go a state, whose fields are names or known numbers, and operands; out comes the state after
them, with the lines that compute it. Nothing is drawn or made here.
"""

from __future__ import annotations

from typing import TypeAlias

from ipmlang.compiler import ir
from ipmlang.runtime.algebra import Operand, Source
from ipmlang.runtime.code import source
from ipmlang.runtime.primitives import UnscannableError

State: TypeAlias = dict[str, Operand]


def mirrors(program: ir.Program) -> bool:
    """Whether a frame of a program may be mirrored."""
    return any(
        each.op == "mirror" or (each.op == "solid" and each.const == "mirrorScope")
        for symbol in program.symbols
        for each in symbol.meaning or ()
    )


class Motion:
    """Writes what frames become."""

    def __init__(self, program: ir.Program, write: Source) -> None:
        self._program = program
        self._write = write
        self._mirrors: bool | None = None  # not known yet

    def hand(self, state: State) -> Operand:
        """1, or -1 in a mirrored frame."""
        scale = state.get("scale", 1.0)
        if isinstance(scale, float):
            return 1.0 if scale > 0 else -1.0
        if self._mirrors is None:
            self._mirrors = mirrors(self._program)
        return self._write.let(f"copysign(1.0, {scale})") if self._mirrors else 1.0

    def moved(self, state: State, x: Operand, y: Operand, z: Operand) -> State:
        """The state after a move along the local axes."""
        write = self._write
        scale = state.get("scale", 1.0)
        size = write.multiply(scale, self.hand(state))
        x, y, z = write.multiply(x, scale), write.multiply(y, size), write.multiply(z, size)
        if "angle" in state:
            cosine, sine = write.unit(state["angle"])
            across = write.multiply(y, sine)
            moved: tuple[Operand, ...] = (
                write.subtract(write.multiply(x, cosine), across),
                write.sum((x, sine), (y, cosine)),
            )
        else:
            rotation = (state["w"], state["i"], state["j"], state["k"])
            moved = write.turned(rotation, (x, y, z))
        changed = {
            axis: write.add(state[axis], step)
            for axis, step in zip("xyz"[: len(moved)], moved, strict=True)
        }
        return {**state, **changed}

    def rotated(self, state: State, axis: str, degrees: Operand) -> State:
        """The state after a turn about a local axis."""
        hand = self.hand(state)
        if "angle" in state:
            turn = self._write.multiply(degrees, hand)
            return {**state, "angle": self._write.add(state["angle"], turn)}
        return self.turned(state, self._write.quaternion(axis, degrees, hand))

    def turned(self, state: State, turn: tuple[Operand, Operand, Operand, Operand]) -> State:
        """The state after a turn by a quaternion."""
        rotation = (state["w"], state["i"], state["j"], state["k"])
        return {**state, **dict(zip("wijk", self._write.product(rotation, turn), strict=True))}

    def oriented(self, state: State, args: list[Operand]) -> State:
        """The state after a turn by a quaternion that may have any length, in the local frame."""
        hand = self.hand(state)
        found = self._write.let(f"normal({', '.join(source(arg) for arg in args)})")
        w, x, y, z = (self._write.let(f"{found}[{axis}]") for axis in range(4))
        turn = (w, x, self._write.multiply(y, hand), self._write.multiply(z, hand))
        return self.turned(state, turn)

    def levelled(self, state: State, quiet: bool) -> State:
        """The state rolled until the left is horizontal; a scan (`quiet`) cannot know how far."""
        if "angle" in state:
            return state
        if quiet:
            raise UnscannableError
        names = ", ".join(source(state[axis]) for axis in "wijk")
        found = self._write.let(f"level({names}, {source(self.hand(state))})")
        own = {axis: self._write.let(f"{found}[{n}]") for n, axis in enumerate("wijk")}
        return {**state, **own}
