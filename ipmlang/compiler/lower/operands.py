"""The arguments of an operation on scopes, in the order of its form, with what was left out.

In go a record and what was written, out come operands. Words and names of assets become numbers
here; a parameter that nobody gave is its default, which may be a number that operations read as
"not given".
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache as remember

from ipmlang.compiler import ast
from ipmlang.compiler.lower.expr import Code, Environment, Known, Operand
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.ops.record import Param


def operands(
    code: Code, record: Operation, args: Sequence[ast.Argument], names: Environment
) -> list[Operand]:
    """One operand for each parameter of the form that the arguments fit."""
    by_place = [each.value for each in args if each.name is None]
    by_name = {each.name: each.value for each in args if each.name is not None}
    form = _form(record.name, len(by_place), frozenset(by_name))
    if len(by_place) == len(form):
        pairs = zip(form, by_place, strict=True)
        return [_operand(code, param, given, names) for param, given in pairs]
    defaults = dict(record.defaults)
    found: list[Operand] = []
    for param in form:
        given = by_name.get(param.name)
        if given is None and by_place and not param.named:
            given = by_place.pop(0)
        if given is None:
            found.append(Known(float(defaults[param.name])))
        else:
            found.append(_operand(code, param, given, names))
    return found


def form_for(record: Operation, args: Sequence[ast.Argument]) -> tuple[Param, ...]:
    """The first form that takes these arguments; the checker has seen to it that there is one."""
    named = [each.name for each in args if each.name is not None]
    return _form(record.name, len(args) - len(named), frozenset(named))


@remember
def _form(name: str, count: int, named: frozenset[str]) -> tuple[Param, ...]:
    """The same for an operation that is called by so many places and by these names."""
    record = OPERATIONS[name]
    for form in record.forms:
        places = [each for each in form if not each.named]
        least = sum(not each.optional for each in places)
        if least <= count <= len(places) and named <= {each.name for each in form}:
            return form
    return record.forms[0]


def _operand(code: Code, param: Param, given: ast.Expr, names: Environment) -> Operand:
    if isinstance(given, ast.Name) and given.id in param.words:
        return code.pool.text(given.id)
    return code.value(given, names)
