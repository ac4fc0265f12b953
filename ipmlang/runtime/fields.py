"""The columns of a shape's state that a program can change, and what they hold at the start.

In go a program and where its turtle starts, out come names in a fixed order. A program that never
scales carries no scale, a flat one no z: executors carry these columns and no others.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from ipmlang.compiler import ir
from ipmlang.runtime.chains import tail_of
from ipmlang.runtime.queries.marks import FIELD as MARK
from ipmlang.runtime.queries.marks import FIRST, PHASE, asked
from ipmlang.runtime.scopes.joins import FIELD as JOIN
from ipmlang.runtime.scopes.laying import FIELD as UV

TRIM = "trim"  # the number of the face that a shape came of, which `trim` asks for
LAG = "lag"  # how many generations later than it waits a shape was made
FLAT = (1.0, 0.0, 0.0, 0.0)  # heading +x, left +y, up +z
BOOK = (0.0, 1.0, 0.0, 0.0)  # heading +x, left -y, up -z: the published end points need it
UPRIGHT = (0.5, 0.5, -0.5, 0.5)  # heading +z, left -x, up -y
PLANE = ("x", "y", "angle")
SPACE = ("x", "y", "z", "w", "i", "j", "k")
SCOPE = ("sx", "sy", "sz", "geo")  # extents, and the number of the geometry in the pool
FRAME = frozenset({"x", "y", "z", "angle", "w", "i", "j", "k", "scale"})
UNSET = -1e300  # of a pen's field that copies leave as it was
IDENTITY = {"w": 1.0, "scale": 1.0}  # all other fields of a frame are 0


def fields(program: ir.Program) -> dict[str, float]:
    """Each field with its value at the start: the frame, the scope, `scale` (signed: negative in a
    mirrored frame), `layer`, and the pen's fields, NaN or -1 where nothing is set.
    """
    found = dict.fromkeys(PLANE if program.flat else SPACE, 0.0)
    if not program.flat:
        found.update(zip("wijk", first_rotation(program), strict=True))
    if program.scoped:
        found.update(dict.fromkeys(SCOPE, 0.0))
        if _joins(program):
            found[JOIN] = -1.0
    used = {(each.op, _field(each)) for each in _meanings(program)}
    ops = {op for op, _ in used}
    if ops & {"scale", "mirror"} or ("solid", "mirrorScope") in used:
        found["scale"] = 1.0
    if ("solid", "trim") in used:
        found[TRIM] = -1.0
    if "lay" in ops:
        found[UV] = -1.0
    if asked(program) is not None:
        found[MARK] = -1.0
    if "phase" in ops:
        found[PHASE] = FIRST
    if "layer" in ops:
        found["layer"] = 0.0
    if _branches(program):
        found[LAG] = 0.0
    width = program.pen_width
    if ("pen", "width") in used or width is not None:
        found["width"] = math.nan if width is None else width
    if program.scoped:
        used |= {("pen", "label")} if _reads_label(program) else set()
    for _, name in sorted(each for each in used if each[0] == "pen" and each[1] != "width"):
        found[name] = -1.0
    return found


def _branches(program: ir.Program) -> bool:
    """Whether rows of a chain may make shapes beside the next row."""
    if program.scoped or program.steps is not None:
        return False
    for number, symbol in enumerate(program.symbols):
        first = program.productions[symbol.productions[0]] if symbol.productions else None
        if first is not None and tail_of(first, number) is not None:
            children = (each for each in _all((first.body,)) if each.op == "module")
            ruled = (program.symbols[int(str(each.const))] for each in children)
            if sum(bool(own.productions) for own in ruled) > 1:
                return True
    return False


def _joins(program: ir.Program) -> bool:
    """Whether some rule makes one solid of several."""
    return any(
        each.op == "join" for each in _all(p.body for p in (*program.productions, program.axiom))
    )


def first_rotation(program: ir.Program) -> tuple[float, float, float, float]:
    """The quaternion that a turtle starts with. In the plane the book's axes are a mirrored frame,
    which `assemble` sees to at the end.
    """
    if program.flat:
        return FLAT
    return BOOK if program.abop else UPRIGHT


def _field(each: ir.Instruction) -> str:
    if each.op == "solid":
        return str(each.const)
    return str(each.const[0]) if each.op == "pen" and isinstance(each.const, tuple) else ""


def _meanings(program: ir.Program) -> Iterator[ir.Instruction]:
    for symbol in program.symbols:
        yield from symbol.meaning or ()


def _reads_label(program: ir.Program) -> bool:
    """Whether some rule asks for the label of a shape that nothing need have labelled."""
    codes = [
        code
        for each in (*program.productions, program.axiom)
        for code in (each.body, () if each.guard is None else each.guard[0])
    ]
    return any(each.op == "state" and each.const == "label" for each in _all(codes))


def _all(codes: Iterable[Sequence[ir.Instruction]]) -> Iterator[ir.Instruction]:
    for code in codes:
        yield from code
        inner = [each.body for each in code if each.body]
        if inner:
            yield from _all(inner)
