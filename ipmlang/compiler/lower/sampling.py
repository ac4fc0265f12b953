"""Contexts to what executors sample: `fetch(mask, x, y)` becomes one value instruction.

In go calls and `context` items, out come operands and the records of the files. A context that
nothing asks is not in the program. No pixel is read here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.names import Place

if TYPE_CHECKING:
    from ipmlang.compiler.lower.expr import Code, Environment, Operand, Pool

UNIT = (0.0, 0.0, 1.0, 1.0)  # what a context covers if its item says nothing


def fetched(code: Code, call: ast.Call, names: Environment) -> Operand:
    """A context's number at x and y, or where the shape's scope has its origin."""
    if not code.shaped:
        raise code.error(
            call.span,
            "no-shape",
            f"`{call.name}` asks while shapes are made, and this is computed before there are any",
            hint="ask in a rule",
        )
    context, *rest = (each.value for each in call.args)
    assert isinstance(context, ast.Name)  # the checker has seen to it
    place = code.unit.find(context.id)
    assert place is not None
    channel = _channel(code, rest[2], names) if len(rest) > 2 else 0
    number = code.pool.context(place, channel)
    if not rest:
        return code.fetch(number, channel, code.state("x"), code.state("y"))
    x, y = (code.value(each, names) for each in rest[:2])
    return code.fetch(number, channel, x, y)


def _channel(code: Code, expr: ast.Expr, names: Environment) -> int:
    known = code.known(expr, names)
    if known is None:
        raise code.error(
            expr.span, "not-constant", "a channel must be known before a derivation starts"
        )
    if not 0 <= known < 4 or known % 1:
        raise code.error(
            expr.span, "out-of-range", f"a channel is 0, 1, 2 or 3, and this is {known:g}"
        )
    return int(known)


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
    from ipmlang.compiler.lower.expr import Code, Known

    code = Code(pool, place.unit, place.item)
    operands = [code.value(each, {}) for each in box]
    known = [each.value for each in operands if isinstance(each, Known)]
    if len(known) == 4:
        left, bottom, width, height = known
        return replace(made, place=(left, bottom, width, height))
    registers = tuple(code.register(each) for each in operands)
    return replace(made, place=None, late=(tuple(code.instructions), registers))
