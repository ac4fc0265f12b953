"""One top-level item by itself: its own values, and the bodies and expressions in it.

In go an item and a view of the names around it, out come findings. What several items say together
(two rules of one symbol, two definitions of one name) is checked elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from ipmlang.compiler import ast
from ipmlang.compiler.checked import ValueEntry
from ipmlang.compiler.checking.arguments import check_argument
from ipmlang.compiler.checking.elements import check_body
from ipmlang.compiler.checking.environment import Environment, View
from ipmlang.compiler.checking.exactness import inexact_part, warn_inexact
from ipmlang.compiler.checking.expressions import (
    Scope,
    Slot,
    constant,
    type_of,
    want,
)
from ipmlang.compiler.checking.findings import Findings
from ipmlang.compiler.checking.residuals import check_residual
from ipmlang.compiler.checking.starts import check_start
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import CONSTANTS, FUNCTIONS, SETTINGS
from ipmlang.compiler.ops.record import Param, ValueType
from ipmlang.compiler.ops.settings import VERSIONS
from ipmlang.compiler.passing import context_modules, passing
from ipmlang.compiler.places import SHAPE
from ipmlang.compiler.types import ATTR_TYPES, NUMERIC, PHRASES, fits


def check_item(environment: Environment, item: ast.Item) -> Findings:
    """All that one item gives."""
    findings = Findings()
    scope = Scope(View(environment, findings.answers), findings)
    match item:
        case ast.Rule():
            _rule(scope, item)
        case ast.Attr():
            _attr(scope, item)
        case ast.Const(value=value):
            _new_name(scope, item.name, item.span)
            findings.result = type_of(scope, value)
            findings.exact = inexact_part(scope, value) is None
        case ast.Function():
            _function(scope, item)
        case ast.Table():
            _table(scope, item)
        case ast.Turtle(settings):
            _settings(scope, "turtle", settings)
        case ast.Limit(settings):
            _settings(scope, "limit", settings)
        case ast.Tropism(vector, elasticity):
            want(scope, vector, "vector", "the direction of a tropism")
            want(scope, elasticity, "number", "the strength of a tropism")
        case ast.Canvas():
            _rectangle(scope, item.box, "the canvas")
        case ast.Field(place=place) if place is not None:
            _rectangle(scope, place, "the context")
        case ast.Residual():
            check_residual(scope, item)
        case ast.Site(radius=radius) if radius is not None:
            want(scope, radius, "number", "a radius")
            _above_zero(scope, radius, "a radius")
        case ast.Start():
            check_start(scope, item)
        case ast.Version(number):
            _version(scope, item, number)
        case _:
            pass
    _close(scope)
    return findings


def entry_of(environment: Environment, item: ast.Item, index: int) -> ValueEntry:
    """What a constant, function or attribute stands for, its type found from its value."""
    found = check_item(environment, item)
    match item:
        case ast.Attr():
            return ValueEntry("attribute", found.result, exact=True, item=index)
        case ast.Function():
            names = tuple(name for name, _ in found.parameters)
            types = tuple(kind for _, kind in found.parameters)
            return ValueEntry("function", found.result, names, None, types, found.exact, index)
        case _:
            return ValueEntry("constant", found.result, exact=found.exact, item=index)


def _close(scope: Scope) -> None:
    """Sum up the calls: the graph's edges, and the calls with arguments other than numbers."""
    findings = scope.findings
    findings.edges = tuple(
        (key, any(site.certain for site in sites)) for key, sites in findings.calls.items()
    )
    findings.odd = frozenset(
        key
        for key, sites in findings.calls.items()
        if any(kind not in NUMERIC for site in sites for kind in site.types)
    )
    findings.named = tuple(
        key for key, sites in findings.calls.items() if any(site.named for site in sites)
    )
    findings.asks = any(kind not in NUMERIC for _, kind in findings.parameters)
    findings.references = tuple(name for kind, name in findings.answers if kind == "reference")


# ----------------------------------------------------------------------------- rules


