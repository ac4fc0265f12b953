"""How fast the string executor is: `python tests/bench/bench_strings.py`.

Prints one JSON object: modules, instances, CPU seconds by stage, modules per CPU second, bytes a
row of the instance table and the peak beyond the process as it was over that table (0 where an
earlier grammar had a higher one), for a stochastic bracketed tree, a parametric one in space, a
curve and a threaded chain. Timings are kept, never asserted.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from ipmlang.compiler import ir
from ipmlang.runtime.assemble import scene
from ipmlang.runtime.draw import drawn
from ipmlang.runtime.grow import derived, interpreted
from ipmlang.runtime.interpret import stream
from ipmlang.runtime.scene import Scene
from ipmlang.runtime.strings import begun, steps_of
from ipmlang.runtime.turtle import Turtle
from tests.engine.grammars import compiled

GRAMMARS = {
    "stochastic tree, plane": """
turtle angle 25
A(l) : 50% --> F(l) [+(25 + rand(-9, 9)) A(l * 0.8)] F(l) [-(25 + rand(-9, 9)) A(l * 0.8)]
    A(l * 0.9)
A(l) : else --> F(l) [-(25 + rand(-9, 9)) A(l * 0.8)] F(l * 0.5) A(l * 0.9)
start A(1) steps 15
""",
    "stochastic tree, space": """
A(l, w) : 50% --> !(w) F(l) [&(45 + rand(-9, 9)) A(l * 0.7, w * 0.7)] /(137.5) A(l * 0.9, w * 0.7)
A(l, w) : else --> !(w) F(l) [&(30) A(l * 0.8, w * 0.7)] /(90) [^(40) A(l * 0.7, w * 0.7)]
    /(137.5) A(l * 0.9, w * 0.7)
start A(1, 10) steps 14
""",
    "Koch island": """
turtle angle 90
F --> F - F + F + F F - F - F + F
start F - F - F - F steps 6
""",
    "threaded chain": """
turtle angle 3
P(m) : m > 0 --> Q f(1) P(m - 1)
P(m) : else --> nil
Q --> F +
start P(3000)
""",
}  # fmt: skip


def measure(program: ir.Program) -> dict[str, float]:
    """One derivation, stage by stage."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    marks = [time.process_time()]
    rewriter = begun(program, (), program.limits)
    string = derived(rewriter, 1, steps_of(rewriter.bound, 1))
    marks.append(time.process_time())
    string = interpreted(rewriter, string)
    acts = stream(rewriter.bound, string)
    turtle = Turtle(program, acts)
    marks.append(time.process_time())
    rows, polygons = drawn(program, acts, turtle)
    found = scene(program, rows, polygons, seed=1, generations=0, shapes=0)
    marks.append(time.process_time())
    stages = np.diff(marks)
    used = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) * 1024
    return {
        "modules": string.length,
        "instances": len(found.instances),
        "rewrite_s": round(float(stages[0]), 3),
        "turtle_s": round(float(stages[1]), 3),
        "table_s": round(float(stages[2]), 3),
        "modules_per_s": round(string.length / float(stages.sum())),
        "bytes_a_row": round(size(found) / max(1, len(found.instances)), 1),
        "peak_over_table": round(used / max(1, size(found)), 2),
    }


def size(found: Scene) -> int:
    """Bytes of an instance table."""
    table = found.instances
    return sum(getattr(table, name).nbytes for name in table.__slots__)


if __name__ == "__main__":
    print(json.dumps({name: measure(compiled(text)) for name, text in GRAMMARS.items()}, indent=1))
