"""The elements of a body: which symbols it calls, and how it uses operations.

In go elements and a scope, out come findings. What an operation is, takes and does is read off its
record alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias, assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.checking.arguments import check_arguments
from ipmlang.compiler.checking.asked import note_snapped
from ipmlang.compiler.checking.exactness import warn_inexact
from ipmlang.compiler.checking.expressions import (
    Row,
    Scope,
    Slot,
    arguments,
    article,
    constant,
    type_of,
    want,
)
from ipmlang.compiler.checking.findings import CallSite
from ipmlang.compiler.checking.locals import warn_unread, with_local
from ipmlang.compiler.checking.operations import (
    find_operation,
    use_at_each,
    use_operation,
    warn_of_mixture,
)
from ipmlang.compiler.checking.symbols import place_parameter, type_given
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.compiler.ops.record import ValueType
from ipmlang.compiler.places import COLUMNS, SHAPE, row_of

_Element: TypeAlias = (
    ast.Module | ast.Bracket | ast.Repeat | ast.Split | ast.Block | ast.Each | ast.Assign
)


def check_body(
    scope: Scope, body: Sequence[ast.Element], certain: bool = True, ends: bool = False
) -> None:
    """Check the elements of a body; `certain`: they are made whenever the rule applies; `ends`: a
    bracket closes behind them, where turtle and scope are what they were.
    """
    outer, named = scope, []
    for element in body:
        if isinstance(element, ast.Local):
            scope = with_local(scope, element)
            named.append((element, scope))
        else:
            _element(scope, element, certain)
    warn_unread(outer, named)
    if not ends:
        warn_of_mixture(scope, body)


def _element(scope: Scope, element: _Element, certain: bool) -> None:
    match element:
        case ast.Module():
            _module(scope, element, certain)
        case ast.Bracket(body):
            check_body(scope, body, certain, ends=True)
        case ast.Repeat():
            _repeat(scope, element, certain)
        case ast.Split():
            _split(scope, element)
        case ast.Block(name, args, parts):
            record = find_operation(scope, element.span, name)
            if record is not None:
                use_operation(scope, record, name, args, element.span, parts)
            _parts(scope, parts, certain and record is not None and bool(record.meaning))
        case ast.Each(parts=parts):
            use_at_each(scope, element)
            _parts(scope, parts, False)
        case ast.Assign(name, value):
            _assign(scope, element, name, value)
        case _:
            assert_never(element)


# --------------------------------------------------------------------------- modules


def _module(scope: Scope, module: ast.Module, certain: bool) -> None:
    name, count = module.name, len(module.args)
    row = scope.locals.get(row_of(name))
    if isinstance(row, Row) and row.shapes and not count:
        for shape in row.shapes:
            _call(scope, replace(module, name=shape), False)
        return
    local = scope.locals.get(name)
    if not count and isinstance(local, Slot):
        local.read = True
        place_parameter(scope, module, local)
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
            scope.findings.trouble(
                module.span, "wrong-arguments", f"`{name}` is an asset and takes no arguments"
            )
    elif record is not None:
        use_operation(scope, record, name, module.args, module.span, None)
    elif entry is not None and (entry.arities or entry.interpreted):
        _wrong_arity(scope, module, entry.arities or entry.interpreted)
    else:
        _undefined(scope, module, certain)


def _call(scope: Scope, module: ast.Module, certain: bool) -> None:
    types: list[ValueType] = []
    named: list[tuple[int, ast.Name]] = []
    for number, argument in enumerate(module.args):
        found: list[ast.Name] = []
        types.append(type_given(scope, argument.value, found))
        named += ((number, name) for name in found)
    for argument in module.args:
        if argument.name is not None:
            scope.findings.trouble(
                argument.span,
                "wrong-arguments",
                f"rules take their arguments by place, not by name: `{argument.name}:`",
            )
    sites = scope.findings.calls.setdefault((module.name, len(types)), [])
    sites.append(CallSite(module.span, tuple(types), certain, tuple(named)))


def _wrong_arity(scope: Scope, module: ast.Module, arities: frozenset[int]) -> None:
    for argument in module.args:
        type_of(scope, argument.value)
    taken = " or ".join(arguments((each, each)) for each in sorted(arities))
    scope.findings.trouble(
        module.span,
        "wrong-arguments",
        f"`{module.name}` takes {taken}, here it has {len(module.args) or 'none'}",
    )


def _undefined(scope: Scope, module: ast.Module, certain: bool) -> None:
    """A terminal that nothing defines, or a dotted name that leads nowhere."""
    name = module.name
    alias, dot, rest = name.partition(".")
    if not dot:
        _call(scope, module, certain)
        scope.findings.terminals.setdefault((name, len(module.args)), module.span)
        value = scope.view.value(name)
        if value is not None and not module.args:
            scope.findings.trouble(
                module.span,
                "value-as-symbol",
                f"`{name}` is {article(value.kind)}, and draws nothing here",
                warning=True,
            )
        return
    environment = scope.view.environment
    if scope.view.is_import(alias):
        message = f"`{alias}` has no rule or asset called `{rest}`"
        known = list(environment.symbol_names())
    else:
        message = f"no import or style is called `{alias}`"
        known = [f"{each}.{rest}" for each in (*environment.imports, *environment.styles)]
        known = [each for each in known if environment.symbol(each) is not None] or known
    span = ast.Span(module.span.start, module.span.start + len(name))
    scope.findings.trouble(
        span, "unknown-symbol", message, suggestions=environment.nearest("symbol", name, known)
    )


def _parts(scope: Scope, parts: Sequence[ast.Part], certain: bool) -> None:
    for part in parts:
        check_body(scope, part.body, certain)


# ----------------------------------------------------------------- split, repeat, set


def _split(scope: Scope, split: ast.Split) -> None:
    record = OPERATIONS["split"]
    if not record.meaning:
        place = ast.Span(split.span.start, split.span.start + 5)
        scope.findings.not_ready.append(("split", place))
    if split.axis not in record.axes:
        scope.findings.trouble(
            ast.Span(split.span.start, split.span.start + len(f"split {split.axis}")),
            "wrong-label",
            f"`split` knows no axis `{split.axis}`",
            expected=", ".join(f"`{each}`" for each in record.axes),
            suggestions=nearest(split.axis, record.axes),
        )
    check_arguments(scope, record, "split", split.args, split.span)
    if split.args and split.axis in record.axes and split.axis not in ("x", "y", "z"):
        scope.findings.trouble(
            split.span,
            "wrong-arguments",
            f"`split {split.axis}` cannot snap: lines stand across x, y or z",
        )
    note_snapped(scope.findings, split)
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
        scope.findings.trouble(
            size.span,
            "wrong-size",
            f"a part of size {value:g} makes no shape",
            expected="a size above 0",
        )
    elif value is not None and size.kind == "relative" and value > 1:
        scope.findings.trouble(
            size.span,
            "wrong-size",
            f"a part of {value:g} times the whole does not fit into it",
            expected="a share up to 1",
            warning=True,
        )


def _repeat(scope: Scope, repeat: ast.Repeat, certain: bool) -> None:
    match repeat.head:
        case ast.Count(variable, limit):
            want(scope, limit, "number", "the count of a `repeat`")
            warn_inexact(scope, limit, "this count")
            inner = scope.inner(variable, Slot("int"))
            count = constant(limit)
            certain = certain and count is not None and count >= 1
        case ast.Rows(variable, table, places):
            columns = columns_of(scope, table, repeat.head.span)
            if places and columns is not None and set(COLUMNS).isdisjoint(columns):
                _no_place(scope, repeat.head, columns)
            inner = scope.inner(variable, _row(scope, table, columns))
            certain = False
        case _:
            assert_never(repeat.head)
    if repeat.rows is not None:
        table = repeat.rows.table
        bound = _row(scope, table, columns_of(scope, table, repeat.rows.span))
        inner = inner.inner(repeat.rows.variable, bound)
    for hole in repeat.holes:
        want(scope, hole, "int", "a hole of a `repeat`")
    for step in repeat.steps:
        want(scope, step, "number", "a step of a `repeat`")
    check_body(inner, repeat.body, certain)


def _row(scope: Scope, table: str, columns: tuple[str, ...] | None) -> Row:
    """A row of a table; its column of symbols holds no values."""
    entry = scope.view.value(table)
    shapes = () if entry is None else entry.shapes
    if shapes and columns is not None:
        columns = tuple(each for each in columns if each != SHAPE)
    return Row(table, columns, shapes)


def _no_place(scope: Scope, rows: ast.Rows, columns: Sequence[str]) -> None:
    """A table whose rows do not say where anything stands."""
    scope.findings.trouble(
        rows.span,
        "no-place",
        f"the rows of `{rows.table}` are no places: its columns are {', '.join(columns)}",
        expected=f"a column {', '.join(COLUMNS[:-1])} or {COLUMNS[-1]}",
        hint=f"`repeat(r in {rows.table})` only reads the rows",
    )


def columns_of(scope: Scope, table: str, span: ast.Span) -> tuple[str, ...] | None:
    """The columns of a table that is read at a place; None where they are not known."""
    entry = scope.view.value(table)
    if entry is not None and entry.kind == "broken":
        return None
    if entry is not None and entry.kind == "table":
        scope.findings.reads.setdefault(table, span)
        return entry.columns
    if entry is not None:
        message = f"`{table}` is {article(entry.kind)}, not a table"
    else:
        message = f"no table is called `{table}`"
    tables = [name for name, each in scope.view.environment.values.items() if each.kind == "table"]
    scope.findings.trouble(
        span,
        "unknown-table",
        message,
        suggestions=scope.view.environment.nearest("table", table, tables),
    )
    return None


def _assign(scope: Scope, element: ast.Assign, name: str, value: ast.Expr) -> None:
    entry = scope.view.value(name)
    if entry is not None and entry.kind == "attribute":
        scope.findings.reads.setdefault(name, element.span)
        want(scope, value, entry.type, f"`{name}`")
        return
    type_of(scope, value)
    if entry is not None and entry.kind == "broken":
        return
    attributes = [
        key for key, each in scope.view.environment.values.items() if each.kind == "attribute"
    ]
    if entry is not None:
        message = f"`{name}` is {article(entry.kind)}: only an attribute can be set"
    elif name in scope.locals:
        local = scope.locals[name]
        kind = local.kind if isinstance(local, Slot) else "row"
        message = f"`{name}` is a {kind}: only an attribute can be set"
    else:
        message = f"no attribute is called `{name}`"
    scope.findings.trouble(
        element.span,
        "not-an-attribute",
        message,
        suggestions=scope.view.environment.nearest("attribute", name, attributes),
    )
