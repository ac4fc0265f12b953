"""From checked files to a program: rule families end here.

In go the main file's unit and those it imports, all checked; out comes `ir.Program`, which
executors run. What is reachable and not executable yet is reported operation by operation.
"""

from __future__ import annotations

from collections.abc import Sequence

from ipmlang.compiler import collector, ir
from ipmlang.compiler.checked import Checked
from ipmlang.compiler.lower.names import Unit, unit
from ipmlang.compiler.lower.program import Lowering

__all__ = ["Unit", "lower", "lower_units", "unit"]


def lower_units(main: Unit, imported: Sequence[Unit] = ()) -> ir.Program:
    """The program of a main file and all that it imports."""
    with collector.held():
        return Lowering(main, (main, *imported)).program()


def lower(checked: Checked) -> ir.Program:
    """The program of a checked grammar. Raises IpmError for what no executor runs yet."""
    files = checked.loaded.files
    units = {id(file): unit(file.grammar, file.source, file.prefix) for file in files}
    for file in files:
        made = units[id(file)]
        made.imports.update({name: units[id(other)] for name, other in file.imports.items()})
    main, *imported = units.values()
    return lower_units(main, imported)
