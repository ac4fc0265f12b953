"""Timing one derivation on the CPU or on the graphics card, and telling on what machine.

Takes a run of a task; gives how long its first, its best and an edited derivation took, and what
came out. Seconds are elapsed ones, the same for both back ends; getting the card ready, its shader
compiled, is timed apart from all tasks. Nothing is printed here.
"""

from __future__ import annotations

import os
import platform
import time
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np

from ipmlang.bench.tasks import Run
from ipmlang.compiler import compile_text
from ipmlang.runtime import derive, derive_table
from ipmlang.runtime.scene import SCOPE, SEGMENT, Instances, Scene

Backend = Literal["cpu", "gpu"]
_BOX, _RECTANGLE, _LINE = 12, 2, 0  # triangles of what a terminal draws
_SMALL = "ipm 1\nWall --> split x { { ~1: Bay }* }\nstart Wall on box(9, 3, 0)\n"


@dataclass(frozen=True, slots=True)
class Measured:
    """One task on one back end. `ran` is what derived it: a grammar may have no place on the card.
    first: seconds of the first derivation, best: of the quickest of all the later ones; edited:
    with an attribute changed; resident: the best of those whose terminals stay on the card, None
    where numpy derives or helps.
    """

    backend: Backend
    ran: str
    terminals: int
    triangles: int
    first: float
    best: float
    edited: float
    resident: float | None = None

    def record(self) -> dict[str, object]:
        """The same as JSON, with terminals and triangles a second."""
        rates = {
            "terminals_per_s": round(self.terminals_per_s),
            "triangles_per_s": round(self.triangles_per_s),
        }
        return asdict(self) | rates

    @property
    def terminals_per_s(self) -> float:
        """Terminals of the best run, of those that stay on the card if there are such."""
        return self.terminals / (self.resident or self.best)

    @property
    def triangles_per_s(self) -> float:
        """Triangles that those terminals are."""
        return self.triangles / (self.resident or self.best)


def measure(run: Run, backend: Backend, repeat: int) -> Measured:
    """Derive a run once, `repeat` times again, and once with its attribute changed."""
    seconds = []
    for _ in range(1 + repeat):
        scene, elapsed = _timed(run, backend, run.attrs)
        seconds.append(elapsed)
    _, edited = _timed(run, backend, run.edited())
    drawn = scene.instances
    best = min(seconds[1:])
    triangles = triangle_count(drawn)
    resident = None if backend == "cpu" else _resident(run, repeat)
    return Measured(
        backend, scene.backend, len(drawn), triangles, seconds[0], best, edited, resident
    )


def warmed(backend: Backend) -> float:
    """Seconds until a back end has derived its very first grammar: for the card, its context opened
    and its shader compiled. Raises IpmError where there is no card.
    """
    begun = time.perf_counter()
    _, program, _ = compile_text(_SMALL)
    derive(program, seed=1, backend=backend)
    return time.perf_counter() - begun


def machine() -> dict[str, object]:
    """What the CPU side ran on."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "system": platform.platform(),
        "cores": os.cpu_count(),
    }


def triangle_count(drawn: Instances) -> int:
    """Triangles of terminals: 12 of a box or a segment, 2 of a rectangle, none of a line."""
    sides = (drawn.size > 0).sum(axis=1)
    scopes = np.choose(sides, [_LINE, _LINE, _RECTANGLE, _BOX])
    each = np.where(drawn.asset == SCOPE, scopes, np.where(drawn.asset == SEGMENT, _BOX, _LINE))
    return int(each.sum())


def _resident(run: Run, repeat: int) -> float | None:
    """Seconds of the quickest derivation that stays on the card; None where none can."""
    from ipmlang.runtime.gpu.reuse import forget

    seconds = []
    for _ in range(1 + repeat):
        forget()  # else it is not derived again
        begun = time.perf_counter()
        table = derive_table(run.program, seed=run.seed, attrs=run.attrs)
        seconds.append(time.perf_counter() - begun)
        if table is None:
            return None
        table.release()
    return min(seconds[1:])


def _timed(
    run: Run, backend: Backend, attrs: dict[str, int | float | bool | str]
) -> tuple[Scene, float]:
    begun = time.perf_counter()
    scene = derive(run.program, seed=run.seed, attrs=attrs, backend=backend)
    return scene, time.perf_counter() - begun
