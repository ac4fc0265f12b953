"""Prove, then print: what was inferred is derived by the one engine and compared with the input.

Takes the text of a grammar and its parts file; gives the comparison. Works in a folder of its own
that is gone afterwards, so that nothing is written before it is known to be right.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from ipmlang.compiler import compile_file
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg import split_compound
from ipmlang.inverse.compare import LIMIT, Comparison, compare
from ipmlang.runtime import derive
from ipmlang.runtime.export.sheet import drawing_of


def derived(text: str, parts: str, stem: str) -> Drawing:
    """What a grammar and its parts file draw."""
    with tempfile.TemporaryDirectory(prefix="ipmlang-") as folder:
        path = Path(folder) / f"{stem}.ipm"
        path.write_text(text, encoding="utf-8")
        (Path(folder) / f"{stem}.parts.svg").write_text(parts, encoding="utf-8")
        _, program, _ = compile_file(path)
        return drawing_of(derive(program))


def prove(drawing: Drawing, text: str, parts: str, stem: str, limit: float = LIMIT) -> Comparison:
    """How what is derived differs from the drawing that was read, whose compound paths are taken
    apart; so are those of a turtle's `path` of many parts. limit: see `compare`.
    """
    again = derived(text, parts, stem)
    if len(again.elements) < len(drawing.elements):
        again = split_compound(again)
    return compare(drawing, again, limit)
