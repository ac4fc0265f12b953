"""How long large grammars take to parse and check: whole, twice the size, and after a small edit.

Run `python tests/bench/bench_check.py`; times are CPU seconds inside the process after imports.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from ipmlang.compiler import check, load

T = TypeVar("T")


def inferred_like(size: int) -> str:
    """A grammar of about `size` bytes as inference prints them: many rules of placed shapes."""
    random.seed(size)
    lines = ["ipm 1", 'attr count : int = 6 in 1..60 "how many"']
    written, number = 0, 0
    while written < size:
        spots = " ".join(
            f"[at({random.uniform(0, 900):.2f}, {random.uniform(0, 900):.2f}) Leaf(m, {k})]"
            for k in range(6)
        )
        rule = (
            f"Part{number}(m) : m > 0 --> repeat(i < count) {{ {spots} f({number % 37}.5) }} "
            f"Part{max(0, number - 1)}(m - 1)\nPart{number}(m) : else --> Leaf(m, 0)"
        )
        lines.append(rule)
        written += len(rule) + 1
        number += 1
    lines += ["Leaf(a, b) --> F(a + b)", f"start Part{number - 1}(3)"]
    return "\n".join(lines) + "\n"


def timed(work: Callable[[], T]) -> tuple[float, T]:
    """CPU seconds of the process, and what the work returned."""
    started = time.process_time()
    result = work()
    return time.process_time() - started, result


def main() -> None:
    """Print one line a size: parse and check, the same after an edit of one rule."""
    words = ("bytes", "errors", "load s", "check s", "edited load", "check")
    print("{:>9} {:>6} {:>8} {:>8} {:>12} {:>8}".format(*words))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "large.ipm"
        for size in (250_000, 500_000, 1_000_000):
            text = inferred_like(size)
            path.write_text(text, encoding="utf-8")
            load_seconds, loaded = timed(lambda: load(path))
            check_seconds, checked = timed(lambda loaded=loaded: check(loaded))
            path.write_text(text.replace("f(5.5)", "f(6.5)", 1), encoding="utf-8")
            again_load, loaded = timed(lambda: load(path))
            again_check, _ = timed(lambda loaded=loaded: check(loaded))
            errors = sum(each.severity == "error" for each in checked.diagnostics)
            print(f"{len(text):>9} {errors:>6} {load_seconds:>8.2f} {check_seconds:>8.2f} "
                  f"{again_load:>12.3f} {again_check:>8.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
