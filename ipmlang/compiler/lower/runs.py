"""Repeats for the rows of one symbol after the other: the second and all others are like the first.

In go the repeat that was lowered for the first symbol of a table, and for another symbol its
number and that of its rows; out comes the repeat as it would be lowered for that one: only these
numbers differ, and where registers and sites begin. What depends on the symbol in any other way
has no pattern.
"""

from __future__ import annotations

from dataclasses import dataclass

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Known
from ipmlang.compiler.places import PLACED

PLAIN = frozenset({"open", "close", "index", "row", "const", "module"})


@dataclass(frozen=True, slots=True)
class Pattern:
    """A repeat that is like those of other symbols; register, site: its first ones, and how many of
    them it takes; constants: what it loads itself.
    """

    repeat: ir.Instruction
    register: int
    site: int
    registers: int
    sites: int
    constants: tuple[ir.Const, ...]


def pattern_of(code: Code, repeat: ast.Repeat) -> Pattern | None:
    """The pattern of the repeat that was lowered last, None if others may be unlike it."""
    made = code.instructions[-1]
    if repeat.rows is not None or repeat.holes or repeat.steps or code.changed:
        return None
    if not all(isinstance(each, ast.Module) and not each.args for each in repeat.body):
        return None
    last = repeat.body[-1] if repeat.body else None
    if not isinstance(last, ast.Module) or last.name != PLACED or len(made.body) < 2:
        return None
    body = made.body
    if not PLAIN.issuperset(each.op for each in body) or body[-2].op != "module":
        return None
    written = [each.out for each in body if each.out >= 0]
    sites = [each.site for each in body if each.site >= 0]
    constants = tuple(each.const for each in body if each.op == "const")
    first = min(written, default=0)
    return Pattern(made, first, min(sites), len(written), len(sites), constants)


def again(code: Code, pattern: Pattern, number: int, table: int, count: int, symbol: int) -> None:
    """Append the repeat of that number, for a symbol and the rows of a table that place it."""
    first, counter = pattern.repeat, code.counter
    by, sites = counter.register - pattern.register, counter.site - pattern.site
    counter.register += pattern.registers
    counter.site += pattern.sites
    body: list[ir.Instruction] = []
    for each in first.body:
        const = each.const
        if each.op == "index":
            const = number
        elif each.op == "row":
            assert isinstance(const, tuple)
            const = (table, const[1])
        args = tuple([arg + by if arg >= pattern.register else arg for arg in each.args])
        out = each.out + by if each.out >= 0 else -1
        site = each.site + sites if each.site >= 0 else -1
        body.append(ir.Instruction(each.op, out, args, const, site, (), each.span))
    last = body[-2]
    body[-2] = ir.Instruction("module", -1, (), symbol, last.site, (), last.span)
    limit = code.register(Known(float(count)))
    made = ir.Instruction("repeat", -1, (limit,), number, -1, tuple(body), first.span)
    code.instructions.append(made)


def is_again(code: Code, pattern: Pattern) -> bool:
    """Whether another repeat would load what the pattern loads: nothing of it is known by now."""
    return not any(code.knows(each) for each in pattern.constants)


__all__ = ["Pattern", "again", "is_again", "pattern_of"]
