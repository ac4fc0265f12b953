"""What checking one item found: troubles, the symbols it calls, the names it reads.

Places are relative to the item, so findings hold as long as the item and what it looked up stay the
same, wherever the item moves in its file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, Label
from ipmlang.compiler.ops.record import ValueType
from ipmlang.compiler.passing import Passing

Key: TypeAlias = tuple[str, int]


@dataclass(frozen=True, slots=True)
class CallSite:
    """A symbol with arguments in a body. `certain`: it is made whenever the body is; `named`: the
    names among its arguments that mean no value, each with the number of its argument.
    """

    span: ast.Span
    types: tuple[ValueType, ...]
    certain: bool
    named: tuple[tuple[int, ast.Name], ...] = ()


@dataclass(slots=True, eq=False)
class Findings:
    """All that one item gave.

    `troubles`: diagnostics without a source. `calls`: modules that are no operation, by name and
    arity. `terminals`: those of them that nothing defines. `reads`: top-level values it looked up.
    `parameters`: a rule's parameters with the types that its body asks of them. `not_ready`:
    operations that no executor runs yet. `result`: the type of a constant's or function's value.
    `edges`: the symbols called, each with whether for certain. `odd`: those of them that are given
    something else than numbers; `asks`: some parameter must be something else than a number.
    `passing`: what a rule does with its parameters as symbols; `valued`: those that it reads, and
    where first; `named`: the symbols that are called with names that mean no value.
    `given`: labels, keys of reports and phases, with their texts where they are known; `asked`:
    those that queries name. `references`: files looked for. `answers`: what was looked up, with the
    answer it got; the findings hold while these hold.
    """

    troubles: list[Diagnostic] = field(default_factory=list)
    calls: dict[Key, list[CallSite]] = field(default_factory=dict)
    terminals: dict[Key, ast.Span] = field(default_factory=dict)
    reads: dict[str, ast.Span] = field(default_factory=dict)
    parameters: tuple[tuple[str, ValueType], ...] = ()
    not_ready: list[tuple[str, ast.Span]] = field(default_factory=list)
    result: ValueType = "any"
    exact: bool = True
    edges: tuple[tuple[Key, bool], ...] = ()
    odd: frozenset[Key] = frozenset()
    asks: bool = False
    passing: Passing | None = None
    valued: dict[str, ast.Span] = field(default_factory=dict)
    named: tuple[Key, ...] = ()
    given: set[tuple[str, str | None]] = field(default_factory=set)
    asked: list[tuple[str, str, ast.Span]] = field(default_factory=list)
    references: tuple[str, ...] = ()
    answers: dict[tuple[str, str], object] = field(default_factory=dict)

    def trouble(
        self,
        span: ast.Span,
        code: str,
        message: str,
        *,
        expected: str | None = None,
        hint: str | None = None,
        suggestions: tuple[str, ...] = (),
        warning: bool = False,
        other: tuple[ast.Span, str] | None = None,
    ) -> None:
        """Note what is wrong at a place of the item; `other` is a second place that matters."""
        labels = () if other is None else (Label(other[0].start, other[0].end, other[1]),)
        self.troubles.append(
            Diagnostic(
                code,
                message,
                "warning" if warning else "error",
                start=span.start,
                end=span.end,
                expected=expected,
                hint=hint,
                suggestions=suggestions,
                labels=labels,
            )
        )
