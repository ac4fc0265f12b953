"""How the time that inference takes grows with the number of parts: 1,000 to 20,000 of them.

    python tests/bench/bench_growth.py [--save] [PARTS …]

Three kinds of models of boxes are written as OBJ and inferred, each in a process of its own after a
tiny one that pays for the imports: a grid, irregular lots with equal houses, and groups of
furniture put anywhere. `--save` keeps the table in RESULTS-growth.md beside this file.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from ipmlang.inverse import infer

RESULTS = Path(__file__).with_name("RESULTS-growth.md")
COUNTS = (1_000, 5_000, 20_000)
CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], float)
FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
COLUMNS = ("model", "parts", "tokens flat", "tokens", "rules", "seconds", "per 100 parts", "MB")
HEAD = """# Growth

Models of boxes as `bench_growth.py --save` inferred them: `grid`, equal boxes in a grid; `lots`,
equal houses of fifty parts on irregular lots; `groups`, eight kinds of groups of five parts put
anywhere. Seconds of CPU time on a machine on which `sum(i * i for i in range(10**6))` took
{low:.3f} to {high:.3f} s beside each; all of it: reading, search, proof and printing.

"""
Box = tuple[np.ndarray, np.ndarray]


def grid(count: int) -> Iterator[Box]:
    """Boxes in two directions."""
    wide = int(np.ceil(np.sqrt(count / 2)))
    for index in range(count):
        yield np.array([2.0 * (index % wide), 0, 3.0 * (index // wide)]), np.array([1, 0.5, 2])


def lots(count: int) -> Iterator[Box]:
    """Houses of a wall and 49 windows."""
    random = np.random.default_rng(1)
    for house in range(count // 50):
        corner = np.array([house % 25 * 20.0, house // 25 * 20, 0])
        corner = np.round(corner + random.uniform(0, 3, 3), 2)
        yield corner, np.array([15.0, 10, 15])
        for window in range(49):
            place = np.array([0.5 + 2 * (window % 7), -0.3, 0.5 + 2 * (window // 7)])
            yield corner + place, np.array([1, 0.2, 1.5])


def groups(count: int) -> Iterator[Box]:
    """Groups of five boxes, of eight kinds."""
    random = np.random.default_rng(2)
    kinds = np.round(random.uniform([0.0] * 3 + [0.2] * 3, [3.0] * 3 + [1.0] * 3, (8, 5, 6)), 2)
    for group in range(count // 5):
        corner = np.array([group % 40 * 6.0, group // 40 * 6, 0])
        corner = np.round(corner + random.uniform(0, 2, 3), 2)
        for box in kinds[random.integers(8)]:
            yield corner + box[:3], box[3:]


MODELS: dict[str, Callable[[int], Iterator[Box]]] = {"grid": grid, "lots": lots, "groups": groups}


def write(path: Path, boxes: list[Box]) -> None:
    """The boxes as an OBJ file."""
    lines = []
    for low, size in boxes:
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in low + CORNERS * size]
    for index in range(len(boxes)):
        lines += ["f " + " ".join(str(8 * index + each + 1) for each in face) for face in FACES]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def loop() -> float:
    """Seconds of a plain loop, which say how quick the machine is now."""
    started = time.process_time()
    sum(i * i for i in range(10**6))
    return time.process_time() - started


def measured(name: str, count: int) -> dict[str, float]:
    """What became of one model."""
    with tempfile.TemporaryDirectory(prefix="ipmlang-bench-") as folder:
        tiny, path = Path(folder) / "tiny.obj", Path(folder) / f"{name}.obj"
        write(tiny, list(grid(4)))
        write(path, list(MODELS[name](count)))
        infer(tiny)
        before = time.process_time()
        report = infer(path).report
        seconds = time.process_time() - before
    return {
        "parts": report.elements,
        "flat": report.tokens_flat,
        "tokens": report.tokens,
        "rules": report.rules,
        "seconds": seconds,
        "loop": loop(),
        "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def row(name: str, record: dict[str, float]) -> str:
    """A line of the table."""
    seconds, parts = record["seconds"], record["parts"]
    cells = (
        name, f"{parts:.0f}", f"{record['flat']:.0f}", f"{record['tokens']:.0f}",
        f"{record['rules']:.0f}", f"{seconds:.1f}", f"{100 * seconds / parts:.2f}",
        f"{record['peak']:.0f}",
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main(words: list[str]) -> None:
    """The command."""
    if "--one" in words:
        print(json.dumps(measured(words[1], int(words[2]))))
        return
    counts = [int(word) for word in words if word.isdigit()] or COUNTS
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|" + "--:|" * (len(COLUMNS) - 1)]
    loops = []
    for name in MODELS:
        for count in counts:
            alone = [sys.executable, __file__, "--one", name, str(count)]
            done = subprocess.run(alone, capture_output=True, text=True, check=True)
            record = json.loads(done.stdout)
            loops.append(record["loop"])
            lines.append(row(name, record))
            print(lines[-1], flush=True)
    text = HEAD.format(low=min(loops), high=max(loops)) + "\n".join(lines) + "\n"
    if "--save" in words:
        RESULTS.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
