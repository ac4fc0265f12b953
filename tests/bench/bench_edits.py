"""How fast edits of buildings are: `python tests/bench/bench_edits.py`.

Prints one JSON object. `solve`: a façade of so many boxes stretched, CPU seconds for finding its
neighbours, marking its equations, factoring them, solving them for another size, and all but the
neighbours; `local`: one window of it made wider. `edits`: resizes of small buildings, from text to
text; `inferred`: one part of models that were read, changed from text to text, imports apart, each
time otherwise, and `proof`: what writing its result takes then. A loop of plain Python with a known
count runs beside (`loop_s`), so that runs on busy machines can be compared. Timings are kept, never
asserted.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from ipmlang import edit, infer  # noqa: E402
from ipmlang.edit.buildings import Wanted, paste, remove, resize, scale  # noqa: E402
from ipmlang.edit.buildings.attachments import (  # noqa: E402
    Attached,
    attach,
    mark,
    settle,
    stretching,
)
from ipmlang.edit.buildings.growing import grown  # noqa: E402
from ipmlang.edit.draft import Draft  # noqa: E402

REAL = ROOT / "../shared/data/mesh"
MODELS = (
    *(REAL / f"{name}.obj" for name in ("castle", "building_F_nobase", "building_H", "tower_A")),
    ROOT / "examples" / "hotel.obj",
)
FILES = ROOT / "tests" / "edit" / "buildings"
LOOP = 10**6


def timed(*works: Callable[[], object]) -> tuple[list[float], object]:
    """CPU seconds of each piece of work, and what came out of the last."""
    took, made = [], None
    for work in works:
        begun = time.process_time()
        made = work()
        took.append(round(time.process_time() - begun, 4))
    return took, made


def least(work: Callable[[], object]) -> tuple[float, object]:
    """The least CPU seconds of three runs, and what came out."""
    took, made = timed(work, work, work)
    return min(took), made


def facade(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A wall with windows, each with a sill below and a head above, between two towers."""
    low, high = [[0.0, 0.0, 0.0]], [[2.0 * columns, 0.4, 3.0 * rows]]
    for i in range(columns):
        for k in range(rows):
            x, z = 2.0 * i + 0.5, 3.0 * k + 0.8
            low += [[x, -0.1, z], [x - 0.1, -0.2, z - 0.2], [x, -0.1, z + 1.5]]
            high += [[x + 1, 0.4, z + 1.5], [x + 1.1, 0.2, z], [x + 1, 0.2, z + 1.8]]
    low += [[-3.0, 0, 0], [2.0 * columns, 0, 0]]
    high += [[0.0, 3, 3.0 * rows + 2], [2.0 * columns + 3, 3, 3.0 * rows + 2]]
    return np.array(low), np.array(high)


def solving(columns: int, rows: int) -> dict[str, float]:
    low, high = facade(columns, rows)
    found, made = least(lambda: attach(low, high, 1e-6))
    assert isinstance(made, Attached)
    faces, count = made.faces[:, 0], len(low)
    fixed = np.sort(np.array([faces[0], faces[count]]))
    marking, _ = least(lambda: mark(made, 0, fixed, [0]))
    both, system = least(lambda: stretching(made, 0, fixed, [0]))
    own = stretching(made, 0, fixed, [0])
    again, _ = least(lambda: own.solve(np.array([0.0, 1.3 * high[0, 0]])))
    held, result = least(lambda: settle(own, np.array([0.0, 1.3 * high[0, 0]])))
    assert result is not None and system is not None
    window = count // 2 - (count // 2 - 1) % 3
    pins = np.sort(np.array([faces[window], faces[window + count]]))
    values = np.sort(np.array([low[window, 0], high[window, 0] + 0.2]))
    local, _ = least(lambda: settle(stretching(made, 0, pins, [window]), values))
    return {
        "boxes": count,
        "equations": own.equations,
        "neighbours_s": found,
        "mark_s": marking,
        "factor_s": round(both - marking, 4),
        "solve_s": again,
        "settle_s": held,
        "all_s": round(both + held, 4),
        "local_s": local,
    }


def whole_edits() -> dict[str, float]:
    tasks = {
        "wall, twice as wide": ("wall", "Castle", Wanted(x=2.0, factors=True), None),
        "wall, one window": ("wall", "Window", Wanted(x=1.5, factors=True), 3),
        "court, half as deep": ("court", "Court", Wanted(y=0.5, factors=True), None),
        "floors, by its lot": ("floors", "Facade", Wanted(x=21.0), None),
    }
    found = {}
    for name, (file, select, wanted, number) in tasks.items():
        draft = edit.read(FILES / f"{file}.ipm")
        found[name], _ = least(
            lambda d=draft, s=select, w=wanted, n=number: resize(d, s, w, number=n)
        )
    return found


# Each takes the number of the try: no two are the same edit, which a memory could know.
LOCAL: dict[str, Callable[[Draft, str, int], Draft]] = {
    "one larger": lambda draft, part, again: resize(
        draft, part, Wanted(z=1.2 + 0.03 * again, factors=True), number=2
    ),
    "terminal scaled": lambda draft, part, again: scale(
        draft, part, np.array([1.1 + 0.03 * again, 1.0, 1.0])
    ),
    "one removed": lambda draft, part, again: remove(draft, part, number=1 + again),
    "one pasted": lambda draft, part, again: paste(draft, part, part, number=2 + again),
}


def of_inferred() -> dict[str, dict[str, float]]:
    """Local edits of the commonest terminal of models as inference says them: of each kind the
    first, and the least of four that differ.
    """
    found: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory(prefix="ipmlang-bench-") as folder:
        for model in MODELS:
            if not model.exists():
                continue
            path = Path(folder) / f"{model.stem}.ipm"
            infer(model).save(path)
            labels = Counter(grown(edit.read(path)).terminals.labels)
            part = min(labels, key=lambda name: (-labels[name], name))
            for name, work in LOCAL.items():
                took, made = timed(*(partial(_edited, path, work, part, n) for n in range(4)))
                assert isinstance(made, Draft)
                proof, _ = least(lambda m=made, p=path: edit.finish(m, p.with_name("new.ipm")))
                found[f"{model.stem}: {name}, {part}"] = {
                    "first_s": took[0], "edit_s": min(took), "proof_s": proof,
                }  # fmt: skip
    return found


def _edited(path: Path, work: Callable[[Draft, str, int], Draft], part: str, again: int) -> Draft:
    return work(edit.read(path), part, again)


def main() -> None:
    begun = time.process_time()
    sum(i * i for i in range(LOOP))
    loop = round(time.process_time() - begun, 3)
    print(json.dumps({
        "loop_s": loop,
        "solve": [solving(*size) for size in ((10, 10), (58, 58), (130, 130))],
        "edits": whole_edits(),
        "inferred": of_inferred(),
    }, indent=1))  # fmt: skip


if __name__ == "__main__":
    main()
