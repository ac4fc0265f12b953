"""What queries ask for, against what the rules of all files give: labels, reports, phases, lines.

In go the findings of all items, out come warnings: for a label that nothing has, a key that nothing
reports, a snap line that nothing makes, a question about earlier phases where there is one phase
alone. Texts that are computed are not followed: where one is given, all may be there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ipmlang.compiler import ast
from ipmlang.compiler.checking.groups import Group
from ipmlang.compiler.diagnostics import Diagnostic, nearest

MESSAGES = {
    "label": "nothing has the label or is called",
    "report": "nothing reports anything under",
    "snap": "nothing makes a snap line called",
}


def given_by(groups: Sequence[Group]) -> set[tuple[str, str | None]]:
    """All labels, keys and phases of all files, if anything asks; a kind with None: any may be
    there.
    """
    given: set[tuple[str, str | None]] = set()
    if not any(findings.asked for group in groups for findings in group.findings):
        return given
    for group in groups:
        given.update(("label", name) for name in group.environment.symbols)
        for findings in group.findings:
            given |= findings.given
            given.update(("label", name) for name, _ in findings.terminals)
    return given


def check_asked(group: Group, given: set[tuple[str, str | None]]) -> Iterator[Diagnostic]:
    """Warnings for what one file asks in vain."""
    for index, findings in enumerate(group.findings):
        for kind, text, span in findings.asked:
            if kind == "phase":
                if ("phase", None) not in given:
                    yield _without_phases(group, index, text, span)
            elif (kind, None) not in given and (kind, text) not in given:
                known = sorted(str(name) for own, name in given if own == kind)
                message = f'{MESSAGES[kind]} "{text}"'
                found = group.diagnostic(index, span, f"unknown-{kind}", message, warning=True)
                yield replace(found, suggestions=nearest(text, known))


def _without_phases(group: Group, index: int, name: str, span: ast.Span) -> Diagnostic:
    return group.diagnostic(
        index,
        span,
        "no-phase",
        f"`{name}` is about shapes of earlier phases, and there is one phase alone",
        hint="put what asks into a later one: phase(2) Door",
        warning=True,
    )
