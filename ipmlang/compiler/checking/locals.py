"""Names that a body gives to values: `with name = value`.

In go the scope of a body and one such element, out come the scope of what follows it, and troubles:
a name that is taken, one that hides an attribute or a constant, one that nothing reads.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast
from ipmlang.compiler.checking.exactness import inexact_part
from ipmlang.compiler.checking.expressions import Row, Scope, Slot, article, type_of
from ipmlang.compiler.ops import CONSTANTS, FUNCTIONS

HIDDEN = ("attribute", "constant", "function")


def with_local(scope: Scope, local: ast.Local) -> Scope:
    """The scope of what follows a local name."""
    found = type_of(scope, local.value)
    if found == "vector":
        scope.findings.trouble(
            local.value.span,
            "wrong-type",
            f"`{local.name}` must be one value, and this is a vector",
            hint="name each of its numbers",
        )
        found = "any"
    _check_name(scope, local)
    source = scope.locals.get(local.value.id) if isinstance(local.value, ast.Name) else None
    slot = Slot(
        found,
        kind="local name",
        source=source if isinstance(source, Slot) else None,
        exact=inexact_part(scope, local.value) is None,
    )
    return scope.inner(local.name, slot)


def _check_name(scope: Scope, local: ast.Local) -> None:
    name, span = local.name, _name_span(local)
    before = scope.locals.get(name)
    if before is not None:
        taken = article("row" if isinstance(before, Row) else before.kind)
        message = f"`{name}` is {taken} already"
        scope.findings.trouble(span, "duplicate-name", message, hint="give it another name")
    elif name in FUNCTIONS or name in CONSTANTS:
        kind = "function" if name in FUNCTIONS else "constant"
        message = f"`{name}` is a built-in {kind} already"
        scope.findings.trouble(span, "duplicate-name", message, hint="give it another name")
    elif "." in name:
        message = f"the name of a value in a body has no dots: `{name}`"
        scope.findings.trouble(span, "dotted-name", message)
    elif (entry := scope.view.value(name)) is not None and entry.kind in HIDDEN:
        hint = "give it another name"
        if entry.kind == "attribute":
            hint += f"; `set {name} = …` changes the attribute for all that follows"
        message = f"in the rest of this body, `{name}` hides the {entry.kind} of this name"
        scope.findings.trouble(span, "hidden-name", message, hint=hint, warning=True)


def warn_unread(scope: Scope, named: Sequence[tuple[ast.Local, Scope]]) -> None:
    """Warn of names that nothing in their body reads."""
    for local, inner in named:
        slot = inner.locals[local.name]
        if isinstance(slot, Slot) and not slot.read:
            scope.findings.trouble(
                _name_span(local),
                "unread-name",
                f"nothing in the rest of this body reads `{local.name}`",
                warning=True,
            )


def _name_span(local: ast.Local) -> ast.Span:
    """`with` and the name, as far as they stand side by side."""
    return ast.Span(local.span.start, local.value.span.start)
