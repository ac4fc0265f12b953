"""Grammars as text or files to programs, for tests of the runtime."""

from __future__ import annotations

from pathlib import Path

from ipmlang.compiler import ir
from ipmlang.compiler.diagnostics import IpmError, Source
from ipmlang.compiler.lower import lower_units, unit
from ipmlang.compiler.parse import parse


def compiled(grammar: str | Path) -> ir.Program:
    """The program of a file, or of a text."""
    text = grammar.read_text() if isinstance(grammar, Path) else grammar
    source = Source(str(grammar) if isinstance(grammar, Path) else "<text>", text)
    tree, diagnostics = parse(source)
    if diagnostics:
        raise IpmError(diagnostics)
    return lower_units(unit(tree, source))
