"""The elements of a body: which symbols it calls, and whether operations are used as their records say.

In go elements and a scope, out come findings. What an operation is, takes and does is read off its
record alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.checking.arguments import check_arguments
from ipmlang.compiler.checking.expressions import (
    Row,
    Scope,
    Slot,
    arguments,
    article,
    constant,
    inexact_part,
    type_of,
    want,
)
from ipmlang.compiler.checking.findings import CallSite
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.ops.record import Effect


def check_body(scope: Scope, body: Sequence[ast.Element], certain: bool = True) -> None:
    """Check the elements of a body; `certain`: they are made whenever the rule applies."""
    for element in body:
        _element(scope, element, certain)
    _mixture(scope, body)


def _element(scope: Scope, element: ast.Element, certain: bool) -> None:
    match element:
        case ast.Module():
            _module(scope, element, certain)
        case ast.Bracket(body):
            check_body(scope, body, certain)
        case ast.Repeat():
            _repeat(scope, element, certain)
        case ast.Split():
            _split(scope, element)
        case ast.Block(name, args, parts):
            record = _operation(scope, element.span, name)
            if record is not None:
                _use(scope, record, name, args, element.span, parts)
            _parts(scope, parts, certain and record is not None and bool(record.meaning))
        case ast.Each(target, feature, parts):
            _each(scope, element, target, feature)
            _parts(scope, parts, False)
        case ast.Assign(name, value):
            _assign(scope, element, name, value)
        case _:
            assert_never(element)


# --------------------------------------------------------------------------- modules


def _module(scope: Scope, module: ast.Module, certain: bool) -> None:
    name, count = module.name, len(module.args)
    if not count and isinstance(scope.locals.get(name), Slot):
        _parameter_as_symbol(scope, module)
        return
    entry, record = scope.view.symbol(name), OPERATIONS.get(name)
    named = any(argument.name is not None for argument in module.args)
    if entry is not None and not named and count in entry.arities | entry.interpreted:
        _call(scope, module, certain)
    elif entry is not None and entry.kind == "broken":
        for argument in module.args:
            type_of(scope, argument.value)
    elif entry is not None and entry.kind == "asset":
        _call(scope, module, certain)
        if count:
            scope.findings.trouble(module.span, "wrong-arguments",
                                   f"`{name}` is an asset and takes no arguments")  # fmt: skip
    elif record is not None:
        _use(scope, record, name, module.args, module.span, None)
    elif entry is not None and (entry.arities or entry.interpreted):
        _wrong_arity(scope, module, entry.arities or entry.interpreted)
    else:
        _undefined(scope, module, certain)


def _call(scope: Scope, module: ast.Module, certain: bool) -> None:
    types = tuple(type_of(scope, argument.value) for argument in module.args)
    for argument in module.args:
        if argument.name is not None:
            scope.findings.trouble(argument.span, "wrong-arguments",
                                   f"rules take their arguments by place, not by name: "
                                   f"`{argument.name}:`")  # fmt: skip
    sites = scope.findings.calls.setdefault((module.name, len(types)), [])
    sites.append(CallSite(module.span, types, certain))


def _wrong_arity(scope: Scope, module: ast.Module, arities: frozenset[int]) -> None:
    for argument in module.args:
        type_of(scope, argument.value)
    taken = " or ".join(arguments((each, each)) for each in sorted(arities))
    scope.findings.trouble(module.span, "wrong-arguments",
                           f"`{module.name}` takes {taken}, here it has {len(module.args) or 'none'}")  # fmt: skip


def _undefined(scope: Scope, module: ast.Module, certain: bool) -> None:
    """A terminal that nothing defines, or a dotted name that leads nowhere."""
    name = module.name
    alias, dot, rest = name.partition(".")
    if not dot:
        _call(scope, module, certain)
        scope.findings.terminals.setdefault((name, len(module.args)), module.span)
        value = scope.view.value(name)
        if value is not None and not module.args:
            scope.findings.trouble(module.span, "value-as-symbol",
                                   f"`{name}` is {article(value.kind)}, and draws nothing here",
                                   warning=True)  # fmt: skip
        return
    environment = scope.view.environment
    if scope.view.is_import(alias):
        message = f"`{alias}` has no rule or asset called `{rest}`"
        known = list(environment.symbol_names())
    else:
        message = f"no import is called `{alias}`"
        known = [f"{each}.{rest}" for each in environment.imports]
    span = ast.Span(module.span.start, module.span.start + len(name))
    scope.findings.trouble(span, "unknown-symbol", message, suggestions=nearest(name, known))


def _parameter_as_symbol(scope: Scope, module: ast.Module) -> None:
    scope.findings.trouble(
        module.span,
        "parameter-as-symbol",
        f"`{module.name}` is a parameter, and no symbol is called so",
        hint=f"to place the asset that it stands for, write insert({module.name})",
    )


# ------------------------------------------------------------------------ operations


def _operation(scope: Scope, span: ast.Span, name: str) -> Operation | None:
    record = OPERATIONS.get(name)
    if record is None:
        with_parts = [key for key, each in OPERATIONS.items() if each.labels is not None]
        scope.findings.trouble(
            ast.Span(span.start, span.start + len(name)),
            "unknown-operation",
            f"no operation is called `{name}`",
            hint="only operations have parts in braces",
            suggestions=nearest(name, with_parts),
        )
    return record


def _use(
    scope: Scope,
    record: Operation,
    name: str,
    args: Sequence[ast.Argument],
    span: ast.Span,
    parts: Sequence[ast.Part] | None,
) -> None:
    """Check one use of an operation; `parts` is None where it stands without braces."""
    check_arguments(scope, record, name, args, span)
    if not record.meaning:
        scope.findings.not_ready.append((name, ast.Span(span.start, span.start + len(name))))
    example = f"for example {record.examples[0]}" if record.examples else None
    if parts is None and ((record.labels is not None and not record.bare) or
                          (record.axes and record.labels is None)):  # fmt: skip
        scope.findings.trouble(span, "needs-braces", f"`{name}` needs parts in braces", hint=example)
    elif parts is not None and record.labels is None:
        scope.findings.trouble(span, "takes-no-braces", f"`{name}` takes no parts in braces",
                               hint=example)  # fmt: skip
    for part in parts or () if record.labels is not None else ():
        _label(scope, record, name, part)


def _label(scope: Scope, record: Operation, name: str, part: ast.Part) -> None:
    known = [each for each in record.labels or () if each[:1].isalpha()]
    if part.label is None:
        if record.labels and "" not in record.labels:
            scope.findings.trouble(part.span, "wrong-label", f"this part of `{name}` has no label",
                                   expected=_labels(record, known))  # fmt: skip
        return
    wrong = _unfit(part.label, record.labels or ())
    if wrong is not None:
        word = wrong.id if isinstance(wrong, ast.Name) else ""
        if isinstance(wrong, ast.Number):
            word = f"{wrong.value:g}"
        if known or "" not in (record.labels or ()):
            message = f"`{name}` makes no part `{word}`" if word else (
                f"`{name}` makes no such part")  # fmt: skip
        else:
            message = f"the parts of `{name}` have no labels"
        scope.findings.trouble(wrong.span, "wrong-label", message,
                               expected=_labels(record, known) or None,
                               suggestions=nearest(word, known) if word else ())  # fmt: skip


def _labels(record: Operation, known: list[str]) -> str:
    digits = [each[1:] for each in record.labels or () if len(each) > 1 and each[0] == "*"]
    words = [f"`{each}`" for each in known[:8]]
    if digits:
        words.append(f"one digit an axis, each of {', '.join(digits[0])}")
    return ", ".join(words) + (" …" if len(known) > 8 else "")


def _unfit(label: ast.Expr, labels: tuple[str, ...]) -> ast.Expr | None:
    """The part of a label that an operation does not know."""
    match label:
        case ast.Name(name):
            return None if name in labels or "#" in labels else label
        case ast.Text():
            return None if '""' in labels else label
        case ast.Number(value):
            digits = next((each for each in labels if each[:1] == "*"), None)
            if digits is None:
                return label
            return None if digits == "*" or set(f"{value:.0f}") <= set(digits[1:]) else label
        case ast.Unary("not", value):
            return _unfit(value, labels)
        case ast.Binary("and" | "or", left, right):
            return _unfit(left, labels) or _unfit(right, labels)
        case _:
            return label


def _parts(scope: Scope, parts: Sequence[ast.Part], certain: bool) -> None:
    for part in parts:
        check_body(scope, part.body, certain)


def _each(scope: Scope, element: ast.Each, target: ast.Module, feature: str) -> None:
    record = _operation(scope, target.span, target.name)
    if record is None:
        return
    _use(scope, replace(record, bare=True), target.name, target.args, target.span, None)
    if feature not in record.axes:
        makes = ", ".join(f"`{each}`" for each in record.axes)
        scope.findings.trouble(element.span, "wrong-label",
                               f"`{target.name}` has nothing `at each {feature}`",
                               expected=makes or None,
                               suggestions=nearest(feature, record.axes))  # fmt: skip


# ----------------------------------------------------------------- split, repeat, set


def _split(scope: Scope, split: ast.Split) -> None:
    record = OPERATIONS["split"]
    scope.findings.not_ready.append(("split", ast.Span(split.span.start, split.span.start + 5)))
    if split.axis not in record.axes:
        scope.findings.trouble(
            ast.Span(split.span.start, split.span.start + len(f"split {split.axis}")),
            "wrong-label",
            f"`split` knows no axis `{split.axis}`",
            expected=", ".join(f"`{each}`" for each in record.axes),
            suggestions=nearest(split.axis, record.axes),
        )
    check_arguments(scope, record, "split", split.args, split.span)
    _split_parts(scope, split.parts)


def _split_parts(scope: Scope, parts: Sequence[ast.SplitPart | ast.SplitGroup]) -> None:
    for part in parts:
        match part:
            case ast.SplitGroup(parts=inner):
                _split_parts(scope, inner)
            case ast.SplitPart(size, body):
                _size(scope, size)
                check_body(scope, body, False)
            case _:
                assert_never(part)


def _size(scope: Scope, size: ast.Size) -> None:
    want(scope, size.value, "number", "the size of a part")
    value = constant(size.value)
    if value is not None and value <= 0:
        scope.findings.trouble(size.span, "wrong-size", f"a part of size {value:g} makes no shape",
                               expected="a size above 0")  # fmt: skip
    elif value is not None and size.kind == "relative" and value > 1:
        scope.findings.trouble(size.span, "wrong-size",
                               f"a part of {value:g} times the whole does not fit into it",
                               expected="a share up to 1", warning=True)  # fmt: skip


def _repeat(scope: Scope, repeat: ast.Repeat, certain: bool) -> None:
    match repeat.head:
        case ast.Count(variable, limit):
            want(scope, limit, "number", "the count of a `repeat`")
            _warn_inexact(scope, limit, "this count")
            inner = scope.inner(variable, Slot("int"))
            count = constant(limit)
            certain = certain and count is not None and count >= 1
        case ast.Rows(variable, table):
            inner = scope.inner(variable, _row(scope, repeat.head, table))
            certain = False
        case _:
            assert_never(repeat.head)
    if repeat.rows is not None:
        bound = _row(scope, repeat.rows, repeat.rows.table)
        inner = inner.inner(repeat.rows.variable, bound)
    for hole in repeat.holes:
        want(scope, hole, "int", "a hole of a `repeat`")
    for step in repeat.steps:
        want(scope, step, "number", "a step of a `repeat`")
    check_body(inner, repeat.body, certain)


def _row(scope: Scope, rows: ast.Rows, table: str) -> Row:
    entry = scope.view.value(table)
    if entry is not None and entry.kind == "broken":
        return Row(table, None)
    if entry is not None and entry.kind == "table":
        scope.findings.reads.setdefault(table, rows.span)
        return Row(table, entry.columns)
    if entry is not None:
        message = f"`{table}` is {article(entry.kind)}, not a table"
    else:
        message = f"no table is called `{table}`"
    tables = [name for name, each in scope.view.environment.values.items() if each.kind == "table"]
    scope.findings.trouble(rows.span, "unknown-table", message,
                           suggestions=nearest(table, tables))  # fmt: skip
    return Row(table, None)


def _assign(scope: Scope, element: ast.Assign, name: str, value: ast.Expr) -> None:
    entry = scope.view.value(name)
    if entry is not None and entry.kind == "attribute":
        scope.findings.reads.setdefault(name, element.span)
        want(scope, value, entry.type, f"`{name}`")
        return
    type_of(scope, value)
    if entry is not None and entry.kind == "broken":
        return
    attributes = [key for key, each in scope.view.environment.values.items()
                  if each.kind == "attribute"]  # fmt: skip
    if entry is not None:
        message = f"`{name}` is {article(entry.kind)}: only an attribute can be set"
    elif name in scope.locals:
        message = f"`{name}` is a parameter: only an attribute can be set"
    else:
        message = f"no attribute is called `{name}`"
    scope.findings.trouble(element.span, "not-an-attribute", message,
                           suggestions=nearest(name, attributes))  # fmt: skip


def _warn_inexact(scope: Scope, expr: ast.Expr, what: str) -> None:
    part = inexact_part(scope, expr)
    if part is not None:
        name = part.name if isinstance(part, ast.Call) else part.id
        scope.findings.trouble(
            part.span,
            "inexact-decision",
            f"{what} hangs on `{name}`, whose last digits differ between machines",
            hint="round what it gives, so that a tiny difference decides nothing",
            warning=True,
        )


def warn_inexact_guard(scope: Scope, guard: ast.Expr) -> None:
    """Warn where a guard may come out differently on another machine."""
    _warn_inexact(scope, guard, "this guard")


# --------------------------------------------------------------------------- mixtures


def _mixture(scope: Scope, body: Sequence[ast.Element]) -> None:
    """Warn of a body that moves the turtle and works on the scope outside brackets."""
    motion = _first(scope, body, "motion")
    work = _first(scope, body, "scope")
    if motion is None or work is None:
        return
    scope.findings.trouble(
        motion[1],
        "mixed-body",
        f"the turtle's `{motion[0]}` carries on behind this rule, and the scope's `{work[0]}` ends "
        "with it",
        hint=f"put brackets around the turtle's part: [ {motion[0]} … ]",
        warning=True,
        other=(work[1], "works on the scope"),
    )


def _first(
    scope: Scope, body: Sequence[ast.Element], effect: Effect
) -> tuple[str, ast.Span] | None:
    for element in body:
        match element:
            case ast.Module(name) | ast.Block(name) | ast.Each(target=ast.Module(name)):
                pass
            case ast.Split():
                name = "split"
            case _:
                continue
        record = OPERATIONS.get(name)
        if record is not None and record.effect == effect and scope.view.symbol(name) is None:
            return name, element.span
    return None
