"""From checked files to a program: rule families end here.

In go the main file's unit and those it imports, all checked; out comes `ir.Program`, which
executors run. What is reachable and not executable yet is reported operation by operation.
"""

from __future__ import annotations

from ipmlang.compiler import collector, ir
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.lower.instances import units_of
from ipmlang.compiler.lower.program import Lowering

__all__ = ["lower"]


def lower(checked: Checked, style: str | None = None) -> ir.Program:
    """The program of a checked grammar, in one of its styles if one is named. Raises IpmError for
    what no executor runs yet, and for a style that it does not have.
    """
    with collector.held():
        units = units_of(checked.loaded, style)
        return Lowering(units[0], tuple(units)).program()
