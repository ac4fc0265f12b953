"""Textbook L-systems recovered from their drawings: a table of segments, bytes, tokens and time.

    python tests/bench/bench_recursion.py [--save] [NAME …]

Each system is run by the engine, its segments are folded back, and the grammar that comes out is
run again and compared. The real L-system drawings of the shared data follow, where they are here.
`--save` also writes the table to RESULTS-recursion.md beside this file.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.textbook import SYSTEMS, Complexes, drawn

from ipmlang.compiler import ast
from ipmlang.compiler.format import format_grammar
from ipmlang.compiler.tokens import count_text_tokens
from ipmlang.formats.svg import read_svg, split_compound
from ipmlang.inverse.recursion import as_grammar, fold, segments

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg"
RESULTS = Path(__file__).with_name("RESULTS-recursion.md")
HEAD = (
    "| system | segments | steps | author's tokens | tokens | bytes | error | CPU s | rules |\n"
    "|---|--:|--:|--:|--:|--:|--:|--:|---|"
)


def row(
    name: str, start: Complexes, end: Complexes, styles: np.ndarray | None, tokens: int
) -> tuple[str, bool]:
    """A line of the table, and whether the system was recovered."""
    began = time.process_time()
    found = fold(start, end, styles=styles)
    seconds = time.process_time() - began
    if found is None:
        return f"| {name} | {len(start)} | | {tokens or ''} | | | | {seconds:.2f} | none |", False
    text = format_grammar(ast.Grammar((ast.Version(1), *as_grammar(found))))
    again = drawn(text)
    points = np.concatenate([start, end])
    diagonal = abs(complex(np.ptp(points.real), np.ptp(points.imag)))
    error = float(np.abs(np.concatenate(again) - points).max()) / diagonal
    rules = "; ".join(line for line in text.splitlines() if "-->" in line)
    return (
        f"| {name} | {len(start)} | {found.steps} | {tokens or ''} | {count_text_tokens(text)} "
        f"| {len(text.encode())} | {error:.0e} | {seconds:.2f} | `{rules}` |",
        error < 1e-6 and seconds <= 10,
    )


def rows(names: list[str]) -> Iterator[tuple[str, bool]]:
    """All lines, the real drawings last."""
    for name, text in SYSTEMS.items():
        if not names or name in names:
            yield row(name, *drawn(text), None, count_text_tokens(text))
    for path in sorted(DATA.glob("lsys_*.svg")):
        if names and path.stem not in names:
            continue
        drawing = split_compound(read_svg(path))
        lines = [(each.outline, each.style) for each in drawing.elements if each.outline]
        lines = [each for each in lines if len(each[0].kind) == 1]
        known: dict[object, int] = {}
        styles = np.array([known.setdefault(style, len(known)) for _, style in lines])
        got = segments([outline for outline, _ in lines], 0.0)
        if got is not None:
            yield row(path.stem, got.start, got.end, styles, 0)


def main() -> None:
    """Print the table and how many were recovered."""
    names = [each for each in sys.argv[1:] if each != "--save"]
    print(HEAD)
    lines, recovered = [], 0
    for line, good in rows(names):
        print(line, flush=True)
        lines.append(line)
        recovered += good
    told = f"{recovered} of {len(lines)} recovered, each within 10 s of processor time."
    print(f"\n{told}")
    if "--save" in sys.argv:
        text = "\n".join(
            ["# L-systems recovered from their drawings", "", told, "", HEAD, *lines, ""]
        )
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
