"""Types of expressions, and what is wrong in them.

In go an expression, what its names stand for and, where it is known, the type that is wanted; out
come its type and troubles. A parameter has no type of its own: it takes the first one that is asked
of it, and the rest of the rule must agree.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import chain
from typing import Literal, assert_never

from ipmlang.compiler import ast
from ipmlang.compiler.checked import ValueEntry
from ipmlang.compiler.checking.asked import note_asked
from ipmlang.compiler.checking.contexts import check_fetched, want_context
from ipmlang.compiler.checking.environment import View
from ipmlang.compiler.checking.findings import Findings
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import CONSTANTS, FUNCTIONS, OPERATIONS, OPERATORS, PREFIXES, QUERIES
from ipmlang.compiler.ops.queries import HERE
from ipmlang.compiler.ops.record import Param, ValueType
from ipmlang.compiler.types import COLOR_WORDS, PHRASES, common, fits, is_color


@dataclass(slots=True, eq=False)
class Slot:
    """A parameter, the number of a copy or a name that a body gives: the type asked of it, and
    where that was. `source`: what else has its value; `exact`: it may feed a decision;
    `valued`: where its value is first read, other than to hand it on.
    """

    type: ValueType = "any"
    place: ast.Span | None = None
    kind: Literal["parameter", "local name"] = "parameter"
    source: Slot | None = None
    exact: bool = True
    read: bool = False
    valued: ast.Span | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table: its columns, None where they are unknown; the symbols that rows place."""

    table: str
    columns: tuple[str, ...] | None
    shapes: tuple[str, ...] = ()


@dataclass(slots=True, eq=False)
class Scope:
    """What an expression sees: the file's names through `view`, its locals, where to report."""

    view: View
    findings: Findings
    locals: dict[str, Slot | Row] = field(default_factory=dict)

    def inner(self, name: str, bound: Slot | Row) -> Scope:
        """The scope of a repeat's body, or of what follows a local name."""
        return Scope(self.view, self.findings, {**self.locals, name: bound})


def want(scope: Scope, expr: ast.Expr, expected: ValueType, what: str) -> None:
    """Check that an expression has a type; `what` it is for, as "`distance` of `f`"."""
    if expected == "context":
        want_context(scope.view, scope.findings, scope.locals, expr, what)
        return
    if isinstance(expr, ast.Name) and _ask(scope, expr, expected):
        return
    if isinstance(expr, ast.If) and expected != "any":
        want(scope, expr.condition, "bool", "what follows `if`")
        want(scope, expr.value, expected, what)
        want(scope, expr.other, expected, what)
        return
    actual = type_of(scope, expr)
    if expected == "color" and isinstance(expr, ast.Text):
        _want_color(scope, expr)
    elif not fits(actual, expected):
        _mismatch(scope, expr.span, what, expected, PHRASES[actual])
    elif expected == "int" and (value := constant(expr)) is not None and value % 1:
        _mismatch(scope, expr.span, what, expected, f"{value:g}")


def _mismatch(scope: Scope, span: ast.Span, what: str, expected: ValueType, found: str) -> None:
    scope.findings.trouble(
        span,
        "wrong-type",
        f"{what} must be {PHRASES[expected]}, and this is {found}",
        expected=PHRASES[expected],
    )


def _ask(scope: Scope, name: ast.Name, expected: ValueType) -> bool:
    """Ask a type of a parameter; false when the name is none."""
    slot = scope.locals.get(name.id)
    if not isinstance(slot, Slot):
        return False
    slot.read = True
    slot.valued = slot.valued or name.span
    if slot.type == "any":
        settle(slot, expected, name.span)
    elif slot.type == "symbol":  # that it has no value is said once, by whoever knows all rules
        return True
    elif not fits(slot.type, expected):
        used = None if slot.place is None else (slot.place, f"here it is {PHRASES[slot.type]}")
        scope.findings.trouble(
            name.span,
            "wrong-type",
            f"`{name.id}` cannot be both {PHRASES[slot.type]} and {PHRASES[expected]}",
            other=used,
        )
    return True


def settle(slot: Slot | None, expected: ValueType, place: ast.Span) -> None:
    """A value takes a type under all its names."""
    while slot is not None and slot.type == "any":
        slot.type, slot.place = expected, place
        slot = slot.source


def _want_color(scope: Scope, text: ast.Text) -> None:
    if not is_color(text.value):
        scope.findings.trouble(
            text.span,
            "not-a-color",
            f'"{text.value}" is no colour',
            expected="`#rgb`, `#rrggbb` or the name of a colour",
            suggestions=scope.view.environment.nearest("color", text.value.lower(), COLOR_WORDS),
        )