def _rule(scope: Scope, rule: ast.Rule) -> None:
    head = rule.head
    beside = [each for module in context_modules(head) for each in module.parameters]
    _bind(scope, [*beside, *head.parameters])
    if head.name.rpartition(".")[2] == "nil":
        scope.findings.trouble(head.span, "reserved-name", "`nil` makes nothing and has no rules")
    if rule.guard is not None and not isinstance(rule.guard, ast.Otherwise):
        want(scope, rule.guard, "bool", "a guard")
        warn_inexact(scope, rule.guard, "this guard")
    if rule.chance is not None:
        _chance(scope, rule.chance)
    check_body(scope, rule.body)
    for each in beside:
        if _slot_type(scope, each.name) == "symbol":
            message = f"`{each.name}` is a parameter of a neighbour, and cannot be a symbol"
            scope.findings.trouble(each.span, "symbol-in-context", message)
    own = ((each.name, scope.locals[each.name]) for each in head.parameters)
    scope.findings.valued = {
        name: slot.valued for name, slot in own if isinstance(slot, Slot) and slot.valued
    }
    found = passing(rule)
    scope.findings.passing = found if found.placed or found.passed else None
    scope.findings.parameters = tuple(
        (each.name, _slot_type(scope, each.name)) for each in head.parameters
    )


def _bind(scope: Scope, parameters: Sequence[ast.Parameter]) -> None:
    for parameter in parameters:
        if parameter.name in scope.locals:
            scope.findings.trouble(
                parameter.span, "duplicate-name", f"two parameters are called `{parameter.name}`"
            )
        scope.locals[parameter.name] = Slot()


def _slot_type(scope: Scope, name: str) -> ValueType:
    slot = scope.locals[name]
    return slot.type if isinstance(slot, Slot) else "any"


def _chance(scope: Scope, chance: ast.Chance) -> None:
    what = "a percentage" if chance.kind == "percent" else "a weight"
    want(scope, chance.value, "number", what)
    warn_inexact(scope, chance.value, what)
    value = constant(chance.value)
    if value is None:
        return
    if value < 0:
        scope.findings.trouble(
            chance.value.span, "out-of-range", f"{what} is {value:g}, and cannot be negative"
        )
    elif chance.kind == "percent" and value > 100:
        scope.findings.trouble(
            chance.value.span,
            "over-100-percent",
            f"a percentage is {value:g}, and cannot be above 100",
        )


# ----------------------------------------------------------- attributes and functions


def _new_name(scope: Scope, name: str, span: ast.Span) -> None:
    """A name of the file must not hide a built-in one."""
    if name in FUNCTIONS or name in CONSTANTS:
        kind = "function" if name in FUNCTIONS else "constant"
        scope.findings.trouble(
            span,
            "duplicate-name",
            f"`{name}` is a built-in {kind} already",
            hint="give it another name",
        )


def _attr(scope: Scope, attr: ast.Attr) -> None:
    _new_name(scope, attr.name, attr.span)
    what = f"the default of `{attr.name}`"
    declared = ATTR_TYPES.get(attr.type or "")
    if attr.type is not None and declared is None:
        scope.findings.trouble(
            attr.span,
            "unknown-type",
            f"there is no type `{attr.type}`",
            expected=", ".join(f"`{each}`" for each in ATTR_TYPES),
            suggestions=nearest(attr.type, ATTR_TYPES),
        )
    if declared is not None:
        want(scope, attr.default, declared, what)
        scope.findings.result = declared
    else:
        scope.findings.result = _default_type(type_of(scope, attr.default))
    if attr.allowed is not None:
        _allowed(scope, attr, scope.findings.result)


def _default_type(found: ValueType) -> ValueType:
    """An attribute whose type is not written may be any number when its default is one."""
    return "number" if found == "int" else found


def _allowed(scope: Scope, attr: ast.Attr, kind: ValueType) -> None:
    match attr.allowed:
        case ast.Range(low, high):
            if not fits(kind, "number"):
                scope.findings.trouble(
                    attr.allowed.span,
                    "wrong-type",
                    f"a range is for numbers, and `{attr.name}` is {PHRASES[kind]}",
                    hint="list its values: in { …, … }",
                )
            for end in (low, high):
                if end is not None:
                    want(scope, end, "number", f"an end of the range of `{attr.name}`")
            _in_range(scope, attr, low, high)
        case ast.Choices(values):
            for value in values:
                want(scope, value, kind, f"a choice of `{attr.name}`")
            if isinstance(attr.default, ast.Number | ast.Text) and attr.default not in values:
                scope.findings.trouble(
                    attr.default.span,
                    "out-of-range",
                    f"the default of `{attr.name}` is none of its choices",
                    other=(attr.allowed.span, "the choices"),
                )
        case _:
            pass


