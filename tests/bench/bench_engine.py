"""How fast the engine is: `python tests/bench/bench_engine.py`.

Prints one JSON object: for each grammar what was derived, CPU seconds of `derive`, modules (every
symbol of the string, brackets and commands too) and instances a CPU second, bytes a row of the
instance table, and the peak beyond the process as it was over that table. Each runs in a process of
its own, so that peaks are its own. Timings are kept, never asserted.
"""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import fields
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from processes import report  # noqa: E402

import ipmlang  # noqa: E402
from ipmlang.compiler import ir  # noqa: E402
from ipmlang.runtime import derive  # noqa: E402
from ipmlang.runtime.scene import Scene  # noqa: E402

GRAMMARS = {
    "stochastic tree in space": """ipm 1
A(l, w) : 50% --> !(w) F(l) [&(45 + rand(-9, 9)) A(l * 0.7, w * 0.7)] /(137.5) A(l * 0.9, w * 0.7)
A(l, w) : else --> !(w) F(l) [&(30) A(l * 0.8, w * 0.7)] /(90) [^(40) A(l * 0.7, w * 0.7)]
    /(137.5) A(l * 0.9, w * 0.7)
start A(1, 10) steps 16
""",
    "stochastic tree in the plane": """ipm 1
A(l) : 50% --> F(l) [+(25 + rand(-9, 9)) A(l * 0.8)] F(l) [-(25 + rand(-9, 9)) A(l * 0.8)]
    A(l * 0.9)
A(l) : else --> F(l) [-(25 + rand(-9, 9)) A(l * 0.8)] F(l * 0.5) A(l * 0.9)
start A(1) steps 15
""",
    "chain of 100,000 in the plane": """ipm 1
P(m) : m > 0 --> F(1) +(3.3) P(m - 1)
P(m) : else --> F(1)
start P(100000)
""",
    "chain of 100,000 in space": """ipm 1
P(m) : m > 0 --> F(1) +(3) &(1) P(m - 1)
P(m) : else --> F(1)
start P(100000)
""",
    "repeat of 1,000,000": """ipm 1
start repeat(i < 1000000) { F(1) +(3.3 + 0.001 * i) }
""",
    "1,000 chains of 100": """ipm 1
P(m) : m > 0 --> F(rand(1, 2)) +(rand(-9, 9)) P(m - 1)
P(m) : else --> F(1)
start repeat(i < 1000) { [f(i) P(100)] }
""",
}  # fmt: skip


def measure(name: str) -> dict[str, float]:
    """One derivation in this process."""
    program = ipmlang.parse(GRAMMARS[name]).program
    derive(ipmlang.parse("ipm 1\nstart repeat(i < 9) { F + }\n").program)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    scene = derive(program, seed=1)
    seconds = time.process_time() - start
    peak = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    table = sum(getattr(scene.instances, each.name).nbytes for each in fields(scene.instances))
    count = len(scene.instances)
    modules = modules_of(program, scene)
    return {
        "instances": count,
        "modules": modules,
        "cpu_s": round(seconds, 3),
        "modules_per_s": round(modules / seconds),
        "instances_per_s": round(count / seconds),
        "bytes_per_row": round(table / count, 1),
        "peak_over_table": round(peak / table, 2),
    }


def modules_of(program: ir.Program, scene: Scene) -> int:
    """How many modules the derivation's last string has, or a little less: what each production
    that drew has added.

    Every production of these grammars draws as many segments each time it is applied, so how often
    it was is the number of its rows over those; what stands in a repeat is counted as a production.
    """
    total = 1
    rules = np.bincount(scene.instances.rule, minlength=len(program.productions) + 1)
    for production, rows in zip((*program.productions, program.axiom), rules.tolist(), strict=True):
        drawn = _drawing(program, production.body)
        if drawn:
            total += rows // drawn * (_length(production.body) - 1)
    return total


def _drawing(program: ir.Program, body: tuple[ir.Instruction, ...]) -> int:
    return sum(
        _drawing(program, each.body)
        if each.op == "repeat"
        else each.op == "module"
        and any(
            step.op == "segment" for step in program.symbols[int(str(each.const))].meaning or ()
        )
        for each in body
    )


def _length(body: tuple[ir.Instruction, ...]) -> int:
    return sum(
        _length(each.body) if each.op == "repeat" else each.op in ("module", "open", "close")
        for each in body
    )


if __name__ == "__main__":
    report(__file__, GRAMMARS, measure, {})
