"""What inference makes of the grammars in tests/inverse/known, against what their authors wrote.

    python tests/bench/bench_known.py [--save] [--tighten] [--show] [NAME …]

Each grammar is run to SVG, the SVG is inferred, what was inferred is run and compared. "Ruled" is
the share of the elements under repetition or rules used twice: inferred, then author. `--save`
keeps the table in RESULTS-known.md beside this file; `--tighten` brings the bounds of the tests to
what was reached and gives new grammars theirs, but loosens none; `--show` prints what was inferred.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.known.answers import BOUNDS, Answer, answer, bounds, names

RESULTS = Path(__file__).with_name("RESULTS-known.md")
WANTED, MOST = 1.5, 3.0  # times the author's tokens: in nine of ten, and never more
HEAD = (
    "| grammar | elements | tokens author | tokens flat | tokens inferred | ratio | ruled | rules "
    "| CPU s | error |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
)


def row(found: Answer) -> str:
    """A line of the table."""
    error = f"{found.comparison.max_error:.0e}" if found.comparison.agrees() else "NOT EXACT"
    return (
        f"| {found.name} | {found.elements} | {found.author} | {found.flat} | {found.inferred} "
        f"| {found.ratio:.2f} | {found.ruled:.0%} / {found.author_ruled:.0%} | {found.rules} "
        f"| {found.seconds:.2f} | {error} |"
    )


def summary(found: list[Answer]) -> str:
    """How the targets are met."""
    good = sum(each.ratio <= WANTED for each in found)
    over = [each.name for each in found if each.ratio > MOST]
    exact = sum(each.comparison.agrees() for each in found)
    flat = [each.name for each in found if each.ruled < 0.9 * each.author_ruled]
    return (
        f"{good} of {len(found)} ({good / len(found):.0%}) within {WANTED:g} times the author's "
        f"tokens (target 90 %); {len(over)} over {MOST:g} times (target 0)"
        f"{': ' if over else ''}{', '.join(over)}; {exact} of {len(found)} exact; "
        f"fewer elements under rules than the author has: {', '.join(flat) or 'none'}; "
        f"{sum(each.seconds for each in found):.1f} CPU s."
    )


def tighten(found: list[Answer]) -> None:
    """Bring the bounds to what was reached, to a hundredth on the generous side."""
    kept = bounds() if BOUNDS.is_file() else {}
    for each in found:
        ceiling, floor = kept.get(each.name, (math.inf, 0.0))
        reached = math.ceil(each.ratio * 100) / 100, math.floor(each.ruled * 100) / 100
        kept[each.name] = min(ceiling, reached[0]), max(floor, reached[1])
    lines = [f' "{name}": {json.dumps(kept[name])}' for name in names() if name in kept]
    text = ",\n".join(lines)
    BOUNDS.write_text(f"{{\n{text}\n}}\n", encoding="utf-8")


def main() -> None:
    """Print the table, and keep it if asked."""
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")]
    print(HEAD)
    found = []
    for name in wanted or names():
        found.append(answer(name))
        print(row(found[-1]), flush=True)
        if "--show" in sys.argv:
            print(f"\n{found[-1].text}")
    print(f"\n{summary(found)}")
    if "--tighten" in sys.argv:
        tighten(found)
    if "--save" in sys.argv and not wanted:
        table = "\n".join([HEAD, *map(row, found)])
        text = f"# Inference against known answers\n\n{table}\n\n{summary(found)}\n"
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
