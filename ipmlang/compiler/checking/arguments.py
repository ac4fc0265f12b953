"""The arguments of an operation against the forms of its record."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache as remember

from ipmlang.compiler import ast
from ipmlang.compiler.checking.expressions import (
    Scope,
    Slot,
    arguments,
    constant,
    counts,
    takes,
    type_of,
    want,
)
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.ops.record import Param


def check_arguments(
    scope: Scope, record: Operation, name: str, args: Sequence[ast.Argument], span: ast.Span
) -> None:
    """Check the arguments of one use of an operation."""
    placed = [argument for argument in args if argument.name is None]
    named = frozenset(argument.name for argument in args if argument.name is not None)
    form = _form(record.name, len(placed), named)
    if form is None:
        scope.findings.trouble(
            span,
            "wrong-arguments",
            f"`{name}` takes {_forms(record)}, here it has {len(placed) or 'none'}",
            hint=_signatures(record, name),
        )
        for argument in args:
            type_of(scope, argument.value)
        return
    by_place = [param for param in form if not param.named]
    for index, argument in enumerate(placed):
        check_argument(scope, by_place[min(index, len(by_place) - 1)], argument.value, name)
    if named or len(by_place) < len(form):
        _named(scope, form, name, args, span)


@remember
def _form(name: str, count: int, named: frozenset[str]) -> tuple[Param, ...] | None:
    """The form of an operation for so many arguments by place and these by name: one that knows
    all of them, if there is one.
    """
    fitting = [each for each in OPERATIONS[name].forms if takes(each, count)]
    knowing = [each for each in fitting if named <= {param.name for param in each}]
    return next(iter([*knowing, *fitting]), None)


def _named(
    scope: Scope, form: tuple[Param, ...], name: str, args: Sequence[ast.Argument], span: ast.Span
) -> None:
    known = {param.name: param for param in form if param.named}
    given: set[str] = set()
    for argument in args:
        if argument.name is None:
            continue
        param = known.get(argument.name)
        if param is None:
            type_of(scope, argument.value)
            scope.findings.trouble(
                argument.span,
                "wrong-arguments",
                f"`{name}` has no argument called `{argument.name}`",
                suggestions=nearest(argument.name, known),
            )
            continue
        if argument.name in given:
            scope.findings.trouble(
                argument.span, "wrong-arguments", f"`{argument.name}` is given twice"
            )
        given.add(argument.name)
        check_argument(scope, param, argument.value, name)
    for param in known.values():
        if not param.optional and param.name not in given:
            scope.findings.trouble(
                span, "wrong-arguments", f"`{name}` needs the argument `{param.name}: …`"
            )


def check_argument(scope: Scope, param: Param, value: ast.Expr, name: str) -> None:
    """Check one argument against its parameter."""
    if _is_plain(param, value):
        return
    what = f"`{param.name}` of `{name}`"
    if param.words:
        check_words(scope, param, value, what)
        return
    want(scope, value, param.type, what)
    if param.suffixes and isinstance(value, ast.Text) and value.value:  # an empty text is no file
        _check_file(scope, param, value, what)
    number = constant(value)
    if param.above is not None and number is not None and number <= param.above:
        scope.findings.trouble(
            value.span, "out-of-range", f"{what} is {number:g}, and must be above {param.above:g}"
        )


def _is_plain(param: Param, value: ast.Expr) -> bool:
    """Whether an argument is what most are: a number where any one fits that is above a bound."""
    if type(value) is not ast.Number or param.type != "number" or param.words:
        return False
    return param.above is None or value.value > param.above


def _check_file(scope: Scope, param: Param, value: ast.Text, what: str) -> None:
    problem = scope.view.reference(value.value)
    if problem is not None:
        scope.findings.trouble(
            value.span,
            problem.code,
            problem.message,
            hint=problem.hint,
            suggestions=problem.suggestions,
        )
    elif not value.value.partition("#")[0].lower().endswith(param.suffixes):
        kinds = " or ".join(param.suffixes)
        scope.findings.trouble(value.span, "wrong-file-type", f"{what} must be a {kinds} file")


def check_words(scope: Scope, param: Param, value: ast.Expr, what: str) -> None:
    """Check an argument that is one of a few bare words, or something that gives a text."""
    word = value.id if isinstance(value, ast.Name) else None
    if isinstance(value, ast.Text):
        word = value.value
    if word in param.words:
        return
    local = scope.locals.get(word or "")
    known = isinstance(local, Slot) or (word is not None and scope.view.value(word) is not None)
    if word is None or (isinstance(value, ast.Name) and known):
        want(scope, value, "string", what)
        return
    scope.findings.trouble(
        value.span,
        "wrong-word",
        f"{what} cannot be `{word}`",
        expected=" or ".join(f"`{each}`" for each in param.words),
        suggestions=nearest(word, param.words),
    )


def _forms(record: Operation) -> str:
    """How many arguments an operation takes, in words."""
    bounds = [counts(form) for form in record.forms]
    if len(bounds) == 1:
        return arguments(bounds[0])
    exact = sorted({count for low, high in bounds for count in range(low, (high or low) + 1)})
    if len(exact) == 1:
        return arguments((exact[0], exact[0]))
    shown = [str(count) if count else "no" for count in exact]
    many = "argument" if exact[-1] == 1 else "arguments"
    return f"{', '.join(shown[:-1])} or {shown[-1]} {many}"


def _signatures(record: Operation, name: str) -> str:
    """The forms of an operation as they are written."""
    return "write " + " or ".join(signature(name, form) for form in record.forms)


def signature(name: str, form: tuple[Param, ...]) -> str:
    """One form as it is written: `at(x, y)`."""
    shown = []
    for param in form:
        text = f"{param.name}: …" if param.named else param.name
        text += ", …" if param.many else ""
        shown.append(f"[{text}]" if param.optional else text)
    return f"{name}({', '.join(shown)})" if shown else name
