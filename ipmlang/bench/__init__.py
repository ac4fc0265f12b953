"""How fast the CPU and the graphics card derive, side by side: named tasks and their measuring.

Takes the names of tasks, how large they should be and who should derive them; gives rows of
measurements. The grammars of the tasks lie beside this file. Nothing is printed or written here.
"""

from __future__ import annotations

from ipmlang.bench.measuring import Measured, machine, measure, warmed
from ipmlang.bench.tasks import TASKS, Run, Task, runs_of

__all__ = ["TASKS", "Measured", "Run", "Task", "machine", "measure", "runs_of", "warmed"]
"""What the command needs."""
