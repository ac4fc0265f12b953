"""Which parameters an edit means: chosen by rule, operation and parameter, in a person's words.

In go a grammar and a selection, out come the numbers of the places that match, or an error that
names what there is instead. Nothing is changed here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ipmlang.compiler import ast
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, nearest
from ipmlang.compiler.ops import OPERATIONS
from ipmlang.edit.places import Found, Place, places

SHOWN = 12  # names listed in an error
NOTHING = "nothing-selected"


@dataclass(frozen=True, slots=True)
class Selection:
    """Parameters of rules. rule: all productions of that symbol, `start` for the axiom, or a
    table; operation: an operation by any of its names, a symbol, or `repeat`, `split`, `steps`,
    `percent`, `weight`, `set`, `row`; parameter: its name, as `angle` of `at(x, y, angle)`;
    number: only the n-th of those that match, from 1. What is None matches all.
    """

    rule: str | None = None
    operation: str | None = None
    parameter: str | None = None
    number: int | None = None

    @property
    def is_empty(self) -> bool:
        """Whether it selects without saying anything."""
        return self == Selection()


def select(
    grammar: ast.Grammar, selection: Selection, allowed: Callable[[Place], bool]
) -> dict[int, Found]:
    """The places that match, by their number in `places`. Raises IpmError if there are none."""
    every = list(enumerate(places(grammar)))
    if selection.rule is not None:
        known = _rules(grammar)
        if selection.rule not in known:
            raise _unknown(f"this grammar has no rule `{selection.rule}`", selection.rule, known)
        every = [each for each in every if each[1][0].rule == selection.rule]
    inside = f"`{selection.rule}`" if selection.rule is not None else "this grammar"
    if selection.operation is not None:
        wanted = _canonical(selection.operation)
        known = {place.operation for _, (place, _) in every}
        every = [each for each in every if _canonical(each[1][0].operation) == wanted]
        if not every:
            what = f"nothing called `{selection.operation}` has parameters in {inside}"
            raise _unknown(what, selection.operation, known)
        inside = f"`{selection.operation}` in {inside}"
    if selection.parameter is not None:
        known = {place.parameter for _, (place, _) in every}
        every = [each for each in every if each[1][0].parameter == selection.parameter]
        if not every:
            what = f"{inside} has no parameter `{selection.parameter}`"
            raise _unknown(what, selection.parameter, known)
    found = {number: each for number, each in every if allowed(each[0])}
    if not found:
        raise _nothing(inside, selection)
    return _numbered(found, selection.number, inside)


def _numbered(found: dict[int, Found], number: int | None, inside: str) -> dict[int, Found]:
    if number is None:
        return found
    if not 1 <= number <= len(found):
        there = f"{len(found)} parameter{'s' * (len(found) != 1)}"
        raise IpmError(
            [Diagnostic(NOTHING, f"there is no parameter {number}: {inside} has {there} that match",
                        hint="they are counted from 1 in the order of the text")]
        )  # fmt: skip
    return dict([list(found.items())[number - 1]])


def _rules(grammar: ast.Grammar) -> set[str]:
    rules = {item.head.name for item in grammar.items if isinstance(item, ast.Rule)}
    tables = {item.name for item in grammar.items if isinstance(item, ast.Table) and item.rows}
    return rules | tables | {"start"}


def _canonical(name: str) -> str:
    record = OPERATIONS.get(name)
    return name if record is None else record.name


def _unknown(message: str, name: str, known: Iterable[str]) -> IpmError:
    names = sorted(set(known))
    listed = ", ".join(f"`{each}`" for each in names[:SHOWN])
    return IpmError(
        [
            Diagnostic(
                NOTHING,
                message,
                expected=f"{listed}{' …' if len(names) > SHOWN else ''}" if names else None,
                suggestions=nearest(name, names),
            )
        ]
    )


def _nothing(inside: str, selection: Selection) -> IpmError:
    hint = "choose others with --rule, --operation and --parameter"
    if selection.is_empty:
        hint = "choose some: --operation at --parameter x, say, are coordinates"
    message = f"{inside} has no parameter that this could change"
    return IpmError([Diagnostic(NOTHING, message, hint=hint)])
