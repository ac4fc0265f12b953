"""Which rules of a grammar the graphics card runs, and why it leaves the others to the CPU.

Takes a program; gives a row for each alternative of each rule, in source order, as records and as a
table to read. Nothing is derived, and no card is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypedDict

if TYPE_CHECKING:
    from ipmlang.compiler.ir import Program
    from ipmlang.runtime.gpu.explain import Reason

_HEADINGS = ("rule", "line", "runs on", "because")


class RuleRow(TypedDict):
    """One alternative: its rule's name, its line, `gpu` or `cpu`, the operation, why not on the
    GPU; both texts are empty for what runs there.
    """

    rule: str
    line: int
    runs_on: str
    operation: str
    why: str


def rule_rows(program: Program) -> list[RuleRow]:
    """A row for each alternative and each reason against it."""
    from ipmlang.runtime.gpu.explain import reasons

    found = reasons(program)
    places = dict.fromkeys(
        (program.symbols[each.symbol].name if each.symbol >= 0 else "start", each.line)
        for each in (program.axiom, *program.productions)
    )
    blamed = [(_place_of(each, list(places)), each) for each in found]
    rows = [row for place in places for row in _rows_of(place, blamed)]
    return [*rows, *(_against(each.rule, each.line, each) for place, each in blamed if not place)]


def rule_lines(rows: Sequence[RuleRow]) -> list[str]:
    """The rows as a table.

    >>> row = RuleRow(rule="Roof", line=7, runs_on="cpu", operation="roofHip", why="no body")
    >>> rule_lines([row])
    ['rule  line  runs on  because', 'Roof     7  cpu      roofHip: no body']
    """
    table = [_HEADINGS, *(_cells(row) for row in rows)]
    wide = [max(len(cells[column]) for cells in table) for column in range(3)]
    return [
        f"{rule:<{wide[0]}}  {line:>{wide[1]}}  {runs:<{wide[2]}}  {why}".rstrip()
        for rule, line, runs, why in table
    ]


def _place_of(reason: Reason, places: Sequence[tuple[str, int]]) -> tuple[str, int] | None:
    """The alternative that a reason is about: the last of its rule that begins before its line."""
    lines = [line for rule, line in places if rule == reason.rule]
    before = [line for line in lines if line <= reason.line]
    return (reason.rule, max(before or lines)) if lines else None


def _rows_of(
    place: tuple[str, int], blamed: Sequence[tuple[tuple[str, int] | None, Reason]]
) -> list[RuleRow]:
    rule, line = place
    against = [_against(rule, line, each) for found, each in blamed if found == place]
    return against or [RuleRow(rule=rule, line=line, runs_on="gpu", operation="", why="")]


def _against(rule: str, line: int, reason: Reason) -> RuleRow:
    operation, why = reason.operation, reason.why
    return RuleRow(rule=rule, line=line, runs_on="cpu", operation=operation, why=why)


def _cells(row: RuleRow) -> tuple[str, str, str, str]:
    because = ": ".join(part for part in (row["operation"], row["why"]) if part)
    return row["rule"], str(row["line"]), row["runs_on"], because
