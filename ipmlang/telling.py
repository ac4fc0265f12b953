"""What every command tells: diagnostics as text or as records, notes, progress at a terminal.

Takes diagnostics and phases of work; prints to standard error, or gives records for JSON. What a
command found is its own to print.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import click

from ipmlang.compiler.diagnostics import Diagnostic, render


def findings_record(found: Sequence[Diagnostic]) -> dict[str, object]:
    """Diagnostics as JSON, and how many of them are errors."""
    errors = sum(each.severity == "error" for each in found)
    return {"errors": errors, "diagnostics": [as_record(each) for each in found]}


def as_record(diagnostic: Diagnostic) -> dict[str, object]:
    """A diagnostic as JSON: code, severity, message, place, expectation, suggestions."""
    record: dict[str, object] = {
        "code": diagnostic.code,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        "expected": diagnostic.expected,
        "hint": diagnostic.hint,
        "suggestions": list(diagnostic.suggestions),
    }
    if diagnostic.source is not None:
        line, column, _ = diagnostic.source.place(diagnostic.start)
        record |= {"file": diagnostic.source.path, "line": line, "column": column}
    return record


def report_lines(reports: Mapping[str, tuple[float, int]]) -> list[str]:
    """What shapes reported, as a table: a line for each key with its sum and how many did.

    >>> report_lines({"area": (12.5, 3)})
    ['report   sum  count', 'area    12.5      3']
    """
    if not reports:
        return []
    rows = [("report", "sum", "count")]
    rows += [(key, f"{total:.10g}", f"{count}") for key, (total, count) in reports.items()]
    wide = [max(len(row[column]) for row in rows) for column in range(3)]
    return [f"{a:<{wide[0]}}  {b:>{wide[1]}}  {c:>{wide[2]}}" for a, b, c in rows]


def show(found: Sequence[Diagnostic]) -> None:
    """Print diagnostics to standard error."""
    for each in found:
        click.echo(render(each) + "\n", err=True)


def tell_notes(notes: Iterable[str]) -> None:
    """Print what a person should know but need not mend."""
    for note in notes:
        click.echo(f"note: {note}", err=True)


def device_record(backend: str) -> dict[str, object] | None:
    """Which graphics card had a part in a derivation as JSON, None where it was numpy alone."""
    if backend == "cpu":
        return None
    from ipmlang.runtime.gpu.device import device

    return device().info.record()


class Say:
    """Tells a person at a terminal what long work is doing; silent elsewhere."""

    def __init__(self, what: str) -> None:
        self.started = time.monotonic()
        self.shown = False
        self.what = what

    def __call__(self, what: str) -> None:
        """Note a new phase; it is shown once the work has taken a second."""
        self.what = what
        if sys.stderr.isatty() and time.monotonic() - self.started > 1.0:
            self.shown = True
            click.echo(f"\r\033[K{what} …", nl=False, err=True)

    def close(self) -> None:
        """Leave the line clean."""
        if self.shown:
            click.echo("\r\033[K", nl=False, err=True)


@contextmanager
def working(what: str) -> Iterator[Say]:
    """Show progress while the block runs."""
    say = Say(what)
    try:
        yield say
    finally:
        say.close()
