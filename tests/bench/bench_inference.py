"""What inference makes of real drawings: a table of elements, tokens, rules, error, time and size.

    python tests/bench/bench_inference.py [--save] [--growth] [NAME …]

Reads every drawing of the shared data, or those named; `--save` also writes the table to
RESULTS-inference.md beside this file. `--growth` adds a made-up town of 500 to 20,000 elements.
Prints one row as soon as it is known.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.synth import STROKED, copies, drawing, rectangle, row

from ipmlang.compiler.diagnostics import IpmError
from ipmlang.formats.drawing import Drawing, DrawnElement
from ipmlang.inverse import infer
from ipmlang.inverse.attempt import best_grammar

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "svg"
# Drawings with structure that a person would have written down: what the target is measured on.
STRUCTURED = {
    "lsys_plant",
    "lsys_dragon",
    "lsys_plant_stochastic",
    "mandala",
    "knotwork",
    "flag_eu",
    "flag_uz",
    "flag_us",
    "flag_ve",
    "flag_ir",
    "batik_symbolViewBox",
    "batik_sunRise",
    "batik_cards",
    "vpype_multi_skull",
    "vpype_halftone",
    "cad_line_types",
    "cad_lego",
    "cad_ex13",
    "vega_small_multiples",
    "pcb_moire",
}
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


def town(count: int) -> Drawing:
    """Houses with a fence each, at irregular distances: repetition on two levels."""
    random = np.random.default_rng(0)
    elements: list[DrawnElement] = []
    for house in range(count // 12 + 1):
        x, y = (house % 40) * 24.0 + int(random.integers(0, 5)), (house // 40) * 30.0 + 5
        elements += copies(rectangle(12, 8), row(1, (0, 0), (x, y)))
        elements += copies(rectangle(14, 2), row(1, (0, 0), (x, y - 5)), STROKED)
        elements += copies(rectangle(2, 2), row(2, (5, 0), (x - 3, y - 1)))
        elements += copies(rectangle(1, 6), row(8, (1.5, 0), (x - 5, y + 8)))
    return drawing(elements[:count], (0, 0, 1000, 30 * (count // 480 + 2)))


def growth() -> Iterator[str]:
    """A line for each size of the town, with CPU seconds."""
    for count in (500, 1200, 5000, 20000):
        made_up = town(count)
        started = time.process_time()
        report = best_grammar(made_up, "town", False, lambda _: None).report
        seconds = time.process_time() - started
        yield f"| town | {count} | {report.rules} rules | {seconds:.2f} CPU s |"


def main() -> None:
    """Print the table, and keep it if asked."""
    names = [word for word in sys.argv[1:] if not word.startswith("-")]
    if not DATA.is_dir():
        print(f"the drawings are not there: {DATA}")
        return
    print(HEAD)
    lines, ratios, structured = [HEAD], [], []
    for line, ratio in rows(names):
        print(line, flush=True)
        lines.append(line)
        ratios.append(ratio)
        if line.split()[1] in STRUCTURED:
            structured.append(ratio)
    summary = (
        f"Median of flat / grammar tokens: {median(ratios or [0.0]):.2f}; "
        f"of the {len(structured)} structured drawings: {median(structured or [0.0]):.2f}."
    )
    print(f"\n{summary}")
    more = []
    if "--growth" in sys.argv:
        for line in growth():
            print(line, flush=True)
            more.append(line)
    if "--save" in sys.argv:
        text = "# Inference on real drawings\n\n" + "\n".join(lines) + f"\n\n{summary}\n"
        text += "\n" + "\n".join(more) + "\n" if more else ""
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