def type_of(scope: Scope, expr: ast.Expr) -> ValueType:
    """The type of an expression; what is wrong in it is reported."""
    match expr:
        case ast.Number(value):
            return "int" if value % 1 == 0 else "number"
        case ast.Text():
            return "string"
        case ast.Truth():
            return "bool"
        case ast.Name():
            return _name(scope, expr)
        case ast.Call():
            return _call(scope, expr)
        case ast.Unary(op, value):
            record = FUNCTIONS[PREFIXES[op]]
            want(scope, value, record.params[0].type, f"what follows `{op}`")
            return record.result
        case ast.Binary():
            return _binary(scope, expr)
        case ast.If(condition, value, other):
            want(scope, condition, "bool", "what follows `if`")
            return _common(scope, expr.span, (value, other), "the two outcomes of this `if`")
        case ast.Tuple(items):
            for item in items:
                want(scope, item, "number", "a coordinate")
            if not 2 <= len(items) <= 3:
                scope.findings.trouble(expr.span, "wrong-arguments", "a vector has 2 or 3 numbers")
            return "vector"
        case _:
            assert_never(expr)


def _binary(scope: Scope, expr: ast.Binary) -> ValueType:
    record = FUNCTIONS[OPERATORS[expr.op]]
    if record.params[0].type == "any":
        _common(scope, expr.span, (expr.left, expr.right), f"the two sides of `{expr.op}`")
    else:
        want(scope, expr.left, record.params[0].type, f"the left side of `{expr.op}`")
        want(scope, expr.right, record.params[1].type, f"the right side of `{expr.op}`")
    return record.result


def _common(scope: Scope, span: ast.Span, values: tuple[ast.Expr, ...], what: str) -> ValueType:
    """The type that all values have; they must have one."""
    types = [type_of(scope, value) for value in values]
    known: ValueType = next((each for each in types if each != "any"), "any")
    found: ValueType | None = types[0] if types else "any"
    for value, each in zip(values, types, strict=True):
        if each == "any" and isinstance(value, ast.Name):
            _ask(scope, value, known)
        found = None if found is None else common(found, each if each != "any" else known)
    if found is None:
        kinds = " and ".join(dict.fromkeys(PHRASES[each] for each in types))
        scope.findings.trouble(span, "wrong-type", f"{what} are {kinds}", expected="the same type")
    return found or "any"


# ----------------------------------------------------------------------------- names


def _name(scope: Scope, name: ast.Name) -> ValueType:
    local = scope.locals.get(name.id)
    if isinstance(local, Slot):
        local.read = True
        local.valued = local.valued or name.span
        return local.type
    head, dot, column = name.id.partition(".")
    row = scope.locals.get(head)
    if dot and isinstance(row, Row):
        return _column(scope, name, row, column)
    if isinstance(local, Row):
        shown = local.columns[0] if local.columns else "column"
        scope.findings.trouble(
            name.span,
            "wrong-type",
            f"`{name.id}` is a row of a table",
            hint=f"name a column of it: {name.id}.{shown}",
        )
        return "any"
    entry = scope.view.value(name.id)
    if entry is not None:
        return _entry(scope, name, entry)
    if name.id in CONSTANTS:
        return "number"
    query = QUERIES.get(name.id)
    if query is not None and query.params is None:
        if not query.ready:
            scope.findings.not_ready.append((name.id, name.span))
        return query.result
    if head == HERE and dot and (entry := scope.view.value(column)) and entry.kind == "context":
        scope.findings.not_ready.append((name.id, name.span))
        return entry.type
    _unknown_name(scope, name)
    return "any"


def _column(scope: Scope, name: ast.Name, row: Row, column: str) -> ValueType:
    if row.columns is not None and column not in row.columns:
        scope.findings.trouble(
            name.span,
            "no-such-column",
            f"table `{row.table}` has no column `{column}`",
            expected=f"one of {', '.join(f'`{each}`' for each in row.columns)}",
            suggestions=nearest(column, row.columns),
        )
    return "any"


def _entry(scope: Scope, name: ast.Name, entry: ValueEntry) -> ValueType:
    scope.findings.reads.setdefault(name.id, name.span)
    match entry.kind:
        case "function":
            names = ", ".join(entry.parameters)
            scope.findings.trouble(
                name.span,
                "wrong-type",
                f"`{name.id}` is a function",
                expected=f"its arguments: {name.id}({names})",
            )
            return "any"
        case "table":
            scope.findings.trouble(
                name.span,
                "wrong-type",
                f"`{name.id}` is a table, not a value",
                hint=f"take its rows: repeat(r in {name.id}) {{ … }}",
            )
            return "any"
        case "context":
            scope.findings.not_ready.append((name.id, name.span))
            return entry.type
        case _:
            return entry.type


