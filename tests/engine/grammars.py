"""Grammars as text or files to programs, for tests of the runtime."""

from __future__ import annotations

from pathlib import Path

from ipmlang.compiler import compile_file, compile_text, ir


def compiled(grammar: str | Path, folder: Path = Path()) -> ir.Program:
    """The program of a file, or of a text whose assets lie in `folder`."""
    if isinstance(grammar, Path):
        return compile_file(grammar)[1]
    return compile_text(grammar, folder=folder)[1]
