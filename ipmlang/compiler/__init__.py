"""The compiler, phase by phase: load, parse, check, lower, verify.

A text becomes trees (`load` reads files and has each parsed, with what they import), trees become a
checked grammar, a checked grammar becomes a program of the typed IR, and the program is verified
before anybody runs it. Each phase takes one type and returns one type plus diagnostics; only `load`
reads files, and nothing here derives, infers or prints.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ipmlang.compiler.ast import Start
from ipmlang.compiler.check import check
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.diagnostics import Diagnostic, IpmError, fail
from ipmlang.compiler.ir import Program
from ipmlang.compiler.load import Loaded, load, load_text
from ipmlang.compiler.lower import lower
from ipmlang.compiler.verify import verify

__all__ = [
    "check",
    "compile_file",
    "compile_loaded",
    "compile_text",
    "diagnose",
    "load",
    "lower",
    "verify",
]


def diagnose(loaded: Loaded) -> tuple[Diagnostic, ...]:
    """All that is wrong with loaded files, whether checking finds it or only making a program of
    them; what no executor runs yet is a warning.
    """
    checked = check(loaded)
    told = checked.diagnostics
    started = any(isinstance(item, Start) for item in loaded.files[0].grammar.items)
    if started and not any(each.severity == "error" for each in told):
        try:
            lower(checked)
        except IpmError as error:
            told += tuple(
                replace(each, severity="warning") if each.code == "not-executable" else each
                for each in error.diagnostics
            )
    return told


def compile_file(
    path: Path, *, allow_outside: bool = False, style: str | None = None
) -> tuple[Checked, Program, tuple[Diagnostic, ...]]:
    """A grammar file as a checked grammar, a program and the warnings on the way; `style` is one
    of those that the file has.

    Raises IpmError with every error of the file.
    """
    return compile_loaded(load(path, allow_outside), style)


def compile_text(
    text: str, *, folder: Path = Path(), style: str | None = None
) -> tuple[Checked, Program, tuple[Diagnostic, ...]]:
    """The same for a text whose assets and imports lie in `folder`."""
    return compile_loaded(load_text(text, folder), style)


def compile_loaded(
    loaded: Loaded, style: str | None = None
) -> tuple[Checked, Program, tuple[Diagnostic, ...]]:
    """The same for loaded files."""
    checked = check(loaded)
    errors = [each for each in checked.diagnostics if each.severity == "error"]
    if errors:
        raise IpmError(errors)
    program = lower(checked, style)
    faults = verify(program)
    if faults:
        hint = "this is a fault of ipmlang, not of the grammar: please report it"
        raise fail("compiler-fault", faults[0], hint=hint)
    return checked, program, checked.diagnostics
