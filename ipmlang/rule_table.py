"""Which rules of a grammar the graphics card runs, and why it leaves the others to the CPU.

Takes a program; gives a row for each alternative of each rule, in source order, as records and as a
table to read. Nothing is derived, and no card is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

if TYPE_CHECKING:
    from ipmlang.compiler.ir import Production, Program
    from ipmlang.runtime.gpu.explain import Reason

_STARTS = "what starts a derivation"
_THREADS = "modules follow the turtle of those before them: all or none"
_HEADINGS = ("rule", "line", "runs on", "because")


class RuleRow(TypedDict):
    """One alternative: its rule's name, its file (empty: the grammar's own) and line, `gpu` or
    `cpu`, the operation, why not on the GPU; both texts are empty for what runs there.
    """

    rule: str
    file: str
    line: int
    runs_on: str
    operation: str
    why: str


def rule_rows(program: Program) -> list[RuleRow]:
    """A row for each alternative, and one for each further reason against it."""
    from ipmlang.runtime.gpu.encode import calls_of
    from ipmlang.runtime.gpu.explain import reasons

    found = reasons(program)
    whole = [each for each in found if not each.rule]
    threads = calls_of(program) == "threads"
    rows: list[RuleRow] = []
    for production in (program.axiom, *program.productions):
        start = production.symbol < 0
        name = "start" if start else program.symbols[production.symbol].name
        against = whole or [each for each in found if _is_about(each, name, production)]
        rows += [_row(program, name, production, each.operation, each.why) for each in against]
        if against:
            continue
        why = _STARTS if start and not threads else _THREADS if threads and found else ""
        rows.append(_row(program, name, production, "", why))
    # A rule that takes symbols is a symbol of its own for each of them, and one rule to a person.
    return list({tuple(row.values()): row for row in rows}.values())


def rule_lines(rows: Sequence[RuleRow]) -> list[str]:
    """The rows as a table.

    >>> row = RuleRow(rule="Roof", file="", line=7, runs_on="cpu", operation="roofHip", why="none")
    >>> rule_lines([row])
    ['rule  line  runs on  because', 'Roof     7  cpu      roofHip: none']
    """
    table = [_HEADINGS, *(_cells(row) for row in rows)]
    wide = [max(len(cells[column]) for cells in table) for column in range(3)]
    return [
        f"{rule:<{wide[0]}}  {line:>{wide[1]}}  {runs:<{wide[2]}}  {why}".rstrip()
        for rule, line, runs, why in table
    ]


def _is_about(reason: Reason, name: str, production: Production) -> bool:
    place = reason.rule, reason.path, reason.line
    return place == (name, production.path, production.line)


def _row(
    program: Program, name: str, production: Production, operation: str = "", why: str = ""
) -> RuleRow:
    return RuleRow(
        rule=name,
        file="" if production.path == program.path else production.path,
        line=production.line,
        runs_on="cpu" if why else "gpu",
        operation=operation,
        why=why,
    )


def _cells(row: RuleRow) -> tuple[str, str, str, str]:
    line = str(row["line"])
    place = f"{Path(row['file']).name}:{line}" if row["file"] else line
    because = ": ".join(part for part in (row["operation"], row["why"]) if part)
    return row["rule"], place, row["runs_on"], because
