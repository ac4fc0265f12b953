"""Which rules of a program the graphics card leaves to the CPU, and why, in a person's words.

Takes a program; gives a reason for each alternative that has no place there. Alternatives of one
rule stay together, since the card chooses among all of them. Nothing is derived, and no card is
needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ipmlang.compiler import ir
from ipmlang.runtime.fields import fields
from ipmlang.runtime.gpu import encode


@dataclass(frozen=True, slots=True)
class Reason:
    """Why the CPU derives an alternative: its rule's name, what in it has no body on the card, its
    line, why, and its file. The rule is empty and the line 0 where it is the whole program.
    """

    rule: str
    operation: str
    line: int
    why: str
    path: str = ""


def reasons(program: ir.Program) -> list[Reason]:
    """A reason for each alternative that the CPU derives; the start, which it begins where shapes
    expand independently, has none there.
    """
    calls = encode.calls_of(program)
    encoded = encode.encode(program, tuple(fields(program)), len(program.attrs), calls=calls)
    found = [each for reason in encoded.reasons for each in _told(program, reason)]
    return list(dict.fromkeys(found))


def _told(program: ir.Program, reason: encode.Reason) -> Iterator[Reason]:
    if reason.production is None:
        yield Reason("", reason.what, 0, reason.why)
        return
    if reason.production == -1 and encode.calls_of(program) == "threads":
        yield Reason("start", reason.what, program.axiom.line, reason.why, program.axiom.path)
        return
    if reason.production < 0:  # an operation by itself: the rules that use it have their own reason
        return
    blamed = program.productions[reason.production]
    symbol = program.symbols[blamed.symbol]
    for number in (*symbol.productions, *symbol.interpretation):
        each = program.productions[number]
        what, why = reason.what, reason.why
        if number != reason.production:
            what, why = "", f"stays with that in line {blamed.line}"
        yield Reason(symbol.name, what, each.line, why, each.path)
