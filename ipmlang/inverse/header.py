"""The comment above an inferred grammar: what was read, how much was explained, the largest error.

Takes a report; gives comments of the syntax tree. Nothing is measured here.
"""

from __future__ import annotations

from pathlib import Path

from ipmlang.compiler import ast
from ipmlang.inverse.report import Report, counted


def header(path: Path, report: Report, flat: bool) -> tuple[ast.Comment, ...]:
    """The lines of the comment."""
    lines = [f"Read from {path.name}: {_read(report)}."]
    if flat:
        lines.append("One placement per element; nothing was looked for.")
    else:
        share = round(report.explained * report.elements)
        rules = counted(report.rules, "rule") if report.rules else "repetition"
        explained = f"{rules} for {share} of them" if report.rules or share else "no rule pays"
        lines.append(f"Found: {explained}; {report.tokens} tokens instead of {report.tokens_flat}.")
    lines.append(_largest_error(report))
    lines += [f"Note: {note}" for note in report.notes]
    return tuple(ast.Comment(line.replace("\n", " ")) for line in lines)


def _read(report: Report) -> str:
    if not report.triangles:
        return f"{report.elements} elements"
    shapes = f"{counted(report.elements, 'component')} of {counted(report.labels, 'shape')}"
    return f"{shapes}, {counted(report.triangles, 'triangle')}"


def _largest_error(report: Report) -> str:
    """How exact the grammar is, and which rule is worst where it is not meant to be exact."""
    line = f"Largest error: {report.max_error:.1e} of the diagonal"
    if report.mode == "ideal":
        line += ", similar shapes being one"
    elif report.mode == "within":
        line += f", {report.limit:.1e} being allowed"
    if report.rule_errors:
        line += f"; most of it in {report.rule_errors[0].rule}"
    return line + "."
