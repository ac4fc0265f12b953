"""The tasks: a grammar, what makes it as large as published measurements are, and its parts.

Takes names and a scale; gives the derivations to time. Sizes follow what was measured elsewhere:
towns of 38,000 simple houses or of 520 detailed towers (2014), one façade, one tree, and many small
seeds beside each other (2012, 2015). No time is taken here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files

from ipmlang.compiler import compile_file
from ipmlang.compiler.diagnostics import fail, nearest
from ipmlang.compiler.ir import Program

_FORK = 2.5  # branches that a branch of the tree ends in, on average


@dataclass(frozen=True, slots=True)
class Task:
    """A grammar, its attribute for the size, the sizes to measure at scale 1, and the seed. With
    `fork` the size is an exponent: so many times more for each that it is larger.
    """

    name: str
    about: str
    attribute: str
    sizes: tuple[int, ...]
    seed: int = 1
    fork: float | None = None

    def at(self, scale: float) -> tuple[int, ...]:
        """The sizes that are so many times the work, each once and at least 1."""
        if self.fork is not None:
            steps = math.log(scale) / math.log(self.fork)
            return tuple(max(1, round(size + steps)) for size in self.sizes)
        most = max(1, round(max(self.sizes) * scale))
        return tuple(dict.fromkeys(min(size, most) for size in self.sizes))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One derivation to time."""

    name: str
    program: Program
    attrs: dict[str, int | float | bool | str]
    seed: int

    def edited(self) -> dict[str, int | float | bool | str]:
        """The attributes of a run that is one smaller: what changes when a person edits one."""
        return {name: max(1, int(value) - 1) for name, value in self.attrs.items()}


TASKS = {
    task.name: task
    for task in (
        Task("facade", "one façade of a million terminals", "floors", (306,)),
        Task("town", "a town of 38,000 simple houses", "houses", (38_000,)),
        Task("towers", "520 detailed towers of about 2,900 terminals", "towers", (520,)),
        Task("tree", "a tree of 3.6 million segments", "age", (16,), seed=26, fork=_FORK),
        Task("seeds", "10 to 100,000 seeds", "lots", (10, 100, 1_000, 10_000, 100_000)),
    )
}


def runs_of(names: Sequence[str], scale: float) -> list[Run]:
    """The derivations of these tasks, or of all; an IpmError for a name that is none."""
    for name in names:
        if name not in TASKS:
            near = nearest(name, TASKS)
            hint = f"did you mean `{near[0]}`?" if near else f"tasks are {', '.join(TASKS)}"
            raise fail("bad-command", f"no task is called `{name}`", hint=hint)
    chosen = [TASKS[name] for name in dict.fromkeys(names or TASKS)]
    return [run for task in chosen for run in _runs(task, scale)]


def _runs(task: Task, scale: float) -> list[Run]:
    with as_file(files("ipmlang.bench") / f"{task.name}.ipm") as path:
        _, program, _ = compile_file(path)
    sizes = task.at(scale)
    return [
        Run(
            task.name if len(task.sizes) == 1 else f"{task.name} {size:,}",
            program,
            {task.attribute: size},
            task.seed,
        )
        for size in sizes
    ]
