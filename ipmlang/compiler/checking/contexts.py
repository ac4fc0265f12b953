"""Contexts by name: what asks for one must name one, and ask what its file can answer.

In go an argument or a call, out come troubles. What is in a file was looked up when its item was
declared; expressions that may stand anywhere are checked elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection

from ipmlang.compiler import ast
from ipmlang.compiler.checked import ValueEntry
from ipmlang.compiler.checking.environment import View
from ipmlang.compiler.checking.findings import Findings
from ipmlang.compiler.ops.record import Query


def want_context(
    view: View, findings: Findings, local: Collection[str], expr: ast.Expr, what: str
) -> None:
    """Check that an expression is the name of a context."""
    named = isinstance(expr, ast.Name) and expr.id not in local
    entry = view.value(expr.id) if named and isinstance(expr, ast.Name) else None
    if entry is not None and entry.kind in ("context", "broken"):
        return
    values = view.environment.values
    contexts = [name for name, found in values.items() if found.kind == "context"]
    shown = f"`{expr.id}`" if isinstance(expr, ast.Name) else "this"
    findings.trouble(
        expr.span,
        "no-context",
        f"{what} must name an item `context`, and {shown} is none",
        suggestions=_close(view, expr, contexts),
        hint=None if contexts else 'write an item for it: context mask = "mask.png"',
    )


def _close(view: View, expr: ast.Expr, contexts: list[str]) -> tuple[str, ...]:
    if not isinstance(expr, ast.Name):
        return ()
    return view.environment.nearest("context", expr.id, contexts)


def check_fetched(view: View, findings: Findings, query: Query, call: ast.Call) -> bool:
    """Whether a call asks a context; if so, it is checked where, and for which of its channels."""
    if not query.params or query.params[0].type != "context":
        return False
    first = call.args[0].value if call.args else None
    entry = view.value(first.id) if isinstance(first, ast.Name) else None
    if isinstance(first, ast.Name) and entry is not None and entry.sampled is not None:
        _check_place(findings, call, first.id, entry)
    return True


def _check_place(findings: Findings, call: ast.Call, name: str, entry: ValueEntry) -> None:
    assert entry.sampled is not None
    count = len(call.args)
    if count == 2:
        findings.trouble(
            call.span,
            "wrong-arguments",
            f"`{call.name}` takes both x and y, or neither for where the shape stands",
        )
    elif count == 1 and not entry.sampled.placed:
        findings.trouble(
            call.span,
            "no-place",
            f"`{name}` lies nowhere on the ground, so there is nothing where a shape stands",
            hint=f"say what it covers: context {name} = … over (left, bottom, width, height)",
        )
    elif count < 4 and entry.type == "vector":
        findings.trouble(
            call.span,
            "wrong-arguments",
            f"`{name}` is a vector field, and a value is one of its components",
            hint=f"for its x: {call.name}({name}, x, y, 0)",
        )
    elif count == 4:
        _check_channel(findings, name, entry, call.args[3].value)


def _check_channel(findings: Findings, name: str, entry: ValueEntry, expr: ast.Expr) -> None:
    assert entry.sampled is not None
    channels = entry.sampled.channels
    if not isinstance(expr, ast.Number) or channels is None or expr.value < channels:
        return
    known = "only the channel 0" if channels == 1 else f"the channels 0 to {channels - 1}"
    findings.trouble(
        expr.span, "out-of-range", f"`{name}` has {known}, and this asks for {expr.value:g}"
    )
