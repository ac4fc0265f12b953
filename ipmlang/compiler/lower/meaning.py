"""What an operation does to the turtle, as code over its own parameters.

In go a record of the operations table and how many arguments a module gives, out comes the meaning
of its symbol: the record's steps, with what was left out taken from the turtle's settings.
"""

from __future__ import annotations

from typing import cast

from ipmlang.compiler import ast, ir
from ipmlang.compiler.lower.expr import Code, Known, Operand, Pool
from ipmlang.compiler.lower.names import Unit
from ipmlang.compiler.ops import SETTINGS, Operation, Step

Settings = dict[str, tuple[int, ast.Expr]]


def form_of(record: Operation, arguments: int) -> int | None:
    """The first form of an operation that takes so many arguments."""
    for number, form in enumerate(record.forms):
        required = sum(not each.optional for each in form)
        if required <= arguments <= len(form):
            return number
    return None


def steps_of(record: Operation, arguments: int) -> tuple[Step, ...] | None:
    """The steps of an operation, None where no executor runs it yet."""
    form = form_of(record, arguments)
    return None if form is None or not record.meaning else record.meaning[form]


class Meanings:
    """Writes meanings; `settings` are the words of the main file's `turtle` items."""

    def __init__(self, pool: Pool, unit: Unit, settings: Settings) -> None:
        self._pool = pool
        self._unit = unit
        self._settings = settings

    def of(
        self, record: Operation, arguments: int, steps: tuple[Step, ...]
    ) -> tuple[tuple[ir.Instruction, ...], int]:
        """The meaning of a module with so many arguments, and how many registers it has."""
        code = Code(self._pool, self._unit, -1)
        form = form_of(record, arguments)
        names = [] if form is None else [each.name for each in record.forms[form]]
        for step in steps:
            args = [self._argument(code, record, names[:arguments], each) for each in step.args]
            const: ir.Const = (step.const, None) if step.op == "pen" else step.const
            code.act(cast("ir.Opcode", step.op), args, const)
        return tuple(code.instructions), code.counter.register

    def _argument(
        self, code: Code, record: Operation, given: list[str], arg: str | float
    ) -> Operand:
        if not isinstance(arg, str):
            return Known(float(arg))
        name = arg.removeprefix("-")
        if name in given:
            value: Operand = code.load("param", given.index(name))
        else:
            value = self._default(code, dict(record.defaults)[name])
        return code.call("neg", (value,)) if arg.startswith("-") else value

    def _default(self, code: Code, default: str | float) -> Operand:
        if not isinstance(default, str):
            return Known(float(default))
        if default in self._settings:
            code.item, expr = self._settings[default]
            return code.value(expr, {})
        value = SETTINGS["turtle", default].default
        return Known(float(value or 0.0))