def _unknown_name(scope: Scope, name: ast.Name) -> None:
    environment = scope.view.environment
    alias, dot, rest = name.id.partition(".")
    if scope.view.symbol(name.id) is not None or name.id in OPERATIONS:
        kind = "an operation" if name.id in OPERATIONS else "a rule"
        scope.findings.trouble(name.span, "unknown-name", f"`{name.id}` is {kind}, not a value")
        return
    message = f"nothing is called `{name.id}` here"
    if dot and scope.view.is_import(alias):
        message = f"`{alias}` has nothing called `{rest}`"
    known = chain(environment.names(), CONSTANTS, QUERIES)
    close = (*environment.nearest("value", name.id, known), *scope.locals)
    scope.findings.trouble(name.span, "unknown-name", message, suggestions=nearest(name.id, close))


# ----------------------------------------------------------------------------- calls


def _call(scope: Scope, call: ast.Call) -> ValueType:
    for argument in call.args:
        if argument.name is not None:
            scope.findings.trouble(
                argument.span,
                "wrong-arguments",
                f"functions take their arguments by place, not by name: `{argument.name}:`",
            )
    entry = scope.view.value(call.name)
    if entry is not None and entry.kind == "function":
        scope.findings.reads.setdefault(call.name, call.span)
        params = tuple(
            Param(name, kind) for name, kind in zip(entry.parameters, entry.takes, strict=False)
        ) or tuple(Param(name, "any") for name in entry.parameters)
        _arguments(scope, call, params)
        return entry.type
    record = FUNCTIONS.get(call.name)
    if record is not None:
        types = _arguments(scope, call, record.params)
        return record.result if record.result != "any" else types
    query = QUERIES.get(call.name)
    if query is not None and query.params is not None:
        if not query.ready:
            scope.findings.not_ready.append((call.name, call.span))
        if not check_fetched(scope.view, scope.findings, query, call):
            note_asked(scope.findings, query, call)
        _arguments(scope, call, query.params)
        return query.result
    if entry is not None and entry.kind == "broken":
        for argument in call.args:
            type_of(scope, argument.value)
    else:
        _unknown_function(scope, call, entry)
    return "any"


def _arguments(scope: Scope, call: ast.Call, params: tuple[Param, ...]) -> ValueType:
    """Check a call's arguments; the common type of those that may be anything."""
    if not takes(params, len(call.args)):
        scope.findings.trouble(
            call.span,
            "wrong-arguments",
            f"`{call.name}` takes {arguments(counts(params))}, "
            f"here it has {len(call.args) or 'none'}",
        )
    free: list[ast.Expr] = []
    for index, argument in enumerate(call.args):
        param = params[min(index, len(params) - 1)] if params else Param("value", "any")
        if param.type == "any":
            free.append(argument.value)
        else:
            want(scope, argument.value, param.type, f"`{param.name}` of `{call.name}`")
    return _common(scope, call.span, tuple(free), f"the values of `{call.name}`") if free else "any"


def _unknown_function(scope: Scope, call: ast.Call, entry: ValueEntry | None) -> None:
    for argument in call.args:
        type_of(scope, argument.value)
    if entry is not None:
        message = f"`{call.name}` is no function: it is {article(entry.kind)}"
    elif call.name in OPERATIONS:
        message = f"`{call.name}` is an operation, not a function"
    elif scope.view.symbol(call.name) is not None:
        message = f"`{call.name}` is a rule, not a function"
    else:
        message = f"no function is called `{call.name}`"
    environment = scope.view.environment
    known = chain(FUNCTIONS, environment.names())
    scope.findings.trouble(
        ast.Span(call.span.start, call.span.start + len(call.name)),
        "unknown-function",
        message,
        suggestions=() if entry else environment.nearest("function", call.name, known),
    )


def takes(params: tuple[Param, ...], given: int) -> bool:
    """Whether so many arguments by place fit."""
    low, high = counts(params)
    return low <= given and (high is None or given <= high)


def counts(params: tuple[Param, ...]) -> tuple[int, int | None]:
    """The fewest and the most arguments by place; None: any number."""
    placed = [each for each in params if not each.named]
    low = sum(not (each.optional or each.many) for each in placed)
    return low, None if any(each.many for each in placed) else len(placed)


def arguments(bounds: tuple[int, int | None]) -> str:
    """How many arguments, in words."""
    low, high = bounds
    if high == 0:
        return "no arguments"
    if high is None:
        return f"{low} arguments or more"
    if low == high:
        return f"{low} argument" if low == 1 else f"{low} arguments"
    return (
        f"at most {high} argument{'s' * (high > 1)}" if low == 0 else f"{low} to {high} arguments"
    )


def article(word: str) -> str:
    """The word with `a` or `an`."""
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def constant(expr: ast.Expr) -> float | None:
    """The value of an expression of literals; None for any other, and where it has no value."""
    match expr:
        case ast.Number(value):
            return value
        case ast.Unary("-", value):
            inner = constant(value)
            return None if inner is None else -inner
        case ast.Binary(op, left, right) if op in ("+", "-", "*", "/"):
            first, second = constant(left), constant(right)
            if first is None or second is None:
                return None
            return FUNCTIONS[OPERATORS[op]].single(first, second)
        case _:
            return None
