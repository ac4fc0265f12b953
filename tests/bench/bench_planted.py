"""How much planted structure inference finds among clutter: recall and precision of its elements.

    python tests/bench/bench_planted.py [--save] [--raise] [--seeds N] [KIND …]

For each kind of structure, share of holes and jitter, one line: recall / precision with elements
painted structure by structure, two structures alternately, and in any order, over all seeds. Where
inference knows the regular form, a second table counts that. `--save` keeps both in
RESULTS-planted.md beside this file; it takes a minute or two of CPU. `--raise` lifts the floors of
the tests to what is reached now, lowers none, and prints no table.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from inverse.planted import (
    CASES,
    FLOORS,
    JITTERS,
    KINDS,
    ORDERS,
    Kind,
    Order,
    Score,
    can_symmetrize,
    floors,
    inferred,
    name_of,
    plant,
    score,
    total,
)

RESULTS = Path(__file__).with_name("RESULTS-planted.md")
HOLES = (0.0, 0.2)
TARGETS = {0.001: 0.95, 0.01: 0.85}
SEEDS = 2
HEAD = f"| structure | holes | jitter | {' | '.join(ORDERS)} |\n|---|--:|--:|{'--:|' * len(ORDERS)}"

Scores = dict[tuple[Kind, float, float, Order], Score]


def measure(kinds: Sequence[Kind], seeds: int, symmetrized: bool) -> Iterator[tuple[str, Scores]]:
    """A line of the table for each kind, share of holes and jitter, with its scores."""
    for kind in kinds:
        for holes in HOLES:
            for jitter in JITTERS:
                scores: Scores = {}
                for order in ORDERS:
                    every = [plant(kind, jitter, order, holes, seed) for seed in range(seeds)]
                    scores[kind, holes, jitter, order] = total(
                        score(planted, inferred(planted, symmetrized)) for planted in every
                    )
                cells = " | ".join(map(str, scores.values()))
                yield f"| {kind} | {holes:.0%} | {jitter:.1%} | {cells} |", scores


def summary(scores: Scores) -> str:
    """Recall and precision by jitter and paint order, all kinds together, against the targets."""
    lines = []
    for jitter in JITTERS:
        said = []
        for order in ORDERS:
            every = total(v for k, v in scores.items() if k[2] == jitter and k[3] == order)
            said.append(f"{order} {every}")
        target = f" (target {TARGETS[jitter]})" if jitter in TARGETS else ""
        lines.append(f"- jitter {jitter:.1%}{target}: {', '.join(said)}")
    return "\n".join(lines)


def table(kinds: Sequence[Kind], seeds: int, symmetrized: bool) -> str:
    """Print a table line by line; its text."""
    form = "the regular grammar" if symmetrized else "the exact grammar"
    title = f"## Recall / precision in {form}, {seeds} seeds\n\n{HEAD}"
    print(title)
    lines, scores = [title], Scores()
    started = time.process_time()
    for line, found in measure(kinds, seeds, symmetrized):
        print(line, flush=True)
        lines.append(line)
        scores |= found
    spent = f"{time.process_time() - started:.0f} CPU s."
    print(f"\n{summary(scores)}\n\n{spent}\n")
    return "\n".join([*lines, "", summary(scores), "", spent])


def lift() -> None:
    """Raise the floors of the tests to what is reached, rounded down to a hundredth."""
    kept = floors() if FLOORS.is_file() else {}
    lines = []
    for case in CASES:
        name, planted = name_of(case), plant(*case)
        reached = score(planted, inferred(planted))
        # Without a rule there is nothing that precision could be said of.
        now = reached.recall, reached.precision if reached.ruled else 0.0
        before = kept.get(name, (0.0, 0.0))
        floor = [
            max(old, math.floor(new * 100) / 100) for old, new in zip(before, now, strict=True)
        ]
        lines.append(f' "{name}": {json.dumps(floor)}')
        print(f"{name}: {reached}", flush=True)
    text = ",\n".join(lines)
    FLOORS.write_text(f"{{\n{text}\n}}\n", encoding="utf-8")


def main() -> None:
    """Print the tables, and keep them if asked."""
    words = sys.argv[1:]
    if "--raise" in words:
        lift()
        return
    seeds = int(words[words.index("--seeds") + 1]) if "--seeds" in words else SEEDS
    kinds = [kind for kind in KINDS if kind in words] or list(KINDS)
    tables = [table(kinds, seeds, False)]
    if can_symmetrize():
        tables.append(table(kinds, seeds, True))
    if "--save" in words:
        text = "# Planted structure\n\n" + "\n\n".join(tables) + "\n"
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
