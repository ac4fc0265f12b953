"""The `start` item: its axiom, what it stands on, and its options."""

from __future__ import annotations

from ipmlang.compiler import ast
from ipmlang.compiler.checking.elements import check_body
from ipmlang.compiler.checking.expressions import Scope, article, constant, want
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops.settings import AVOIDABLE, DIRECTIONS


def check_start(scope: Scope, start: ast.Start) -> None:
    """Check a start."""
    check_body(scope, start.axiom)
    if not start.axiom:
        scope.findings.trouble(
            start.span,
            "empty-start",
            "this `start` has nothing to start with",
            hint="name a symbol: start Fence",
        )
    if start.place is not None:
        _place(scope, start.place)
    for value, what in (
        (start.steps, "the number of steps"),
        (start.seeds, "the number of seeds"),
        (start.retries, "the number of retries"),
    ):
        if value is None:
            continue
        want(scope, value, "int", what)
        number = constant(value)
        if number is not None and number < 0:
            scope.findings.trouble(
                value.span, "out-of-range", f"{what} is {number:g}, and cannot be negative"
            )
    _word(scope, start, start.direction, DIRECTIONS, "direction")
    _word(scope, start, start.avoiding, AVOIDABLE, "avoiding")
    for name in dict.fromkeys(start.sites):
        _site(scope, start, name)


def _word(
    scope: Scope, start: ast.Start, word: str | None, known: tuple[str, ...], option: str
) -> None:
    if word is not None and word not in known:
        scope.findings.trouble(
            start.span,
            "wrong-word",
            f"`{option}` cannot be `{word}`",
            expected=" or ".join(f"`{each}`" for each in known),
            suggestions=nearest(word, known),
        )


def _site(scope: Scope, start: ast.Start, name: str) -> None:
    entry = scope.view.value(name)
    if entry is not None and entry.kind in ("site", "broken"):
        return
    sites = [key for key, each in scope.view.environment.values.items() if each.kind == "site"]
    message = (
        f"`{name}` is {article(entry.kind)}, not a site"
        if entry
        else (f"no site is called `{name}`")
    )
    scope.findings.trouble(start.span, "unknown-site", message, suggestions=nearest(name, sites))


def _place(scope: Scope, place: ast.Place) -> None:
    match place.kind:
        case "box":
            for size in place.args:
                want(scope, size, "number", "an extent of the box")
        case "polygon":
            for point in place.args:
                want(scope, point, "vector", "a corner of the polygon")
            if len(place.args) < 3:
                scope.findings.trouble(
                    place.span,
                    "wrong-arguments",
                    f"a polygon has 3 corners or more, here are {len(place.args)}",
                )
        case "surface":
            _surface(scope, place)
        case "file":
            pass


def _surface(scope: Scope, place: ast.Place) -> None:
    name = place.reference or ""
    entry = scope.view.value(name)
    if entry is not None and entry.kind in ("surface", "broken"):
        return
    surfaces = [
        key for key, each in scope.view.environment.values.items() if each.kind == "surface"
    ]
    message = (
        f"`{name}` is {article(entry.kind)}, not a surface"
        if entry
        else (f"no surface is called `{name}`")
    )
    scope.findings.trouble(
        place.span,
        "unknown-surface",
        message,
        expected="a surface, box(…), polygon […] or a file",
        suggestions=nearest(name, surfaces),
    )
