"""What an item gives that queries can ask for, and what its own queries ask for.

In go an operation or a query and its arguments, out come entries in the findings; what they say
together is checked elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import ast
from ipmlang.compiler.checking.findings import Findings
from ipmlang.compiler.ops.queries import OCCLUSION
from ipmlang.compiler.ops.record import Operation, Query

SPLIT_KINDS = {"snap": "snap", "within": "label"}
KINDS = {"label": "label", "within": "label", "key": "report"}


def note_given(findings: Findings, record: Operation, args: Sequence[ast.Argument]) -> None:
    """Note the label, the key, the phase or the snap line that an operation gives."""
    if record.name not in ("label", "report", "phase", "snap"):
        return
    value = args[0].value if args else None
    text = value.value if isinstance(value, ast.Text) else None
    findings.given.add((record.name, text))


def note_snapped(findings: Findings, split: ast.Split) -> None:
    """Note the snap lines that a split asks for, and the label that they stand within."""
    for argument in split.args:
        text = argument.value.value if isinstance(argument.value, ast.Text) else None
        if argument.name == "snap" and text != "":
            findings.asked.append(("phase", "split(snap: …)", argument.span))
        if argument.name in SPLIT_KINDS and text:
            findings.asked.append((SPLIT_KINDS[argument.name], text, argument.value.span))


def note_asked(findings: Findings, query: Query, call: ast.Call) -> None:
    """Note the labels and keys that a query asks for, and that it asks."""
    if query.name not in OCCLUSION:
        place = ast.Span(call.span.start, call.span.start + len(call.name))
        findings.asked.append(("phase", query.name, place))
    for param, argument in zip(query.params or (), call.args, strict=False):
        if param.name in KINDS and isinstance(argument.value, ast.Text):
            asked = (KINDS[param.name], argument.value.value, argument.value.span)
            findings.asked.append(asked)
