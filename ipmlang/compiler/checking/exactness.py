"""Decisions that may come out differently on another machine.

In go guards, counts and chances, out come warnings for those that hang on a function or a value
whose last bits depend on the machine. Parameters are not followed from rule to rule.
"""

from __future__ import annotations

from ipmlang.compiler import ast
from ipmlang.compiler.checking.expressions import Scope, Slot
from ipmlang.compiler.ops import FUNCTIONS


def warn_inexact(scope: Scope, expr: ast.Expr, what: str) -> None:
    """Warn where a decision, `this guard` or `this count`, may differ on another machine."""
    part = inexact_part(scope, expr)
    if part is not None:
        name = part.name if isinstance(part, ast.Call) else part.id
        scope.findings.trouble(
            part.span,
            "inexact-decision",
            f"{what} hangs on `{name}`, whose last digits differ between machines",
            hint=_mend(scope, name),
            warning=True,
        )


def _mend(scope: Scope, name: str) -> str:
    entry = None if name in scope.locals else scope.view.value(name)
    if entry is not None and entry.kind == "context":
        return "`nearest` at the end of its item gives single texels, exactly"
    return "round what it gives, so that a tiny difference decides nothing"


def inexact_part(scope: Scope, expr: ast.Expr) -> ast.Name | ast.Call | None:
    """The first part of an expression whose last bits depend on the machine, if there is one."""
    match expr:
        case ast.Name(name):
            local = scope.locals.get(name)
            if local is not None:
                return expr if isinstance(local, Slot) and not local.exact else None
            entry = scope.view.value(name)
            return None if entry is None or entry.exact else expr
        case ast.Call(name, args):
            record, entry = FUNCTIONS.get(name), scope.view.value(name)
            if (record is not None and not record.exact) or (entry is not None and not entry.exact):
                return expr
            parts: tuple[ast.Expr, ...] = tuple(each.value for each in args)
        case ast.Unary(value=value):
            parts = (value,)
        case ast.Binary(left=left, right=right):
            parts = (left, right)
        case ast.If(condition, value, other):
            parts = (condition, value, other)
        case ast.Tuple(items):
            parts = items
        case _:
            parts = ()
    return next((found for part in parts if (found := inexact_part(scope, part))), None)
