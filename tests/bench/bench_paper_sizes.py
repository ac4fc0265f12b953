"""How long inference takes at the sizes of the 2010 paper, on loose lines and on a large drawing.

    python tests/bench/bench_paper_sizes.py [--save] [NAME …]

Three drawings of 72, 500 and 1,184 elements, as many as the paper's, stand beside its published
seconds; 8,500 loose lines and a town of 20,000 elements show how time and memory grow. Each drawing
is inferred in a process of its own, after a tiny one that pays for the imports. `--save` keeps the
table in RESULTS-paper-sizes.md beside this file.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from bench.bench_inference import town

import ipmlang
from ipmlang.formats.drawing import Drawing
from ipmlang.formats.svg.write import write_svg
from ipmlang.inverse import infer

RESULTS = Path(__file__).with_name("RESULTS-paper-sizes.md")
TERMINALS = Path(__file__).parents[1] / "inverse" / "known"
TINY = "<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0L1 2'/><path d='M5 0L6 2'/></svg>"

PATTERN = """ipm 1
canvas (0, 0, 200, 160)
asset star, petal in "shapes.parts.svg"
Pattern --> repeat(j < 3) { repeat(i < 4) { [at(45 * i + 20 * mod(j, 2), 45 * j) Flower] } }
Flower --> [star] repeat(k < 5) { [+(72 * k + 18) f(7) petal] }
start at(25, 30) Pattern
"""

FACADE = """ipm 1
canvas (0, 0, 300, 380)
asset frame, pane, sill, arch, cornice, shop, lamp, eye in "house.parts.svg"
asset bar in "shapes.parts.svg"
House -->
    repeat(i < 6) { [at(38 * i, 0) [shop] [at(33, 20) lamp]] }
    [at(0, 38) cornice] repeat(j < 7) { [at(0, 50 + 40 * j) Floor] } [at(0, 330) cornice]
    repeat(i < 34) { [at(4 + 6.8 * i, 338, 0, 0.6) eye] }
    repeat(i < 60) { [at(2 + 3.85 * i, 345) bar] }
Floor --> repeat(i < 8) { [at(5 + 29 * i, 0) Window] }
Window -->
    frame repeat(r < 2) { repeat(c < 2) { [at(1.5 + 6 * c, 1.5 + 9 * r) pane] } } sill
    [at(0, 21) arch]
start at(20, 6) House
"""

PAGE = """ipm 1
canvas (0, 0, 800, 800)
asset leaf, petal, berry, star, diamond, comma, wedge in "shapes.parts.svg"
Page -->
    repeat(k < 4) { [at(400, 400, 90 * k) Side] } [at(400, 400) Wreath] [at(325, 340) Field]
    [at(240, 240) +(45) Scroll] [at(560, 240) mirror +(45) Scroll]
    [at(240, 560) turn mirror +(45) Scroll] [at(560, 560) turn +(45) Scroll]
Side --> [at(-330, -370) Border] [at(-365, -365) Rosette]
Border --> repeat(i < 60) { [+(60) leaf] [at(3, 0) turn mirror -(120) leaf] f(11) }
Rosette --> star repeat(k < 12) { [+(30 * k) f(8) petal] [+(30 * k + 15) f(22) berry] }
Wreath --> repeat(r < 3) { repeat(k < 36) { [+(10 * k) f(125 + 25 * r) [leaf] [at(4, 5) berry]] } }
Field --> repeat(j < 8) { repeat(i < 10) { [at(16 * i, 16 * j) [diamond] [at(5, 5) comma]] } }
Scroll --> repeat(i < 57) { [wedge] f(9) *(0.975) +(9) }
start Page
"""


def written(text: str) -> Callable[[], str]:
    """The SVG of a grammar whose terminals lie with the known answers."""

    def svg() -> str:
        with tempfile.TemporaryDirectory(prefix="ipmlang-sizes-") as folder:
            path = Path(folder) / "drawn.svg"
            ipmlang.save(ipmlang.parse(text, folder=TERMINALS).run(), path)
            return path.read_text(encoding="utf-8")

    return svg


def loose_lines() -> str:
    """Lines between points at random, of random lengths: nothing to find."""
    ends = np.random.default_rng(1).uniform(0, 1000, (8500, 4)).round(2)
    lines = "\n".join(f'<path d="M{a} {b}L{c} {d}"/>' for a, b, c, d in ends.tolist())
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 1000">'
    return f'{head}<g fill="none" stroke="#000000">\n{lines}\n</g></svg>'


def large_town() -> str:
    """Houses with fences, at irregular distances."""
    made: Drawing = town(20_000)
    return write_svg(made)


@dataclass(frozen=True, slots=True)
class Case:
    """elements: as many there must be; limit: CPU seconds wanted, a hundredth of what the paper
    published where it did.
    """

    svg: Callable[[], str]
    elements: int
    limit: float
    published: float | None = None


CASES = {
    "small pattern": Case(written(PATTERN), 72, 0.16, 16.0),
    "facade": Case(written(FACADE), 500, 2.09, 209.0),
    "ornamental page": Case(written(PAGE), 1184, 12.15, 1215.0),
    "loose lines": Case(loose_lines, 8500, 15.0),
    "town": Case(large_town, 20_000, 60.0),
}
HEAD = (
    "| drawing | elements | CPU s | published s | times faster | wanted s | s per 1,000 "
    "| tokens flat | tokens | ratio | rules | error | peak MB |\n" + "|---|" + "--:|" * 12
)


def measure(name: str) -> dict[str, float]:
    """The report of one drawing in this process, and the most memory it had."""
    with tempfile.TemporaryDirectory(prefix="ipmlang-sizes-") as folder:
        tiny, path = Path(folder) / "tiny.svg", Path(folder) / "drawn.svg"
        tiny.write_text(TINY, encoding="utf-8")
        path.write_text(CASES[name].svg(), encoding="utf-8")
        infer(tiny)
        report = infer(path).report
    return {
        "elements": report.elements,
        "seconds": report.seconds,
        "flat": report.tokens_flat,
        "tokens": report.tokens,
        "rules": report.rules,
        "error": report.max_error,
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def row(name: str, found: dict[str, float]) -> str:
    """A line of the table."""
    case, seconds = CASES[name], found["seconds"]
    published = "" if case.published is None else f"{case.published:.0f}"
    faster = "" if case.published is None else f"{case.published / seconds:.0f}"
    return (
        f"| {name} | {found['elements']} | {seconds:.2f} | {published} | {faster} "
        f"| {case.limit:g} | {1000 * seconds / found['elements']:.2f} | {found['flat']} "
        f"| {found['tokens']} | {found['flat'] / found['tokens']:.1f} | {found['rules']} "
        f"| {found['error']:.0e} | {found['megabytes']:.0f} |"
    )


def alone(name: str) -> dict[str, float]:
    """The same in a process of its own."""
    command = [sys.executable, __file__, "--one", name]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout)
    if found["elements"] != CASES[name].elements:
        raise SystemExit(f"{name}: {found['elements']} elements, not {CASES[name].elements}")
    return found


def main() -> None:
    """Print the table, and keep it if asked."""
    if "--one" in sys.argv:
        print(json.dumps(measure(sys.argv[-1])))
        return
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")]
    print(HEAD)
    lines = [HEAD]
    for name in wanted or CASES:
        lines.append(row(name, alone(name)))
        print(lines[-1], flush=True)
    if "--save" in sys.argv and not wanted:
        text = "# Inference at the paper's sizes\n\n" + "\n".join(lines) + "\n"
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
