"""What inference makes of the buildings in tests/inverse/buildings, against what an author wrote.

    python tests/bench/bench_known_buildings.py [--save] [--tighten] [--show] [NAME …]

Each grammar is derived, its triangles shuffled (then turned, then welded too), written as an OBJ
without names, inferred, derived again and compared. `--save` keeps the table in
RESULTS-known-buildings.md beside this file; `--tighten` brings the bounds of the tests to what was
reached and loosens none; `--show` prints what was inferred.
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.buildings.answers import BOUNDS, DISGUISES, Answer, answer, bounds, names

RESULTS = Path(__file__).with_name("RESULTS-known-buildings.md")
WANTED, ERROR = 1.5, 1e-6
HEAD = (
    "| building | disguise | parts | tokens author | tokens flat | tokens inferred | ratio "
    "| rules author | rules | CPU s | error |\n|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
)


def row(found: Answer) -> str:
    """A line of the table."""
    return (
        f"| {found.name} | {found.disguise} | {found.parts} | {found.author} | {found.flat} "
        f"| {found.inferred} | {found.ratio:.2f} | {found.author_rules} | {found.rules} "
        f"| {found.seconds:.2f} | {found.error:.0e} |"
    )


def summary(found: list[Answer]) -> str:
    """How the targets are met."""
    lines = []
    for disguise in DISGUISES:
        of = [each for each in found if each.disguise == disguise]
        short = [each for each in of if each.ratio <= WANTED]
        few = [each for each in of if each.rules <= WANTED * each.author_rules]
        both = [each for each in short if each in few]
        exact = sum(each.error <= ERROR for each in of)
        lines.append(
            f"- {disguise}: {len(both)} of {len(of)} within {WANTED:g} times the author's rules "
            f"and tokens ({len(short)} by tokens, {len(few)} by rules; target 90 %); {exact} of "
            f"{len(of)} exact; {sum(each.seconds for each in of):.1f} CPU s."
        )
    return "\n".join(lines)


def tighten(found: list[Answer]) -> None:
    """Bring the bounds to what was reached, to a hundredth on the generous side."""
    kept = bounds() if BOUNDS.is_file() else {}
    for each in found:
        key = f"{each.name} {each.disguise}"
        kept[key] = min(kept.get(key, math.inf), math.ceil(each.ratio * 100) / 100)
    BOUNDS.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def main() -> None:
    """Print the table, and keep it if asked."""
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")]
    print(HEAD)
    found = []
    for name in wanted or names():
        for disguise in DISGUISES:
            found.append(answer(name, disguise))
            print(row(found[-1]), flush=True)
        if "--show" in sys.argv:
            print(f"\n{found[-1].text}")
    print(f"\n{summary(found)}")
    if "--tighten" in sys.argv:
        tighten(found)
    if "--save" in sys.argv and not wanted:
        rows = "\n".join(map(row, found))
        text = f"# Buildings that an author wrote, inferred\n\n{HEAD}\n{rows}\n\n{summary(found)}\n"
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
