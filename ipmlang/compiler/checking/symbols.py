"""Symbols as arguments, as far as one item tells: which a call may give, which are placed.

In go the arguments of a call and the scope that they stand in, out come their types and the names
among them that mean no value there. Whether the rules that are called take symbols there is for
`taking.py`, which knows all items.
"""

from __future__ import annotations

from ipmlang.compiler import ast
from ipmlang.compiler.checking.expressions import Row, Scope, Slot, settle, type_of, want
from ipmlang.compiler.ops import CONSTANTS, QUERIES
from ipmlang.compiler.ops.queries import HERE
from ipmlang.compiler.ops.record import ValueType
from ipmlang.compiler.passing import leaves
from ipmlang.compiler.places import row_of
from ipmlang.compiler.types import PHRASES


def type_given(scope: Scope, expr: ast.Expr, found: list[ast.Name]) -> ValueType:
    """The type of an argument of a rule; names in it that can only be symbols go to `found`."""
    if isinstance(expr, ast.Name) and _is_symbol(scope, expr):
        found.append(expr)
        return "symbol"
    if isinstance(expr, ast.Name) and isinstance(slot := scope.locals.get(expr.id), Slot):
        slot.read = True
        return slot.type
    if isinstance(expr, ast.If) and all(_may_be(scope, each) for each in leaves(expr)):
        return _type_chosen(scope, expr, found)
    return type_of(scope, expr)


def _may_be(scope: Scope, expr: ast.Expr) -> bool:
    """Whether an outcome of a choice may be a symbol: it can be nothing else, it is an asset, or
    a parameter of which something else is not known.
    """
    if not isinstance(expr, ast.Name):
        return False
    slot, entry = scope.locals.get(expr.id), scope.view.value(expr.id)
    if isinstance(slot, Slot):
        return slot.type in ("any", "asset", "symbol")
    return _is_symbol(scope, expr) or (entry is not None and entry.kind == "asset")


def _type_chosen(scope: Scope, expr: ast.If, found: list[ast.Name]) -> ValueType:
    """The type of a choice between what may be symbols: if one is, all are."""
    want(scope, expr.condition, "bool", "what follows `if`")
    kinds = [type_given(scope, each, found) for each in (expr.value, expr.other)]
    if "symbol" not in kinds:
        return next((each for each in kinds if each != "any"), "any")
    for outcome in (expr.value, expr.other):
        slot = scope.locals.get(outcome.id) if isinstance(outcome, ast.Name) else None
        if isinstance(slot, Slot) and slot.type == "any":
            settle(slot, "symbol", outcome.span)
    return "symbol"


def _is_symbol(scope: Scope, expr: ast.Name) -> bool:
    """Whether a name can only be a symbol: it means no value here."""
    name = expr.id
    if name in scope.locals:
        return False
    row = scope.locals.get(row_of(name))
    if isinstance(row, Row) and row.shapes:
        return True
    query = QUERIES.get(name)
    if name in CONSTANTS or (query is not None and query.params is None):
        return False
    head, dot, _ = name.partition(".")
    if dot and (head == HERE or head in scope.locals or scope.view.symbol(name) is None):
        return False
    return scope.view.value(name) is None


def place_parameter(scope: Scope, module: ast.Module, slot: Slot) -> None:
    """A parameter, or another local name, that stands where a symbol does."""
    name = module.name
    if slot.kind == "local name":
        scope.findings.trouble(
            module.span,
            "local-as-symbol",
            f"`{name}` is a local name, and no symbol is called so",
            hint=f"to place the asset that it stands for, write insert({name})",
        )
    elif slot.type == "any":
        settle(slot, "symbol", module.span)
    elif slot.type != "symbol":
        used = None if slot.place is None else (slot.place, f"here it is {PHRASES[slot.type]}")
        asset = slot.type == "asset"
        scope.findings.trouble(
            module.span,
            "parameter-as-symbol",
            f"`{name}` cannot be both {PHRASES[slot.type]} and a symbol",
            hint=f"to place the asset that it stands for, write insert({name})" if asset else None,
            other=used,
        )
