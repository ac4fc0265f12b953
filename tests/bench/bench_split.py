"""How fast split grammars are derived: `python tests/bench/bench_split.py`.

Prints one JSON object: for each task how many terminals came out, CPU seconds of the first
derivation in a process and the best of three, terminals a CPU second, and the peak beyond the
process as it was; and the CPU seconds of the whole command for one small house. A loop of plain
Python with a known count runs beside each task (`loop_s`), so that runs on busy machines can be
compared. Timings are kept, never asserted.
"""

from __future__ import annotations

import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from processes import report  # noqa: E402

import ipmlang  # noqa: E402

FACADE = """ipm 1
Lot   --> split y { 4: Floor | { ~3: Floor }* }
Floor --> split x { ~1: Wall | { ~2.5: Bay }* | ~1: Wall }
Bay   --> split x { ~1: Wall | 1.2: Win | ~1: Wall }
Win   --> split y { 0.8: Sill | ~1: Pane | 0.3: Lintel }
start Lot on box(1640, 930, 0)
"""
SNAPPED = FACADE.replace("4: Floor | { ~3: Floor }*", "4: Piers | { ~3: phase(2) Floor }*").replace(
    "Floor --> split x {",
    'Piers --> split x { { ~4.1: snap("pier", x) Pier }* }\nFloor --> split x(snap: "pier") {',
)
HOUSE = """ipm 1
Lot    --> extrude(10) comp { side: Facade | top: Roof }
Facade --> split y { { ~3: Floor }* }
Floor  --> split x { { ~3: Tile }* }
Tile   --> split x { ~1: Wall | 1.4: Mid | ~1: Wall }
Mid    --> split y { 0.8: Wall | 1.5: Window | ~1: Wall }
Roof   --> RoofTop
start Lot on box(8, 11, 0)
"""
HOUSES = HOUSE.replace(
    "start Lot on box(8, 11, 0)",
    "start repeat(i < 1000) { [translate(20 * mod(i, 40), 25 * floor(i / 40), 0) "
    "size(8 + 0.01 * mod(i, 7), 11, 0) Lot] } on box(1, 1, 0)",
)
TOWN = """ipm 1
attr floors : int = irand(1, 4) in 1..9
asset tree = "tree.obj"
Lot    --> setback(1.5, front: 3) { shape: Mass | front: Front | border: Lawn }
Front  --> scatter(2) size(2, 2, 3) insert(tree) Tree
Mass   --> extrude(floors * 3 + 0.5) comp { side: Facade | top: Roof }
Facade --> split y { { ~3: Floor }* | 0.5: Cornice }
Floor  --> split x { ~0.6: Wall | { ~2.2: Bay }* | ~0.6: Wall }
Bay    --> split x { ~1: Wall | 1: Win | ~1: Wall }
Win    --> split y { ~1: Wall | 1.4: Pane | ~0.6: Wall }
Roof : 50%  --> roofHip(35, overhang: 0.4) Tiles
Roof : else --> roofGable(40) comp { slope: Tiles | gable: Wall | bottom: nil }
start Lot on "lots.obj"
"""
TREE = (
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 3\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
)
TASKS = {
    "a facade of a million terminals": FACADE,
    "a facade of a million terminals that snaps": SNAPPED,
    "a thousand houses": HOUSES,
    "a town of 2,000 lots": TOWN,
}


def lots(count: int) -> str:
    """Footprints of lots: most near-rectangular, a quarter L-shaped, no two alike."""
    draw = random.Random(3)
    points: list[tuple[float, float]] = []
    faces: list[str] = []
    for number in range(count):
        x, y = 24 * (number % 50) + draw.random(), 30 * (number // 50) + draw.random()
        w, h = 18 + 4 * draw.random(), 22 + 5 * draw.random()
        own = [(x, y), (x + w, y + draw.uniform(-1, 1)), (x + w + draw.uniform(-1, 1), y + h),
               (x + draw.uniform(-1, 1), y + h)]  # fmt: skip
        if draw.random() < 0.25:
            own = [(x, y), (x + w, y), (x + w, y + h / 2), (x + w / 2, y + h / 2),
                   (x + w / 2, y + h), (x, y + h)]  # fmt: skip
        numbers = range(len(points) + 1, len(points) + 1 + len(own))
        faces.append("f " + " ".join(map(str, numbers)))
        points += own
    vertices = [f"v {x:.4f} {y:.4f} 0" for x, y in points]
    return "\n".join([*vertices, *faces, ""])


def loop() -> float:
    """CPU seconds of a loop that is always the same."""
    start = time.process_time()
    total = 0
    for number in range(2_000_000):
        total += number & 7
    return time.process_time() - start


def measure(name: str) -> dict[str, float]:
    """One task in this process."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "lots.obj").write_text(lots(2000), encoding="utf-8")
        Path(folder, "tree.obj").write_text(TREE, encoding="utf-8")
        grammar = ipmlang.parse(TASKS[name], folder=folder)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        seconds = []
        for _ in range(3):
            start = time.process_time()
            count = len(grammar.run(seed=1).instances)
            seconds.append(time.process_time() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return {
        "terminals": count,
        "first_s": round(seconds[0], 3),
        "best_s": round(min(seconds), 3),
        "terminals_per_s": round(count / min(seconds)),
        "peak_mb": round(peak / 1024),
        "loop_s": round(loop(), 3),
    }


def command() -> dict[str, float]:
    """The whole command for one small house, with compiled bytecode, as an installation has it."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "house.ipm").write_text(HOUSE, encoding="utf-8")
        more = {"PYTHONPYCACHEPREFIX": str(Path(folder, "pyc")), "PYTHONDONTWRITEBYTECODE": ""}
        line = [sys.executable, "-m", "ipmlang", "run", "house.ipm", "-o", "house.glb", "--json"]
        seconds = []
        for _ in range(3):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            done = subprocess.run(line, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT),
                                  **more}, check=True, capture_output=True, text=True)  # fmt: skip
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    terminals = json.loads(done.stdout)["terminals"]
    return {"terminals": terminals, "best_s": round(min(seconds), 3), "loop_s": round(loop(), 3)}


if __name__ == "__main__":
    report(__file__, TASKS, measure, {"one small house, the whole command": command})