def _in_range(scope: Scope, attr: ast.Attr, low: ast.Expr | None, high: ast.Expr | None) -> None:
    least = None if low is None else constant(low)
    most = None if high is None else constant(high)
    value = constant(attr.default)
    assert attr.allowed is not None
    if least is not None and most is not None and least > most:
        scope.findings.trouble(
            attr.allowed.span,
            "out-of-range",
            f"the range of `{attr.name}` is empty: {least:g} is above {most:g}",
        )
    elif value is not None and (
        (least is not None and value < least) or (most is not None and value > most)
    ):
        scope.findings.trouble(
            attr.default.span,
            "out-of-range",
            f"the default of `{attr.name}` is {value:g}, outside its range",
            other=(attr.allowed.span, "the range"),
        )


def _function(scope: Scope, function: ast.Function) -> None:
    _new_name(scope, function.name, function.span)
    _bind(scope, function.parameters)
    scope.findings.result = type_of(scope, function.value)
    scope.findings.exact = inexact_part(scope, function.value) is None
    scope.findings.parameters = tuple(
        (each.name, _slot_type(scope, each.name)) for each in function.parameters
    )
    if isinstance(function.value, ast.Name):
        scope.findings.result = _slot_or(scope, function.value.id, scope.findings.result)


def _slot_or(scope: Scope, name: str, otherwise: ValueType) -> ValueType:
    return _slot_type(scope, name) if name in scope.locals else otherwise


# -------------------------------------------------------------- tables and settings


def _table(scope: Scope, table: ast.Table) -> None:
    seen: set[str] = set()
    for column in table.columns:
        if column in seen:
            scope.findings.trouble(
                table.span, "duplicate-name", f"two columns are called `{column}`"
            )
        seen.add(column)
    for row in table.rows:
        for column, cell in zip(table.columns, row, strict=False):
            if column == SHAPE:
                _shape(scope, cell)
            else:
                type_of(scope, cell)


def _shape(scope: Scope, cell: ast.Expr) -> None:
    """A cell of the column of symbols: an asset, or a symbol with a rule that takes nothing."""
    if not isinstance(cell, ast.Name):
        message = "a shape is the name of an asset, or of a rule"
        scope.findings.trouble(cell.span, "wrong-type", message)
        return
    entry, environment = scope.view.symbol(cell.id), scope.view.environment
    if entry is None:
        message = f"no asset and no rule is called `{cell.id}`"
        known = list(environment.symbol_names())
        near = environment.nearest("symbol", cell.id, known)
        scope.findings.trouble(cell.span, "unknown-symbol", message, suggestions=near)
    elif entry.kind not in ("asset", "broken") and 0 not in entry.arities:
        message = f"`{cell.id}` takes arguments, and a shape in a table has none"
        scope.findings.trouble(cell.span, "wrong-arguments", message)


def _settings(
    scope: Scope, item: Literal["turtle", "limit"], settings: Sequence[ast.Setting]
) -> None:
    for setting in settings:
        record = SETTINGS.get((item, setting.key))
        if record is None:
            known = [name for kind, name in SETTINGS if kind == item]
            scope.findings.trouble(
                setting.span,
                "unknown-setting",
                f"`{item}` has no setting `{setting.key}`",
                expected=", ".join(f"`{each}`" for each in known),
                suggestions=nearest(setting.key, known),
            )
            type_of(scope, setting.value)
            continue
        param = Param(setting.key, record.type, above=record.above, words=record.words)
        check_argument(scope, param, setting.value, item)


def _rectangle(scope: Scope, box: tuple[ast.Expr, ...], whose: str) -> None:
    for number in box:
        want(scope, number, "number", f"a number of {whose}")
    for number, name in zip(box[2:], ("width", "height"), strict=True):
        _above_zero(scope, number, f"{whose}'s {name}")


def _above_zero(scope: Scope, expr: ast.Expr, what: str) -> None:
    value = constant(expr)
    if value is not None and value <= 0:
        scope.findings.trouble(
            expr.span, "out-of-range", f"{what} is {value:g}, and must be above 0"
        )


def _version(scope: Scope, item: ast.Version, number: int) -> None:
    if number not in VERSIONS:
        known = ", ".join(str(each) for each in VERSIONS)
        scope.findings.trouble(
            item.span,
            "unknown-version",
            f"version {number} of the language is not known here",
            expected=f"`ipm {known}`",
            hint="a newer ipmlang may read this file",
        )
