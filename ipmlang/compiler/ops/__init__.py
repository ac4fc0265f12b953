"""THE TABLE: every operation, function, query and setting of the language, by name.

`OPERATIONS` finds an operation by its name or a synonym; the others by name. Nothing is added to
these at run time.
"""

from __future__ import annotations

from types import MappingProxyType

from ipmlang.compiler.ops import (
    docking,
    functions,
    marching,
    pen,
    queries,
    scope,
    settings,
    solids,
    turtle,
)
from ipmlang.compiler.ops.functions import CONSTANTS, OPERATORS, PREFIXES
from ipmlang.compiler.ops.record import Function, Operation, Query, SettingRecord, Step

ALL_OPERATIONS: tuple[Operation, ...] = (
    turtle.TABLE + pen.TABLE + scope.TABLE + solids.TABLE + docking.TABLE + marching.TABLE
)
OPERATIONS = MappingProxyType(
    {name: record for record in ALL_OPERATIONS for name in (record.name, *record.synonyms)}
)
FUNCTIONS = MappingProxyType({record.name: record for record in functions.TABLE})
QUERIES = MappingProxyType({record.name: record for record in queries.TABLE})
SETTINGS = MappingProxyType({(record.item, record.name): record for record in settings.TABLE})

__all__ = [
    "ALL_OPERATIONS",
    "CONSTANTS",
    "FUNCTIONS",
    "OPERATIONS",
    "OPERATORS",
    "PREFIXES",
    "QUERIES",
    "SETTINGS",
    "Function",
    "Operation",
    "Query",
    "SettingRecord",
    "Step",
    "leaves_plane",
]


def leaves_plane(operation: Operation, form: int) -> bool:
    """Whether one form of an operation can leave z = 0: said by its record, or by its steps."""
    steps = operation.meaning[form] if operation.meaning else ()
    return operation.leaves_plane or any(_tilts(step) for step in steps)


def _tilts(step: Step) -> bool:
    match step.op:
        case "orient":
            return True
        case "rotate":
            return step.const != "z"
        case "move":
            return step.args[2] != 0.0
        case _:
            return False
