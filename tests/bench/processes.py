"""The ending that benches share: each task is measured in a process of its own.

In go a bench's file, its tasks and how one is measured; out comes one JSON object on the output.
Nothing is measured here.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterable

Measure = Callable[[str], dict[str, float]]


def report(
    file: str, names: Iterable[str], measure: Measure, more: dict[str, Callable[[], object]]
) -> None:
    """Print what is found of all tasks, or of the one that the command line names; `more`: what
    needs no process of its own, by name, found when all tasks are asked for.
    """
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1])))
        return
    found: dict[str, object] = {}
    for name in names:
        line = [sys.executable, file, name]
        done = subprocess.run(line, check=True, capture_output=True, text=True)
        found[name] = json.loads(done.stdout)
    found.update((name, make()) for name, make in more.items())
    print(json.dumps(found, indent=2))
