"""What inference makes of real drawings: a table of elements, tokens, rules, error, time and size.

    python tests/bench/bench_inference.py [--save] [NAME …]

Reads every drawing of the shared data, or those named; `--save` also writes the table to
RESULTS-inference.md beside this file. Prints one row as soon as it is known.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.inverse import infer

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg"
RESULTS = Path(__file__).with_name("RESULTS-inference.md")
HEAD = (
    "| drawing | elements | tokens flat | tokens | flat / grammar | rules | used twice | explained "
    "| error | CPU s | source B | grammar + parts B |\n"
    "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
)


def rows(names: list[str]) -> Iterator[tuple[str, float]]:
    """A line of the table for each drawing, with flat / grammar tokens."""
    for path in sorted(DATA.glob("*.svg")):
        if names and path.stem not in names:
            continue
        try:
            report = infer(path).report
        except IpmError as error:
            yield f"| {path.stem} | {str(error).splitlines()[0]} |" + " |" * 10, 0.0
            continue
        ratio = report.tokens_flat / report.tokens
        yield (
            f"| {path.stem} | {report.elements} | {report.tokens_flat} | {report.tokens} "
            f"| {ratio:.1f} | {report.rules} | {report.rules_twice} | {report.explained:.0%} "
            f"| {report.max_error:.0e} | {report.seconds:.1f} | {report.source_bytes} "
            f"| {report.grammar_bytes + report.parts_bytes} |",
            ratio,
        )


def main() -> None:
    """Print the table, and keep it if asked."""
    names = [word for word in sys.argv[1:] if not word.startswith("-")]
    if not DATA.is_dir():
        print(f"the drawings are not there: {DATA}")
        return
    print(HEAD)
    lines, ratios = [HEAD], []
    for line, ratio in rows(names):
        print(line, flush=True)
        lines.append(line)
        ratios.append(ratio)
    summary = f"Median of flat / grammar tokens: {median(ratios or [0.0]):.2f}."
    print(f"\n{summary}")
    if "--save" in sys.argv:
        text = "# Inference on real drawings\n\n" + "\n".join(lines) + f"\n\n{summary}\n"
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
