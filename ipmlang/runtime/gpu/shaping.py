"""Operations on scopes and geometry as bytecode, by name, and what each changes of the state.

In go instructions, out come words for what fills its scope; any other geometry sends the run back
to the CPU when it is met. A name that is not here has no body on the GPU.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from ipmlang.compiler import ir
from ipmlang.compiler.ops.record import NOT_GIVEN
from ipmlang.runtime.gpu.isa import Op
from ipmlang.runtime.gpu.unsupported import UnsupportedError
from ipmlang.runtime.scopes.pool import BOX
from ipmlang.runtime.scopes.shaping import SHARES

if TYPE_CHECKING:
    from ipmlang.runtime.gpu.elements import Elements

PLACE = frozenset("xyz")
TURN = frozenset({"w", "i", "j", "k", "angle"})
SIZE = frozenset({"sx", "sy", "sz"})
EXTRUDED = (
    -1.0
)  # of a constant: the number of the box that `extrude` makes, known when a run starts
Given = Mapping[int, float]


def changes(each: ir.Instruction) -> frozenset[str]:
    """The fields of the state that an instruction of a meaning changes."""
    match each.op:
        case "move" | "segment":
            return PLACE
        case "rotate" | "orient" | "level":
            return TURN
        case "scale" | "mirror":
            return frozenset({"scale"})
        case "resize":
            return SIZE | {"geo"}
        case "layer":
            return frozenset({"layer"})
        case "pen":
            assert isinstance(each.const, tuple)
            name = str(each.const[0])
            return frozenset({"color", "fill", "stroke"} if name == "color" else {name})
        case "solid":
            return PLACE | TURN | SIZE | {"geo", "scale"}
        case _:
            return frozenset()


def solid(elements: Elements, each: ir.Instruction, args: Sequence[int], known: Given) -> None:
    """Append an operation on the shape's geometry. `known`: its arguments that are constants."""
    name = str(each.const)
    if name not in BODIES:
        raise UnsupportedError(name, "its geometry is made on the CPU")
    BODIES[name](elements, args, known)


def face_split(each: ir.Instruction, known: Given) -> int:
    """The number of an operation that takes the faces of boxes apart."""
    assert isinstance(each.const, tuple)
    name, number, _ = each.const
    if name != "comp" or any(known.get(arg) != NOT_GIVEN for arg in each.args):
        raise UnsupportedError(str(name), "its parts are made on the CPU")
    assert isinstance(number, int)
    return number


def _text(elements: Elements, name: str, known: Given, place: int) -> str | None:
    """The text that an argument is in all shapes; None where it is not given."""
    if place not in known:
        raise UnsupportedError(name, "its words differ from shape to shape")
    if known[place] == NOT_GIVEN:
        return None
    return elements.words.program.strings[int(known[place])]


def _extrude(elements: Elements, args: Sequence[int], known: Given) -> None:
    if len(args) > 1 and _text(elements, "extrude", known, 1) not in (None, "normal", "z"):
        raise UnsupportedError("extrude", "it goes along an axis of the world")
    elements.words.put(Op.EXTRUDE, a=args[0], z=elements.words.extruded())


def _rotate(elements: Elements, args: Sequence[int], known: Given) -> None:
    share = SHARES[str(_text(elements, "rotate", known, 3))]
    at = elements.words.numbers(share)
    elements.words.put(Op.CENTER, z=at)
    for axis, angle in enumerate(args[:3]):
        elements.words.put(Op.TURN, a=angle, z=axis)
    elements.words.put(Op.CENTER, z=at, n=1)


def _flip(elements: Elements, args: Sequence[int], known: Given) -> None:
    axis = "xyz".index(str(_text(elements, "mirrorScope", known, 0)))
    elements.words.put(Op.FLIP, z=axis)
    elements.words.put(Op.MIRROR)


def _cube(elements: Elements, args: Sequence[int], known: Given) -> None:
    at = elements.words.constant(float(BOX))
    elements.words.put(Op.LOAD, out=elements.slot("geo"), z=at)


def _quad(elements: Elements, args: Sequence[int], known: Given) -> None:
    _cube(elements, args, known)
    elements.words.put(Op.LOAD, out=elements.slot("sz"), z=elements.words.constant(0.0))


BODIES: Mapping[str, Callable[[Elements, Sequence[int], Given], None]] = {
    "extrude": _extrude,
    "rotate": _rotate,
    "mirrorScope": _flip,
    "cube": _cube,
    "quad": _quad,
}
