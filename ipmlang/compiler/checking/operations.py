"""The use of an operation: its arguments, its braces and the labels of its parts.

In go a record and what was written, out come troubles. What an operation is, takes and makes is
read off its record alone; the bodies of its parts are not looked at here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.checking.arguments import check_arguments
from ipmlang.compiler.checking.asked import note_given
from ipmlang.compiler.checking.expressions import Scope
from ipmlang.compiler.diagnostics import nearest
from ipmlang.compiler.ops import OPERATIONS, Operation
from ipmlang.compiler.ops.record import Effect


def find_operation(scope: Scope, span: ast.Span, name: str) -> Operation | None:
    """The record of an operation with parts; a name that has none is reported."""
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


def use_operation(
    scope: Scope,
    record: Operation,
    name: str,
    args: Sequence[ast.Argument],
    span: ast.Span,
    parts: Sequence[ast.Part] | None,
) -> None:
    """Check one use of an operation; `parts` is None where it stands without braces."""
    check_arguments(scope, record, name, args, span)
    note_given(scope.findings, record, args)
    if not record.meaning:
        scope.findings.not_ready.append((name, ast.Span(span.start, span.start + len(name))))
    example = f"for example {record.examples[0]}" if record.examples else None
    if parts is None and (
        (record.labels is not None and not record.bare) or (record.axes and record.labels is None)
    ):
        scope.findings.trouble(
            span, "needs-braces", f"`{name}` needs parts in braces", hint=example
        )
    elif parts is not None and record.labels is None:
        scope.findings.trouble(
            span, "takes-no-braces", f"`{name}` takes no parts in braces", hint=example
        )
    for part in parts or () if record.labels is not None else ():
        _label(scope, record, name, part)


def _label(scope: Scope, record: Operation, name: str, part: ast.Part) -> None:
    known = [each for each in record.labels or () if each[:1].isalpha()]
    if part.label is None:
        if record.labels and "" not in record.labels:
            scope.findings.trouble(
                part.span,
                "wrong-label",
                f"this part of `{name}` has no label",
                expected=_labels(record, known),
            )
        return
    wrong = _unfit(part.label, record.labels or ())
    if wrong is not None:
        word = wrong.id if isinstance(wrong, ast.Name) else ""
        if isinstance(wrong, ast.Number):
            word = f"{wrong.value:g}"
        if known or "" not in (record.labels or ()):
            message = (
                f"`{name}` makes no part `{word}`" if word else (f"`{name}` makes no such part")
            )
        else:
            message = f"the parts of `{name}` have no labels"
        scope.findings.trouble(
            wrong.span,
            "wrong-label",
            message,
            expected=_labels(record, known) or None,
            suggestions=nearest(word, known) if word else (),
        )


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


def use_at_each(scope: Scope, element: ast.Each) -> None:
    """Check an operation with parts `at each` of something that it makes."""
    target, feature = element.target, element.feature
    record = find_operation(scope, target.span, target.name)
    if record is None:
        return
    use_operation(scope, replace(record, bare=True), target.name, target.args, target.span, None)
    if feature not in record.axes:
        makes = ", ".join(f"`{each}`" for each in record.axes)
        scope.findings.trouble(
            element.span,
            "wrong-label",
            f"`{target.name}` has nothing `at each {feature}`",
            expected=makes or None,
            suggestions=nearest(feature, record.axes),
        )


def warn_of_mixture(scope: Scope, body: Sequence[ast.Element]) -> None:
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
        record = OPERATIONS.get(name) if name not in scope.locals else None
        if record is not None and record.effect == effect and scope.view.symbol(name) is None:
            return name, element.span
    return None
