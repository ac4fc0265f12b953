"""The contexts of a program as records of files: where each lies, and which channels are asked for.

In go the contexts that code came upon, out come `ir.ContextFile`s. A context that nothing asks is
not in the program. No pixel is read here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Known, Pool
from ipmlang.compiler.lower.names import Place

UNIT = (0.0, 0.0, 1.0, 1.0)  # what a context covers if its item says nothing


def context_files(pool: Pool) -> tuple[ir.ContextFile, ...]:
    """The contexts that a program samples, in the order in which it came upon them."""
    return tuple(_context(pool, place, most + 1) for place, most in pool.contexts.values())


def _context(pool: Pool, place: Place, channels: int) -> ir.ContextFile:
    unit, item = place.unit, place.unit.grammar.items[place.item]
    assert isinstance(item, ast.Field)
    where = unit.diagnostic(place.item, item.span, "", "")
    path = (unit.folder / item.reference).absolute()
    made = ir.ContextFile(
        unit.attribute(item.name), path, item.kind, UNIT, None, item.nearest, channels,
        where.source, where.start, where.end,
    )  # fmt: skip
    return made if item.place is None else _placed(pool, place, made, item.place)


def _placed(
    pool: Pool, place: Place, made: ir.ContextFile, box: Sequence[ast.Expr]
) -> ir.ContextFile:
    """The context with the rectangle that it covers, known or as code."""
    code = Code(pool, place.unit, place.item)
    operands = [code.value(each, {}) for each in box]
    known = [each.value for each in operands if isinstance(each, Known)]
    if len(known) == 4:
        left, bottom, width, height = known
        return replace(made, place=(left, bottom, width, height))
    registers = tuple(code.register(each) for each in operands)
    return replace(made, place=None, late=(tuple(code.instructions), registers))
